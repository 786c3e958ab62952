"""The cases of a plan: one for each point of its sweep and each repetition."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from benchtool.errors import AnalysisError
from benchtool.plan.model import OperatingPoint, Plan, Setting, Variant, part

_AROUND, _READING_S = 1.25, 0.1  # the settling time with the ramp of the load; readings before the record


@dataclass(frozen=True)
class Coordinates:
    """Coordinates of a case in its plan.

    `group` is the name that all of its repetitions share, `variant` that of its variant, empty without one,
    `point` its values of the sweep, by key. Repetitions count from 1.
    """

    group: str
    variant: str = ""
    point: Mapping[str, Setting] = field(default_factory=dict)
    repetition: int = 1

    def apart_from(self, *keys: str) -> str:
        """Return a label that distinguishes it from cases that only differ in these keys of the sweep and in
        the repetition."""
        return _name(self.variant, {key: value for key, value in self.point.items() if key not in keys})

    def to_json(self) -> dict[str, Any]:
        """As a manifest and the JSON of a run have it."""
        return {
            "group": self.group,
            "variant": self.variant,
            "point": dict(self.point),
            "repetition": self.repetition,
        }


@dataclass(frozen=True)
class Case:
    """One case of a plan: its name, its coordinates, what differs from the profile's emulated bench and from
    the plan's setup, and where the machine runs."""

    name: str
    coordinates: Coordinates
    emulator: Mapping[str, float]
    setup: Mapping[str, Setting]
    operating_point: OperatingPoint

    @property
    def group(self) -> str:
        """Name of the case and its other repetitions."""
        return self.coordinates.group

    @property
    def variant(self) -> str:
        """Name of its variant, empty without one."""
        return self.coordinates.variant

    @property
    def repetition(self) -> int:
        """Which repetition it is, from 1."""
        return self.coordinates.repetition

    @property
    def folder(self) -> str:
        """Folder name of the case."""
        return re.sub(r"[^\w.,=+-]", "_", self.name)


def cases(plan: Plan) -> tuple[Case, ...]:
    """Return every case of `plan`, in the order in which they run."""
    return tuple(
        _case(plan, variant, point, repetition)
        for variant in plan.variants or (None,)
        for point in _points(plan)
        for repetition in range(1, plan.repetitions + 1)
    )


def case_named(plan: Plan, name: str) -> Case:
    """Return the case of that name; if the plan has only one case, return that.

    Raises:
        AnalysisError: the plan has several cases, and none has that name.
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
    coordinates = Coordinates("", "" if variant is None else variant.name, dict(point), repetition)
    group = coordinates.apart_from() or plan.case or str(plan.setup.get("law", "case"))
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
    operating_point = plan.operating_point.model_copy(update=swept)
    return Case(name, replace(coordinates, group=group), emulator, setup, operating_point)


def _name(variant: str, point: Mapping[str, Setting]) -> str:
    """Return the part of a case's name for a variant and a point of a sweep."""
    shown = ((value, f"{key}={part(value)}") for key, value in point.items())
    parts = (value if isinstance(value, str) else number for value, number in shown)
    return ",".join((*((variant,) if variant else ()), *parts))


def drive_time_s(plan: Plan) -> float:
    """Return the about how long a plan takes in the drive's time: ramping a load, settling, reading and
    recording."""
    points = [case.operating_point for case in cases(plan)]
    return sum(_AROUND * point.settle_s + _READING_S + plan.record.duration_s for point in points)
