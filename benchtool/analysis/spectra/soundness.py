"""Whether the fundamental is suitable as a reference: one regime, on a phase, out of the noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples, CoherentSpectrum
from benchtool.analysis.noise.noise import harmonic_noise
from benchtool.analysis.noise.noise_of_lines import line_noise
from benchtool.analysis.phase.wander import Wander
from benchtool.analysis.statistics.regimes import STANDS_OUT, change_of_regime

_ABOVE_FLOOR = 4.0  # of the rms amplitude of a bin of noise: by chance once in ten million
_HIGHEST_TURNED, _QUARTERS, _TURNS = 13, 4, 0.5
_CANCEL = 1.5  # times the most that a harmonic and lines beside it have together
_LARGEST_WANDER_RAD = 0.1  # at which harmonic 5 reads an eighth low

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Soundness:
    """Reasons why amplitudes, or ratios to the fundamental, are undefined; empty where they are defined."""

    of_amplitudes: str
    of_ratios: str


def soundness(spectrum: CoherentSpectrum, seen: Wander, invalid: str, name: str) -> Soundness:
    """Return whether the record is of one regime and on a phase, and the fundamental out of the noise;
    `invalid` is why it is not for other reasons."""
    reason = (
        invalid
        or change_of_regime(seen.amplitude, f"the amplitude of {name}")
        or _jump(seen, name)
        or _off_phase(seen, name)
    )
    amplitude = spectrum.fundamental
    noise = line_noise(spectrum, np.array([spectrum.periods])).in_phase.item()
    floor = math.sqrt(2.0) * harmonic_noise(spectrum, 1).item()
    if not amplitude > 0.0:
        return Soundness(reason, reason or "the fundamental is zero")
    if amplitude < STANDS_OUT * noise or amplitude < _ABOVE_FLOOR * floor:
        lost = f"the fundamental of {amplitude:.3g} does not stand out of the noise around it"
        return Soundness(reason, reason or lost)
    return Soundness(reason, reason)


def turned_around(
    coherent: CoherentSamples, seen: Wander, name: str, with_lines: CoherentSamples | None = None
) -> str:
    """Return why a record without an angle is of two regimes by its two strongest harmonics; empty if not.

    A current that reverses where it is greatest or least goes on as before, but for the phases of these.
    Lines beside a harmonic explain a phase that turns as well, where they and it cancel each other: then it
    is larger without them than it is anywhere in the record `with_lines`.
    """
    courses = _courses(coherent, seen)
    if courses is None:
        return ""
    means, noise = courses
    size = np.mean(np.abs(means), axis=0)
    change = np.max(np.abs(means[:, np.newaxis] - means), axis=(0, 1))
    turned = (change > _TURNS * size + STANDS_OUT * noise) & (size > STANDS_OUT * noise)
    if with_lines is not None and (courses := _courses(with_lines, seen)) is not None:
        means, noise = courses
        turned |= size > _CANCEL * np.max(np.abs(means), axis=0) + STANDS_OUT * noise
    for strongest in np.argsort(-size)[:2]:
        if turned[strongest]:
            return (
                f"harmonic {2 + strongest} of {name} turns against the fundamental between parts of the "
                f"window: it reversed or changed its load; choose a window in steady state"
            )
    return ""


def _courses(coherent: CoherentSamples, seen: Wander) -> tuple[NDArray[np.complex128], Floats] | None:
    """Return the phasors of harmonics from the second on against the fundamental in parts of a record, shape
    (parts, harmonics), and their noise; None of too short a record."""
    table = coherent.values.reshape(coherent.periods, coherent.per_period)
    highest = min(_HIGHEST_TURNED, coherent.per_period // 2 - 1)
    parts = min(_QUARTERS, coherent.periods // 2)
    if parts < 2:
        return None
    order = np.arange(2, highest + 1)
    phasors = fft.rfft(table, axis=1)[:, 2 : highest + 1] * np.exp(
        -1j * np.outer(seen.phase_rad[: coherent.periods], order)
    )
    groups = np.array_split(phasors, parts)
    means = np.array([np.mean(each, axis=0) for each in groups])
    noise = np.sqrt(np.mean([np.var(each, axis=0, ddof=1) / len(each) for each in groups], axis=0))
    return means, noise


def _jump(seen: Wander, name: str) -> str:
    if not seen.jump_rad:
        return ""
    if seen.jumps_alone:
        slipped = (
            "the encoder, its coupling or belt slipped, or lost counts"
            if seen.by_angle
            else "rows are missing or repeat others"
        )
        return (
            f"the phase of {name} jumps by {seen.jump_rad:.2g} rad from one period to the next, and its "
            f"amplitude and frequency stay: {slipped}, or the load changed; choose a window without it"
        )
    return (
        f"the phase of {name} jumps by {seen.jump_rad:.2g} rad from one period to the next: it reversed, "
        f"stood still or changed its load; choose a window in steady state"
    )


def _off_phase(seen: Wander, name: str) -> str:
    if not seen.excess_rad > _LARGEST_WANDER_RAD:
        return ""
    return f"the phase of {name} wanders by {seen.excess_rad:.2g} rad rms about the best track of it"
