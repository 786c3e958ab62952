"""The analyses of a steady state that a plan does not make, as far as that is known before it runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from benchtool.plan.cases import Case, cases
from benchtool.plan.lazy_catalogue import catalogue
from benchtool.plan.model import Plan
from benchtool.plan.rating import speed_rad_s

if TYPE_CHECKING:
    from benchtool.analysis import Analysis


def not_made(plan: Plan, *, transducer: bool) -> dict[str, str]:
    """Return the analyses that the recorded channels or the length of the record do not allow, by title, each
    with what it needs."""
    channels, found = frozenset(plan.record.channels), {}
    for analysis in catalogue().analyses:
        settings = plan.analyses.settings(analysis) if analysis.of_steady_state else None
        if settings is None or not plan.analyses.made(analysis) or analysis.transducer > transducer:
            continue
        if missing := analysis.missing(channels, settings):
            found[analysis.title] = f"needs {', '.join(missing)}"
        elif analysis.every_tick and plan.record.stride > 1:
            found[analysis.title] = f"needs every tick, record.stride is {plan.record.stride}"
        elif few := few_revolutions(plan, analysis, cases(plan)):
            found[analysis.title] = few
    return found


def few_revolutions(plan: Plan, analysis: Analysis[Any], among: Sequence[Case]) -> str:
    """Return that the steady state of a case is too short for an analysis, by the first such case; empty
    where none is, or where the speed is not known before the run."""
    window_s = plan.record.duration_s - plan.analyses.steady_from_s
    for case in among:
        omega_m = speed_rad_s(case.operating_point, plan.stimulus)
        if omega_m is None or not analysis.fewest_revolutions:
            continue
        turns = window_s * abs(omega_m) / (2.0 * math.pi)
        if turns < analysis.fewest_revolutions:
            least_s = analysis.fewest_revolutions * window_s / turns if turns else math.inf
            remedy = (
                f"record {plan.analyses.steady_from_s + least_s:.3g} s at least" if turns else "it stands"
            )
            of_case = f" (case '{case.name}')" if len(cases(plan)) > 1 else ""
            return (
                f"needs {analysis.fewest_revolutions:g} mechanical revolutions, the steady state lasts "
                f"{window_s:g} s, {turns:.3g} at {omega_m:g} rad/s{of_case}: {remedy}"
            )
    return ""
