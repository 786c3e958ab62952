"""Results of the cases of a plan, and of their repetitions together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from benchtool.plan import Missed, Verdict, worst
from benchtool.results.assessment import Assessment
from benchtool.results.calibration import Overdue
from benchtool.results.judged_repetitions import JudgedTogether, LimitsTogether
from benchtool.results.repetitions import Repeated, judged_together


@dataclass(frozen=True)
class RunResult:
    """Results of every case of a plan and, by the name of each case, of its repetitions together."""

    assessments: tuple[Assessment, ...]
    repeated: Mapping[str, tuple[Repeated, ...]] = field(default_factory=dict)

    @property
    def verdict(self) -> Verdict:
        return worst((*(each.verdict for each in self.assessments), self._verdict_together))

    @property
    def unjudged(self) -> Mapping[str, LimitsTogether]:
        """Limits that hold for repetitions of which one alone is here, by the name of that."""
        if self.repeated:
            return {}
        return {each.case: each.together for each in self.assessments if each.together is not None}

    @property
    def missed(self) -> tuple[tuple[str, Missed], ...]:
        """The limits over repetitions that were not met, each with its case."""
        judged = judged_together(self.repeated)
        return tuple((case, told) for case, each in judged if (told := each.missed))

    @property
    def contradicted(self) -> tuple[tuple[str, JudgedTogether], ...]:
        """The limits over repetitions whose value the transducer contradicts, each with its case."""
        judged = judged_together(self.repeated)
        return tuple((case, each) for case, each in judged if each.disagreement is not None)

    @property
    def overdue(self) -> tuple[Overdue, ...]:
        """The instruments whose calibration was due before their case was run."""
        return tuple(dict.fromkeys(each for case in self.assessments for each in case.overdue))

    @property
    def _verdict_together(self) -> Verdict:
        unjudged = [Verdict.UNDECIDED] if self.unjudged else []
        return worst((*(each.counted for _, each in judged_together(self.repeated)), *unjudged))

    @property
    def verdict_by_transducer(self) -> Verdict | None:
        """As that of the cases; None where none has a transducer."""
        found = [each.verdict_by_transducer for each in self.assessments]
        known = [verdict for verdict in found if verdict is not None]
        together = [each.verdict_by_transducer for _, each in judged_together(self.repeated)]
        together += [Verdict.UNDECIDED] if self.unjudged else []
        return worst((*known, *together)) if known else None

    def to_json(self) -> dict[str, Any]:
        """Return the document that `--json` prints."""
        document: dict[str, Any] = {
            "verdict": str(self.verdict),
            "verdict_by_transducer": self.verdict_by_transducer,
            "cases": {each.case: each.to_json() for each in self.assessments},
        }
        if self.repeated:
            document["repeated"] = {
                case: {each.name: each.to_json() for each in together}
                for case, together in self.repeated.items()
            }
        return document
