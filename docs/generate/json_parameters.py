"""What `params`, `profile new`, `plan new`, `plans` and `run --dry-run` print with `--json`."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import RootModel

from docs.generate.json_results import Document, Plain


class Parameter(Document):
    """One parameter."""

    name: str
    """Name in the dictionary."""
    index: str
    """Index and sub-index."""
    value: Plain
    """Value."""
    unit: str
    """Unit."""
    minimum: float | None
    """Least value."""
    maximum: float | None
    """Greatest value."""
    values: dict[str, int] | list[str] | None
    """Names of an enumeration's values."""
    default: Plain
    """Default."""
    differs: bool
    """Whether the value differs from it."""
    access: str
    """Access."""
    enabled_write: bool
    """Whether it may be written with the power stage on."""
    description: str
    """What it is."""


class Parameters(Document):
    """`params list`."""

    parameters: list[Parameter]
    """The parameters."""
    warnings: list[str]
    """What is odd about the EDS."""


class Value(Document):
    """A value read."""

    value: Plain
    """Value."""
    unit: str
    """Unit."""


class Values(RootModel[dict[str, Value]]):
    """`params get`: values by name."""


class Written(Document):
    """A value written and read back."""

    before: Plain
    """Value before."""
    value: Plain
    """Value read back."""
    unit: str | None = None
    """Unit; `params load` leaves it out."""


class WrittenValues(RootModel[dict[str, Written]]):
    """`params set`: values by name."""


class ParameterFile(Document):
    """`params dump`: what the file has."""

    drive: dict[str, int | str]
    """Which drive it is of, and when it was read."""
    parameters: dict[str, Plain]
    """Values by key, which ends in the unit."""


class KeyDifference(Document):
    """A key whose values differ; null where a side has no such key."""

    key: str
    """The key."""
    a: Plain
    """Value of the first."""
    b: Plain
    """Value of the second."""


class Differences(Document):
    """`params diff`."""

    equal: bool
    """Whether they are equal."""
    a: str
    """The first."""
    b: str
    """The second, `drive` if it is the drive."""
    differences: list[KeyDifference]
    """What differs."""


class Loaded(Document):
    """`params load`."""

    changed: dict[str, Written]
    """Values that were written, by name."""
    loaded: int
    """Parameters of the file."""
    left_as_they_were: list[str]
    """Parameters of the drive that the file does not have."""


class Stored(Document):
    """`params save`."""

    stored: Literal[True]
    """Always true: a failure is an exit code."""
    parameters: dict[str, Plain]
    """Values that the drive keeps, by key."""


class Restored(Document):
    """`params restore`."""

    restored: Literal[True]
    """Always true: a failure is an exit code."""
    parameters: dict[str, Plain]
    """Values in force, by name."""


class DerivedValue(Document):
    """A parameter that was derived from the motor."""

    value: Plain
    """Value."""
    rule: str
    """The rule that gives it."""
    before: Plain = None
    """Value of the drive before; `profile new` leaves it out."""


class NewProfile(Document):
    """`profile new`."""

    file: str | None
    """The file, or null for standard output."""
    motor: dict[str, Plain]
    """`[motor]` of the profile."""
    parameters: dict[str, DerivedValue]
    """`[drive.parameters]`, by key."""


class NewPlan(Document):
    """`plan new`."""

    file: str | None
    """The file, or null for standard output."""
    profile: str
    """Profile that the plan names."""


class ListedPlan(Document):
    """A plan in a line."""

    title: str
    """What it tests."""
    cases: int
    """Its cases."""
    profiles: list[str]
    """The profiles that it is run with."""
    measures: str
    """What it measures, in words."""
    duration_s: float
    """Drive time of all cases with all profiles."""


class ListedPlans(RootModel[dict[str, ListedPlan]]):
    """`plans`: plans by name."""


class ListedProfile(Document):
    """A shipped profile."""

    title: str
    """What a report calls its motor and bench."""
    motor: dict[str, float | int]
    """`[motor]` of the profile."""
    u_dc_V: float | None
    """Voltage of the dc link of its emulated bench; null without one."""
    control_period_s: float
    """Control period that its drive is to have."""
    law: str | None
    """The law that it states."""


class ListedProfiles(RootModel[dict[str, ListedProfile]]):
    """`profiles`: profiles by name."""


class DryRun(Document):
    """`run --dry-run`."""

    dry_run: Literal[True]
    """Nothing was opened or sent."""
    link: str
    """Address of the drive."""
    plans: dict[str, dict[str, Any]]
    """What each plan would do: in words, and setup and cases as data."""


class DerivedParameters(Document):
    """`params derive`."""

    written: bool
    """Whether they were written."""
    parameters: dict[str, DerivedValue]
    """Parameters by key."""
