"""The path of the stator flux in the plane: its radius, its centre, and how far it is from a circle."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.declaration import Analysis, Drawing, Findings, NoSettings, Quantity
from benchtool.analysis.drawings import WAVEFORMS
from benchtool.analysis.flux.revolutions import ORDERS, fits, forwards, revolutions_of
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.quantisation.repeated_steps import RepeatedSteps, steps_of_periods
from benchtool.analysis.quantisation.resolution import resolution
from benchtool.analysis.sensitivity import Content, Extremes, Level, Power, Sensitivities
from benchtool.analysis.spectra.amplitude_trend import FEWEST_PERIODS, amplitude_trend
from benchtool.analysis.statistics.between_samples import BETWEEN, between_samples
from benchtool.analysis.statistics.excesses import FEWEST_EXTREMES
from benchtool.analysis.statistics.regimes import change_of_regime
from benchtool.analysis.statistics.scatter import (
    MeanError,
    at_lowest_frequencies,
    error_of_periods,
    error_of_root,
    error_of_series,
    is_memory_untold,
)
from benchtool.analysis.torque.ripple import peak_to_peak_number
from benchtool.analysis.torque.ripple_extremes import Tails, extremes_of_ripple
from benchtool.analysis.uncertainty import Contribution, combined
from benchtool.analysis.validity import require_signal, require_unbroken
from benchtool.analysis.window import Window
from benchtool.block import Block

_TOO_SLOW = "the revolutions are too few, or too much alike, to tell how much they scatter: record longer"
_LEVEL: Final = Level()
_DOF_OF_EXTREMES = 10.0  # of a tail from a few of the largest values
_SLOW_SHARE = 0.03  # of a mean square, that the radius of whole revolutions makes up
_BY_CHANCE = 1.0  # standard deviation of a correlation: one that is taken for chance leaves far too little
_CLEARLY = 3.0  # standard deviations of a correlation
_FEWEST_VALUES = 10.0  # that do not depend on each other, of which an rms says something
_FINE = 1e-5  # of the radius: a smaller step is the last digit of a number


def flux_trajectory(block: Block) -> tuple[Measurement, ...]:
    """Return the radius, centre and hexagonality of the stator flux over whole revolutions of it.

    The revolutions come from the flux's own angle about its centre: a quadratic fit to it, so that its ripple
    stays in the numbers. Centre and hexagon are least-squares fits to the samples, in every revolution by
    itself; their scatter over the revolutions is the uncertainty.

    Args:
        block: a capture without gaps, with psi_alpha and psi_beta, amplitude-invariant (peak).

    Raises:
        AnalysisError: a gap, a missing channel, a dead signal, fewer than two revolutions, or a speed that is
            not steady.
    """
    require_unbroken(block)
    alpha, beta = block.column("psi_alpha"), block.column("psi_beta")
    require_signal(alpha, "psi_alpha")
    require_signal(beta, "psi_beta")
    psi = forwards(alpha + 1j * beta)
    track, revolutions = revolutions_of(psi)
    begin_rad = float(track.at(np.zeros(1))[0])
    edges = revolutions[0].start, revolutions[-1].stop
    rate_Hz = block.sample_rate_Hz
    count = edges[1] - edges[0]
    basis = Basis(
        samples=count,
        sample_rate_Hz=rate_Hz,
        duration_s=count / rate_Hz,
        bandwidth_Hz=0.5 * rate_Hz,
        window=f"{len(revolutions)} whole revolutions by a quadratic fit to the flux's angle",
        gaps=0,
    )
    turns = (track.at(np.arange(*edges, dtype=np.float64)) - begin_rad) / (2.0 * np.pi)
    flux = _Revolutions(psi, revolutions, turns, begin_rad, fits(psi, track, revolutions), basis)
    return (*_of_radius(flux), *_of_shape(flux))


@dataclass(frozen=True)
class _Revolutions:
    """Whole revolutions of a flux `psi`, shape (n,), each a slice of it; `turns` is where the samples in them
    are, in revolutions from the first, whose electrical angle begins at `begin_rad`, and `orders`, shape
    (revolutions, orders), are the fits of `ORDERS` to each."""

    psi: NDArray[np.complex128]
    parts: Sequence[slice]
    turns: NDArray[np.float64]
    begin_rad: float
    orders: NDArray[np.complex128]
    basis: Basis

    @cached_property
    def path(self) -> NDArray[np.complex128]:
        """The flux of all of them, shape (m,)."""
        return self.psi[self.parts[0].start : self.parts[-1].stop]

    @cached_property
    def radius(self) -> NDArray[np.float64]:
        """The distance of the path from zero, shape (m,)."""
        return np.abs(self.path)

    @cached_property
    def begins(self) -> NDArray[np.int64]:
        """The rows of the path in which revolutions begin, shape (revolutions,)."""
        return np.array([part.start - self.parts[0].start for part in self.parts])

    @cached_property
    def means(self) -> NDArray[np.float64]:
        """Means of the radius over each, shape (revolutions,)."""
        return self.means_of(self.radius)

    def means_of(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return means of values along the path, shape (m,), over each, shape (revolutions,)."""
        return np.asarray(np.add.reduceat(values, self.begins) / self.counts)

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """Samples of each, shape (revolutions,)."""
        return np.array([part.stop - part.start for part in self.parts])

    @property
    def after(self) -> float:
        """The part of a record behind the last, over all of them."""
        return float(len(self.psi) - self.parts[-1].stop) / len(self.path)

    @cached_property
    def step(self) -> float:
        """Step of a converter of both coordinates; 0 without one."""
        step = max(resolution(self.psi.real), resolution(self.psi.imag))
        return step if step > _FINE * float(np.mean(self.radius)) else 0.0

    @cached_property
    def steps(self) -> _Steps:
        """What that does alike in every revolution."""
        return _Steps.of(self.path, np.append(self.begins, len(self.path)), self.step, self.turns)

    @cached_property
    def reason(self) -> str:
        """Why there are no numbers; empty if there are."""
        about = self.radius - float(np.mean(self.radius))
        signs = np.where(np.arange(len(about)) % 2, -1.0, 1.0)
        reason = change_of_regime(self.means, "the radius of the flux")
        if not reason and is_memory_untold(self.means, self.means_of(signs * about)):
            return f"the radius of the flux wanders over the {len(self.means)} revolutions: record longer"
        return reason

    def number(
        self,
        name: str,
        text: str,
        value: float,
        error: MeanError,
        *further: Contribution,
        content: Content = _LEVEL,
    ) -> Measurement:
        """Return a number with its error over the revolutions and further contributions."""
        if self.reason:
            return Measurement.undefined(name, "Wb", text, self.reason, self.basis)
        source = f"scatter over {len(self.means)} revolutions, with their correlation"
        budget = [error.line(source)]
        budget += [each for each in further if each.standard != 0.0]
        uncertain = combined(budget, source)
        return Measurement(
            name,
            value,
            "Wb",
            text,
            self.basis,
            uncertain,
            uncertainty_reason=_TOO_SLOW if uncertain is None else "",
            sensitivities=Sensitivities(content=content),
        )


def _of_radius(flux: _Revolutions) -> Iterator[Measurement]:
    """Yield mean, peak-to-peak and rms of the radius."""
    radius, begins, step = flux.radius, flux.begins, flux.step
    mean, rms, span = float(np.mean(radius)), float(np.std(radius)), float(np.ptp(radius))
    resolved = Contribution("resolution", "B", flux.steps.of_radius)
    # a revolution ends within a sample
    ends = Contribution("samples at both ends", "B", span / (math.sqrt(24.0) * len(radius)))
    text = "mean of sqrt(psi_alpha^2 + psi_beta^2), peak"
    of_mean = _of_mean(flux.means, flux.after, radius)
    yield flux.number("flux_radius_mean", text, mean, of_mean, resolved, ends)
    scatter = math.nan
    if len(begins) >= FEWEST_EXTREMES:
        scatter = extremes_of_ripple(radius, radius, begins, Tails.of(radius, begins, flux.counts))
    text = "maximum minus minimum of sqrt(psi_alpha^2 + psi_beta^2); grows with the duration"
    of_both = Contribution("resolution", "B", flux.steps.of_span(step))
    extremes = MeanError(scatter, _DOF_OF_EXTREMES)
    between = between_samples(radius, flux.turns)
    missed = Contribution(BETWEEN, "B", 0.0 if between is None else between.error_of(np.ptp))
    yield flux.number("flux_radius_pp", text, span, extremes, of_both, missed, content=Extremes())
    name, text = "flux_radius_rms", "rms of sqrt(psi_alpha^2 + psi_beta^2) about its mean"
    scale = 1.0 / (2.0 * rms) if rms > 0.0 else 0.0
    # steps add a twelfth of their square to the mean square
    added = Contribution("power that the steps add", "B", scale * step**2 / 12.0)
    of_rms, untold = _of_slow_rms(flux.means, error_of_root(flux.means_of((radius - mean) ** 2), rms), rms)
    # about the mean of the record, and not about that of all records, it is less by the former's variance
    own_mean = Contribution("deviation of the mean", "B", scale * of_mean.standard**2)
    if untold and not flux.reason:
        yield Measurement.undefined(name, "Wb", text, untold, flux.basis)
    else:
        yield flux.number(name, text, rms, of_rms, resolved, added, own_mean, content=Power())


def _of_shape(flux: _Revolutions) -> Iterator[Measurement]:
    """Yield the distance of the centre from zero, and order 6 of the radius."""
    # a radius that grows by d within a revolution reads d / 2 pi as a centre, and a sixth of that as order 7
    growth, of_growth = _growth(flux.orders[:, 1])
    found, rows = flux.orders.copy(), len(flux.path) / len(flux.parts)
    for column, order in enumerate(ORDERS):
        if order != 1:
            turned = np.exp(1j * (1 - order) * flux.begin_rad)
            found[:, column] -= growth * turned / (rows * (np.exp(2j * np.pi * (1 - order) / rows) - 1.0))
    centre = found[:, 0]
    of_ramp = Contribution("growth of the radius within a revolution", "B", of_growth / (2.0 * np.pi))
    text = "distance from zero of the mean of psi_alpha + j psi_beta, fitted together with orders 1, -5 and 7"
    length, bias, along = _length(centre, flux.after)
    by_scatter = Contribution("length that the scatter adds", "B", bias, adds_power=True)
    of_steps = Contribution("resolution", "B", flux.steps.of_centre(complex(np.mean(centre))))
    yield flux.number("flux_centre_offset", text, length, along, by_scatter, of_ramp, of_steps)

    # |c_1 e^jx + c_-5 e^-5jx + c_7 e^7jx| is |c_1| + Re((c_1 c_-5* + c_1* c_7) e^6jx) / |c_1| to first order
    sixth = (found[:, 1] * np.conj(found[:, 2]) + np.conj(found[:, 1]) * found[:, 3]) / np.abs(found[:, 1])
    # where the speed swings it turns with six times the phase of order 1
    sixth *= np.exp(-6j * np.angle(found[:, 1]))
    text = (
        "peak amplitude of order 6 of the radius along a revolution, the mean of all, from orders -5 and 7 "
        "of psi_alpha + j psi_beta; 0 for a circle, 1/25 + 1/49 of order 1 for a hexagon run along its sides "
        "evenly"
    )
    length, bias, along = _length(sixth, flux.after)
    by_scatter = Contribution("length that the scatter adds", "B", bias, adds_power=True)
    of_two = Contribution("resolution", "B", flux.steps.of_sixth)
    yield flux.number("flux_radius_order_6", text, length, along, by_scatter, of_two)


@dataclass(frozen=True)
class _Steps:
    """Errors that the steps of a converter make alike in every revolution, of both coordinates."""

    both: tuple[RepeatedSteps | None, RepeatedSteps | None] = (None, None)

    @staticmethod
    def of(
        path: NDArray[np.complex128], begins: NDArray[np.int64], step: float, turns: NDArray[np.float64]
    ) -> _Steps:
        """Return those of a path, shape (n,), whose revolutions begin at rows, shape (revolutions + 1,), and
        where its samples are, in revolutions, shape (n,)."""
        if not step > 0.0:
            return _Steps()
        alpha, beta = (
            steps_of_periods(np.ascontiguousarray(part), begins, 1, step, turns)
            for part in (path.real, path.imag)
        )
        return _Steps((alpha, beta))

    @property
    def of_radius(self) -> float:
        """Standard uncertainty of the mean radius, along which the error of a coordinate is by its share of
        it."""
        found = [each for each in self.both if each is not None]
        deviations = [each.waveform - np.mean(each.waveform) for each in found]
        return math.hypot(
            *(each.of_mean(of / np.max(np.abs(of))) for each, of in zip(found, deviations, strict=True))
        )

    def of_centre(self, centre: complex) -> float:
        """Standard uncertainty of the distance of a centre from zero."""
        away = centre / abs(centre) if centre else 1.0
        shares = (complex(away).real, complex(away).imag)
        return math.hypot(
            *(
                share * each.of_mean()
                for share, each in zip(shares, self.both, strict=True)
                if each is not None
            )
        )

    def of_span(self, step: float) -> float:
        """Standard uncertainty of the difference of the extremes of the radius, by those of an ensemble."""
        alpha, beta = self.both
        if alpha is None or beta is None:
            return 0.0 if alpha is beta else step / math.sqrt(6.0)
        points = min(alpha.errors.shape[1], beta.errors.shape[1])
        places = [np.arange(points) * each.errors.shape[1] // points for each in (alpha, beta)]
        read = [
            each.waveform[at] + each.errors[:, at] for each, at in zip((alpha, beta), places, strict=True)
        ]
        # levels of one are anywhere beside those of the other
        draws = np.random.default_rng(0).permutation(len(read[1]))
        return float(np.std(np.ptp(np.hypot(read[0], read[1][draws]), axis=1)))

    @property
    def of_sixth(self) -> float:
        """Standard uncertainty of order 6 of the radius: half of a coordinate's orders 5 and 7 are in orders
        -5 and 7 of the path, and half of their power along it."""
        power = [float(np.sum(each.power_at(np.array([5, 7])))) for each in self.both if each is not None]
        return math.sqrt(sum(power) / 8.0)


def _growth(circle: NDArray[np.complex128]) -> tuple[complex, float]:
    """Return by how much order 1, shape (revolutions,), grows in each revolution on average, and how far that
    is unknown: of too few revolutions to tell a trend from chance, all that it may be."""
    count, size = len(circle), np.abs(circle)
    middle = complex(np.mean(circle))
    trend = amplitude_trend(size)
    if trend is not None:
        return middle * trend.growth / count, 0.0
    if count >= FEWEST_PERIODS or count < 2:
        return 0j, 0.0
    return 0j, abs(float(size[-1] - size[0])) / (count - 1)


def _of_mean(
    values: NDArray[np.float64], after: float, samples: NDArray[np.float64] | None = None
) -> MeanError:
    """Of the mean of values, shape (revolutions,), that of what a trend leaves of them, if they have one:
    `after` is the share of the record after the last revolution. Without one, where they are the means of
    `samples`, shape (n,), of what a control holds, the density of these tells it too."""
    trend = amplitude_trend(values, after=after)
    if trend is None:
        error = error_of_periods(values)
        return error if samples is None else _by_density(samples, error, len(values))
    mean, left = abs(float(np.mean(values))), error_of_series(trend.rest)
    return MeanError(mean * math.hypot(left.standard, trend.deviation), left.dof)


def _by_density(samples: NDArray[np.float64], by_parts: MeanError, count: int) -> MeanError:
    """Return the error of the mean of samples, shape (n,), of so many revolutions, by their means and by the
    density of the samples, unless that rises too steeply: the means then have been continued."""
    if not math.isfinite(by_parts.standard):
        return by_parts
    error = at_lowest_frequencies(samples, by_parts, count, pooled=True, may_fall=True)
    return error if math.isfinite(error.standard) else by_parts


def _of_slow_rms(means: NDArray[np.float64], by_squares: MeanError, rms: float) -> tuple[MeanError, str]:
    """Of an rms to which a radius adds that keeps its value for some revolutions, and why there is none.

    By the correlation r of neighbours, less its bias (1 + 3 r) / n (Kendall, Biometrika 41 (1954) 403),
    (1 + r^2) / (1 - r^2) revolutions count as one of the mean square of a Gauss-Markov sequence. Its own
    correlations are small and often taken for chance.
    """
    count, deviation = len(means), means - np.mean(means)
    power = float(deviation @ deviation)
    share = power / (count * rms**2) if rms > 0.0 else 0.0
    if not share > 0.0 or not rms > _FINE * abs(float(np.mean(means))):
        return by_squares, ""
    neighbours = float(deviation[1:] @ deviation[:-1]) / power
    if neighbours * math.sqrt(count) < _BY_CHANCE:
        return by_squares, ""
    memory = min(max(0.0, neighbours + (1.0 + 3.0 * neighbours) / count), 1.0 - 1.0 / count)
    # refused is by what the memory may be: of a long one those records in which it seems short read low
    longest = min(memory + _CLEARLY * math.sqrt((1.0 - neighbours**2) / count), 1.0 - 1.0 / count)
    fewest = count * (1.0 - longest) / (1.0 + longest)
    # few values may all be near each other, and make up far more of other records
    if not share * max(1.0, _FEWEST_VALUES / fewest) > _SLOW_SHARE:
        return by_squares, ""
    if fewest < _FEWEST_VALUES:
        return (
            by_squares,
            "the radius changes so slowly that the record holds few values of it: record longer",
        )
    values = count * (1.0 - memory**2) / (1.0 + memory**2)
    relative = share * math.sqrt(2.0 / values)
    slow = MeanError(0.5 * rms * relative * (1.0 + 2.0 * relative), max(1.0, values - 1.0))
    return (slow if slow.standard > by_squares.standard else by_squares), ""


def _length(points: NDArray[np.complex128], after: float) -> tuple[float, float, MeanError]:
    """Return distance of the mean of points from zero, the share of it that their scatter explains, and the
    error of the mean along its direction."""
    mean = complex(np.mean(points))
    length = abs(mean)
    turned = points * (np.conj(mean) / length if length else 1.0)
    along, across = _of_mean(turned.real, after), error_of_periods(turned.imag)
    variance = along.standard**2 + across.standard**2
    left = length**2 - variance if math.isfinite(variance) else length**2
    return length, length - math.sqrt(max(0.0, left)), along


def _measure_ripple(window: Window, _: NoSettings) -> Findings:
    what = "the drive's estimate psi_s (peak)"
    number = peak_to_peak_number(window.block, "psi_s", "flux_ripple_pp", track=window.track, what=what)
    return Findings((number,))


def _measure_trajectory(window: Window, _: NoSettings) -> Findings:
    return Findings(flux_trajectory(window.block))


FLUX_RIPPLE: Final = Analysis(
    name="flux_ripple",
    title="flux ripple",
    measure=_measure_ripple,
    quantities=(Quantity(("flux_ripple_pp",), "Wb", "max - min of psi_s", "as pp", headline=True),),
    settings=NoSettings,
    channels=("psi_s",),
    figures=(WAVEFORMS,),
)
FLUX_TRAJECTORY: Final = Analysis(
    name="flux_trajectory",
    title="flux trajectory",
    measure=_measure_trajectory,
    quantities=(
        Quantity(("flux_radius_mean",), "Wb", "mean of `sqrt(psi_alpha^2 + psi_beta^2)`, peak"),
        Quantity(("flux_radius_pp",), "Wb", "its maximum minus minimum"),
        Quantity(("flux_radius_rms",), "Wb", "its rms about the mean"),
        Quantity(("flux_centre_offset",), "Wb", "`abs(mean of c_0)`"),
        Quantity(
            ("flux_radius_order_6",),
            "Wb",
            "`abs` of the mean of `(c_1 conj(c_-5) + conj(c_1) c_7) / abs(c_1)`: peak amplitude of order 6 "
            "of the radius; `(1/25 + 1/49) c_1` for a hexagon run along its sides evenly",
        ),
    ),
    settings=NoSettings,
    channels=("psi_alpha", "psi_beta"),
    figures=(
        Drawing(
            "flux_trajectory",
            "Flux trajectory",
            "Stator flux in stator coordinates over the last two electrical periods.",
        ),
    ),
)
