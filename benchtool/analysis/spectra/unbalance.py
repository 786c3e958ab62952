"""Symmetrical components of three phase currents at the fundamental, and their unbalance factors.

Fortescue's positive-, negative- and zero-sequence components (IEC 60034-26:2006, IEC 61000-4-30:2015, 5.7.1):
I_1 = (I_a + a I_b + a^2 I_c) / 3, I_2 = (I_a + a^2 I_b + a I_c) / 3, I_0 = (I_a + I_b + I_c) / 3 with
a = exp(j 2 pi / 3), of the phasors of the fundamental.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.resampling import gain_error
from benchtool.analysis.coherent.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    coherent_samples_of_all,
    spectrum_of,
)
from benchtool.analysis.declaration import Analysis, Findings, NoSettings, Quantity
from benchtool.analysis.distributions import fisher_above, median_of_exponentials
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.noise.converter_lines import converter_steps, repeated_quantisation
from benchtool.analysis.noise.noise_of_lines import PAIRS, NoiseAround, noise_at_lines
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.quantisation.resolution import level_of, resolution
from benchtool.analysis.sensitivity import Component, PhaseSequence, Sensitivities, Sensitivity
from benchtool.analysis.spectra.amplitude_trend import AmplitudeTrend
from benchtool.analysis.spectra.current import CurrentSpectrum, current_of
from benchtool.analysis.spectra.flat_crests import flat_crest, with_flat_crest
from benchtool.analysis.spectra.interharmonics import Interharmonics, interharmonics, without
from benchtool.analysis.spectra.modulation import CORRELATED, PeriodsInTime
from benchtool.analysis.spectra.moving_tones import Course
from benchtool.analysis.statistics.magnitudes import added_by_noise
from benchtool.analysis.statistics.regimes import change_of_regime
from benchtool.analysis.statistics.scatter import (
    MeanError,
    error_of_series,
    is_memory_untold,
    mean_of_periods,
)
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined
from benchtool.analysis.validity import clipping, require_unbroken
from benchtool.analysis.window import Window
from benchtool.block import Block

Phasors = NDArray[np.complex128]
Floats = NDArray[np.float64]

_BY_CHANCE = 0.1
_ORDERS_AROUND, _FEWEST_AROUND = 2, 20  # whose bins tell the noise; bins
_STANDS_OUT = 5.0  # standard uncertainties of the positive sequence
_DITHERS = 0.25  # of a step: the least amplitude of a tone that moves the signal from step to step
_LITTLE = 5e-3  # of the positive sequence: scatter of another one that is little beside it
_TOO_SLOW = "the periods are too few, or too much alike, to tell how much they scatter: record longer"
_SEQUENCES: Final[tuple[PhaseSequence, ...]] = ("positive", "negative", "zero")
_UNBALANCES: Final[tuple[tuple[int, str, PhaseSequence], ...]] = (
    (0, "current_unbalance_percent", "negative"),
    (1, "current_unbalance_zero_percent", "zero"),
)
_SOURCE = (
    "noise of the components, beside the fundamental or from period to period, and what that, repeated "
    "steps and a phase that wanders do to a magnitude"
)


@dataclass(frozen=True)
class _Sequence:
    """A symmetrical component in the frame of the fundamental: `samples`, shape (n,), equally far apart in
    angle, whose mean is its phasor."""

    samples: Phasors
    periods: int
    in_time: PeriodsInTime

    @cached_property
    def magnitude(self) -> float:
        return float(abs(np.mean(self.samples)))

    @cached_property
    def turned(self) -> _Sequence:
        """Along its mean, which then is real."""
        if not self.magnitude > 0.0:
            return self
        return replace(self, samples=self.samples * (np.conj(np.mean(self.samples)) / self.magnitude))

    @cached_property
    def of_periods(self) -> Phasors:
        """The means of its periods, shape (periods,)."""
        return np.asarray(np.mean(self.samples.reshape(self.periods, -1), axis=1))

    @cached_property
    def trend(self) -> AmplitudeTrend | None:
        """The course of the real part of its mean, if that is one of few constants, and no step."""
        found = self.in_time.trend(self.of_periods.real)
        return None if found is None or found.is_step else found

    @cached_property
    def along(self) -> tuple[float, MeanError]:
        """By how much the incomplete cycles of a swing move the real part of its mean, and its error, which
        is that about the course of an amplitude."""
        of_periods, whole = self.of_periods.real, float(np.mean(self.of_periods.real))
        if (trend := self.trend) is not None:
            left = error_of_series(trend.rest)
            standard = whole * math.hypot(left.standard, trend.of_level)
            return -whole * trend.level, replace(left, standard=standard)
        mean, error = self._error_of(self.samples.real, of_periods)
        return whole - mean, error

    @cached_property
    def across(self) -> MeanError:
        """The error of the imaginary part of its mean."""
        return self._error_of(self.samples.imag, self.of_periods.imag)[1]

    def _error_of(self, samples: Floats, of_periods: Floats) -> tuple[float, MeanError]:
        """Return a mean and its error: that of a swing by what is left of it over the periods, else that by
        the noise beside the fundamental, or by the periods where these are correlated.

        Means of periods have in them what is far from the fundamental, where the noise of a controlled
        current is greater, and a phase that wanders within them.
        """
        mean, by_periods = mean_of_periods(of_periods)
        if mean != float(np.mean(of_periods)) or not math.isfinite(by_periods.standard):
            return mean, by_periods
        noise = _beside(samples, self.periods)
        alone = error_of_series(of_periods).dof + 1.0
        if len(of_periods) > CORRELATED * alone and by_periods.standard > noise.standard:
            return mean, by_periods
        return mean, noise


def _beside(samples: Floats, periods: int) -> MeanError:
    """Return the error of the mean of samples, shape (n,), that hold so many periods, by the bins beside zero
    frequency that are no harmonics, as that of a line (`line_noise`)."""
    bins = fft.rfft(samples)[: max(_ORDERS_AROUND * periods, 2 * PAIRS + 1)] / len(samples)
    power, number = bins.real**2 + bins.imag**2, np.arange(len(bins))
    nearest = power[: 2 * PAIRS + 1][number[: 2 * PAIRS + 1] % periods != 0][:PAIRS]
    others = power[np.minimum(number % periods, -number % periods) > 1]
    if len(nearest) < PAIRS or len(others) < _FEWEST_AROUND:
        found = noise_at_lines(nearest[np.newaxis])
    else:
        of_others = float(np.median(others)) / median_of_exponentials(len(others))
        around = NoiseAround(np.array([of_others]), np.array([float(len(others))]))
        found, _ = around.with_pairs(nearest[np.newaxis])
    return MeanError(math.sqrt(float(found[0])), 2.0 * len(nearest))


@dataclass(frozen=True)
class _Component:
    """Magnitude of the mean of one phasor per period, with its uncertainty; `swung` is that of a mean that
    has the incomplete cycles of a slow swing in it, `scatter` the standard deviation of the phasors."""

    magnitude: float
    swung: float
    budget: tuple[Contribution, ...]
    scatter: float

    @property
    def uncertainty(self) -> Uncertainty | None:
        return combined(self.budget, _SOURCE)

    @property
    def stands_out(self) -> bool:
        """Whether it does of its noise, or, where that is not known, of the scatter of its periods."""
        own = self.uncertainty
        return self.magnitude > (self.scatter if own is None else _STANDS_OUT * own.standard)


def current_unbalance(
    block: Block,
    track: PhaseTrack,
    channels: Sequence[str] = ("i_a", "i_b", "i_c"),
    known: Mapping[str, CurrentSpectrum] | None = None,
) -> tuple[Measurement, ...]:
    """Return the sequence components of the fundamental, A peak, and the unbalance factors, %.

    Of negative and positive sequence the positive is the larger, whichever way the machine turns.

    Args:
        block: rows without gaps.
        track: electrical phase over the rows, as `CurrentSpectrum.track` has it.
        channels: the currents of phases a, b and c; if one current was computed from the other two, the zero
            sequence is zero by definition.
        known: the spectra along that track of those channels that have one already.

    Raises:
        AnalysisError: a gap, a missing channel, a dead signal, or fewer than two electrical periods.
    """
    require_unbroken(block)
    columns = [np.ascontiguousarray(block.column(name)) for name in channels]
    known = known or {}
    read = _read(dict(zip(channels, columns, strict=True)), block.sample_rate_Hz, track, known)
    tones = _tones(read)
    parts = [_without(*each) for each in zip(read, tones, strict=True)]
    first = parts[0]
    of_period = np.exp(-2j * np.pi / first.per_period * np.arange(first.per_period))
    turn = np.tile(of_period, first.periods)
    a = np.exp(2j * np.pi / 3.0)
    of_phases = np.array([[1.0, a, a**2], [1.0, a**2, a], [1.0, 1.0, 1.0]]) / 3.0
    rotating = of_phases @ np.array([2.0 * turn * each.values for each in parts])
    if abs(np.mean(rotating[0])) < abs(np.mean(rotating[1])):
        # in reverse rotation positive and negative sequence change places
        rotating = rotating[[1, 0, 2]]
    turns = track.turns_from(FIRST_ROW)
    in_time = PeriodsInTime.of(first, turns, FIRST_ROW)
    sequences = [_Sequence(each, first.periods, in_time) for each in rotating]
    image = np.conj(_course(sequences[0])) * turn**2
    sequences[1] = replace(sequences[1], samples=sequences[1].samples - image)
    resolutions = [resolution(each) for each in columns]
    steps = _of_steps(parts, columns, tones, resolutions)
    positive = _component(sequences[0], steps, beside=sequences[1])
    # which lowers all components alike
    lost = positive.magnitude * gain_error(first.periods / first.samples) / math.sqrt(3.0)
    resampled = Contribution("resampling", "B", lost)
    positive = replace(positive, budget=(*positive.budget, resampled))
    beside = [_component(each, steps, sequences[0]) for each in sequences[1:]]
    components = [positive, *(_alike(each, positive) for each in beside)]
    basis = Basis(
        samples=first.samples,
        sample_rate_Hz=block.sample_rate_Hz,
        duration_s=first.samples / block.sample_rate_Hz,
        frequency_Hz=first.fundamental_Hz,
        window=f"rectangular, {first.periods} whole electrical periods from row {FIRST_ROW} (from 0) on, by "
        f"{track.source}",
        reference="positive sequence of the fundamental",
        gaps=0,
    )
    reason = next(filter(None, map(clipping, columns)), "")
    reason = reason or change_of_regime(np.abs(sequences[0].of_periods), "the positive-sequence current")
    numbers = _numbers(components, beside, channels, block.unit(channels[0]), basis, reason)
    shares = (
        known[name].flat_crest if name in known else flat_crest(each, turns, step)
        for name, each, step in zip(channels, columns, resolutions, strict=True)
    )
    if share := max(shares):
        return tuple(with_flat_crest(each, share) for each in numbers)
    return tuple(numbers)


def _read(
    columns: Mapping[str, Floats], rate_Hz: float, track: PhaseTrack, known: Mapping[str, CurrentSpectrum]
) -> list[CoherentSamples]:
    """Return the columns at the same steps of phase: those that are `known` again, where they have another
    number of steps in a period, as at a whole number of rows."""
    sampled = {name: known[name].coherent for name in columns if name in known}
    others = {name: each for name, each in columns.items() if name not in known}
    if others:
        sampled |= zip(others, coherent_samples_of_all(others, rate_Hz, track), strict=True)
    if len({len(each.values) for each in sampled.values()}) > 1:
        return list(coherent_samples_of_all(columns, rate_Hz, track))
    return [sampled[name] for name in columns]


def _course(sequence: _Sequence) -> Phasors:
    """Return the course of a component over its periods, on straight lines through their means, shape (n,).

    In the frame of the opposite sequence it turns twice in each period. Over whole periods that is nothing
    while the amplitude is steady, and of one that rises by d over n periods d / (4 pi n).
    """
    periods, of_periods = sequence.periods, sequence.of_periods
    if periods < 2:
        return np.full(len(sequence.samples), np.mean(of_periods))
    begin, end = 1.5 * of_periods[0] - 0.5 * of_periods[1], 1.5 * of_periods[-1] - 0.5 * of_periods[-2]
    places = np.concatenate([[0.0], np.arange(periods) + 0.5, [periods]])
    values = np.concatenate([[begin], of_periods, [end]])
    at = (np.arange(len(sequence.samples)) + 0.5) * (periods / len(sequence.samples))
    return np.asarray(np.interp(at, places, values))


def _tones(parts: Sequence[CoherentSamples]) -> list[Interharmonics | None]:
    """Return the sinusoids between the harmonics of currents, of which incomplete cycles are in a mean and no
    noise is; where the first has none the others, which add up to little with it, have none."""
    found = [interharmonics(spectrum_of(parts[0]), len(parts[0].values))]
    if found[0] is None:
        return [None] * len(parts)
    return found + [interharmonics(spectrum_of(each), len(each.values)) for each in parts[1:]]


def _without(part: CoherentSamples, tones: Interharmonics | None) -> CoherentSamples:
    if tones is None:
        return part
    place = np.arange(len(part.values)) / len(part.values)
    return without(part, tones, Course(place, place))


def _of_steps(
    parts: Sequence[CoherentSamples],
    columns: Sequence[NDArray[np.float64]],
    tones: Sequence[Interharmonics | None],
    resolutions: Sequence[float],
) -> float:
    """Return the standard uncertainty of either part of a sequence component by the steps of a converter that
    are the same in every period: of three channels, each with its own, a third of their root sum of squares.

    A tone of the amplitude a moves the signal from step to step, and leaves J_0(2 pi a / step) of the errors
    (Widrow and Kollar, Quantization Noise, 2008, ch. 19), of which the rms is that of its crests over root 2.
    A tone of less than a quarter of a step may be a line of these errors, as there are where several periods
    hold a whole number of samples: it moves nothing.
    """
    square = 0.0
    for part, samples, beside, step in zip(parts, columns, tones, resolutions, strict=True):
        if not step > 0.0:
            continue
        spectrum = spectrum_of(part)
        steps = converter_steps(spectrum, step, level=level_of(samples, step))
        along, power = repeated_quantisation(spectrum, steps)
        tones_A = np.abs([] if beside is None else beside.phasors)
        turned = 2.0 * np.pi / step * tones_A[tones_A > _DITHERS * step]
        left2 = float(np.prod(1.0 / (np.pi * turned)))
        square += left2 * max(float(along[0]) ** 2, 0.5 * float(power[0]))
    return math.sqrt(square) / len(parts)


def _component(
    sequence: _Sequence, steps: float, reference: _Sequence | None = None, beside: _Sequence | None = None
) -> _Component:
    """Return the magnitude of the mean; as the numerator of a ratio to that of a `reference`, with the budget
    of the ratio times the latter: what both do alike cancels in it. A sequence `beside` it has as much of the
    noise of the three currents, and nothing of a phase that wanders."""
    turned, magnitude = sequence.turned, sequence.magnitude
    if reference is not None and reference.magnitude > 0.0:
        common = magnitude / reference.magnitude * reference.turned.samples.real
        turned = replace(turned, samples=turned.samples - common)
    (moved, along), across, of_periods = turned.along, turned.across, turned.of_periods
    if turned.trend is None and is_memory_untold(of_periods.real, of_periods.imag):
        along = _of_one_period(of_periods.real, 0.0 if reference is None else reference.magnitude)
    if not math.isfinite(across.standard):  # a track that is a little off turns it steadily
        across = along
    bias = added_by_noise(magnitude, math.hypot(across.standard, steps))
    of_phase = across if beside is None else _without_wander(across, beside)
    along = _pooled(along, of_phase)
    # of a phase that wanders by phi rms a mean is phi^2 / 2 shorter
    lost = 0.5 * float(np.var(of_periods.imag)) / magnitude if of_phase is not across else 0.0
    return _Component(
        magnitude - moved,
        magnitude,
        (
            along.line("noise along the phasor"),
            Contribution("what scatter adds to a magnitude", "B", bias, adds_power=True),
            *((Contribution("steps of the converter that repeat", "B", steps),) if steps else ()),
            *((Contribution("what a phase that wanders takes off a magnitude", "B", lost),) if lost else ()),
        ),
        scatter=float(np.std(sequence.of_periods)),
    )


def _of_one_period(of_periods: Floats, positive: float) -> MeanError:
    """Return the error of a mean of periods that wander for a while that they do not tell: it is no better
    known than one of them, where they differ by little of the positive sequence, and else not known."""
    scatter = float(np.std(of_periods, ddof=1))
    known = scatter if scatter < _LITTLE * positive else math.nan
    return MeanError(known, len(of_periods) - 1.0)


def _without_wander(across: MeanError, beside: _Sequence) -> MeanError:
    """Return the error across a phasor, or that of the sequence beside it where it is clearly less: then the
    phase wanders, which moves a magnitude in the second order alone."""
    noise = _mean_square(beside.turned.along[1], beside.turned.across)
    return noise if _is_more(across, noise) else across


def _pooled(along: MeanError, across: MeanError) -> MeanError:
    """Return the error along a phasor, by both components where they do not differ by more than chance: noise
    is isotropic."""
    if _is_more(along, across) or _is_more(across, along):
        return along
    return _mean_square(along, across)


def _mean_square(one: MeanError, other: MeanError) -> MeanError:
    return MeanError(math.sqrt(0.5 * (one.standard**2 + other.standard**2)), one.dof + other.dof)


def _is_more(one: MeanError, other: MeanError) -> bool:
    """Return whether an error is more than another by more than chance; both are known."""
    if not other.standard > 0.0:
        return False
    return fisher_above(one.dof, other.dof, (one.standard / other.standard) ** 2) < _BY_CHANCE


def _alike(component: _Component, positive: _Component) -> _Component:
    """Return a component, in ratio to the positive sequence so far, with what that one's amplitude does."""
    own = positive.uncertainty
    standard = math.nan if own is None else own.standard
    steady = positive.magnitude / positive.swung if positive.swung > 0.0 else 1.0
    share = component.magnitude / positive.magnitude if positive.magnitude > 0.0 else 0.0
    common = Contribution("wander of the positive sequence", "A", share * standard, own.dof if own else 1.0)
    return replace(component, magnitude=steady * component.magnitude, budget=(*component.budget, common))


def _numbers(
    components: Sequence[_Component],
    ratios: Sequence[_Component],
    channels: Sequence[str],
    unit: str,
    basis: Basis,
    reason: str,
) -> Iterator[Measurement]:
    each_third = sum(component.magnitude for component in components) / 3.0

    def sensed(which: PhaseSequence, scale: float, *, in_percent: bool = False) -> Sensitivities:
        """Each phase contributes a third to each component, at any angle."""
        phases = tuple(Sensitivity(channel, scale * each_third) for channel in channels)
        return Sensitivities(phases, Component(which, positive.magnitude, in_percent))

    of = f"sequence component of the fundamental of {', '.join(channels)} (Fortescue), peak"
    positive = components[0]
    for component, name in zip(components, _SEQUENCES, strict=True):
        text = f"magnitude of the {name}-{of}"
        if reason:
            yield Measurement.undefined(f"current_sequence_{name}", unit, text, reason, basis)
            continue
        uncertain = component.uncertainty
        yield Measurement(
            f"current_sequence_{name}",
            component.magnitude,
            unit,
            text,
            basis,
            uncertain,
            uncertainty_reason=_TOO_SLOW if uncertain is None else "",
            sensitivities=sensed(name, 1.0),
        )
    if not positive.stands_out and not reason:
        reason = "the positive sequence does not stand out of the noise"
    for index, number, short in _UNBALANCES:
        text = f"100 x {short}- over positive-{of}; unbalance after IEC 61000-4-30:2015, 5.7.1"
        if reason:
            yield Measurement.undefined(number, "%", text, reason, basis)
            continue
        scale, ratio = 100.0 / positive.swung, ratios[index]
        uncertain = combined((each.scaled(scale) for each in ratio.budget), _SOURCE)
        why = _TOO_SLOW if uncertain is None else ""
        value = scale * ratio.magnitude
        yield Measurement(
            number,
            value,
            "%",
            text,
            basis,
            uncertain,
            uncertainty_reason=why,
            sensitivities=sensed(short, scale, in_percent=True),
        )


def _measure(window: Window, _: NoSettings) -> Findings:
    of_a = window.cached(current_of)
    return Findings(current_unbalance(window.block, of_a.track, known={"i_a": of_a}))


CURRENT_UNBALANCE: Final = Analysis(
    name="current_unbalance",
    title="current unbalance",
    measure=_measure,
    quantities=(
        Quantity(
            ("current_sequence_positive", "current_sequence_negative", "current_sequence_zero"),
            "A",
            "magnitude, peak, of the symmetrical components (Fortescue) of the fundamental",
        ),
        Quantity(
            ("current_unbalance_percent",),
            "%",
            "100 x negative / positive sequence (IEC 61000-4-30:2015, 5.7.1; IEC 60034-26:2006)",
        ),
        Quantity(("current_unbalance_zero_percent",), "%", "100 x zero / positive sequence"),
    ),
    settings=NoSettings,
    channels=("i_a", "i_b", "i_c"),
)
