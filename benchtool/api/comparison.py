"""Runs and results side by side, with their differences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from benchtool.api.bundles import Bundle, folder_of
from benchtool.api.named import Named
from benchtool.api.plans import CaseResult, PlanResult
from benchtool.api.results import Results
from benchtool.errors import AnalysisError, UsageError
from benchtool.notebook import table_html

if TYPE_CHECKING:
    from benchtool.plan import Limit
    from benchtool.results import Delta

Comparable: TypeAlias = str | Path | Bundle | PlanResult | Results


class Comparison(Named["Delta"]):
    """Differences of one run, or one result, to a reference, by measurement.

        benchtool.compare("runs/tpc", "runs/dtc")["torque_ripple_pp"].percent

    `exceeds` of a difference tells whether it is more than its expanded uncertainty.
    """

    def __init__(self, reference: str, other: str, deltas: Sequence[Delta]) -> None:
        self.reference = reference
        self.other = other
        self._deltas = {each.name: each for each in deltas}

    def __getitem__(self, name: str) -> Delta:
        """Return the difference of a measurement.

        Raises:
            AnalysisError: not both have it.
        """
        if name not in self._deltas:
            raise AnalysisError(
                f"'{name}' was not measured of both {self.reference} and {self.other}: there are "
                f"{', '.join(self) or 'none'}"
            )
        return self._deltas[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._deltas)

    def __str__(self) -> str:
        rows = [[*row] for row in self._rows()]
        widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))] if rows else []
        head = f"{self.other} against {self.reference} (* beyond the expanded uncertainty, ~ within)"
        lines = [
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows
        ]
        return "\n".join([head, *(line.rstrip() for line in lines)])

    def __repr__(self) -> str:
        return f"<Comparison of {self.other} against {self.reference}: {len(self)} measurements>"

    def _rows(self) -> Iterator[tuple[str, ...]]:
        for each in self._deltas.values():
            values = each.reference_text, each.value_text, each.text
            yield (each.name, *values, each.marked_percent(" %"), each.unit)

    def _repr_html_(self) -> str:
        titles = ("measurement", f">{self.reference}", f">{self.other}", ">difference", ">", "unit")
        return table_html(
            titles, self._rows(), footer="* beyond the expanded uncertainty (95 %), ~ within it"
        )


def compare(reference: Comparable, other: Comparable) -> Comparison:
    """Set two results side by side; recorded runs are measured again.

    Args:
        reference: a bundle or its folder, what `run` gave, or what `analyze` gave; of one case.
        other: likewise.

    Raises:
        UsageError: one of them has several cases: `PlanResult[name]` and the folder of a case are one.
        AnalysisError, RecordingError: a run cannot be measured again.
    """
    from benchtool.results import deltas

    one, two = _Measured(reference), _Measured(other)
    labels = [one.label, two.label]
    if labels[0] == labels[1]:
        labels = [f"{one.label} (A)", f"{two.label} (B)"]
    return Comparison(labels[0], labels[1], deltas(one, two))


class _Measured:
    """Measurements, and the limits that say which direction is good."""

    def __init__(self, given: Comparable) -> None:
        result = given if isinstance(given, Results) else _result(given)
        self.measurements = result.measurements
        self.limits: Mapping[str, Limit] = {}
        self.label = "result"
        if isinstance(result, CaseResult):
            self.limits = result.assessment.limits
            self.label = result.folder.resolve().name
        elif isinstance(given, Bundle):
            self.label = given.path.resolve().name


def _result(run: str | Path | Bundle | PlanResult) -> Results:
    from benchtool.results import complete_cases

    if isinstance(run, PlanResult):
        return run.case
    if isinstance(run, Bundle):
        return run.analyze()
    folder = folder_of(run)
    found = complete_cases(folder)
    if len(found) != 1:
        names = ", ".join(each.case for each in found)
        raise UsageError(f"{folder} holds {len(found)} cases, {names}: compare the folders of two of them")
    return CaseResult(found[0])
