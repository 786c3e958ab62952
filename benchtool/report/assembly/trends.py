"""Which measurements of a plan's cases are drawn over what is swept, and their values."""

from __future__ import annotations

import math
from collections.abc import Sequence

from benchtool.analysis import Measurement, catalogue
from benchtool.plan import Limit, Plan, Setting
from benchtool.report.figures.trend import REPETITION, Point, Trend
from benchtool.results import Assessment, Repeated, over_repetitions

_MOST = 3
_ALONE = "measured"  # what a legend calls a single series


def trend_names(plan: Plan, results: Sequence[Assessment]) -> tuple[str, ...]:
    """Return the measurements that are worth a trend: what the plan draws and judges, else what is asked
    first."""
    if len(results) < 2:
        return ()
    measured = {each.name for result in results for each in result.measurements if each.is_told}
    judged = [*plan.limits, *(name for limits in plan.case_limits.values() for name in limits)]
    asked = [plan.figure_of] if plan.figure == "sweep" else []
    names = dict.fromkeys(name for name in (*asked, *judged) if name in measured)
    return (
        tuple(names)[:_MOST]
        or tuple(name for name in (plan.figure_of, *catalogue().headline) if name in measured)[:1]
    )


def trend_of(plan: Plan, results: Sequence[Assessment], name: str) -> Trend:
    """Return one measurement over what the plan sweeps, the mean where it repeats its cases; over the
    repetitions where it does nothing else."""
    units = (each.unit for result in results for each in result.measurements if each.name == name)
    unit = next(units, "")
    if len({result.coordinates.group for result in results}) == 1:
        alone = tuple(_alone(result, name, result.coordinates.repetition) for result in results)
        return Trend(name, unit, REPETITION, {_ALONE: tuple(each for each in alone if each is not None)})
    key, together = _swept(plan), _repeated(plan, results, name)
    apart = _numeric(plan) if plan.sweep.order == "list" else (key,)
    series: dict[str, list[Point]] = {}
    for group, members in _groups(results).items():
        at = members[0].coordinates
        x = float(at.point[key]) if key else group
        point = together[group] if group in together else _alone(members[0], name, x)
        if isinstance(point, Repeated):
            point = _mean(point, members, x)
        if point is not None:
            series.setdefault(at.apart_from(*apart) if key else "", []).append(point)
    return Trend(name, unit, key, {label or _ALONE: tuple(points) for label, points in series.items()})


def _numeric(plan: Plan) -> tuple[str, ...]:
    """Return the swept keys that have numbers, that with the most of them first."""
    axes: dict[str, Sequence[Setting]] = {**plan.sweep.setup, **plan.sweep.emulator}
    axes = {**{str(key): values for key, values in plan.sweep.operating_point.items()}, **axes}
    numeric = [key for key, values in axes.items() if not any(isinstance(value, str) for value in values)]
    return tuple(sorted((key for key in numeric if len(axes[key]) > 1), key=lambda key: -len(axes[key])))


def _swept(plan: Plan) -> str:
    return next(iter(_numeric(plan)), "")


def _groups(results: Sequence[Assessment]) -> dict[str, list[Assessment]]:
    groups: dict[str, list[Assessment]] = {}
    for result in results:
        groups.setdefault(result.coordinates.group, []).append(result)
    return groups


def _repeated(plan: Plan, results: Sequence[Assessment], name: str) -> dict[str, Repeated]:
    found = over_repetitions(plan, {result.case: result.measurements for result in results})
    return {group: each for group, together in found.items() for each in together if each.name == name}


def _alone(result: Assessment, name: str, x: float | str) -> Point | None:
    measured = next((each for each in result.measurements if each.name == name and each.is_told), None)
    return None if measured is None else _point(x, measured, (), result.limits.get(name))


def _mean(together: Repeated, members: Sequence[Assessment], x: float | str) -> Point:
    judged = together.judged or members[0].judged.get(together.name)
    single = tuple(
        each.value
        for member in members
        for each in member.measurements
        if each.name == together.name and math.isfinite(each.value)
    )
    return _point(x, together.measured, single, None if judged is None else judged.limit)


def _point(x: float | str, measured: Measurement, single: tuple[float, ...], limit: Limit | None) -> Point:
    expanded = math.nan if measured.uncertainty is None else measured.uncertainty.expanded
    bound = measured.upper_bound
    least, greatest = (None, None) if limit is None else (limit.min, limit.max)
    value = measured.value if bound is None else bound
    return Point(x, value, expanded, single, least, greatest, bound is not None)
