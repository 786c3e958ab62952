"""What the rounding of an angle by counts does to the orders of a speed that is computed of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples, coherent_samples_of_all, spectrum_of
from benchtool.analysis.orders.angle import AngleCoverage
from benchtool.analysis.orders.angle_orders import amplitudes_of_all
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.quantisation.counted_angle import CountedAngle


def without_rounding(counted: CountedAngle, coherent: CoherentSamples, track: PhaseTrack) -> CoherentSamples:
    """Return samples along a track without what rounding has added to them: their noise is then that of the
    motion. Each order still has what rounding puts there."""
    added = _along(counted.added()[np.newaxis], coherent, track)
    return replace(coherent, values=coherent.values - added[0].values) if added else coherent


def rounding_by_time(
    counted: CountedAngle, coherent: CoherentSamples, track: PhaseTrack, orders: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return the standard uncertainty by rounding of the amplitudes of orders of a coherent spectrum, shape
    (orders,)."""
    square, places = np.zeros(len(orders)), 0
    for some in counted.may_add():
        places += len(some)
        for each in _along(some, coherent, track):
            square += spectrum_of(each).amplitude[orders * each.periods] ** 2
    return np.sqrt(0.5 * square / places)


def rounding_by_angle(counted: CountedAngle, coverage: AngleCoverage, orders: int) -> NDArray[np.float64]:
    """Return that of so many orders fitted on angles, shape (orders,)."""
    square, places = np.zeros(orders), 0
    for some in counted.may_add():
        places += len(some)
        square += np.sum(amplitudes_of_all(coverage, some, orders) ** 2, axis=0)
    return np.sqrt(0.5 * square / places)


def _along(
    signals: NDArray[np.float64], like: CoherentSamples, track: PhaseTrack
) -> tuple[CoherentSamples, ...]:
    """Return signals of rows, shape (signals, n), along a track as samples that were read with them, without
    those that are constant."""
    columns = {f"rounding {place}": each for place, each in enumerate(signals) if np.ptp(each) > 0.0}
    return coherent_samples_of_all(columns, like.sample_rate_Hz, track) if columns else ()
