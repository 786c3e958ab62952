"""Where the shaft does not agree with the drive: numbers of its estimate that a transducer contradicts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchtool.analysis import Measurement, Uncertainty
from benchtool.analysis.uncertainty import of_difference
from benchtool.plan.limits import Limit, Verdict

_TRUE = "true_"


@dataclass(frozen=True)
class Disagreement:
    """A number by the drive's estimate, and by the transducer, further apart than their uncertainties.

    `verdict` is what the plan's limit says of the transducer's number; None without a limit.
    """

    estimate: Measurement
    true: Measurement
    verdict: Verdict | None

    @property
    def name(self) -> str:
        """Of the number by the estimate."""
        return self.estimate.name

    def to_json(self) -> dict[str, Any]:
        """Both values, and what the limit says of the transducer's."""
        return {
            "estimate": self.estimate.value,
            "transducer": self.true.value,
            "unit": self.estimate.unit,
            "standard_uncertainty": _of_difference(self.estimate, self.true).standard,
            "verdict_by_transducer": None if self.verdict is None else str(self.verdict),
        }


def true_name(name: str) -> str:
    """The name by the transducer of what NAME is by the drive's estimate."""
    return f"{_TRUE}{name}"


def disagreements(
    measurements: Sequence[Measurement], limits: Mapping[str, Limit]
) -> tuple[Disagreement, ...]:
    """Every number NAME that differs from true_NAME by more than the expanded uncertainty of the difference.

    An uncertainty that is not known counts as zero, so that a difference is rather told once too often.
    """
    return tuple(_disagreements({each.name: each for each in measurements}, limits))


def _disagreements(found: Mapping[str, Measurement], limits: Mapping[str, Limit]) -> Iterator[Disagreement]:
    for name, estimate in found.items():
        true = found.get(true_name(name))
        if true is None or not (math.isfinite(true.value) and math.isfinite(estimate.value)):
            continue
        if abs(estimate.value - true.value) > _of_difference(estimate, true).expanded:
            verdict = limits[name].judge(true.value, true.uncertainty) if name in limits else None
            yield Disagreement(estimate, true, verdict)


def _of_difference(estimate: Measurement, true: Measurement) -> Uncertainty:
    return of_difference(_known(estimate.uncertainty), _known(true.uncertainty))


def _known(uncertainty: Uncertainty | None) -> Uncertainty:
    known = uncertainty is not None and math.isfinite(uncertainty.expanded)
    return uncertainty if known and uncertainty is not None else Uncertainty(0.0, "not known")
