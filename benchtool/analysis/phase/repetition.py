"""What moves the phase of a fundamental and is repeated by its harmonics, and what is a line beside it.

A phase that moves by x moves harmonic k by k x, whatever the amplitude does; an amplitude that moves, moves
all of them alike, and no phase; a line beside the fundamental moves the phase of that alone. So the phase of
each harmonic, less k times that of the fundamental, shows what the fundamental does by itself, and a drift of
the speed is not in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples
from benchtool.analysis.spectral_window import hann_response

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

FEWEST_PERIODS = 16
"""Periods of which it is told what harmonics repeat."""

_HIGHEST = 25
_STANDS_OUT = 12.0  # times the mean square of noise: by chance one frequency in 160000
_MOST = 2.0  # times what the fundamental does, of a line that motion does not cancel by chance
_CLEARLY, _NO_EVENT = 4.0, 2.0  # standard deviations; of a sum that one period makes it is one
_MOST_LINES, _PADDED = 8, 8
_SURELY = 2.0  # times what leaks, above which a harmonic is one
_LN_2 = math.log(2.0)  # median over mean of an exponential distribution


@dataclass(frozen=True)
class Repetition:
    """How the phase of the fundamental moves by the harmonics.

    `motion_rad`, rms, is repeated by them beyond chance, and `undecided_rad` what may be besides.
    `phase_rad`, shape (periods - 1,), is that of the fundamental where one period ends and the next begins,
    without what none of them repeats: a line beside it.
    """

    motion_rad: float
    undecided_rad: float
    phase_rad: Floats


def repetition(coherent: CoherentSamples) -> Repetition | None:
    """Return what the harmonics up to the 25th repeat of the phase of the fundamental; None where periods or
    harmonics are too few."""
    highest = min(_HIGHEST, int(coherent.usable_order), coherent.per_period // 2 - 1)
    if coherent.periods < FEWEST_PERIODS or highest < 2:
        return None
    phasors = _phasors(coherent, highest)
    first = phasors[:, 0]
    size = float(np.mean(np.abs(first)))
    lines = phasors[:, 1:] * np.exp(-1j * np.outer(np.angle(first), np.arange(2, highest + 1)))
    phase_rad, orders = np.unwrap(np.angle(first)), np.arange(2, highest + 1)
    mean, scatter2 = np.mean(lines, axis=0), np.var(lines, axis=0)
    # others may be what the fundamental leaks there, whose phase is no k-fold of its own
    known = np.abs(mean) ** 2 > scatter2 + (_SURELY * size * _leaked(phase_rad, orders)) ** 2
    moved = fft.rfft(phase_rad)[1:]
    to_rad2 = 2.0 / len(first) ** 2
    if not size > 0.0 or not np.any(known):
        return Repetition(0.0, math.sqrt(to_rad2 * float(np.sum(np.abs(moved) ** 2))), phase_rad)
    order, relative = orders[known], lines[:, known] / mean[known]
    of_first = fft.rfft(np.abs(first) / size)[1:]
    in_phase, quadrature = fft.rfft(relative.real, axis=0)[1:], fft.rfft(relative.imag, axis=0)[1:]
    beside, noise2 = _beside(in_phase, quadrature, of_first, order)
    # what harmonics do and the fundamental does not is no line beside that
    least2 = np.where(np.abs(beside) < _MOST * np.abs(moved), _STANDS_OUT * noise2, np.inf)
    stands_out = np.abs(beside) ** 2 > least2
    repeated, followed_rad = moved - beside, phase_rad - _as_lines(beside, least2, len(first))
    # what both have in common has no bias by noise, which is another in each
    power = np.where(stands_out, np.abs(repeated) ** 2 - noise2, np.real(moved * np.conj(repeated)))
    variance = np.where(stands_out, noise2**2, 0.5 * np.abs(moved) ** 2 * noise2)
    most = np.abs(np.where(stands_out, repeated, moved)) ** 2
    motion2, deviation = to_rad2 * float(np.sum(power)), to_rad2 * math.sqrt(float(np.sum(variance)))
    products = (followed_rad - np.mean(followed_rad)) * fft.irfft(np.append(0.0, repeated), len(first))
    is_event = float(np.sum(products)) < _NO_EVENT * math.sqrt(float(products @ products))
    return Repetition(
        math.sqrt(motion2) if motion2 > _CLEARLY * deviation and not is_event else 0.0,
        math.sqrt(min(max(0.0, motion2) + deviation, to_rad2 * float(np.sum(most)))),
        followed_rad,
    )


def _phasors(coherent: CoherentSamples, highest: int) -> Complex:
    """Return harmonics 1 to `highest` of each two neighbouring periods under a Hann window, which keeps other
    lines off, shape (periods - 1, orders)."""
    size = coherent.per_period
    table = coherent.values.reshape(coherent.periods, size)
    number = np.arange(2 * size)
    window = np.sin(np.pi / (2.0 * size) * number) ** 2 * (2.0 / size)
    turned = 2.0 * np.pi / size * np.outer(number, np.arange(1, highest + 1))
    found = []
    for part in (np.cos(turned), -np.sin(turned)):
        weights = window[:, np.newaxis] * part
        found.append((table @ weights[:size])[:-1] + (table @ weights[size:])[1:])
    return np.asarray(found[0] + 1j * found[1])


def _leaked(phase_rad: Floats, order: NDArray[np.int64]) -> Floats:
    """Return what a fundamental of amplitude 1 whose phase, shape (periods - 1,), turns against the periods
    leaks to harmonics, shape (orders,), by the spectrum of a Hann window."""
    turned = float(np.sqrt(np.mean(np.diff(phase_rad) ** 2))) / np.pi  # bins of two periods
    apart = np.stack([2.0 * (order - 1.0) - turned, 2.0 * (order + 1.0) + turned])
    return np.asarray(np.sum(np.abs(hann_response(apart)), axis=0))


def _beside(
    in_phase: Complex, quadrature: Complex, of_first: Complex, order: NDArray[np.int64]
) -> tuple[Complex, Floats]:
    """Return what moves the fundamental's phase alone, by frequency, and the mean square of its noise, both
    of shape (frequencies,): the mean of the harmonics, each weighted by its noise.

    That is the median over all frequencies, and no less than what the harmonic does in phase without the
    fundamental doing so or doing none of it: a line beside it does both alike.
    """
    count = len(quadrature)
    # Hann windows that overlap by half: neighbours are correlated by a sixth
    shape = 1.0 + np.cos(np.pi * np.arange(1, count + 1) / count) / 3.0
    by_itself = np.minimum(np.abs(in_phase) ** 2, np.abs(in_phase - of_first[:, np.newaxis]) ** 2)
    usual = np.median(np.abs(quadrature) ** 2, axis=0) / _LN_2
    noise2 = np.maximum(np.outer(shape, usual), by_itself)
    weights = order**2 / np.maximum(noise2, 1e-300)
    total = np.sum(weights, axis=1)
    return -np.sum(weights * quadrature / order, axis=1) / total, 1.0 / total


def _as_lines(beside: Complex, least2: Floats, count: int) -> Floats:
    """Return what is more than the `least2` square at its frequency as a sum of sinusoids, shape (count,).

    A sinusoid of no whole number of cycles is one frequency, and in a DFT many.
    """
    series, place = fft.irfft(np.append(0.0, beside), count), np.arange(count)
    found, turned = np.zeros(count), np.empty(0)
    for _ in range(_MOST_LINES):
        power = np.abs(fft.rfft(series - found)[1:]) ** 2
        largest = int(np.argmax(np.where(power > least2, power, 0.0)))
        if not power[largest] > least2[largest]:
            break
        first = _PADDED * largest + 1  # from the frequency below to that above
        fine = np.abs(fft.rfft(series - found, _PADDED * count))[first : first + 2 * _PADDED]
        turned = np.append(turned, 2.0 * np.pi / (_PADDED * count) * (first + int(np.argmax(fine))))
        angle = np.outer(place, turned)
        basis = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
        found = basis @ np.linalg.lstsq(basis, series, rcond=1e-6)[0]
    return np.asarray(found)
