"""The cases of a plan: one for each point of its sweep and each repetition."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from benchtool.experiment.plan import OperatingPoint, Plan, Setting


@dataclass(frozen=True)
class Case:
    """One point of a plan: its name, what differs from the plan's setup, and where the machine runs."""

    name: str
    setup: Mapping[str, Setting]
    operating_point: OperatingPoint

    @property
    def folder(self) -> str:
        """The name as a folder is called."""
        return re.sub(r"[^\w.,=+-]", "_", self.name)


def cases(plan: Plan) -> tuple[Case, ...]:
    """Every case of `plan`, in the order in which they run."""
    return tuple(
        _case(plan, point, repetition)
        for point in _points(plan)
        for repetition in range(1, plan.repetitions + 1)
    )


def _points(plan: Plan) -> Iterator[tuple[tuple[str, Setting], ...]]:
    axes = [
        [(key, value) for value in values]
        for key, values in (*plan.sweep.setup.items(), *plan.sweep.operating_point.items())
    ]
    if not axes:
        return iter([()])
    return itertools.product(*axes) if plan.sweep.order == "grid" else zip(*axes, strict=True)


def _case(plan: Plan, point: tuple[tuple[str, Setting], ...], repetition: int) -> Case:
    values: dict[str, Setting] = dict(point)
    name = (
        ",".join(_part(key, value) for key, value in point) or plan.case or str(plan.setup.get("law", "case"))
    )
    if plan.repetitions > 1:
        name = f"{name}.{repetition}"
    swept = {key: value for key, value in values.items() if key in set[str](plan.sweep.operating_point)}
    return Case(
        name,
        {key: value for key, value in values.items() if key in plan.sweep.setup},
        plan.operating_point.model_copy(update=swept),
    )


def _part(key: str, value: Setting) -> str:
    return value if isinstance(value, str) else f"{key}={value:g}"
