"""Distortions of a current as numbers: against which reference, with which uncertainty."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from benchtool.analysis.coherent.spectrum import CoherentSamples, CoherentSpectrum
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.numbers import raw
from benchtool.analysis.sensitivity import Harmonics, Sensitivities, Sensitivity
from benchtool.analysis.spectra.groups import (
    FEWEST_WINDOWS,
    PERIODS_PER_WINDOW,
    GroupDistortion,
    HarmonicGroups,
    Kind,
    group_distortion,
    ratio_of,
    scatter_of_begins,
    scatter_of_bursts,
)
from benchtool.analysis.spectra.harmonics import (
    HIGHEST_HARMONIC,
    Distortion,
    Reference,
    total_harmonic_distortion,
)
from benchtool.analysis.spectra.line_errors import LineErrors
from benchtool.analysis.statistics.scatter import MeanError
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined, combined_by_names

_STANDARD: Final = "IEC 61000-4-7:2002+A1:2008"
_NAMES: Final[Mapping[Kind, str]] = {
    "group": "current_thd_f_groups",
    "subgroup": "current_thd_f_subgroups",
}


@dataclass(frozen=True)
class Beside:
    """Samples and groups `without` what is between the harmonics, and how much its phases move the
    distortions."""

    samples: CoherentSamples
    without: HarmonicGroups
    of_groups: float
    of_subgroups: float


def distortions(
    spectrum: CoherentSpectrum,
    errors: LineErrors,
    basis: Basis,
    channel: str,
    current_rated_A_rms: float | None,
    unit: str,
) -> Iterator[Measurement]:
    """Yield THD_F, THD_R and, where the rated current is known, TDD."""
    bases = [
        ("current_thd_f", Reference.FUNDAMENTAL, 0.0, "fundamental"),
        ("current_thd_r", Reference.TOTAL, 0.0, Reference.TOTAL.value),
    ]
    if current_rated_A_rms is not None:
        rated = f"rated current of {raw(current_rated_A_rms, 6)} {unit} rms, a reference of benchtool's own"
        bases.append(("current_tdd", Reference.STATED, math.sqrt(2.0) * current_rated_A_rms, rated))
    for name, reference, stated, base in bases:
        distortion = total_harmonic_distortion(spectrum, HIGHEST_HARMONIC, reference, stated, errors)
        last = distortion.highest_harmonic
        text = (
            f"100 x root of (sum of squares of harmonics 2 to {last} - what the noise floor around them and "
            f"repeated quantisation add to it), at least 0, / {base}"
        )
        if reference is Reference.STATED:
            text += ": after IEEE Std 519-2022, which has the maximum demand load current there"
        to_last = replace(basis, bandwidth_Hz=last * spectrum.fundamental_Hz, harmonics=last, reference=base)
        if last < 2 or math.isnan(distortion.with_noise):
            reason = "no harmonic is within the band" if last < 2 else f"the {base} is zero"
            yield Measurement.undefined(name, "%", text, reason, to_last)
            continue
        own = Sensitivities.of_distortion(channel, spectrum.fundamental_Hz)
        if reference is Reference.STATED:
            value = 100.0 * distortion.ratio
            own = Sensitivities((Sensitivity(channel, value),), Harmonics(spectrum.fundamental_Hz))
        yield _distortion(name, distortion, text, to_last, errors.unknown, own)


def _distortion(
    name: str,
    distortion: Distortion,
    definition: str,
    basis: Basis,
    unknown: str,
    sensitivities: Sensitivities,
) -> Measurement:
    """Return a distortion without the power of its noise, undefined where that is not known."""
    if math.isnan(distortion.ratio):
        reason = "fewer than 8 bins are between harmonics: record longer"
        return Measurement.undefined(name, "%", definition, reason, basis)
    source = (
        f"{', '.join(each.name for each in distortion.budget)}; noise and repeated quantisation alone would "
        f"read {raw(100 * distortion.noise, 2)} %, with which it is {raw(100 * distortion.with_noise, 4)} %"
    )
    found = combined(distortion.budget, source)
    return Measurement(
        name,
        100.0 * distortion.ratio,
        "%",
        definition,
        basis,
        None if found is None else found.scaled(100.0),
        uncertainty_reason=unknown if found is None else "",
        sensitivities=sensitivities,
    )


def group_distortions(
    coherent: CoherentSamples,
    spectrum: CoherentSpectrum,
    errors: LineErrors,
    groups: HarmonicGroups | None,
    basis: Basis,
    channel: str,
    beside: Beside | None = None,
) -> Iterator[Measurement]:
    """Yield the distortions by groups and by subgroups; undefined without `groups`. Where there is something
    `beside` the harmonics, the noise is that of the groups without it."""
    if groups is None:
        orders = max(0, int(coherent.usable_order))
        reason = (
            f"{coherent.periods} electrical periods in the window and {orders} harmonics in the band, at "
            f"least 4 and 2 are needed: record longer, or at a higher rate"
        )
        for kind, name in _NAMES.items():
            to_order_1 = replace(basis, reference=f"{kind} of order 1")
            yield Measurement.undefined(name, "%", _definition(kind, "and above"), reason, to_order_1)
        return
    for kind, found in _by_groups(coherent, spectrum, errors, groups, beside).items():
        text = _definition(kind, f"to {groups.orders}")
        if groups.periods_per_window < PERIODS_PER_WINDOW:
            text += (
                f", over the {groups.periods_per_window} periods there are in place of {PERIODS_PER_WINDOW}"
            )
        own = replace(group_basis(coherent, groups, basis), reference=f"{kind} of order 1")
        if math.isnan(found.ratio):
            reason = "order 1 is zero, or alone in the band"
            yield Measurement.undefined(_NAMES[kind], "%", text, reason, own)
            continue
        uncertain = _percent([each for each in found.budget if each.standard != 0.0])
        if groups.windows < FEWEST_WINDOWS and math.isnan(errors.wander[0]):
            uncertain = None  # what an amplitude that wanders adds to them has no scatter
        yield Measurement(
            _NAMES[kind],
            100.0 * found.ratio,
            "%",
            text,
            own,
            uncertain,
            uncertainty_reason=errors.unknown if uncertain is None else "",
            sensitivities=Sensitivities.of_distortion(channel, spectrum.fundamental_Hz),
        )


def _definition(kind: Kind, orders: str) -> str:
    return f"100 x rms of harmonic {kind}s of order 2 {orders} / {kind} of order 1, after {_STANDARD}"


def _by_groups(
    coherent: CoherentSamples,
    spectrum: CoherentSpectrum,
    errors: LineErrors,
    groups: HarmonicGroups,
    beside: Beside | None,
) -> Mapping[Kind, GroupDistortion]:
    """Return the distortions as ratios, with all that makes them uncertain."""
    errors = errors.first(groups.orders)  # the last harmonics may be without a whole group
    distortion = total_harmonic_distortion(spectrum, len(errors.noise), errors=errors)
    by_noise = combined(distortion.of_harmonics, "")
    of_order_1, noise = distortion.of_fundamental, None
    if by_noise is not None:
        # windows leave out the rest of the periods
        rest = math.sqrt(coherent.periods / (groups.windows * groups.periods_per_window))
        noise, of_order_1 = MeanError(rest * by_noise.standard, by_noise.dof), rest * of_order_1
    # the square that a converter's steps add to the harmonics, at most, over that of the fundamental
    steps2 = errors.most_power_of_steps / spectrum.fundamental**2 if spectrum.fundamental else 0.0
    samples, clean = (coherent, groups) if beside is None else (beside.samples, beside.without)
    begins, of_bursts = scatter_of_begins(samples, HIGHEST_HARMONIC), scatter_of_bursts(samples)
    found: dict[Kind, GroupDistortion] = {}
    for kind in _NAMES:
        value = group_distortion(clean, kind, noise, of_order_1, distortion.with_noise, of_bursts)
        ratio = ratio_of(groups.of(kind)) if groups.orders > 1 else value.ratio
        budget = [*value.budget, Contribution("phase at which windows begin", "B", begins[kind])]
        added = ratio - math.sqrt(max(0.0, ratio**2 - steps2))
        if added:
            budget.append(Contribution("steps of the converter that repeat", "B", added))
        if beside is not None:
            phases = beside.of_groups if kind == "group" else beside.of_subgroups
            budget.append(Contribution("phases of components between the harmonics", "B", phases))
        found[kind] = GroupDistortion(ratio, tuple(budget))
    return found


def group_basis(coherent: CoherentSamples, groups: HarmonicGroups, basis: Basis) -> Basis:
    """Return the basis of numbers of groups."""
    periods = groups.windows * groups.periods_per_window
    return replace(
        basis,
        samples=coherent.samples * periods / coherent.periods,
        duration_s=periods / coherent.fundamental_Hz,
        bandwidth_Hz=(groups.orders + 1) * coherent.fundamental_Hz,
        window=f"rectangular, {groups.periods_per_window} whole periods; {_over(groups.windows)}",
        harmonics=groups.orders,
    )


def _over(windows: int) -> str:
    return "one of them" if windows == 1 else f"rms over {windows} of them"


def _percent(budget: Iterable[Contribution]) -> Uncertainty | None:
    found = combined_by_names(budget)
    return None if found is None else found.scaled(100.0)
