"""Disagreements: numbers by the drive's estimate that a torque transducer contradicts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from benchtool.analysis import BANDWIDTH, Measurement, Uncertainty, of_difference, raw
from benchtool.plan import JudgedLimit, Limit, Verdict

_TRANSDUCER = "transducer_"
_MEAN_DIFFERENCES: Final = {"torque_mean": "torque_error"}


@dataclass(frozen=True)
class Disagreement:
    """A number by the drive's estimate, and by the transducer, further apart than their uncertainties.

    Where the transducer is slower than the capture, the estimate in the band that it shows was compared with
    what it read.
    `difference` is the uncertainty of the difference of the two that were compared.
    `judged` is the plan's limit held against the transducer's number; None without a limit.
    """

    estimate: Measurement
    true: Measurement
    difference: Uncertainty
    judged: JudgedLimit | None = None

    def __str__(self) -> str:
        """Return what each of the two reads and, with a limit, how the transducer's meets it."""
        shaft = f"is {self.true.in_unit}"
        if self.judged is not None:
            told = self.judged.told
            shaft = f"{shaft if told is None else told.reason} ({self.judged.verdict})"
        return (
            f"{self.name} is {self.estimate.in_unit} by the drive's own estimate{self.band_text}; "
            f"on the shaft it {shaft}"
        )

    @property
    def verdict(self) -> Verdict | None:
        """That of the transducer's number under the plan's limit; None without a limit."""
        return None if self.judged is None else self.judged.verdict

    @property
    def name(self) -> str:
        """Name of the number by the estimate."""
        return self.estimate.name

    @property
    def compared(self) -> Measurement:
        """The number by the estimate that is held against the transducer's."""
        return in_common_band(self.estimate)

    @property
    def shown(self) -> Measurement:
        """The transducer's number that it is held against: in its band what it read."""
        return _shown(self.estimate, self.true)

    @property
    def band_text(self) -> str:
        """What estimate and transducer are in the transducer's band, in brackets; empty where the whole was
        compared."""
        if self.compared is self.estimate:
            return ""
        return (
            f" ({self.compared.in_unit} in the transducer's band, up to {raw(self._band_Hz, 4)} Hz, where "
            f"the transducer reads {self.shown.in_unit})"
        )

    @property
    def _band_Hz(self) -> float:
        band_Hz = None if self.compared is self.estimate else self.compared.basis.bandwidth_Hz
        return math.nan if band_Hz is None else band_Hz

    def to_json(self) -> dict[str, Any]:
        """Return both values, and the verdict on the transducer's."""
        document: dict[str, Any] = {
            "estimate": self.estimate.value,
            "transducer": self.true.value,
            "unit": self.estimate.unit,
            "standard_uncertainty": self.difference.standard,
            "verdict_by_transducer": None if self.verdict is None else str(self.verdict),
        }
        if self.compared is not self.estimate:
            document |= {
                "estimate_in_band": self.compared.value,
                "transducer_in_band": self.shown.value,
                "band_Hz": self._band_Hz,
            }
        return document


def transducer_name(name: str) -> str:
    """Return the name of the transducer's number for a number by the drive's estimate."""
    return f"{_TRANSDUCER}{name}"


def mean_difference_name(name: str) -> str:
    """Return the name of the mean difference to the transducer over the same time, whose uncertainty leaves
    out what both have in common, as a load that wanders; empty for a number that has none."""
    return _MEAN_DIFFERENCES.get(name, "")


def in_common_band(estimate: Measurement) -> Measurement:
    """Return a number by the estimate in the band of a slower transducer; itself where there is none."""
    return estimate.in_common_band or estimate


def disagreements(
    measurements: Sequence[Measurement], limits: Mapping[str, Limit]
) -> tuple[Disagreement, ...]:
    """Return every number NAME that differs from transducer_NAME by more than the expanded uncertainty of
    both, in the transducer's band where that ends below the capture's.

    An unknown uncertainty counts as zero, so that no disagreement is missed.
    """
    return tuple(_disagreements({each.name: each for each in measurements}, limits))


def _disagreements(found: Mapping[str, Measurement], limits: Mapping[str, Limit]) -> Iterator[Disagreement]:
    for name, estimate in found.items():
        true = found.get(transducer_name(name))
        seen = in_common_band(estimate)
        if true is None or not (math.isfinite(true.value) and math.isfinite(seen.value)):
            continue
        difference = _of_mean_difference(found, name) or _of_difference(estimate, true)
        if abs(seen.value - _shown(estimate, true).value) > difference.expanded:
            judged = JudgedLimit.of(name, limits[name], true) if name in limits else None
            yield Disagreement(estimate, true, difference, judged)


def _shown(estimate: Measurement, true: Measurement) -> Measurement:
    """Return the transducer's number that the estimate is held against: in the transducer's band, where the
    estimate is as the transducer would read it, what it read, with what is not known of that."""
    if estimate.in_common_band is None:
        return true
    uncertainty = true.uncertainty
    if uncertainty is not None:
        budget = uncertainty.budget
        lags = [each for each in budget if each.instrument and each.instrument.effect == BANDWIDTH]
        uncertainty = uncertainty.without(lags)
        if true.value:  # it was enlarged with the value
            uncertainty = uncertainty.scaled(true.as_read / true.value)
    return replace(true, value=true.as_read, uncertainty=uncertainty, correction=None)


def _of_mean_difference(found: Mapping[str, Measurement], name: str) -> Uncertainty | None:
    """Return that of the number that is the difference; None where there is none, or none is known of it."""
    difference = found.get(mean_difference_name(name))
    return None if difference is None else _known(difference.uncertainty)


def _of_difference(estimate: Measurement, true: Measurement) -> Uncertainty:
    """Return that of the difference of the two numbers that are compared, taken as independent."""
    seen, shown = in_common_band(estimate), _shown(estimate, true)
    unknown = Uncertainty(0.0, "not known")
    return of_difference(_known(seen.uncertainty) or unknown, _known(shown.uncertainty) or unknown)


def _known(uncertainty: Uncertainty | None) -> Uncertainty | None:
    return None if uncertainty is None or not math.isfinite(uncertainty.expanded) else uncertainty
