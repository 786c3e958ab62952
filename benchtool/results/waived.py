"""Limits that were not met and are waived, of cases and of their repetitions together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from benchtool.plan import Missed, Waived
from benchtool.results.assessment import Assessment
from benchtool.results.repetitions import Repeated, judged_together


@dataclass(frozen=True)
class WaivedLimit:
    """A limit of a `case` that was not met, `missed` in words, and the `consent` to that."""

    case: str
    missed: Missed
    consent: Waived


def waived_limits(
    cases: Iterable[Assessment], repeated: Mapping[str, Sequence[Repeated]]
) -> Iterator[WaivedLimit]:
    """Yield those of each case, then those of the repetitions of cases together, by the case's name."""
    alone = ((case.case, each) for case in cases for each in case.judged.values())
    for case, each in (*alone, *judged_together(repeated)):
        if each.waived is not None and each.limit.waived is not None:
            yield WaivedLimit(case, each.waived, each.limit.waived)
