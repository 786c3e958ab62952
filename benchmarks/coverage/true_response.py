"""True numbers of a frequency response that is known, by their definitions."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from benchmarks.coverage.families import NEVER
from benchtool.analysis import Measurement

Floats = NDArray[np.float64]
Response = Callable[[Floats], NDArray[np.complex128]]
"""A response at frequencies, Hz."""

_HALF_POWER_DB = -10.0 * math.log10(2.0)
_PARTS = np.unique(np.concatenate([np.geomspace(1e-5, 0.9999, 20_000), np.linspace(5e-5, 0.9999, 40_000)]))
_PLACES = 5_000  # of a line of the phase, all frequencies alike
_TENTH = 0.1  # of its upper end, where it begins


def sampled(above: Floats, below: Floats, rate_Hz: float) -> Response:
    """Return the response of a filter by its coefficients."""

    def response(frequency_Hz: Floats) -> NDArray[np.complex128]:
        return np.asarray(signal.freqz(above, below, worN=frequency_Hz, fs=rate_Hz)[1])

    return response


def true_numbers_of_response(
    response: Response, top_Hz: float, found: Iterable[Measurement]
) -> Mapping[str, float]:
    """Return the truths of the numbers that were `found` of a response, which is known up to a frequency."""
    grid_Hz = top_Hz * _PARTS
    closed = response(grid_Hz)
    rest = float(response(np.zeros(1))[0].real)
    gain_dB, phase = _decibels(closed / rest), _unwrapped(closed / rest)
    bandwidth_Hz = _falls_to(grid_Hz, gain_dB, _HALF_POWER_DB)
    return {
        "response_gain": rest,
        "bandwidth_3dB": bandwidth_Hz,
        "bandwidth_90deg": _falls_to(grid_Hz, phase, -0.5 * math.pi),
        "resonance_peak": max(0.0, float(np.max(gain_dB))),
        "response_delay": _delay(response, bandwidth_Hz, found),
        "sensitivity_peak": float(np.max(np.abs(1.0 - closed))),
        **_of_open_loop(grid_Hz, closed / (1.0 - closed)),
    }


def _of_open_loop(grid_Hz: Floats, opened: NDArray[np.complex128]) -> Mapping[str, float]:
    gain_dB, phase = _decibels(opened), _unwrapped(opened)
    crossover_Hz = _falls_to(grid_Hz, gain_dB, 0.0)
    if not math.isfinite(crossover_Hz):
        return dict.fromkeys(("crossover", "phase_margin", "gain_margin"), NEVER)
    there = float(np.interp(crossover_Hz, grid_Hz, phase))
    margin = math.remainder(math.pi + there, 2.0 * math.pi)
    # two integrators begin near -180 degrees, which they fall to above the crossover
    above = slice(int(np.searchsorted(grid_Hz, crossover_Hz)), None)
    turned_Hz = _falls_to(grid_Hz[above], phase[above] - there + margin, 0.0)
    is_turned = math.isfinite(turned_Hz)
    return {
        "crossover": crossover_Hz,
        "phase_margin": math.degrees(margin),
        "gain_margin": -float(np.interp(turned_Hz, grid_Hz, gain_dB)) if is_turned else NEVER,
    }


def _delay(response: Response, bandwidth_Hz: float, found: Iterable[Measurement]) -> float:
    """Return the delay over the frequencies that it states: its own ends, but for those of the record."""
    text = "".join(each.definition for each in found if each.name == "response_delay")
    ends = re.search(r"here from (\S+) Hz to (\S+) Hz", text)
    if ends is None:
        return NEVER
    upper_Hz = float(ends[2]) if "up to the highest frequency used" in text else bandwidth_Hz
    lower_Hz = float(ends[1]) if "from the lowest frequency used" in text else _TENTH * upper_Hz
    if not math.isfinite(upper_Hz):
        return NEVER
    along = (np.arange(_PLACES) + 0.5) / _PLACES - 0.5
    phase = _unwrapped(response(0.5 * (lower_Hz + upper_Hz) + (upper_Hz - lower_Hz) * along))
    slope = float(along @ phase / (along @ along)) / (upper_Hz - lower_Hz)
    return -slope / (2.0 * math.pi)


def _decibels(values: NDArray[np.complex128]) -> Floats:
    return np.asarray(20.0 * np.log10(np.abs(values)))


def _unwrapped(values: NDArray[np.complex128]) -> Floats:
    return np.asarray(np.unwrap(np.angle(values)))


def _falls_to(frequency_Hz: Floats, values: Floats, level: float) -> float:
    """Return the first place below a level, `NEVER` without one."""
    below = np.flatnonzero(values < level)
    if not len(below) or not below[0]:
        return NEVER
    pair = slice(int(below[0]) - 1, int(below[0]) + 1)
    return float(np.interp(-level, -values[pair], frequency_Hz[pair]))
