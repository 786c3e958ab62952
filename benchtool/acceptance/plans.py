"""Plans that a test runs on its bench."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from benchtool.acceptance.measuring import held
from benchtool.acceptance.notes import Notes

if TYPE_CHECKING:
    from benchtool.api import Bench, PlanResult
    from benchtool.plan import Plan


def run_on_bench(
    bench: Bench, plan: str | Path | Plan, notes: Notes, *, judge: bool, allow_different: bool
) -> PlanResult:
    """Run a plan on an open bench, and keep its bundle with the test.

    The limits become those of the test, the operating point's among them: one that was not reached fails.

    Args:
        judge: whether they do.
        allow_different: run a drive whose parameters contradict the profile.

    Raises:
        PlanError: the plan is wrong, or does not fit the bench.
        BenchError: whatever went wrong; the drive is disabled.
    """
    title = Path(plan).stem if isinstance(plan, str | Path) else plan.title
    folder = notes.path(title)
    result = bench.run(plan, folder, allow_different=allow_different)
    notes.attach(title, folder)
    if judge:
        for each in result.result.assessments:
            prefix = f"{each.case}: " if len(result) > 1 else ""
            for name, limit in each.limits.items():
                found = each.found.get(name)
                if found is None:
                    judged = held(f"{prefix}{name}", None, limit.unit or "", limit)
                else:
                    judged = held(
                        *(f"{prefix}{name}", found.value, found.unit, limit, found.uncertainty),
                        reason=found.reason,
                        below=found.upper_bound,
                    )
                notes.judged.append(judged)
    return result
