"""Error of the drive's estimate of torque against a transducer, over the same time."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis import Measurement, torque_ripple, track_angle, transducer_torque
from benchtool.block import Block

RATE_HZ, PER_PERIOD, PERIODS = 10e3, 100, 60
ERROR_NM = 0.05


def _wandering(random: np.random.Generator, count: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return a load of 2 Nm that wanders by some 50 mNm in half of a record."""
    steps = 0.05 / np.sqrt(0.5 * count) * random.standard_normal(count)
    return np.asarray(2.0 + np.cumsum(steps))


def _error(
    seed: int, every: int = 1, periods: float = PERIODS + 0.3, *, angle: bool = True, step_Nm: float = 0.0
) -> Measurement:
    """Return torque_error where the transducer has each `every`th row of the capture."""
    random, count = np.random.default_rng(seed), round(periods * PER_PERIOD)
    theta = 2.0 * np.pi * np.arange(count) / PER_PERIOD
    load = _wandering(random, count)
    torque = load + ERROR_NM + 0.02 * np.cos(6.0 * theta) + 0.02 * random.standard_normal(count)
    read = (load + 0.01 * random.standard_normal(count))[::every]
    if step_Nm:
        read = step_Nm * np.round(read / step_Nm)
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=torque)
    transducer = Block.from_arrays(RATE_HZ / every, {"torque_transducer": "Nm"}, torque_transducer=read)
    track = track_angle(theta, 1) if angle else None
    estimate = torque_ripple(block, track=track)[0]
    return transducer_torque(transducer, block, estimate=estimate, track=track)[-1]


@pytest.mark.parametrize("every", [1, 4])
def test_a_load_that_wanders_is_in_both_and_not_in_their_difference(every: int) -> None:
    relative, standard = [], []
    for seed in range(12):
        error = _error(seed, every)
        assert error.uncertainty is not None
        relative.append((error.value - ERROR_NM) / error.uncertainty.standard)
        standard.append(error.uncertainty.standard)
    # of 6000 rows whose noise is 22 mNm, beside a wander that moves both means by some 20 mNm
    assert np.median(standard) == pytest.approx(0.0224 / np.sqrt(6030.0), rel=0.4)
    assert 0.6 < np.sqrt(np.mean(np.square(relative))) < 1.4


def test_steps_of_the_transducer_stand_beside_the_scatter() -> None:
    """A mean that wanders too slowly has no uncertainty that would hold them."""
    error = _error(0, step_Nm=0.05)
    assert error.uncertainty is not None
    of_scatter, of_steps = error.uncertainty.budget
    assert of_scatter.name.startswith("scatter of the difference over the periods")
    assert of_steps.name == "resolution 0.05 Nm of the transducer"
    assert of_steps.standard == pytest.approx(0.05 / np.sqrt(12.0))


def test_without_periods_there_is_no_scatter_of_the_difference() -> None:
    error = _error(0, angle=False)
    assert error.uncertainty is None
    assert error.uncertainty_reason
    assert error.value == pytest.approx(ERROR_NM, abs=2e-3)
