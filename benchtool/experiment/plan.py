"""A plan as a validated TOML file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from benchtool.document import Section, load_document
from benchtool.errors import PlanError
from benchtool.experiment.limits import Limit
from benchtool.shipped import shipped

Seconds = Annotated[float, Field(gt=0, le=3600)]
Setting = float | str


class OperatingPoint(Section):
    """Where the machine runs: the drive holds the speed, the load machine loads the shaft."""

    omega_m_rad_s: float
    load_torque_Nm: float = 0.0
    settle_s: Seconds = 1.0


class Record(Section):
    """What the drive captures, at `stride` control ticks per row."""

    duration_s: Seconds
    channels: Annotated[tuple[str, ...], Field(min_length=1, max_length=16)]
    stride: Annotated[int, Field(ge=1, le=10000)] = 1


class Sweep(Section):
    """Values to go through: every combination (`grid`), or the first of each, the second of each (`list`)."""

    order: Literal["grid", "list"] = "grid"
    setup: dict[str, Annotated[tuple[Setting, ...], Field(min_length=1)]] = Field(default_factory=dict)
    operating_point: dict[
        Literal["omega_m_rad_s", "load_torque_Nm"], Annotated[tuple[float, ...], Field(min_length=1)]
    ] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _lists_are_equally_long(self) -> Sweep:
        lengths = {len(values) for values in (*self.setup.values(), *self.operating_point.values())}
        if self.order == "list" and len(lengths) > 1:
            raise ValueError(f"order = 'list' needs lists of one length, these are {sorted(lengths)}")
        return self


class Plan(Section):
    """One test: set up, run, record, measure, judge; once, or for every point of a sweep."""

    title: str
    profile: str
    case: str = ""
    repetitions: Annotated[int, Field(ge=1, le=1000)] = 1
    setup: dict[str, Setting] = Field(default_factory=dict)
    operating_point: OperatingPoint
    sweep: Sweep = Sweep()
    record: Record
    analysis: Literal["steady_state"] = "steady_state"
    limits: dict[str, Limit] = Field(default_factory=dict)


def plan_path(name: str) -> Path:
    """File of a shipped plan's name (`zhu2011/ripple`), or of a path.

    Raises:
        PlanError: neither exists.
    """
    given = Path(name)
    if given.suffix == ".toml":
        if given.is_file():
            return given
        raise PlanError(f"no plan file {given}: give an existing TOML file or a name ({_names()})")
    path = shipped("profiles") / f"{name}.toml"
    if not path.is_file() or path.name == "profile.toml":
        raise PlanError(f"no plan '{name}': the names are {_names()}; or give a TOML file")
    return path


def load_plan(name: str) -> Plan:
    """The plan of a name or of a file.

    Raises:
        PlanError: unknown, unreadable, or a key is wrong.
    """
    return load_document(plan_path(name), Plan, PlanError)


def _names() -> str:
    root = shipped("profiles")
    plans = (path for path in root.glob("*/*.toml") if path.name != "profile.toml")
    return ", ".join(sorted(str(path.relative_to(root).with_suffix("")) for path in plans))
