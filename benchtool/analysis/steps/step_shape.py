"""Locating a step of a reference and its levels; refusing references that are not a single step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.quantisation.counted_speed import (
    covariance_of_counts,
    is_counted,
    most_of_counts,
)
from benchtool.analysis.statistics.clicks import KnownClicks
from benchtool.analysis.statistics.outlying_samples import converter_step, without_clicks
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.plateau_noise import noise_of_plateau
from benchtool.analysis.steps.row_times import Repeats, even_hold, scatter_of_times
from benchtool.analysis.steps.slopes import without_drift
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.tails import without_course
from benchtool.analysis.steps.treads import HELD, answered_tread, long_tread
from benchtool.analysis.uncertainty import Uncertainty
from benchtool.analysis.validity import require_finite, require_signal, require_unbroken
from benchtool.block import Block
from benchtool.errors import AnalysisError

Floats = NDArray[np.float64]

TAIL = 0.1
"""Part of the window, at its end, where the final value and the noise are read."""

_OPPOSITE = 0.5  # of the height: the most that a step goes the other way
_QUARTERS = 0.25, 0.75
_AT_REST = 1e-3  # of the height: smaller deviations are not a transition
_SIGMAS = 3.0  # standard deviations of its noise, likewise
_LEAVES = 6.0  # standard deviations of its noise, which that does not reach
_ARRIVED = 0.9  # share of the samples from a step on, of which one in ten is beyond where it arrives
_WAY_UP, _EDGE = (0.1, 0.5), 2  # of the way an answer comes; rows between them of one that is as an edge
_FIRST_PEAKS = 20  # rows from there on
_EARLIER = 1.0 / 3.0  # rows: of many ticks


@dataclass(frozen=True)
class Step:
    """A step as if it went upwards: signal `y` and reference `r` are times `sign`, from its `begin` on.

    `begin` is the row in which the reference leaves its first level, `row` the one in which it has come half
    the way. `zero` is the instant of that, in samples from `begin`; the step is taken to be so much
    `earlier`, which is its standard uncertainty as well. `before`, `greatest` and `final` are levels of the
    reference, the last of its `tail` rows; `greatest_error` and `final_error` are the standard uncertainties
    that its noise leaves in these, and `r_errors`, shape (draws, n), what it may leave in `r`; without noise
    there are no draws. `y_clear` is the signal without its `clicks` samples that are far from their
    neighbours and its `repeats` of the one before, `known_clicks` are those of the former left out, `y_doubt`
    the standard uncertainty of what stands for the latter, `y_before` is the same up to the step, `r_before`
    the reference until then, and `of_plateau` the noise on the plateau if it is another than at rest. A speed
    `is_counted` where each sample is how far a counter has come since the one before. `shown_late` is for how
    long after a row it is shown at most, in rows.
    """

    y: Floats
    y_clear: Floats
    clicks: int
    known_clicks: KnownClicks
    repeats: int
    y_doubt: Floats
    y_before: Floats
    is_counted: bool
    of_plateau: Noise | None
    r: Floats
    r_before: Floats
    r_errors: Floats
    sign: float
    begin: int
    row: int
    zero: float
    earlier: float
    before: float
    greatest: float
    greatest_error: float
    tail: int
    final: float
    final_error: float
    shown_late: float
    period_s: float
    unit: str
    basis: Basis

    def number(self, name: str, definition: str, value: float, uncertain: Uncertainty | None) -> Measurement:
        """Return a number of the step in the signal's unit."""
        return Measurement(name, value, self.unit, definition, self.basis, uncertain)

    @cached_property
    def converter_step(self) -> float:
        """Step of a converter in the signal; 0 without one."""
        return converter_step(self.y)

    @property
    def level_step(self) -> float:
        """Step of the levels that the curve is read on, sample by sample: no counts, of which the next sample
        has what one lacks."""
        return 0.0 if self.is_counted else self.converter_step

    @cached_property
    def y_noise(self) -> Noise:
        """Noise at rest, before the step and in the last rows; a drift that both have is none, nor an answer
        that is still on its way."""
        before = self.y_before[: self.begin]
        last = without_course(self.y_clear, self.tail, before)
        return self.noise_of(*without_drift(before, last))

    @cached_property
    def time_scatter(self) -> float:
        """Standard deviation of the times of the samples, in rows: what repeats the row before is not in the
        curve and among the samples. 0 without."""
        is_late = (self.y != self.y_clear) & (np.diff(self.y, prepend=math.nan) == 0.0)
        return scatter_of_times(self.y, self.y_noise, self.converter_step) if np.any(is_late) else 0.0

    def noise_of(self, *pieces: Floats) -> Noise:
        """Return the noise of the signal by samples at rest. That of counts is another at each speed: on the
        way to them it is that of all."""
        found, step = Noise.of(*pieces), self.converter_step
        most = most_of_counts(step)
        if not self.is_counted or found.rms > most:
            return found
        return Noise(covariance_of_counts(step), as_line=most)

    @property
    def plateau_noise(self) -> Noise:
        """Noise on the plateau."""
        return self.y_noise if self.of_plateau is None else self.of_plateau

    @property
    def holds(self) -> int:
        """Row from `begin` on from which the reference is near its greatest value."""
        return int(np.argmax(self._near_greatest))

    @property
    def leaves(self) -> int:
        """Row in which it falls from there, and the number of rows if it does not."""
        left = np.flatnonzero(~self._near_greatest[self.holds :])
        return self.holds + int(left[0]) if len(left) else len(self.r)

    @property
    def fall(self) -> int:
        """Row in which a pulse falls; 0 of a step, which has no fall."""
        return self.leaves if self.leaves < len(self.r) else 0

    @property
    def _near_greatest(self) -> NDArray[np.bool_]:
        return self.r >= self.greatest - HELD * self.height

    @property
    def height(self) -> float:
        return self.greatest - self.before


def find_step(block: Block, signal: str, reference: str, *, held: bool = False) -> Step:
    """Return the one step of a reference and the signal that answers it.

    The step is where the reference first leaves its first value by half of its greatest excursion, so that
    a ramp counts from its middle: between two samples if it is on its way in both, otherwise at its row. The
    record does not show whether a step was made at its row or anywhere within the row before: a third of a
    row before it is off by a third of a row rms in both cases. A reference that is `held`, as a drive holds
    its own from tick to tick, changes at one of the ticks since the row before: at its row exactly where each
    tick is a row. A reference
    that falls back after a while is a pulse and allowed. Of a signal that is held for several rows one sample
    of each is taken.

    Raises:
        AnalysisError: a gap, a missing channel, a dead signal, units that differ, no step, or more than one.
    """
    require_unbroken(block)
    y, r = block.column(signal), block.column(reference)
    require_signal(y, signal)
    require_finite(r, reference)
    unit, other = block.unit(signal), block.unit(reference)
    if unit != other:
        raise AnalysisError(
            f"'{signal}' is in {unit or 'no unit'} and '{reference}' in {other or 'no unit'}, "
            f"a step response needs one unit: convert one of the two, or choose the signal's own reference"
        )
    tail = max(1, round(TAIL * len(r)))
    row = _step_row(r, reference)
    r_noise = Noise.of(r[-tail:])
    sign = 1.0 if np.max(r) - r[0] >= r[0] - np.min(r) else -1.0
    y, r = sign * y, sign * r
    r, greatest, greatest_error, r_errors = _without_noise(r, row, r_noise)
    before = float(r[0])
    _require_one_step(sign, r, before, greatest, reference, unit)
    begin, zero = _begin(r, row, r_noise.rms)
    earlier = _earlier(block, held=held) * float(r[row] - r[row - 1]) / (greatest - before)
    held_rows, first = even_hold(y)
    y, r = y[first::held_rows], r[first::held_rows]
    way, answer = ((each - before) / (greatest - before) for each in (r, y))
    if (level := answered_tread(way, answer)) is not None:
        raise _is_staircase(sign, before, level, greatest, reference, unit)
    instant = (begin + zero - first) / held_rows
    begin = math.ceil((begin - first) / held_rows)
    if begin >= len(y):
        raise AnalysisError(
            f"no sample of '{signal}', each held for {held_rows} rows, follows the step in row {row}: record "
            f"for longer after it"
        )
    tail = max(1, round(TAIL * len(r)))
    repeats = Repeats.among(y, Noise.of(y[:begin], y[-tail:]), converter_step(y))
    clear, clicks = _without_clicks(repeats.without, begin)
    rate_Hz, after = block.sample_rate_Hz / held_rows, len(y) - begin
    against = (
        f"{signal} against {reference}, which goes from {sign * before:.6g} to {sign * greatest:.6g} "
        f"{unit} in row {row}, where it has come half the way"
    )
    if held_rows > 1:
        against += f"; each sample of {signal} is held for {held_rows} rows"
    return Step(
        y=y[begin:],
        y_clear=clear[begin:],
        clicks=clicks,
        known_clicks=_known_clicks(repeats.without, clear, begin),
        repeats=repeats.count,
        y_doubt=repeats.doubt[begin:],
        y_before=clear[: max(1, begin)],
        is_counted=is_counted((clear[:begin], clear[-tail:]), converter_step(y)),
        of_plateau=_noise_of_plateau(clear, r, begin, greatest, tail, y),
        r=r[begin:],
        r_before=r[: max(1, begin)],
        r_errors=r_errors[:, first::held_rows][:, begin:],
        sign=sign,
        begin=begin,
        row=row,
        zero=instant - begin,
        earlier=earlier / held_rows,
        before=before,
        greatest=greatest,
        greatest_error=greatest_error,
        tail=tail,
        final=float(np.mean(r[-tail:])),
        final_error=r_noise.of_mean(tail),
        shown_late=1.0 if held_rows > 1 else 0.0,
        period_s=1.0 / rate_Hz,
        unit=unit,
        basis=Basis(after, rate_Hz, after / rate_Hz, 0.5 * rate_Hz, reference=against, gaps=0),
    )


def _noise_of_plateau(
    clear: Floats, r: Floats, begin: int, greatest: float, tail: int, y: Floats
) -> Noise | None:
    """Return the noise of the later half of the plateau of a signal without clicks, shape (n,), and with
    them, if it is not that before the row `begin` and, of a pulse, in its last rows."""
    height = greatest - float(r[0])
    far = r[begin:] < greatest - HELD * height
    holds = int(np.argmin(far))
    length = int(np.argmax(np.append(far[holds:], True)))
    is_pulse = holds + length < len(far)
    late = slice(begin + holds + length // 2, begin + holds + length)
    at_rest = [clear[:begin], *([clear[-tail:]] if is_pulse else [])]
    return noise_of_plateau(clear[late], at_rest, height, converter_step(y))


def _without_clicks(y: Floats, begin: int) -> tuple[Floats, int]:
    """Return a signal that rises from row `begin` on, shape (n,), without its clicks, and their number.

    Of an answer that is up within two rows the first peaks are as short as clicks are, and are none.
    """
    clear, clicks = without_clicks(y)
    if not clicks:
        return clear, 0
    rest, answer = float(np.median(clear[: max(1, begin)])), clear[begin:]
    height = float(np.quantile(answer, _ARRIVED)) - rest
    leaves, half = (int(np.argmax(answer >= rest + share * height)) for share in _WAY_UP)
    if half - leaves <= _EDGE:
        peaks = slice(begin + leaves, begin + half + _FIRST_PEAKS)
        clicks -= int(np.count_nonzero(clear[peaks] != y[peaks]))
        clear = clear.copy()
        clear[peaks] = y[peaks]
    return clear, clicks


def _known_clicks(y: Floats, clear: Floats, begin: int) -> KnownClicks:
    """Return the clicks of a signal, shape (n,), that it is `clear` of, with their places from a row on. A
    row that repeats the one before is beyond a course without noise, too, and is none."""
    is_click = y != clear
    repeats = is_click & (np.diff(y, prepend=math.nan) == 0.0)
    repeats[1:] &= ~is_click[:-1]
    places = np.flatnonzero(is_click & ~repeats)
    return KnownClicks((y - clear)[places], places - begin, len(y))


def _without_noise(r: Floats, row: int, noise: Noise) -> tuple[Floats, float, float, Floats]:
    """Return a reference, shape (n,), that rises by about half its way in `row`, without its noise; its
    greatest value, the mean of those that noise may make it, with the standard uncertainty of that; and
    what noise may have left in all, shape (draws, n)."""
    if not noise.rms > 0.0:
        return r, float(np.max(r)), 0.0, np.empty((0, len(r)))
    curve = NoisyCurve.through(r[row:], noise)
    top = int(np.argmax(curve.values))
    near = curve.values >= curve.values[top] - 2.0 * _SIGMAS * curve.standard
    greatest = float(np.mean(r[row:][near]))
    rest = r[:row].copy()
    still = int(np.argmax(np.append(rest - rest[0] > _LEAVES * noise.rms, True)))
    rest[:still] = np.mean(rest[:still])
    left = np.pad(curve.errors, ((0, 0), (row, 0)))
    smooth = np.concatenate([rest, curve.values])
    return smooth, greatest, noise.of_mean(int(np.count_nonzero(near))), left


def _earlier(block: Block, *, held: bool) -> float:
    """Return by how much before its row a step is taken to be, and the standard uncertainty of that, in rows.

    The recorder may run with the steps, which are at their row then, or not, and they are at any of the ticks
    since the row before: the rms distance from E(v^2) / (2 E(v)) before the row, v evenly distributed over
    these, is as much in either case.
    """
    ticks = block.stride
    if not held:
        return _EARLIER
    return (2.0 * ticks - 1.0) / (6.0 * ticks) if ticks > 1 else 0.0


def _step_row(reference: Floats, name: str) -> int:
    excursion = np.abs(reference - reference[0])
    greatest = float(np.max(excursion))
    if not greatest > 0.0:
        raise AnalysisError(
            f"'{name}' holds {reference[0]:g} over {len(reference)} samples, a step is needed: "
            f"record across it"
        )
    return int(np.argmax(excursion >= 0.5 * greatest))


def _begin(r: Floats, row: int, noise: float) -> tuple[int, float]:
    """Return the row in which a reference leaves its first level, and the instant of half the way in samples
    from it."""
    height = float(np.max(r) - r[0])
    rest = np.flatnonzero(r[:row] - r[0] <= _AT_REST * height + _SIGMAS * noise)
    begin = int(rest[-1]) + 1
    if begin == row:
        return row, 0.0
    short = 0.5 * height - float(r[row - 1] - r[0])
    return begin, row - 1 - begin + short / float(r[row] - r[row - 1])


def _require_one_step(sign: float, r: Floats, before: float, greatest: float, name: str, unit: str) -> None:
    """Refuse staircases, square waves and doublets: numbers of a step mean nothing there. The reference `r`
    is times `sign`, so that it rises."""
    if not greatest > before:
        raise AnalysisError(
            f"'{name}' has no step that stands out of its own noise, one is needed: record across it"
        )
    way = (r - before) / (greatest - before)
    low, high = _QUARTERS
    side = np.where(way >= high, 1, np.where(way <= low, 0, -1))
    rises = int(np.count_nonzero(np.diff(side[side >= 0]) > 0))
    if rises > 1:
        raise AnalysisError(
            f"'{name}' rises {rises} times by {greatest - before:.4g} {unit}, one step is needed: record or "
            f"choose a window with one"
        )
    if (least := float(np.min(way))) < -_OPPOSITE:
        raise AnalysisError(
            f"'{name}' goes by {greatest - before:.4g} {unit} one way and by "
            f"{-least * (greatest - before):.4g} {unit} the other, a single step is needed: record one"
        )
    if (level := long_tread(way)) is not None:
        raise _is_staircase(sign, before, level, greatest, name, unit)


def _is_staircase(
    sign: float, before: float, level: float, greatest: float, name: str, unit: str
) -> AnalysisError:
    """Return the refusal of a reference with a tread at a `level` of its way."""
    return AnalysisError(
        f"'{name}' rests near {sign * (before + level * (greatest - before)):.4g} {unit} on its way to "
        f"{sign * greatest:.4g} {unit}, a single step is needed: record each step of a staircase by itself"
    )
