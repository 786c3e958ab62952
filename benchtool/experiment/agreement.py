"""Where the shaft does not agree with the drive: numbers of its estimate that a transducer contradicts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchtool.analysis import Measurement
from benchtool.experiment.limits import Limit, Verdict

COVERAGE = 2.0  # k: of a normal distribution, 95 % of the differences that chance makes lie within
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
            "standard_uncertainty": _standard(self.estimate, self.true),
            "verdict_by_transducer": None if self.verdict is None else str(self.verdict),
        }


def disagreements(
    measurements: Sequence[Measurement], limits: Mapping[str, Limit]
) -> tuple[Disagreement, ...]:
    """Every number NAME that differs from true_NAME by more than twice their combined standard uncertainty.

    The combined one is sqrt(u_1^2 + u_2^2) (JCGM 100:2008, 5.1.2); one that is not known counts as zero, so
    that a difference is rather told once too often.
    """
    return tuple(_disagreements({each.name: each for each in measurements}, limits))


def _disagreements(found: Mapping[str, Measurement], limits: Mapping[str, Limit]) -> Iterator[Disagreement]:
    for name, estimate in found.items():
        true = found.get(f"{_TRUE}{name}")
        if true is None or not (math.isfinite(true.value) and math.isfinite(estimate.value)):
            continue
        if abs(estimate.value - true.value) > COVERAGE * _standard(estimate, true):
            verdict = limits[name].judge(true.value, true.uncertainty) if name in limits else None
            yield Disagreement(estimate, true, verdict)


def _standard(*pair: Measurement) -> float:
    known = (each.uncertainty.standard for each in pair if each.uncertainty is not None)
    return math.hypot(*(value for value in known if math.isfinite(value)))
