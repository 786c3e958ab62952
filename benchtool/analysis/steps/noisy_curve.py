"""The smooth curve through a noisy transient, and the uncertainty of values read off it.

Noise with the measured spectrum is smoothed like the samples and added to the curve repeatedly; the scatter
of the values then read off is their uncertainty (parametric bootstrap: Efron and Tibshirani, An Introduction
to the Bootstrap, 6.5). The random numbers are the same at every call, so that the same samples give the same
numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.distributions import least_odds
from benchtool.analysis.quantisation.read_noise import noise_of_readings
from benchtool.analysis.quantisation.repeated_steps import noise_beside, share_left
from benchtool.analysis.statistics.outlying_samples import converter_step
from benchtool.analysis.steps.bursts import noise_and_levels, residual_levels
from benchtool.analysis.steps.converter_levels import HIDES, at_turns, within_levels
from benchtool.analysis.steps.crests import rms_beyond_crests
from benchtool.analysis.steps.lobes import Lobes
from benchtool.analysis.steps.passages import (
    LEAST_DEFINED,
    SEED,
    Instant,
    Passage,
    first_passage,
    first_passages,
    last_passage,
    last_passages,
    places_of,
    rising,
)
from benchtool.analysis.steps.row_times import scatter_of_times
from benchtool.analysis.steps.settled_course import SettledCourse
from benchtool.analysis.steps.smoothing import Noise, UnevenNoise, fitted_smoothers
from benchtool.analysis.steps.tops import Top, kink, of_three, parabola, quartic
from benchtool.analysis.steps.tops_on_levels import (
    is_on_level,
    middle_of_level,
    read_back,
    rows_of_level,
)

Floats = NDArray[np.float64]

CALM = 5.0
"""Standard uncertainties of the curve that noise alone hardly ever leaves."""

_OF_BIAS = 0.5  # of a bend a quarter, as of (3/2)^4 - 1; of an edge more
_DRAWS = 80
_FEWEST_DRAWS = 20
_MOST_VALUES = 1 << 24  # of all draws together, 128 MiB
_TIED = 3.0  # standard deviations of the greatest value, and of another that may also be the greatest
_TOGETHER, _DEGREE = 0.5, 2  # of the rows from the first to the last that are tied; of the curve through them
_EVEN = 1e-3  # rows that their times scatter by: as much as rounding
_OF_WINDOWS = 0.05  # of the noise: as much where there is less leaves windows beside it long enough
_HIDES_ALL = 0.41  # of a step: noise that is read as half of one on average
_SURE = 2.0  # standard deviations beyond a level that noise does not reach


def at_rest_error(at_rest: Floats, step: float) -> float:
    """Return the standard uncertainty that a converter's `step` leaves in the mean of samples `at_rest`; 0
    where noise hides it, or there is no converter."""
    return left_of_steps(noise_of_readings(at_rest, step), step)


def left_of_steps(noise: float, step: float) -> float:
    """Return the standard uncertainty that a converter's `step` leaves in the mean of samples under noise of
    this rms; 0 where that hides it."""
    return share_left(noise, step) * step / math.sqrt(12.0) if noise < _HIDES_ALL * step else 0.0


@dataclass(frozen=True)
class NoisyCurve:
    """Smooth `values`, shape (n,), and `errors`, shape (draws, n), that noise may cause in them.

    Without noise there are no draws. `time_scatter` is the standard deviation of the times of the samples, in
    rows, and `longer`, shape (n,), the curve under longer windows, if there is one. `before`, shape (draws,),
    is what the same noise makes of the mean of the samples before the first. `turned`, shape (draws, n), is
    what is added to errors where noise does not hide the steps of a converter and the curve turns back within
    a level of it; None otherwise. `beside`, shape (n,), is how much of the noise the samples have about the
    curve, if any is smoothed, and `uneven` that noise, if it is not the same on a plateau and at rest.
    """

    values: Floats
    errors: Floats
    time_scatter: float = 0.0
    longer: Floats | None = None
    before: Floats | None = None
    turned: Floats | None = None
    beside: Floats | None = None
    uneven: UnevenNoise | None = None

    @classmethod
    def through(
        cls,
        samples: Floats,
        noise: Noise,
        before: int = 0,
        of_plateau: Noise | None = None,
        step: float | None = None,
        doubt: Floats | float = 0.0,
    ) -> NoisyCurve:
        """Return the curve through samples, shape (n,), the first of which is where a transient begins; there
        were so many `before`, with the `noise` at rest, which need not be that `of_plateau`. The `step` of
        levels that each is read on is, where it is not stated, that which they show.

        Where noise does not hide the steps of a converter, what is read as one of its levels may be anywhere
        within half a step of it, or within what the noise leaves of that. Where the times of the samples
        scatter, each is off by that times the slope of the curve; `doubt`, shape (n,), is by how much more.
        """
        count, shown = len(samples), converter_step(samples)
        step = shown if step is None else step
        at_rest = noise
        noise, levels = noise_and_levels(samples, noise, of_plateau)
        of_windows = np.maximum(levels, _OF_WINDOWS)
        smoother, longer = fitted_smoothers(samples, noise, of_windows)
        draws = max(_FEWEST_DRAWS, min(_DRAWS, _MOST_VALUES // count))
        random = np.random.default_rng(SEED)
        of_steps: float | Floats = 0.0
        if noise.rms < HIDES * step:
            of_steps = _left_of_steps(noise.rms, step) * within_levels(random, samples, step, draws)
        scatter = scatter_of_times(samples, noise, shown)
        if noise.rms == 0.0:
            of_times = _of_times(random, samples, scatter, draws, doubt)
            if isinstance(of_steps, float):
                known = scatter == 0.0 and not np.any(doubt)
                return cls(samples, np.empty((0, count)) if known else of_times, scatter)
            at_levels = at_turns(random, samples, step, of_steps) - of_steps
            return cls(samples, of_steps + of_times, scatter, turned=at_levels)
        drawn = noise.draw(random, (draws, before + count))
        of_before = np.mean(drawn[:, :before], axis=1) if before else None
        if of_before is not None and of_plateau is not None:
            of_before *= at_rest.rms / noise.rms
        drawn = levels * drawn[:, before:]
        errors, curve = smoother.apply(drawn), smoother.apply(samples)
        turned: Floats | None = None
        if isinstance(of_steps, np.ndarray):
            turned = smoother.apply(at_turns(random, samples, step, of_steps) - of_steps)
            of_steps = smoother.apply(of_steps)
        if scatter or np.any(doubt):
            errors += smoother.apply(_of_times(random, curve, scatter, draws, doubt))
        blunt = longer.apply(samples)
        bias = _OF_BIAS * (blunt - curve)
        beside = np.std(drawn - errors, axis=0) / np.std(drawn, axis=0)
        louder = residual_levels((samples - curve) / of_windows, noise.rms)
        errors *= louder
        errors += of_steps + random.standard_normal((draws, 1)) * bias
        uneven = None if of_plateau is None else UnevenNoise(noise, levels)
        return cls(curve, errors, scatter, blunt, of_before, turned, beside, uneven)

    def against(self, sign: float, reference: Floats | float = 0.0) -> NoisyCurve:
        """Return the curve, and what noise makes of it, less a reference, shape (n,), times a sign."""
        longer = None if self.longer is None else sign * (self.longer - reference)
        values = sign * (self.values - reference)
        turned = None if self.turned is None else sign * self.turned
        return replace(self, values=values, errors=sign * self.errors, longer=longer, turned=turned)

    def beyond(self, level: float) -> NoisyCurve:
        """Return the curve less the `level` that the samples before it had, with what noise makes of the
        difference: the slowest moves both alike."""
        of_level = 0.0 if self.before is None else self.before[:, np.newaxis]
        return replace(self, values=self.values - level, errors=self.errors - of_level)

    @property
    def is_on_levels(self) -> bool:
        """Whether the errors are those of a converter's steps alone."""
        return self.turned is not None and self.beside is None

    @property
    def _turning(self) -> Floats:
        """Errors where the curve may turn back within a level of a converter."""
        return self.errors if self.turned is None else self.errors + self.turned

    @cached_property
    def standard(self) -> Floats:
        """Standard uncertainty at every sample, shape (n,)."""
        return np.std(self.errors, axis=0) if len(self.errors) else np.zeros(len(self.values))

    def drifting(self, doubt: float, before: int = 0) -> NoisyCurve:
        """Return the curve with a drift, of this standard deviation per sample, among what may be in it, and
        in the mean of so many samples `before` it."""
        if not doubt > 0.0:
            return self
        errors = self.errors if len(self.errors) else np.zeros((_DRAWS, len(self.values)))
        drifts = doubt * np.random.default_rng(SEED).standard_normal(len(errors))
        level = (0.0 if self.before is None else self.before) - 0.5 * before * drifts
        errors = errors + drifts[:, np.newaxis] * np.arange(len(self.values))
        return replace(self, errors=errors, before=level)

    def since(self, row: int) -> NoisyCurve:
        """Return the part of the curve from a row onwards."""
        longer = None if self.longer is None else self.longer[row:]
        turned = None if self.turned is None else self.turned[:, row:]
        values, errors = self.values[row:], self.errors[:, row:]
        return replace(self, values=values, errors=errors, longer=longer, turned=turned)

    def blunted(self) -> tuple[float, float]:
        """Return by how much longer windows lower the peak of the greatest value, and how much later they
        make it, in rows.

        At a corner what windows do to both is in proportion to their length, so that as long ones are half as
        much longer it is twice this; of a smooth peak it is a quarter, as of (3/2)^4 - 1.
        """
        top = int(np.argmax(self.values))
        if self.longer is None or not 0 < top < len(self.values) - 1:
            return 0.0, 0.0
        at = top
        while 0 < at < len(self.longer) - 1:
            beside = at + 1 if self.longer[at + 1] > self.longer[at - 1] else at - 1
            if self.longer[beside] <= self.longer[at]:
                break
            at = beside
        sharp, blunt = parabola(self.values, top), parabola(self.longer, at)
        lower = self.values[top] + sharp.above - self.longer[at] - blunt.above
        return float(lower), at + blunt.beside - top - sharp.beside

    def greatest(self, *, kinked: bool = False, begin: int = 0) -> tuple[float, float]:
        """Return the greatest value, from a row on, and its standard uncertainty.

        Noise raises the greatest of several similar values, and this bias is subtracted: what it does to
        those that three standard deviations of both make as great (Chernozhukov, Lee and Rosen, Econometrica
        81 (2013) no. 2), on the parabola through them. As if they were equal, a peak would be lowered by what
        only a plateau has; on the curve as it is, whose own noise tells them apart, a plateau hardly would.
        The less likely noise makes that parabola as high as the curve is, the more the middle of both is
        taken. What the course between samples adds is added: at a kink, which the curve may have where it is
        `kinked`, or on a parabola. A curve with kinks may have a low crest beside a plateau, too.
        """
        values, errors = self.values[begin:], self.errors[:, begin:]
        greatest = float(np.max(values))
        vertex = self._vertex(begin + int(np.argmax(values)), kinked=kinked)
        between, unknown = vertex.above, vertex.above_error
        if not len(errors):
            return greatest + between, unknown
        within = _TIED * self.standard[begin:]
        tied = np.flatnonzero(values + within >= np.max(values - within))
        # a parabola through a plateau does not bend as its ends do
        shape = np.minimum(_shape(values, tied), values[tied] + _SURE * self.standard[begin:][tied])
        highest = np.max(shape + errors[:, tied], axis=1)
        bias = float(np.mean(highest) - np.max(shape))
        as_it_is = float(np.mean(np.max(values + errors, axis=1))) - greatest
        as_high = np.count_nonzero(highest >= greatest)
        share = 0.5 + 0.5 * least_odds((1.0 + as_high) / (1.0 + len(highest)))
        # anywhere between both, evenly, and which of both
        between_both = (bias - as_it_is) * math.sqrt(1.0 / 12.0 + share * (1.0 - share))
        of_highest = float(np.std(highest, ddof=1))
        of_row = float(self.standard[begin + int(np.argmax(values))])
        falls = float(np.max(shape)) - max(float(shape[0]), float(shape[-1]))
        if kinked and falls < _TIED * of_row:  # a crest beside a plateau has the noise of one row
            of_highest = max(of_highest, of_row)
        of_noise = math.hypot(of_highest, between_both)
        bias = share * bias + (1.0 - share) * as_it_is
        return greatest + between - bias, math.hypot(of_noise, unknown)

    def least_after_greatest(self) -> tuple[float, float]:
        """Return the least value after the greatest, and its standard uncertainty.

        Of peaks alike any may be the greatest: what follows each counts by how often the draws make it that.
        Of several runs of rows on the highest level of a converter, either noise that is less than a step has
        read that level there and back, and the greatest is in the last, or the curve has turned back within
        it, and the first holds it: one is as likely as the other.
        """
        top = int(np.argmax(self.values))
        after = np.minimum.accumulate(self.values[::-1])[::-1]
        if self.is_on_levels:
            tops = np.array([top, rows_of_level(self.values, top)[1]])
        else:
            tops = np.argmax(self.values + self.errors, axis=1) if len(self.errors) else np.array([top])
        levels, counts = np.unique(after[tops], return_counts=True)
        begins = [int(np.max(np.extract(after[tops] == level, tops))) for level in levels]
        turned = self.against(-1.0)
        found = np.array([turned.greatest(kinked=True, begin=begin) for begin in begins])
        shares = counts / len(tops)
        least, _ = turned.greatest(kinked=True, begin=top)
        if self.is_on_levels:
            least = float(shares @ found[:, 0])
        square = found[:, 1] ** 2 + (found[:, 0] - least) ** 2
        return -least, math.sqrt(float(shares @ square))

    def place_of_greatest(self) -> Instant:
        """Return where the greatest value is, between samples by a kink or a parabola."""
        top = int(np.argmax(self.values))
        smoothed = self.beside is not None and bool(self.beside[top] > 0.0)
        if not smoothed and is_on_level(self.values, top):
            middle, standard = middle_of_level(self.values, top)
            return Instant(middle, standard, of_rows=standard)
        vertex = self._vertex(top, kinked=True)
        place = top + vertex.beside
        # of a draw the parabola stands for a kink too: what both differ by is no noise
        smooth = top + parabola(self.values, top).beside
        first, last = rows_of_level(self.values, top)
        if first < last:  # means of readings on levels that happen to be alike, or are of one level
            place = smooth = 0.5 * (first + last)
        drawn = self.values + self._turning
        tops = np.argmax(drawn, axis=1) if len(drawn) else np.empty(0, dtype=np.int64)
        moved = [at + parabola(each, int(at)).beside - smooth for each, at in zip(drawn, tops, strict=True)]
        of_noise = float(np.sqrt(np.mean(np.square(moved)))) if moved else 0.0
        of_rows = vertex.beside_within / math.sqrt(3.0)
        return Instant(place, math.hypot(of_noise, of_rows), of_rows=of_rows)

    def greatest_elsewhere(self, reach: int) -> float:
        """Return the rms distance of the greatest value where noise puts it further away than so many rows,
        over all draws."""
        if not len(self.errors):
            return 0.0
        away = np.argmax(self.values + self.errors, axis=1) - float(np.argmax(self.values))
        return float(np.sqrt(np.mean(np.where(np.abs(away) > reach, away, 0.0) ** 2)))

    def _vertex(self, top: int, *, kinked: bool) -> Top:
        """Return the course between samples about the greatest."""
        if not kinked:
            return parabola(self.values, top)
        found = kink(self.values, top, float(self.standard[top]))
        # levels of a converter, and rows at other times, bend a curve otherwise than its modes
        if found is None and not self.is_on_levels and self.time_scatter < _EVEN:
            found = quartic(self.values, top) or of_three(self.values, top, float(self.standard[top]))
        return found or parabola(self.values, top)

    def first_above(self, level: float | Floats) -> Instant | None:
        """Return where the curve first rises to a level, or to one that is of shape (n,); None if it does
        not, and before the first sample where that is above already.

        Until the curve is beyond the level by more than the noise, it may cross repeatedly: the instant is
        placed after as many samples as lie below the level. A trough that noise does not make ends that. That
        noise alone may make a crest pass the level, or keeps it below, is in the uncertainty.
        """
        found = self.passage(level)
        return None if found is None else found.instant

    def passage(self, level: float | Floats, doubt: float = 0.0) -> Passage | None:
        """Return `first_above` with what every draw makes of it, so that differences of two are drawn too.

        The level is anywhere within sqrt(3) times `doubt`, its standard uncertainty, in a draw the same at
        every call.
        """
        above, sure = self.values - level, _SURE * self.standard
        found = first_passage(above, sure)
        if found is None:
            return None
        within = math.sqrt(3.0) * doubt
        moved = np.random.default_rng(SEED).uniform(-within, within, len(self.errors)) if doubt else ()
        shifted = self.errors - np.reshape(moved, (-1, 1)) if doubt else self.errors
        course = rising(above, sure) if len(shifted) else above
        places = places_of(first_passages(course + shifted, sure))
        of_crests = 0.0
        if len(shifted):
            of_crests = rms_beyond_crests(above, course, self.errors, self.standard, found.place, places)
        return Passage(found.place, found.reach, places, of_crests)

    def rise(self, low: float, high: float) -> Instant | None:
        """Return how long the curve takes from its first rise to a level to that to a higher one; None if it
        does not reach it.

        What the errors move both by cancels.
        """
        lower, upper = self.passage(low), self.passage(high)
        if lower is None or upper is None:
            return None
        wide = math.hypot(lower.reach, upper.reach) / math.sqrt(3.0)
        duration = upper.place - lower.place
        moved = upper.places - lower.places - duration
        moved = moved[np.isfinite(moved)]
        if len(moved) < LEAST_DEFINED * len(self.errors):
            return Instant(duration, math.inf)
        noise = float(np.sqrt(np.mean(np.square(moved)))) if len(moved) else 0.0
        of_crests = math.hypot(lower.of_crests, upper.of_crests)
        return Instant(duration, math.hypot(noise, wide, of_crests), of_rows=wide)

    def last_outside(self, level: float, band: float, since: int = 0) -> Instant | None:
        """Return where the curve enters `level` +- `band` finally, 0 if it never leaves; None if it ends
        outside.

        A curve that turns back just within a level of a converter may leave the band there or not: which it
        is, is what most draws make of it. Where noise reads the last level outside there and back, the curve
        enters after as many rows as are outside. That noise alone may make the last lobe leave the band, or
        keeps it within, is in the uncertainty. Where the curve leaves the band once more while it still
        rings, by noise or by itself, the instant is half way between both entries.
        """
        if len(self.errors) and not self.is_on_levels:
            return self._settled(self.values - level, band, since)
        found = last_passage(self.values, level, band)
        if found is None:
            return None
        errors = self._turning if self.is_on_levels else self.errors
        places = places_of(last_passages(self.values + errors, level, band))
        is_either = self.is_on_levels and not np.all(np.isnan(places))
        most = float(np.nanmedian(places)) if is_either else found.place
        instant = Passage(most, found.reach, places).instant
        last = math.ceil(most) - 1
        if not self.is_on_levels or not 0 <= last < len(self.values) - 1:
            return instant
        again, rows = read_back(self.values, last)  # by noise that rows at rest do not show
        standard = math.hypot(instant.standard, rows / math.sqrt(12.0))
        return replace(instant, place=instant.place - again, standard=standard)

    def _settled(self, away: Floats, band: float, since: int) -> Instant | None:
        """Return `last_outside` of a curve so far `away` from its level, shape (n,), that noise moves."""
        settled = SettledCourse.of(away, self.errors, self.standard, band, since)
        course = settled.without_noise(away)
        found = last_passage(course, 0.0, band)
        if found is None:
            return None
        if settled.leaves_late(course):  # itself, or by a rare burst of its noise
            return Instant(found.place, math.inf)
        drawn = settled.all_without_noise(course + self.errors)
        rings = settled.with_rises(course, away)
        lobes = Lobes.of(rings, self.standard, settled.most_soon)
        entries = places_of(last_passages(drawn, 0.0, band))
        entry = lobes.entries(found.place, entries, self.errors, band)
        instant = Passage(entry.expected, found.reach, entry.drawn).instant
        instant = replace(instant, likeliest=entry.likeliest)
        # it falls and is there at once, or rises in between and is there later: one is as likely as the other
        later = last_passage(rings, 0.0, band)
        if later is None or entry.likeliest != found.place or lobes.at(later.place) != lobes.at(found.place):
            return instant
        of_rise = 0.5 * max(0.0, later.place - found.place)
        place, likeliest = entry.expected + of_rise, entry.likeliest + of_rise
        standard = math.hypot(instant.standard, of_rise)
        return replace(instant, place=place, standard=standard, likeliest=likeliest)


def _shape(values: Floats, rows: NDArray[np.int64]) -> Floats:
    """Return the least-squares parabola through the values in these rows; where they are apart, one through
    each run of them."""
    together = len(rows) >= _TOGETHER * (rows[-1] - rows[0] + 1)
    runs = [rows] if together else np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    return np.concatenate([_parabola_through(each, values[each]) for each in runs])


def _parabola_through(rows: NDArray[np.int64], values: Floats) -> Floats:
    """Return the values, shape (n,), of the least-squares parabola; three or fewer are on it themselves."""
    if len(rows) <= _DEGREE + 1:
        return values
    return np.asarray(Polynomial.fit(rows, values, _DEGREE)(rows))


def _left_of_steps(noise_rms: float, step: float) -> float:
    """Return how much of the errors of a converter's steps is left in a mean, by the rms that is read at
    rest."""
    return share_left(noise_beside(noise_rms**2, step), step)


def _of_times(
    random: np.random.Generator, curve: Floats, scatter: float, draws: int, doubt: Floats | float
) -> Floats:
    """Return errors, shape (draws, n), of samples whose times scatter by so many rows, and some of which are
    in doubt."""
    slope = np.gradient(curve) if scatter else np.zeros(len(curve))
    return np.asarray(np.hypot(scatter * slope, doubt) * random.standard_normal((draws, len(curve))))
