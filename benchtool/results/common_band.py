"""The drive's estimate of torque in the band that a slower transducer shows, so that both can be compared."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy import fft

from benchtool.analysis import Instruments, Measurement, catalogue, measure
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.results.agreement import transducer_name
from benchtool.results.analyses import Planned

_ESTIMATE, _TRANSDUCER = "torque", "torque_transducer"


def with_common_band(
    measurements: Sequence[Measurement],
    capture: Block,
    transducer: Block | None,
    todo: Callable[[Block], Iterable[Planned]],
    instruments: Instruments,
) -> tuple[Measurement, ...]:
    """Return the measurements; those by the estimate hold what they are in the transducer's band, where that
    ends below the capture's.

    Args:
        measurements: by estimate and transducer.
        capture: with the estimate, without gaps.
        transducer: its torque, at any rate.
        todo: returns the analyses of a capture in place of that one.
        instruments: the sensors of both.
    """
    sensor = instruments.bench.channels.get(_TRANSDUCER)
    if transducer is None or _ESTIMATE not in capture.names:
        return tuple(measurements)
    lag_Hz = math.inf if sensor is None or sensor.bandwidth_Hz is None else sensor.bandwidth_Hz
    ends_Hz = 0.5 * transducer.sample_rate_Hz
    if min(lag_Hz, ends_Hz) >= 0.5 * capture.sample_rate_Hz:
        return tuple(measurements)
    narrow = _low_passed(capture, lag_Hz, ends_Hz)
    found: list[Measurement] = []
    try:
        for each in todo(narrow):
            if each.possible and not each.refusal and _is_compared(each):
                found.extend(measure(each.analysis, each.window, each.settings).measurements)
    except AnalysisError:  # nothing of the estimate is left in that band
        return tuple(measurements)
    band_Hz = min(lag_Hz, ends_Hz)
    in_band = {
        each.name: replace(each, basis=replace(each.basis, bandwidth_Hz=band_Hz))
        for each in instruments.applied(found)
    }
    return tuple(replace(each, in_common_band=in_band.get(each.name)) for each in measurements)


def _is_compared(each: Planned) -> bool:
    """Return whether an analysis is of the estimate alone, and the transducer gives the same numbers."""
    twins = map(catalogue().measuring, map(transducer_name, each.analysis.names))
    return each.analysis.channels == (_ESTIMATE,) and not each.analysis.transducer and any(twins)


def _low_passed(capture: Block, lag_Hz: float, ends_Hz: float) -> Block:
    """Return the capture with the estimate as a first-order lag of `lag_Hz` shows it, up to `ends_Hz`.

    The record is continued as in a mirror at both ends.
    """
    torque = capture.column(_ESTIMATE)
    rows = len(torque)
    mirrored = np.concatenate([torque, torque[::-1]])
    frequency_Hz = fft.rfftfreq(len(mirrored), 1.0 / capture.sample_rate_Hz)
    response = np.where(frequency_Hz <= ends_Hz, 1.0 / (1.0 + 1j * frequency_Hz / lag_Hz), 0.0)
    data = np.array(capture.data)
    filtered = fft.irfft(fft.rfft(mirrored) * response, len(mirrored))
    data[:, capture.names.index(_ESTIMATE)] = filtered[:rows]
    return replace(capture, data=data)
