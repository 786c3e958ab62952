"""What the repetitions of a case come to together: the mean of each measurement, and what it is worth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchtool.analysis import Measurement
from benchtool.experiment.cases import cases
from benchtool.experiment.plan import Plan


@dataclass(frozen=True)
class Repeated:
    """One measurement over `n` repetitions in which it was defined.

    `standard_uncertainty` is that of the mean, the standard deviation over sqrt(n) (JCGM 100:2008, 4.2.3),
    and nan of fewer than two. It knows nothing of what all repetitions share.
    """

    name: str
    unit: str
    mean: float
    standard_uncertainty: float
    n: int

    def to_json(self) -> dict[str, Any]:
        """JSON has no nan, so that it becomes null."""
        return {
            "mean": _finite(self.mean),
            "standard_uncertainty": _finite(self.standard_uncertainty),
            "n": self.n,
            "unit": self.unit,
        }


def over_repetitions(
    plan: Plan, measured: Mapping[str, Sequence[Measurement]]
) -> dict[str, tuple[Repeated, ...]]:
    """Every measurement of every case over its repetitions, by the case's name without their number.

    Args:
        plan: if it has one repetition only, there is nothing to say.
        measured: the measurements of its cases by name.
    """
    if plan.repetitions < 2:
        return {}
    groups: dict[str, list[Sequence[Measurement]]] = {}
    for case in cases(plan):
        groups.setdefault(case.group, []).append(measured[case.name])
    return {name: tuple(_together(group)) for name, group in groups.items()}


def _together(group: Sequence[Sequence[Measurement]]) -> Iterator[Repeated]:
    units = {each.name: each.unit for measurements in group for each in measurements}
    for name, unit in units.items():
        found = (each.value for measurements in group for each in measurements if each.name == name)
        values = [value for value in found if math.isfinite(value)]
        mean = float(np.mean(values)) if values else math.nan
        spread = float(np.std(values, ddof=1)) / math.sqrt(len(values)) if len(values) > 1 else math.nan
        yield Repeated(name, unit, mean, spread, len(values))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
