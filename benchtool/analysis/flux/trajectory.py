"""The path of the stator flux in the plane: its radius, its centre, and how far it is from a circle."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.declaration import Analysis, Drawing, Findings, NoSettings, Quantity
from benchtool.analysis.distributions import students_deviation
from benchtool.analysis.flux.radius_as_read import radius_as_read
from benchtool.analysis.flux.radius_errors import (
    FINE,
    error_of_mean,
    error_of_slow_rms,
    growth_within,
    length_of_mean,
)
from benchtool.analysis.flux.revolutions import ORDERS, fits, forwards, revolutions_of
from benchtool.analysis.flux.step_errors import StepErrors
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.quantisation.repeated_steps import rms_before_steps
from benchtool.analysis.quantisation.resolution import resolution
from benchtool.analysis.sensitivity import Content, Extremes, Level, Power, Sensitivities
from benchtool.analysis.spectra.amplitude_trend import FEWEST_PERIODS
from benchtool.analysis.statistics.between_samples import BETWEEN, between_samples
from benchtool.analysis.statistics.excesses import FEWEST_EXTREMES
from benchtool.analysis.statistics.regimes import change_of_regime
from benchtool.analysis.statistics.scatter import (
    MeanError,
    error_of_root,
    is_memory_untold,
)
from benchtool.analysis.statistics.straight_lines import slope_of
from benchtool.analysis.torque.means_of_periods import Periods
from benchtool.analysis.torque.ripple_extremes import Tails, extremes_of_ripple
from benchtool.analysis.torque.slow_ripple import SlowRipple
from benchtool.analysis.uncertainty import Contribution, combined_by_names
from benchtool.analysis.validity import require_signal, require_unbroken
from benchtool.analysis.window import Window
from benchtool.block import Block

_TOO_SLOW = "the revolutions are too few, or too much alike, to tell how much they scatter: record longer"
_LEVEL: Final = Level()
_DOF_OF_EXTREMES = 10.0  # of a tail from a few of the largest values


def flux_trajectory(block: Block) -> tuple[Measurement, ...]:
    """Return the radius, centre and hexagonality of the stator flux over whole revolutions of it.

    The revolutions come from the flux's own angle about its centre: a quadratic fit to it, so that its
    ripple stays in the numbers, and where the speed swings about that the phase of order 1 in each
    revolution. Centre and hexagon are least-squares fits to the samples, in every revolution by itself; the
    uncertainty is by their scatter over the revolutions or, of few, by the density of the samples too.

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
    followed = "" if track.departure is None else ", and the phase of order 1 about it"
    basis = Basis(
        samples=count,
        sample_rate_Hz=rate_Hz,
        duration_s=count / rate_Hz,
        bandwidth_Hz=0.5 * rate_Hz,
        window=f"{len(revolutions)} whole revolutions by a quadratic fit to the flux's angle{followed}",
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
        return step if step > FINE * float(np.mean(self.radius)) else 0.0

    @property
    def are_few(self) -> bool:
        """Whether the scatter of the revolutions tells less than the density within them."""
        return len(self.parts) < FEWEST_PERIODS

    @cached_property
    def circle(self) -> NDArray[np.complex128]:
        """The path that order 1 alone would take, of radius 1, shape (m,)."""
        return np.asarray(np.exp(1j * (2.0 * np.pi * self.turns + self.begin_rad)))

    def without_growth(self, growth: complex) -> NDArray[np.complex128]:
        """Return the orders, shape (revolutions, orders), without what a `growth` of order 1 in each
        revolution adds to the others: over 2 pi to the centre, and a sixth of that to orders -5 and 7; nor
        what the centre, which drifts along a line by more or less, adds to them."""
        found, rows = self.orders.copy(), len(self.path) / len(self.parts)
        centre = self.orders[:, ORDERS.index(0)]
        drift = complex(slope_of(centre.real), slope_of(centre.imag))
        for moving, by in ((1, growth), (0, drift)):
            for column, order in enumerate(ORDERS):
                if order != moving:
                    turned = np.exp(1j * (moving - order) * self.begin_rad)
                    around = rows * (np.exp(2j * np.pi * (moving - order) / rows) - 1.0)
                    found[:, column] -= by * turned / around
        return found

    def without(self, *orders: int) -> NDArray[np.complex128]:
        """Return the path without order 1, as it is in each revolution, and without the means of other
        orders, shape (m,)."""
        means = dict(zip(ORDERS, np.mean(self.orders, axis=0), strict=True))
        first = np.interp(self.turns, np.arange(len(self.parts)) + 0.5, self.orders[:, 1])
        rest = self.path - first * self.circle
        return np.asarray(rest - sum(means[each] * self.circle**each for each in orders))

    @property
    def of_centre(self) -> NDArray[np.complex128]:
        """Values, shape (m,), whose mean is the centre."""
        return self.without(-5, 7)

    @property
    def of_sixth(self) -> NDArray[np.complex128]:
        """Values, shape (m,), whose mean is order 6 of the radius along a revolution."""
        rest = self.without(0) * np.conj(self.circle) * np.exp(-1j * np.angle(np.mean(self.orders[:, 1])))
        return np.asarray((rest + np.conj(rest)) * np.conj(self.circle) ** 6)

    @cached_property
    def steps(self) -> StepErrors:
        """What that does alike in every revolution."""
        return StepErrors.of(self.path, np.append(self.begins, len(self.path)), self.step, self.turns)

    @cached_property
    def reason(self) -> str:
        """Why there are no numbers; empty if there are."""
        about = self.radius - float(np.mean(self.radius))
        signs = np.where(np.arange(len(about)) % 2, -1.0, 1.0)
        reason = change_of_regime(self.means, "the radius of the flux")
        # a line that revolutions cut makes their means differ as well, and tells what the mean of all is
        if not reason and is_memory_untold(self.means, self.means_of(signs * about), fewest=0):
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
        of: str = "scatter over",
        of_student: bool = True,
    ) -> Measurement:
        """Return a number with its error, `of` what over the revolutions, and further contributions; an error
        that is not `of_student` does not allow for being known from few."""
        if self.reason:
            return Measurement.undefined(name, "Wb", text, self.reason, self.basis)
        budget = [replace(error.line(f"{of} {len(self.means)} revolutions"), of_student=of_student)]
        budget += [each for each in further if each.standard != 0.0]
        uncertain = combined_by_names(budget)
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
    of_mean = error_of_mean(flux.means, flux.after, radius)
    yield flux.number("flux_radius_mean", text, mean, of_mean, resolved, ends)
    scatter = math.nan
    if len(begins) >= FEWEST_EXTREMES:
        slow = SlowRipple.over(radius, Periods(np.append(begins, len(radius)), "revolutions"))
        tails = Tails.of(radius, begins, flux.counts)
        scatter = extremes_of_ripple(radius, slow.mean.left, begins, tails, slow=slow)
    text = "maximum minus minimum of sqrt(psi_alpha^2 + psi_beta^2)"
    larger = radius_as_read(flux.path, flux.without(), flux.circle, len(begins), step)
    if step:
        text = f"{text}, less the {larger.mean:.2g} Wb that steps of {step:.3g} Wb add"
    of_both = Contribution("resolution", "B", larger.standard)
    extremes = MeanError(scatter, _DOF_OF_EXTREMES)
    between = between_samples(radius, flux.turns)
    missed = Contribution(BETWEEN, "B", 0.0 if between is None else between.error_of(np.ptp))
    by = "scatter of the extremes, by those of"
    yield flux.number(
        "flux_radius_pp",
        f"{text}; grows with the duration",
        max(0.0, span - larger.mean),
        extremes,
        of_both,
        missed,
        content=Extremes(),
        of=by,
        of_student=False,
    )
    name, text = "flux_radius_rms", "rms of sqrt(psi_alpha^2 + psi_beta^2) about its mean"
    if step:
        rms = rms_before_steps(rms, step)
        text = f"{text}, less what steps of {step:.3g} Wb add"
    scale = 1.0 / (2.0 * rms) if rms > 0.0 else 0.0
    of_rms, untold = error_of_slow_rms(
        flux.means, error_of_root(flux.means_of((radius - mean) ** 2), rms), rms
    )
    # about the mean of the record, and not about that of all records, it is less by the former's variance
    own_mean = Contribution("deviation of the mean", "B", scale * of_mean.standard**2)
    length, beyond = _centre_beyond_its_scatter(flux)
    of_centre = Contribution("slow motion of the centre", "B", scale * length * beyond)
    if untold and not flux.reason:
        yield Measurement.undefined(name, "Wb", text, untold, flux.basis)
    else:
        resolved = Contribution("resolution", "B", flux.steps.of_rms(rms))
        yield flux.number(name, text, rms, of_rms, resolved, own_mean, of_centre, content=Power())


def _centre_beyond_its_scatter(flux: _Revolutions) -> tuple[float, float]:
    """Return how far the centre is from zero, and the standard uncertainty of that by what moves it too
    slowly to be in the scatter of the revolutions: the mean square of the radius has half of its square."""
    centre = flux.without_growth(growth_within(flux.orders[:, 1])[0])[:, 0]
    length, _, along = length_of_mean(centre, flux.after, flux.of_centre)
    own, dof = along.experimental, max(1.0, len(centre) - 1.0)
    by_scatter = math.sqrt(0.5 * float(np.var(centre)) / dof) * students_deviation(dof)
    return length, math.sqrt(max(own**2 - by_scatter**2, 0.0))


def _of_shape(flux: _Revolutions) -> Iterator[Measurement]:
    """Yield the distance of the centre from zero, and order 6 of the radius."""
    growth, of_growth = growth_within(flux.orders[:, 1])
    found, other = flux.without_growth(growth), flux.without_growth(growth + of_growth)
    centre, apart = found[:, 0], other[:, 0] - found[:, 0]
    text = "distance from zero of the mean of psi_alpha + j psi_beta, fitted together with orders 1, -5 and 7"
    steps = flux.steps.of_centre(complex(np.mean(centre)))
    length, bias, along = length_of_mean(centre, flux.after, flux.of_centre, steps)
    by_scatter = Contribution("length that the scatter adds", "B", bias, adds_power=True)
    of_steps = Contribution("resolution", "B", steps)
    yield flux.number("flux_centre_offset", text, length, along, by_scatter, _grows(centre, apart), of_steps)

    sixth, apart = _sixth(found), _sixth(other) - _sixth(found)
    text = (
        "peak amplitude of order 6 of the radius along a revolution, the mean of all, from orders -5 and 7 "
        "of psi_alpha + j psi_beta; 0 for a circle, 1/25 + 1/49 of order 1 for a hexagon run along its sides "
        "evenly"
    )
    steps = flux.steps.of_sixth(complex(np.mean(sixth)), flux.begin_rad)
    samples = flux.of_sixth if flux.are_few else None
    length, bias, along = length_of_mean(sixth, flux.after, samples, steps)
    by_scatter = Contribution("length that the scatter adds", "B", bias, adds_power=True)
    of_two = Contribution("resolution", "B", steps)
    yield flux.number("flux_radius_order_6", text, length, along, by_scatter, _grows(sixth, apart), of_two)


def _sixth(orders: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return order 6 of the radius along each revolution, shape (revolutions,), by its `ORDERS`.

    |c_1 e^jx + c_-5 e^-5jx + c_7 e^7jx| is |c_1| + Re((c_1 c_-5* + c_1* c_7) e^6jx) / |c_1| to first order.
    """
    _, first, fifth, seventh = orders.T
    sixth = (first * np.conj(fifth) + np.conj(first) * seventh) / np.abs(first)
    # where the speed swings it turns with six times the phase of order 1
    return np.asarray(sixth * np.exp(-6j * np.angle(first)))


def _grows(points: NDArray[np.complex128], apart: NDArray[np.complex128]) -> Contribution:
    """Return what a growth of the radius may add to the length of the mean of points, which are then `apart`
    from where they are, both of shape (revolutions,)."""
    mean = complex(np.mean(points))
    towards = np.conj(mean) / abs(mean) if mean else 1.0
    moved = abs(float(np.real(towards * np.mean(apart))))
    return Contribution("growth of the radius within a revolution", "B", moved)


def _measure_trajectory(window: Window, _: NoSettings) -> Findings:
    return Findings(flux_trajectory(window.block))


FLUX_TRAJECTORY: Final = Analysis(
    name="flux_trajectory",
    title="flux trajectory",
    measure=_measure_trajectory,
    quantities=(
        Quantity(("flux_radius_mean",), "Wb", "mean of `sqrt(psi_alpha^2 + psi_beta^2)`, peak"),
        Quantity(
            ("flux_radius_pp",), "Wb", "its maximum minus minimum, without what steps of a converter add"
        ),
        Quantity(
            ("flux_radius_rms",), "Wb", "its rms about the mean, in steps of q without their `q^2 / 12`"
        ),
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
