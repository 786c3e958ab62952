"""Ripple in percent of the mean, or of a rated value."""

from __future__ import annotations

import math
from dataclasses import replace

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.sensitivity import Sensitivities, Sensitivity
from benchtool.analysis.uncertainty import combined

_SMALLEST_MEAN = 0.02  # share of the peak-to-peak ripple below which "percent of mean" has no meaning
_SIGNIFICANT = 5.0  # standard uncertainties of the mean, from which a ratio to it is one


def no_base(mean: Measurement, peak_to_peak: float, name: str) -> str:
    """Return why no percentage of the mean is given; empty if the mean is far enough from zero.

    Of a mean of unknown uncertainty it is not known how much of a ripple that reaches zero is in it.
    """
    size = abs(mean.value)
    if size <= _SMALLEST_MEAN * peak_to_peak:
        return f"the mean {name} is zero, or less than {100 * _SMALLEST_MEAN:g} % of its ripple"
    if mean.uncertainty is None and size <= 0.5 * peak_to_peak:
        return (
            f"the mean {name} of {mean.value:.3g} {mean.unit} has no uncertainty and is less than half of "
            f"its ripple of {peak_to_peak:.3g} {mean.unit} peak to peak: how much of that is in the mean is "
            f"not known, an angle or a speed that tells its periods is expected"
        )
    if mean.uncertainty is not None and size < _SIGNIFICANT * mean.uncertainty.standard:
        return (
            f"the mean {name} of {mean.value:.3g} {mean.unit} has a standard uncertainty of "
            f"{mean.uncertainty.standard:.2g}, at most a fifth of it is allowed for a percentage"
        )
    return ""


def percent(
    number: Measurement,
    prefix: str,
    suffix: str,
    base: float,
    base_text: str,
    reason: str,
    base_number: Measurement | None = None,
) -> Measurement:
    """Return a `number` of a ripple in percent of a base, `base_text`, which is `base_number` where that is
    measured; undefined for a `reason`. Its name is a prefix and a suffix about percent."""
    which = "_rms" if number.name.endswith("_rms") else ""
    name, text = f"{prefix}{which}_percent_{suffix}", f"100 x {number.name} / {base_text}"
    basis = Basis(**{**vars(number.basis), "reference": base_text})
    if reason:
        return Measurement.undefined(name, "%", text, reason, basis)
    scale, uncertain = 100.0 / base, None
    if number.uncertainty is not None and (base_number is None or base_number.uncertainty is not None):
        own = number.uncertainty
        budget = [own.line(number.name, scale)]
        width = None if own.half_width is None else scale * own.half_width
        of_base = None if base_number is None else base_number.uncertainty
        if base_number is not None and of_base is not None:
            share = scale * number.value / base
            budget.append(of_base.line(base_number.name, share))
            width = None if width is None else math.hypot(width, share * of_base.expanded)
        uncertain = combined(budget, " and ".join(each.name for each in budget), half_width=width)
    why = number.uncertainty_reason or (base_number.uncertainty_reason if base_number is not None else "")
    value, why = scale * number.value, why if uncertain is None else ""
    return Measurement(
        name,
        value,
        "%",
        text,
        basis,
        uncertain,
        uncertainty_reason=why,
        sensitivities=_of_percent(number, scale, base_number),
    )


def _of_percent(number: Measurement, scale: float, mean: Measurement | None) -> Sensitivities:
    """Return those of a ripple in percent of a `mean`, whose gain is the ripple's, or of a rated value."""
    whole = number.sensitivities
    parts = tuple(
        Sensitivity(
            each.channel,
            scale * each.gain if mean is None else 0.0,
            0.0 if mean is None else -scale * number.value / mean.value,
            scale * each.resolution,
        )
        for each in whole.channels or ()
    )
    return replace(whole, channels=parts)
