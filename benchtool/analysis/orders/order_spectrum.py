"""Amplitude over order, cycles per mechanical revolution: by time in steady state, else by angle alone."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    coherent_samples_of_all,
)
from benchtool.analysis.distributions import students_deviation
from benchtool.analysis.measurement import Basis
from benchtool.analysis.noise.converter_lines import converter_steps, repeated_quantisation
from benchtool.analysis.noise.noise_of_lines import line_noise
from benchtool.analysis.numbers import count_of
from benchtool.analysis.orders.angle import (
    TURN,
    AngleCoverage,
    across_gaps,
    between_updates,
    least_step_rad,
    unwrapped_angle,
)
from benchtool.analysis.orders.angle_orders import AngleFit, fit_orders
from benchtool.analysis.orders.counted_orders import rounding_by_angle, rounding_by_time, without_rounding
from benchtool.analysis.orders.order_courses import of_levels, without_courses
from benchtool.analysis.orders.stated_speed import speed_of_record
from benchtool.analysis.orders.wobble import Wobble, repeated_wobble_rad
from benchtool.analysis.periods import PhaseTrack, track_angle
from benchtool.analysis.quantisation.counted_angle import CountedAngle, counted_angle
from benchtool.analysis.quantisation.repeated_steps import repeated_steps
from benchtool.analysis.quantisation.resolution import counting_step, level_of
from benchtool.analysis.spectra.modulation import PeriodsInTime
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined
from benchtool.analysis.validity import require_signal, require_unbroken, require_unheld
from benchtool.block import Block
from benchtool.errors import AnalysisError

HIGHEST_ORDER = 200
FEWEST_REVOLUTIONS = 2.0
_FEWEST_OF_A_MEMORY = 8  # revolutions, of which fewer do not tell how long an amplitude remembers

LARGEST_WOBBLE_RAD = 1.5e-3
"""Rms deviation of the angle from a smooth track at which order 200 loses 5 %: it turns by 0.3 rad."""

BY_CHANCE = 0.01
"""Share of records of noise alone in which one of all orders exceeds what noise is taken to cause."""

_OF_DOF = 0.75  # the median of pairs of bins scatters more than their mean: so many of its degrees of freedom
_OF_OTHERS = 4.5  # standard uncertainties by resolution, resampling and wobble of the angle


@dataclass(frozen=True)
class OrderSpectrum:
    """Peak `amplitude` of orders `order` (1, 2, 3 ... per mechanical revolution), both of shape (orders,).

    `standard` is the standard uncertainty of each, from `uncertainty_source`: noise, of `dof` degrees of
    freedom, by the standard deviation of Student's distribution, and `others`, which is not. `mean` is order
    0. `stands_out_above`, of shape (orders,), is the least amplitude that noise and the other errors do not
    explain. In `others` is what a wobble of the angle may have taken off each, `lost`, and put `beside` the
    others, shape (orders,). All are in `unit`. `method` says in words how they were made. The amplitudes of
    the orders `untold` wander, for a while that few revolutions do not tell: they have no uncertainty.
    """

    signal: str
    unit: str
    order: NDArray[np.int64]
    amplitude: NDArray[np.float64]
    standard: NDArray[np.float64]
    mean: float
    revolutions: float
    method: str
    uncertainty_source: str
    basis: Basis
    dof: NDArray[np.float64]
    stands_out_above: NDArray[np.float64]
    others: NDArray[np.float64]
    lost: NDArray[np.float64]
    beside: NDArray[np.float64]
    step: float = 0.0
    untold: frozenset[int] = frozenset()

    def uncertainty(self, order: int, factor: float = 1.0) -> Uncertainty:
        """Return that of the amplitude of one order, times a factor."""
        standard, others = float(self.standard[order - 1]), float(self.others[order - 1])
        dof, source = float(self.dof[order - 1]), self.uncertainty_source
        if order in self.untold or not math.isfinite(standard):
            return Uncertainty(math.nan, source, dof)
        by_noise = factor * math.sqrt(max(0.0, standard**2 - others**2))
        noise = Contribution("noise", "A", by_noise, dof, of_student=True)
        rest = Contribution(
            "resolution, resampling, wobble and wander of the phase, course of the amplitude",
            "B",
            factor * others,
        )
        return combined((noise, rest), source) or Uncertainty(math.nan, source)

    @property
    def largest(self) -> NDArray[np.int64]:
        """Orders by falling amplitude."""
        return self.order[np.argsort(-self.amplitude, kind="stable")]

    def with_wobble(self, lost: NDArray[np.float64], beside: NDArray[np.float64]) -> OrderSpectrum:
        """Return it where the wobble may have taken off and put beside no more than this, shape (orders,)."""
        lost, beside = np.minimum(lost, self.lost), np.minimum(beside, self.beside)
        less2 = self.lost**2 - lost**2 + self.beside**2 - beside**2
        return replace(
            self,
            standard=np.sqrt(np.maximum(0.0, self.standard**2 - less2)),
            stands_out_above=np.sqrt(np.maximum(0.0, self.stands_out_above**2 - _OF_OTHERS**2 * less2)),
            others=np.sqrt(np.maximum(0.0, self.others**2 - less2)),
            lost=lost,
            beside=beside,
        )


@dataclass(frozen=True)
class Revolutions:
    """Channels at equal steps of a smooth track of the rotor's angle, over the same whole revolutions.

    The angle as it was read is off `track` by `wobble`; there is none where the speed was stated.
    """

    track: PhaseTrack
    wobble: Wobble
    samples: Mapping[str, CoherentSamples]

    @property
    def stated(self) -> bool:
        """Whether the speed was stated."""
        return self.track.measured_rad is None


def angle_of(block: Block, angle: str = "theta_m") -> NDArray[np.float64]:
    """Return the angle of a recording, rad, without jumps, followed between updates that are rarer than rows
    and over gaps.

    Raises:
        AnalysisError: as `unwrapped_angle`.
    """
    read, times = np.ascontiguousarray(block.column(angle)), block.ticks().astype(np.float64)
    theta_m = unwrapped_angle(read, angle)
    if block.gaps and not np.array_equal(read, theta_m):  # one that counts turns counts those in gaps
        theta_m = across_gaps(theta_m, times)
    return between_updates(theta_m, times)


def revolutions_of(
    block: Block,
    channels: Iterable[str],
    angle: str = "theta_m",
    largest_wobble_rad: float = LARGEST_WOBBLE_RAD,
) -> Revolutions:
    """Return some channels along the angle, for little more than one takes.

    Raises:
        AnalysisError: as `resampled_orders`.
    """
    require_unbroken(block)
    theta_m = angle_of(block, angle)
    track = track_angle(theta_m, 1)
    wobble_rad = track.residual_rad or 0.0
    if wobble_rad > largest_wobble_rad:
        raise AnalysisError(
            f"'{angle}' is off a smooth track by {wobble_rad:.3g} rad rms, at most {largest_wobble_rad:.3g} "
            f"is allowed: fit orders to the angle itself"
        )
    step_rad = least_step_rad(block.column(angle))
    rms_rad = math.sqrt(max(0.0, wobble_rad**2 - step_rad**2 / 12.0))
    rows = np.arange(track.samples, dtype=np.float64)
    forwards_rad = theta_m if theta_m[-1] > theta_m[0] else -theta_m
    repeated_rad = repeated_wobble_rad(forwards_rad, forwards_rad - track.at(rows))
    return _along(block, channels, track, Wobble(rms_rad, repeated_rad))


def counted_of(block: Block, channel: str, angle_rad: NDArray[np.float64]) -> CountedAngle | None:
    """Return the counts of an angle without jumps, shape (n,), of which a channel is computed; None where it
    is not."""
    if block.unit(channel) != "rad/s":
        return None
    times = block.ticks().astype(np.float64)
    return counted_angle(angle_rad, block.column(channel), times, block.sample_rate_Hz)


def _along(block: Block, channels: Iterable[str], track: PhaseTrack, wobble: Wobble) -> Revolutions:
    columns = {name: np.ascontiguousarray(block.column(name)) for name in channels}
    samples = coherent_samples_of_all(columns, block.sample_rate_Hz, track)
    return Revolutions(track, wobble, dict(zip(columns, samples, strict=True)))


def resampled_orders(
    block: Block,
    channel: str,
    angle: str = "theta_m",
    largest_wobble_rad: float = LARGEST_WOBBLE_RAD,
    known: Revolutions | None = None,
) -> OrderSpectrum:
    """Return orders of a uniformly sampled channel: bin k x revolutions of its coherent spectrum is order k.

    The uncertainty is from the bins beside each order (`line_noise`), and from the wobble of the angle about
    its smooth track, which may be a motion of the rotor or an error of the encoder. `known` are the
    revolutions where the channel is among those resampled already.

    Raises:
        AnalysisError: as `track_angle` and `coherent_spectrum`, a gap, or an angle that is off its smooth
            track by more than `largest_wobble_rad`, rms, so that orders by time are not orders by angle.
    """
    if known is None or channel not in known.samples:
        known = revolutions_of(block, (channel,), angle, largest_wobble_rad)
    return _orders_on(block, channel, known)


def orders_at_speed(block: Block, channel: str, omega_m_rad_s: float) -> OrderSpectrum:
    """Return the orders of a uniformly sampled channel at a constant mechanical speed that is stated, not
    measured.

    Where lines of the channel tell that the rotor turned a little faster or slower, over the record less
    than half a bin of the largest, it is their speed; further away there are no orders (`speed_of_record`).

    Raises:
        AnalysisError: a gap, a dead or clipped signal, a speed of zero, fewer than two revolutions, or lines
            of another speed.
    """
    require_unbroken(block)
    omega = abs(omega_m_rad_s) / block.sample_rate_Hz
    turns = omega * len(block.data) / TURN
    if not turns >= FEWEST_REVOLUTIONS:
        raise AnalysisError(
            f"the record has {turns:.3g} mechanical revolutions at the stated {omega_m_rad_s:.4g} rad/s, at "
            f"least {FEWEST_REVOLUTIONS:g} are needed for orders: record a longer window"
        )
    require_signal(block.column(channel), channel, block.unit(channel))
    require_unheld(block.column(channel), channel, block.unit(channel))
    speed = speed_of_record(block, channel, omega_m_rad_s)
    source = f"stated constant speed of {omega_m_rad_s:.6g} rad/s"
    if speed.omega_m_rad_s != omega_m_rad_s:
        source += f", {speed.omega_m_rad_s:.6g} rad/s by the lines of {channel},"
    omega = abs(speed.omega_m_rad_s) / block.sample_rate_Hz
    track = PhaseTrack(Polynomial([0.0, omega]), len(block.data), source)
    # an even deviation from end to end, rms
    off_rad = speed.standard_rad_s * len(block.data) / block.sample_rate_Hz / math.sqrt(12.0)
    return _orders_on(block, channel, _along(block, (channel,), track, Wobble(off_rad)))


def _orders_on(block: Block, channel: str, along: Revolutions) -> OrderSpectrum:
    """Return the orders of a channel along a mechanical phase."""
    samples, track, wobble = block.column(channel), along.track, along.wobble
    coherent = along.samples[channel]
    in_time = PeriodsInTime.of(coherent, track.turns_from(FIRST_ROW), FIRST_ROW)
    spectrum, courses = without_courses(coherent, HIGHEST_ORDER, in_time)
    turns = spectrum.periods
    count = min(HIGHEST_ORDER, (len(spectrum.amplitude) - 1) // turns)
    orders = np.arange(1, count + 1)
    noise = line_noise(spectrum, orders * turns)
    amplitude = spectrum.amplitude[orders * turns]
    step = counting_step(samples)
    counted = None if track.measured_rad is None else counted_of(block, channel, track.measured_rad)
    if counted is not None:
        step = counted.step
        by_steps = rounding_by_time(counted, coherent, track, orders)
        moves, _ = without_courses(without_rounding(counted, coherent, track), HIGHEST_ORDER, in_time)
        noise = line_noise(moves, orders * turns)
    else:
        steps = converter_steps(spectrum, step, level=level_of(samples, step))
        by_steps = repeated_quantisation(spectrum, steps)[0][:count]
    largest = int(np.argmax(amplitude)) if count else 0
    resampling = np.array(
        [
            spectrum.resampling_error(float(each), float(order), (largest + 1.0, float(amplitude[largest])))
            for each, order in zip(amplitude, orders, strict=True)
        ]
    )
    lost, beside = wobble.lost(amplitude), wobble.beside(amplitude)
    of_level = of_levels(courses, count)
    others = np.sqrt(of_level**2 + noise.lost**2 + by_steps**2 + resampling**2 + lost**2 + beside**2)
    # of one pair, whose distribution has no deviation, the noise of a line allows for more
    by_noise = np.maximum(noise.in_phase, _of_student(noise.experimental, noise.dof))
    about = f"{wobble.rms_rad:.2g} rad rms of {'the stated speed' if along.stated else 'wobble'}"
    return OrderSpectrum(
        signal=channel,
        unit=block.unit(channel),
        order=orders,
        amplitude=amplitude,
        standard=np.hypot(by_noise, others),
        others=others,
        mean=float(np.mean(coherent.values)),
        revolutions=float(turns),
        method=f"DFT over {count_of(turns, 'whole revolution')}, resampled to equal steps of a {track.source}"
        + (", less what mean and amplitudes do from revolution to revolution" if courses else ""),
        uncertainty_source="noise and leakage beside the order, resampling, resolution, wander of the phase, "
        f"and {about}",
        dof=noise.dof,
        stands_out_above=_explained(noise.experimental, _OF_DOF * noise.dof, others),
        lost=lost,
        beside=beside,
        step=step,
        untold=frozenset(orders[noise.wanders].tolist() if turns < _FEWEST_OF_A_MEMORY else ()),
        basis=Basis(
            samples=spectrum.samples,
            sample_rate_Hz=block.sample_rate_Hz,
            duration_s=spectrum.samples / block.sample_rate_Hz,
            bandwidth_Hz=float(spectrum.frequency_Hz[-1]),
            window=f"rectangular, {count_of(turns, 'whole mechanical revolution')}",
            harmonics=count,
            frequency_Hz=spectrum.fundamental_Hz,
            gaps=0,
        ),
    )


def fitted_orders(
    coverage: AngleCoverage,
    values: NDArray[np.float64],
    signal: str,
    unit: str,
    angle: str = "theta_m",
    basis: Basis | None = None,
    wobble: Wobble | None = None,
    counted: CountedAngle | None = None,
) -> OrderSpectrum:
    """Return the orders of samples taken at any times, by angle alone: see `angle_orders.fit_orders`.

    Args:
        coverage: the angle, from `angle_coverage`.
        values: the signal at those angles, shape (n,).
        signal, unit, angle: names for the definitions.
        basis: what is known of the samples; window and highest order are filled in.
        wobble: what may be an error of the angle itself.
        counted: the counts of the angle that a speed was computed of, from `counted_of`.

    Raises:
        AnalysisError: not finite, constant, or an arc of the circle is left out.
    """
    fit = fit_orders(coverage, values, HIGHEST_ORDER, signal)
    count = len(fit.coefficient)
    arc = math.degrees(coverage.largest_arc_rad)
    method = (
        f"least squares of orders 1 to {count} on {angle}, each degree of each of {coverage.revolutions:.4g} "
        f"revolutions weighted the same, largest arc without a sample {arc:.3g} degrees"
    )
    if coverage.resolution_rad > 0.0:
        method += f", angle in steps of {math.degrees(coverage.resolution_rad):.3g} degrees"
    if fit.on_a_course:
        method += ", less what it does from revolution to revolution"
    order = np.arange(1, count + 1)
    # values are averaged over a step of the angle, which lowers them by this factor
    low = np.sinc(order * coverage.resolution_rad / TURN)
    amplitude = 2.0 * np.abs(fit.coefficient) / low
    step, spread = counting_step(values), fit
    if counted is None:
        by_steps = _repeated_steps(fit, values, coverage) / low
    else:
        step, by_steps = counted.step, rounding_by_angle(counted, coverage, count) / low
        spread = fit_orders(coverage, values - counted.added(), count, signal)
    basis = basis or Basis(len(values))
    wobble = wobble or Wobble()
    about = f"{wobble.rms_rad:.2g} rad rms of wobble"
    lost, beside = wobble.lost(amplitude), wobble.beside(amplitude)
    wanders2 = np.maximum(0.0, spread.standard**2 - spread.noise**2) / low**2
    others = np.sqrt(by_steps**2 + wanders2 + lost**2 + beside**2)
    noise, dof = spread.noise / low, spread.noise_dof
    return OrderSpectrum(
        signal=signal,
        unit=unit,
        order=order,
        amplitude=amplitude,
        standard=np.hypot(_of_student(noise, dof), others),
        others=others,
        mean=fit.mean,
        revolutions=coverage.revolutions,
        method=method,
        uncertainty_source=f"{spread.uncertainty_source}, resolution, and {about}",
        dof=dof,
        stands_out_above=_explained(noise, dof, others),
        lost=lost,
        beside=beside,
        step=step,
        basis=replace(
            basis,
            window=f"by angle, {coverage.revolutions:.4g} mechanical revolutions",
            harmonics=count,
            frequency_Hz=coverage.revolutions / basis.duration_s if basis.duration_s else None,
        ),
    )


def _repeated_steps(
    fit: AngleFit, values: NDArray[np.float64], coverage: AngleCoverage
) -> NDArray[np.float64]:
    """Return what the steps of a quantised signal, alike in every revolution, do to each amplitude."""
    step = counting_step(values)
    if step <= 0.0:
        return np.zeros(len(fit.coefficient))
    lines, level = 2.0 * fit.coefficient, level_of(values, step)
    samples, turns = float(len(coverage.angle_rad)), max(1, round(coverage.revolutions))
    found = repeated_steps(fit.mean, lines, step, fit.left_rms**2, samples, turns, level=level)
    return np.zeros(len(lines)) if found is None else found.of_lines(lines)[0]


def _of_student(experimental: NDArray[np.float64], dof: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(experimental * [students_deviation(float(each)) for each in dof])


def _explained(
    noise: NDArray[np.float64], dof: NDArray[np.float64], others: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the amplitude of each order up to which noise and other errors explain it.

    Noise alone has two components of the standard deviation s in the amplitude a. Where s is an estimate of
    n degrees of freedom, (a / s)^2 / 2 is a ratio of variances with 2 and n: it exceeds z^2 / 2 with the
    probability (1 + z^2 / n)^(-n / 2). z is such that one of all orders does so in `BY_CHANCE` of the
    records.
    """
    each = -math.expm1(math.log1p(-BY_CHANCE) / max(1, len(noise)))
    z = np.sqrt(dof * np.expm1(-2.0 / dof * math.log(each)))
    return np.asarray(np.hypot(z * noise, _OF_OTHERS * others))
