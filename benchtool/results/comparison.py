"""Cases of runs side by side, and how many of their differences chance would make."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Literal, Protocol, Self, TypeVar

from benchtool.analysis import COVERAGE, Measurement, raw
from benchtool.plan import Limit, Verdict
from benchtool.results.assessment import Assessment
from benchtool.results.calibration import Overdue
from benchtool.results.comparability import SAME
from benchtool.results.delta import Delta, Measured, deltas
from benchtool.results.judged_repetitions import JudgedTogether
from benchtool.results.repetitions import Repeated


@dataclass(frozen=True)
class Chance:
    """Number of `decided` differences that exceed their uncertainty, without a correction for their
    number."""

    decided: int
    exceeding: int

    @classmethod
    def of(cls, deltas: Sequence[Delta]) -> Self:
        """Count those that have an uncertainty."""
        decided = [each.exceeds for each in deltas if each.exceeds is not None]
        return cls(len(decided), sum(decided))

    @property
    def expected(self) -> float:
        """Expected number of false alarms if nothing differed; it also holds for dependent differences."""
        return self.decided * (1.0 - COVERAGE)

    def __str__(self) -> str:
        """Return a sentence; empty where none or one is decided."""
        if self.decided < 2:
            return ""
        return (
            f"{self.exceeding} of {self.decided} differences exceed their uncertainty; if nothing differed, "
            f"{raw(self.expected, 2)} of them would do so by chance on average."
        )

    def to_json(self) -> dict[str, Any]:
        """Return the counts and the number expected by chance."""
        return {
            "decided": self.decided,
            "exceeding": self.exceeding,
            "expected_by_chance": self.expected,
        }


class MeasuredCase(Measured, Protocol):
    """What was measured in a case of a plan."""

    @property
    def case(self) -> str: ...

    @property
    def verdicts(self) -> Mapping[str, Verdict]: ...


@dataclass(frozen=True)
class RepeatedCase:
    """What a case came to over its repetitions: their means, and the limits that hold for them together."""

    case: str
    together: tuple[Repeated, ...]

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """The means."""
        return tuple(each.measured for each in self.together)

    @property
    def judged(self) -> tuple[JudgedTogether, ...]:
        """The limits over the repetitions."""
        return tuple(each.judged for each in self.together if each.judged is not None)

    @property
    def limits(self) -> Mapping[str, Limit]:
        """Those limits, by name."""
        return {each.name: each.limit for each in self.judged}

    @property
    def verdicts(self) -> Mapping[str, Verdict]:
        """Their verdicts."""
        return {each.name: each.verdict for each in self.judged}


_Result = TypeVar("_Result", bound=MeasuredCase, covariant=True)


@dataclass(frozen=True)
class SideBySide(Generic[_Result]):
    """The same case of several runs; the first is the reference. `deltas` are of the others, by label."""

    case: str
    results: Mapping[str, _Result]
    deltas: Mapping[str, tuple[Delta, ...]]

    @classmethod
    def of(cls, case: str, results: Mapping[str, _Result]) -> Self:
        """Compare `results`, by label, with the first of them."""
        (_, reference), *others = results.items()
        return cls(case, results, {label: deltas(reference, other) for label, other in others})

    @property
    def names(self) -> tuple[str, ...]:
        """Every measurement that one of the runs has."""
        found = (each.name for result in self.results.values() for each in result.measurements)
        return tuple(dict.fromkeys(found))

    @property
    def chance(self) -> Chance:
        """Number of significant differences of all runs, compared with the number expected by chance."""
        return Chance.of([each for found in self.deltas.values() for each in found])

    @property
    def not_compared(self) -> tuple[str, ...]:
        """A sentence for each reason why values are not compared, with their names."""
        found = self._by_reason(lambda delta: delta.reason)
        return tuple(f"{', '.join(names)}: {reason}." for reason, names in found.items())

    @property
    def without_uncertainty(self) -> Mapping[str, tuple[str, ...]]:
        """The names of the differences without an uncertainty, by the reason."""
        return self._by_reason(lambda delta: delta.uncertainty_reason)

    @property
    def without_percent(self) -> Mapping[str, tuple[str, ...]]:
        """The names of the differences that are not told in percent, by the reason."""
        return self._by_reason(lambda delta: delta.percent_reason)

    def _by_reason(self, reason_of: Callable[[Delta], str]) -> dict[str, tuple[str, ...]]:
        found: dict[str, dict[str, None]] = {}
        for each in (delta for of_run in self.deltas.values() for delta in of_run):
            if reason := reason_of(each):
                found.setdefault(reason, {})[each.name] = None
        return {reason: tuple(names) for reason, names in found.items()}


@dataclass(frozen=True)
class Comparison(SideBySide[Assessment]):
    """A case of several runs, or cases of one, side by side."""

    @property
    def overdue(self) -> tuple[Overdue, ...]:
        """The instruments of any of the runs whose calibration was due before it."""
        return tuple(dict.fromkeys(late for result in self.results.values() for late in result.overdue))

    @property
    def unlike(self) -> tuple[str, ...]:
        """A sentence for each condition under which runs were measured unlike the first one."""
        durations = {label: _greatest(result, "duration_s") for label, result in self.results.items()}
        rates = {label: _greatest(result, "sample_rate_Hz") for label, result in self.results.items()}
        found = (
            (
                "Measured over other times",
                _unlike_first(durations, "over", "s"),
                "A peak-to-peak value grows with the length of a record, and what noise adds to amplitudes "
                "and distortions falls.",
            ),
            (
                "Sampled at other rates",
                _unlike_first(rates, "at", "Hz"),
                "What lies above half the lower rate is in the numbers of one run alone, or is aliased "
                "there: densities, groups, and peak-to-peak values differ by that too.",
            ),
        )
        return tuple(f"{what}: {shown}. {effect}" for what, shown, effect in found if shown)


def compare_cases(runs: Mapping[str, Sequence[Assessment]]) -> tuple[tuple[Comparison, ...], tuple[str, ...]]:
    """Return the cases of several runs matched by name, and those without a counterpart in the first run."""
    comparisons = tuple(Comparison.of(case, found) for case, found in _matched(runs))
    compared = {id(result) for each in comparisons for result in each.results.values()}
    alone = (
        f"{label}: {each.case}" for label, found in runs.items() for each in found if id(each) not in compared
    )
    return comparisons, tuple(alone)


def compare_repeated(
    runs: Mapping[str, Mapping[str, tuple[Repeated, ...]]],
) -> tuple[SideBySide[RepeatedCase], ...]:
    """Return what several runs come to over the repetitions of their cases, matched as cases are; nothing of
    a case that has no counterpart."""
    cases = {
        label: [RepeatedCase(case, together) for case, together in repeated.items()]
        for label, repeated in runs.items()
    }
    found = (SideBySide.of(case, results) for case, results in _matched(cases))
    return tuple(each for each in found if each.deltas)


def _matched(runs: Mapping[str, Sequence[_Result]]) -> Iterator[tuple[str, Mapping[str, _Result]]]:
    """Yield the cases of the first run, each with those of the same name in the others.

    Runs of one case each are compared regardless of names; of a single run, its cases are compared with the
    first.
    """
    (_, reference), *others = runs.items()
    if len(runs) == 1:
        if reference:
            yield "", {each.case: each for each in reference}
    elif all(len(found) == 1 for found in runs.values()):
        yield "", {label: found[0] for label, found in runs.items()}
    else:
        for one in reference:
            same = {label: each for label, found in others for each in found if each.case == one.case}
            if same:
                yield one.case, {next(iter(runs)): one, **same}


def _greatest(result: Assessment, of_basis: Literal["duration_s", "sample_rate_Hz"]) -> float:
    """Return the greatest value of all measurements; 0 if unknown."""
    return max((getattr(each.basis, of_basis) or 0.0 for each in result.measurements), default=0.0)


def _unlike_first(values: Mapping[str, float], preposition: str, unit: str) -> str:
    """Return the value of the first label and those that differ from it; empty where none does."""
    first, *others = values
    unlike = [
        label
        for label in others
        if abs(values[label] - values[first]) > SAME * max(values[label], values[first])
    ]
    shown = (f"{label} {preposition} {raw(values[label], 5)} {unit}" for label in (first, *unlike))
    return ", ".join(shown) if unlike else ""
