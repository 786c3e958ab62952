"""What the angle of a shaft repeats in its speed, taken out of its answer to a stimulus that repeats itself.

Cogging, harmonics of the EMF, an eccentric encoder and the differences of the current sensors move the speed
of a light rotor by more than a stimulus may. They come at orders of the revolution, whose frequencies the
stimulus shifts; over the periods of the stimulus the shaft is at other angles each time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

_POWERS: Final = 3  # of the speed, by which the answer of the closed loop to an order changes
_FEWEST_PERIODS: Final = 3


def without_orders(
    omega_m: NDArray[np.float64], period_rows: int, row_s: float, orders: Sequence[int]
) -> NDArray[np.float64]:
    """Return a speed, in rad/s and of shape (n,), without what its shaft's angle repeats.

    Each order has cosine and sine of the angle, with amplitudes that are parabolas in the mean speed of that
    row of a period. They are fitted to what differs from period to period, so that the answer to the stimulus
    is neither fitted nor taken out. Rows beyond whole periods are left as they are.

    Args:
        omega_m: the speed.
        period_rows: of the stimulus, which repeats itself from the first row on.
        row_s: time from row to row.
        orders: periods in a revolution of the shaft.
    """
    periods = len(omega_m) // period_rows
    if periods < _FEWEST_PERIODS or not orders:
        return omega_m
    rows = periods * period_rows
    theta_m = row_s * np.cumsum(omega_m[:rows])  # up to a constant, which the fit takes up
    speeds = omega_m[:rows].reshape(periods, period_rows)
    mean = np.mean(speeds, axis=0)
    scale = float(np.std(mean))
    about = np.tile((mean - np.mean(mean)) / scale if scale > 0.0 else np.zeros(period_rows), periods)
    columns = np.column_stack(
        [
            wave(order * theta_m) * about**power
            for order in orders
            for power in range(_POWERS if scale > 0.0 else 1)
            for wave in (np.cos, np.sin)
        ]
    )
    differing = columns.reshape(periods, period_rows, -1)
    differing = (differing - np.mean(differing, axis=0)).reshape(rows, -1)
    amplitudes = np.linalg.lstsq(differing, (speeds - mean).ravel(), rcond=None)[0]
    found = np.array(omega_m)
    found[:rows] -= columns @ amplitudes
    return found
