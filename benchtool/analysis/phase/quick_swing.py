"""The phase of a fundamental within its periods, where load or speed swing within few of them.

The load of a compressor swings once in a revolution, of two to four periods, and amplitude and phase of its
current do. A mean over a period has less of a swing of f cycles in a period, sinc(f) of it, and beside it its
image at the negative frequency: f / (f - 2) of the conjugate, which makes a phase of what the amplitude does.
Both are known, and are taken back for swings of up to `_FASTEST` cycles in a period, by weights of means half
a period apart, by least squares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import FIRST_ROW, CoherentSamples
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.predicted_phase import prediction
from benchtool.analysis.phase.turned_phase import Turned
from benchtool.analysis.uncertainty import Contribution

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_FASTEST = 0.8  # cycles in a period
_TAPS = 8  # halves of a period, to either side
_FREQUENCIES = 401
_SIZES = (10, 14, 20, 28)  # phases that foresee the next: two revolutions of seven periods
_OF_FEW = (6, 8)  # where those are not told
FEWEST_FORESEEN = 23
"""Periods of which the fewest phases foresee the next one."""
_IS_NO_NOISE = 9.0  # times the mean square by which the next phase is missed
_HIGHEST = 25
_SLOWLY, _OFF_TRACK = 24, 0.01  # halves of a period; cycles in a period, by which harmonics leave their zeros


@dataclass(frozen=True)
class QuickSwing:
    """The phasor of a fundamental against a track, and its means over periods, at `rows` half a period apart,
    all of shape (n,); `harmonics` are the amplitudes from the first on, shape (orders,)."""

    rows: Floats
    phasor: Complex
    mean: Complex
    harmonics: Floats

    def turned(self, track: PhaseTrack, standard_rad: float, beside_rad: float) -> Turned | None:
        """Return the phase from the first to the last row of the track; None where means over periods, by
        which it is `standard_rad` uncertain, tell it as well: they are off the phase within them by no more
        than that, or than lines that are no sidebands put it off, `beside_rad`, and it is no surer with
        these. None, too, where they are off by what is noise, where a swing is not told, or where the
        frequency itself leaves that of the track.
        """
        off2 = float(np.var(np.angle(self.phasor * np.conj(self.mean))))
        phase_rad = np.unwrap(np.angle(self.phasor))
        if not _keeps_to_track(phase_rad):
            return None
        going_on = prediction(phase_rad, 0.0, _SIZES) or prediction(phase_rad, 0.0, _OF_FEW)
        if going_on is None or not off2 > _IS_NO_NOISE * going_on.missed2:
            return None
        rows, last = self.rows, track.samples - 1.0
        before, after = rows[0] / (rows[1] - rows[0]), (last - rows[-1]) / (rows[-1] - rows[-2])
        own_rad = float(going_on.weights(after) @ phase_rad[-going_on.size :])
        own_rad -= float(going_on.weights(before) @ phase_rad[::-1][-going_on.size :])
        ends = track.at(np.array([0.0, last]))
        foreseen = math.sqrt(going_on.error2(before) + going_on.error2(after))
        source = "phase within periods, and its continuation to both ends"
        budget = (
            Contribution(source, "A", foreseen, len(phase_rad) / 2.0),
            Contribution("harmonics that swing with it", "B", self._of_harmonics(phase_rad)),
            Contribution("what swings twice as fast", "B", self._twice_as_fast(phase_rad)),
        )
        found = Turned(float(ends[1] - ends[0]) + own_rad, budget, source)
        is_off = off2 > max(standard_rad, beside_rad) ** 2
        return found if is_off or math.hypot(found.standard, beside_rad) < standard_rad else None

    def _twice_as_fast(self, phase_rad: Floats) -> float:
        """Return what amplitude and phase that swing together make of a difference of two phases beyond what
        the weights take back, rad: lines at twice the frequency, about as large as the product of both."""
        size = np.abs(self.phasor) / float(np.mean(np.abs(self.phasor)))
        return _beyond(phase_rad, 0.5 * _FASTEST) * _beyond(size, 0.5 * _FASTEST)

    def _of_harmonics(self, phase_rad: Floats) -> float:
        """Return what harmonics that swing with the fundamental leave in the difference of two phases, rad.

        Of harmonic k, which swings k times as far, by f cycles in a period, a mean over that keeps
        sin(pi f) / (pi (k - 1)), and of its conjugate that by k + 1: half of what it changes by from period
        to period. Of odd harmonics means half a period apart keep it alike, so that at both ends it cancels
        as far as these changes are the same; of even ones its sign alternates, at one cycle in a period.
        """
        order = np.arange(2, min(_HIGHEST, len(self.harmonics)) + 1)
        size = np.abs(self.phasor) / float(np.mean(np.abs(self.phasor)))
        swing = size[:, np.newaxis] * np.exp(1j * np.outer(phase_rad, order))
        changes = 0.5 * (swing[2:] - swing[:-2])
        ends2 = 0.5 * np.abs(changes[-1] - changes[0]) ** 2
        changes2 = np.maximum(np.mean(np.abs(changes) ** 2, axis=0), ends2)
        alternating = np.exp(1j * np.pi * np.arange(2 * _TAPS + 1))
        gain = np.where(order % 2, 1.0, np.linalg.norm([alternating @ each for each in _weights()]))
        kept = np.hypot(1.0 / (order - 1.0), 1.0 / (order + 1.0)) / np.pi
        left = gain * kept * self.harmonics[order - 1] / self.harmonics[0]
        return float(np.linalg.norm(left * np.sqrt(changes2)))


def _beyond(values: Floats, cycles: float) -> float:
    """Return how far, rms, values half a period apart, shape (n,), swing by more cycles in a period."""
    swings = values - np.mean(values)
    power = np.abs(fft.rfft(swings * np.hanning(len(swings) + 2)[1:-1])) ** 2
    fast = float(np.sum(power[fft.rfftfreq(len(swings), 0.5) > cycles]))
    return math.sqrt(float(np.var(swings)) * fast / float(np.sum(power))) if fast > 0.0 else 0.0


def quick_swing(coherent: CoherentSamples, track: PhaseTrack, harmonics: Floats) -> QuickSwing | None:
    """Return how the fundamental swings within its periods about a track without a departure, of amplitudes
    of `harmonics` from the first on, shape (orders,); None of too few periods, or of none."""
    size, count = coherent.per_period, len(coherent.values)
    if coherent.periods <= _TAPS + 1 or not harmonics[0] > 0.0:
        return None
    turned = 2.0 * np.pi / size * np.arange(count)
    sums = np.concatenate([[0.0], np.cumsum(coherent.values * np.exp(-1j * turned))])
    means = (sums[size:] - sums[:-size]) * (2.0 / size)
    begin = 0.5 * size * np.arange(2 * coherent.periods - 1)
    numbers = np.arange(len(means), dtype=np.float64)
    halves = np.interp(begin, numbers, means.real) + 1j * np.interp(begin, numbers, means.imag)
    middle_rad = 2.0 * np.pi / size * (begin + 0.5 * (size - 1.0))
    own, image = _weights()
    inner = slice(_TAPS, -_TAPS)
    phasor = np.convolve(halves, own, "valid")
    phasor += np.exp(-2j * middle_rad[inner]) * np.convolve(np.conj(halves), image, "valid")
    first_rad = float(track.at(np.array([float(FIRST_ROW)]))[0])
    rows = track.sample_numbers(np.asarray(first_rad + middle_rad[inner], dtype=np.float64))
    return QuickSwing(rows, phasor, halves[inner], harmonics)


def _keeps_to_track(phase_rad: Floats) -> bool:
    """Return whether phases half a period apart, shape (n,), rise or fall slowly beside their swing: their
    course, and the parabola through all of them as far as the first and the last row."""
    if len(phase_rad) <= _SLOWLY:
        return False
    window = np.hanning(_SLOWLY + 2)[1:-1]
    course_rad = np.convolve(phase_rad, window / np.sum(window), "valid")
    parabola = np.polynomial.Polynomial.fit(np.arange(len(phase_rad)), phase_rad, 2)
    steepest = np.abs(parabola.deriv()(np.array([-_TAPS, len(phase_rad) + _TAPS])))
    most_rad = np.pi * _OFF_TRACK
    return bool(np.max(np.abs(np.diff(course_rad))) < most_rad and np.max(steepest) < most_rad)


@lru_cache(maxsize=1)
def _weights() -> tuple[Complex, Complex]:
    """Return the weights of means half a period apart, and of their conjugates, in the phasor in the middle,
    both of shape (2 `_TAPS` + 1,).

    Of means H (z + q(f) z*), H = sinc(f) and q = f / (f - 2), z is (means - q(f) means*) / H / (1 - q(f)
    q(-f)). A speed that swings turns the phase the further the slower it does: errors count by 1 / f.
    """
    cycles = np.linspace(-_FASTEST, _FASTEST, _FREQUENCIES)
    places = 0.5 * np.arange(-_TAPS, _TAPS + 1)
    basis = np.exp(-2j * np.pi * np.outer(cycles, places))
    image = cycles / (cycles - 2.0)
    own = 1.0 / (np.sinc(cycles) * (1.0 - image * image[::-1]))
    sought = np.stack([own, -image * own], axis=1).astype(np.complex128)
    of_speeds = 1.0 / (np.abs(cycles) + cycles[1] - cycles[0])[:, np.newaxis]
    found = np.linalg.lstsq(of_speeds * basis, of_speeds * sought, rcond=1e-9)[0]
    return np.asarray(found[:, 0]), np.asarray(found[:, 1])
