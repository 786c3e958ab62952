"""The cases of a plan: one for each point of its sweep and each repetition."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from benchtool.errors import AnalysisError
from benchtool.plan.model import OperatingPoint, Plan, Setting, Variant, part


@dataclass(frozen=True)
class Case:
    """One point of a plan: its name, that of all its repetitions, what differs from the profile's emulated
    bench and from the plan's setup, and where the machine runs."""

    name: str
    group: str
    emulator: Mapping[str, float]
    setup: Mapping[str, Setting]
    operating_point: OperatingPoint
    repetition: int = 1

    @property
    def folder(self) -> str:
        """The name as a folder is called."""
        return re.sub(r"[^\w.,=+-]", "_", self.name)


def cases(plan: Plan) -> tuple[Case, ...]:
    """Every case of `plan`, in the order in which they run."""
    return tuple(
        _case(plan, variant, point, repetition)
        for variant in plan.variants or (None,)
        for point in _points(plan)
        for repetition in range(1, plan.repetitions + 1)
    )


def case_named(plan: Plan, name: str) -> Case:
    """The case of that name; the only case of a plan goes by any.

    Raises:
        AnalysisError: the plan has several, and none is called so.
    """
    todo = cases(plan)
    if len(todo) == 1:
        return replace(todo[0], name=name)
    for case in todo:
        if case.name == name:
            return case
    names = ", ".join(case.name for case in todo)
    raise AnalysisError(f"'{name}' is no case of plan '{plan.title}', which has {names}: choose one of these")


def _points(plan: Plan) -> Iterator[tuple[tuple[str, Setting], ...]]:
    axes = [
        [(key, value) for value in values]
        for key, values in (
            *plan.sweep.emulator.items(),
            *plan.sweep.setup.items(),
            *plan.sweep.operating_point.items(),
        )
    ]
    if not axes:
        return iter([()])
    return itertools.product(*axes) if plan.sweep.order == "grid" else zip(*axes, strict=True)


def _case(
    plan: Plan, variant: Variant | None, point: tuple[tuple[str, Setting], ...], repetition: int
) -> Case:
    parts = [variant.name] if variant is not None and variant.name else []
    parts += [part(value) if isinstance(value, str) else f"{key}={part(value)}" for key, value in point]
    group = ",".join(parts) or plan.case or str(plan.setup.get("law", "case"))
    name = f"{group}.{repetition}" if plan.repetitions > 1 else group
    emulator: dict[str, float] = dict(plan.emulator)
    setup: dict[str, Setting] = {}
    if variant is not None:
        emulator |= variant.emulator
        setup |= variant.setup
    swept: dict[str, Setting] = {}
    for key, value in point:
        if key in plan.sweep.emulator:
            emulator[key] = float(value)
        elif key in plan.sweep.setup:
            setup[key] = value
        else:
            swept[key] = value
    return Case(name, group, emulator, setup, plan.operating_point.model_copy(update=swept), repetition)
