"""A plan as a validated TOML file."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import AfterValidator, Field, ValidationError, field_validator, model_validator
from pydantic_core import InitErrorDetails

from benchtool.document import (
    Array,
    Faults,
    Further,
    Section,
    closest,
    defaults,
    document_path,
    load_document,
)
from benchtool.drive import Stimulus
from benchtool.errors import PlanError
from benchtool.file_kinds import FileKind, mistaken
from benchtool.misfits import Path_
from benchtool.plan.analyses import Analyses
from benchtool.plan.former_names import upgraded
from benchtool.plan.lazy_catalogue import catalogue
from benchtool.plan.limits import Limit
from benchtool.plan.stated_units import with_units, without_units
from benchtool.profile import shipped_profiles
from benchtool.protocol import Mode
from benchtool.shipped import shipped

Seconds = Annotated[float, Field(gt=0, le=3600)]
Setting = float | str


def _distinct(values: Sequence[Setting]) -> Sequence[Setting]:
    """Refuse an array with a repeated value."""
    shown = [part(value) for value in values]
    for position, text in enumerate(shown):
        if text in shown[:position]:
            raise ValueError(f"{text} appears twice, once is expected: leave one out")
    return values


def part(value: Setting) -> str:
    """Return a swept value as part of a case's name: text unchanged, a number to six digits."""
    return value if isinstance(value, str) else f"{value:g}"


Swept = Annotated[Array[float], Field(min_length=1), AfterValidator(_distinct)]
OF_RATED: Final = {
    "omega_m_of_rated": "omega_m_rad_s",
    "load_torque_of_rated": "load_torque_Nm",
    "torque_of_rated": "torque_Nm",
    "hold_speed_of_rated": "hold_speed_rad_s",
}
"""Setpoints in parts of the motor's rated values, and the keys of the same in SI."""

_OF_MODE = {
    "velocity": frozenset({"omega_m_rad_s", "load_torque_Nm", "omega_m_of_rated", "load_torque_of_rated"}),
    "torque": frozenset(
        {"torque_Nm", "hold_speed_rad_s", "load_torque_Nm"}
        | {"torque_of_rated", "hold_speed_of_rated", "load_torque_of_rated"}
    ),
}


_ALWAYS = ("none", "sweep")  # values of `figure` besides the figures of analyses


class OperatingPoint(Section):
    """Where the machine runs.

    In velocity mode the drive holds the speed and the load machine loads the shaft. In torque mode the drive
    makes the torque and the load machine holds the speed; without `hold_speed_rad_s` it loads the shaft.
    `u_dc_V` is the dc link that this takes; without it, that of the profile's emulated bench. A key that ends
    in `_of_rated` takes the place of the one in SI, for a plan that fits any motor.
    """

    mode: Literal["velocity", "torque"] = "velocity"
    """What the drive holds: the speed, or the torque."""
    omega_m_rad_s: float = 0.0
    """Mechanical speed that the drive holds; velocity mode needs it."""
    load_torque_Nm: float = 0.0
    """Torque of the load, against positive rotation."""
    torque_Nm: float = 0.0
    """Torque that the drive makes; torque mode only."""
    hold_speed_rad_s: float | None = None
    """Speed that the load machine holds; torque mode only."""
    omega_m_of_rated: float | None = None
    """Speed that the drive holds, in parts of the rated one."""
    load_torque_of_rated: float | None = None
    """Torque of the load, in parts of the rated one."""
    torque_of_rated: float | None = None
    """Torque that the drive makes, in parts of the rated one."""
    hold_speed_of_rated: float | None = None
    """Speed that the load machine holds, in parts of the rated one."""
    u_dc_V: Annotated[float, Field(gt=0)] | None = None
    """Voltage of the dc link that the point takes; by default that of the emulated bench."""
    settle_s: Seconds = 1.0
    """Time at the operating point before the capture, in drive time."""

    @model_validator(mode="after")
    def _keys_are_of_the_mode(self) -> OperatingPoint:
        given = {key for key in self.model_fields_set if getattr(self, key) is not None}
        if self.mode == "velocity" and not {"omega_m_rad_s", "omega_m_of_rated"} & given:
            raise ValueError("velocity mode needs omega_m_rad_s")
        for key, in_si in OF_RATED.items():
            if {key, in_si} <= given:
                raise ValueError(f"{key} and {in_si} state one thing: give one of them")
        for key in sorted(frozenset[str]().union(*_OF_MODE.values()) - _OF_MODE[self.mode]):
            if getattr(self, key):
                raise ValueError(f"{self.mode} mode has no {key}")
        held = self.hold_speed_rad_s is not None or self.hold_speed_of_rated is not None
        if held and (self.load_torque_Nm or self.load_torque_of_rated):
            raise ValueError("a load machine holds a speed or a torque: give one of the two")
        return self

    @property
    def mode_of_operation(self) -> Mode:
        """The drive's mode."""
        return Mode[self.mode.upper()]

    def setpoint_of(self, quantity: str) -> float:
        """Return what the drive adds a stimulus of this quantity to, in the unit of that."""
        return {"speed": self.omega_m_rad_s, "torque": self.torque_Nm}.get(quantity, 0.0)


class Record(Section):
    """What the drive captures, `stride` control ticks per row, from `pretrigger_s` before a stimulus on."""

    duration_s: Seconds
    """Length of the capture."""
    channels: Annotated[Array[str], Field(min_length=1, max_length=16), AfterValidator(_distinct)]
    """Signals of the drive's dictionary that are captured."""
    stride: Annotated[int, Field(ge=1, le=10000)] = 1
    """Control periods per row; 1 captures at the control rate."""
    pretrigger_s: Annotated[float, Field(ge=0)] = 0.01
    """Time before a stimulus that the capture holds."""


class Sweep(Section):
    """Values of a sweep: every combination (`grid`), or the first of each, then the second (`list`).

    `emulator` names what differs on an emulated bench (`inverter.dead_time_s`).
    """

    order: Literal["grid", "list"] = "grid"
    """Every combination, or the first value of each list, then the second, and so on."""
    setup: dict[str, Annotated[Array[Setting], Field(min_length=1), AfterValidator(_distinct)]] = Field(
        default_factory=dict
    )
    """Values of drive parameters, by name."""
    emulator: dict[str, Swept] = Field(default_factory=dict)
    """Values of the emulated bench, such as `inverter.dead_time_s`."""
    operating_point: dict[
        Literal[
            "omega_m_rad_s",
            "load_torque_Nm",
            "torque_Nm",
            "hold_speed_rad_s",
            "omega_m_of_rated",
            "load_torque_of_rated",
            "torque_of_rated",
            "hold_speed_of_rated",
        ],
        Swept,
    ] = Field(default_factory=dict)
    """Values of the operating point."""

    @model_validator(mode="after")
    def _lists_are_equally_long(self) -> Sweep:
        axes = (*self.setup.values(), *self.emulator.values(), *self.operating_point.values())
        lengths = {len(values) for values in axes}
        if self.order == "list" and len(lengths) > 1:
            raise ValueError(f"order = 'list' needs lists of one length, these are {sorted(lengths)}")
        return self


class Variant(Section):
    """A departure from the plan: other drive parameters, or another emulated bench; without a name, the plan
    unchanged."""

    name: str = ""
    """Part of the case's name."""
    setup: dict[str, Setting] = Field(default_factory=dict)
    """Drive parameters that differ from the plan's."""
    emulator: dict[str, float] = Field(default_factory=dict)
    """Keys of the emulated bench that differ."""


class Plan(Section):
    """One test: set up, run, record, measure, judge; once, or for every variant at every point of a sweep.

    `emulator` alters the emulated bench that the plan runs on. With a `stimulus`, the capture is that of the
    drive playing it. `limits` hold for every case, `case_limits` for the case that they name, or for all of
    its repetitions. `judge` says what of these the limits hold for: each, their mean with its uncertainty, or
    the worst; data quality, the operating point reached and limits of a single repetition hold for each
    anyway. `published` holds the figures of a publication for comparison, by case, `readings` its open points
    and how they are read here. `figure` sets the cases side by side: one that an analysis declares, or
    `sweep` for `figure_of` against the operating point that is swept; `tabulate` names the measurements of a
    table with a row for each case.
    """

    title: str
    """One line that names the test in reports."""
    profile: str
    """Name or file of the profile, or a pattern such as `motors/*`: the plan is run with each that fits.
    `--profile` overrides it."""
    case: str = ""
    """Name of the case where there is one only."""
    repetitions: Annotated[int, Field(ge=1, le=1000)] = 1
    """How often every case is run."""
    setup: dict[str, Setting] = Field(default_factory=dict)
    """Drive parameters that are set before the run and restored afterwards."""
    operating_point: OperatingPoint
    """Where the machine runs."""
    variants: Array[Variant] = ()
    """Departures from the plan, each of which is a case."""
    sweep: Sweep = defaults(Sweep)
    """Values that are gone through; each combination is a case."""
    record: Record
    """What the drive captures."""
    stimulus: Stimulus | None = None
    """What the drive plays during the capture."""
    analyses: Analyses = defaults(Analyses)
    """What is measured of the capture."""
    limits: dict[str, Limit] = Field(default_factory=dict)
    """Limits of measurements by name, for every case; a name may end in the unit."""
    case_limits: dict[str, dict[str, Limit]] = Field(default_factory=dict)
    """Limits for one case, by its name."""
    judge: Literal["each", "mean", "worst"] = "each"
    """What the limits hold for: each repetition, their mean with its uncertainty, or the worst."""
    published: dict[str, dict[str, float]] = Field(default_factory=dict)
    """Figures of a publication to print beside the measured ones, by case."""
    requirements: Array[str] = ()
    """Requirements that the plan is evidence for, by their numbers; a limit may name its own."""
    readings: Array[str] = ()
    """What that publication leaves open, and how it is read here."""
    figure: str = "none"
    """Figure that sets the cases side by side: `sweep`, or one that an analysis declares."""
    figure_of: str = "torque_ripple_pp"
    """Measurement that `figure = "sweep"` draws."""
    tabulate: Array[str] = ()
    """Measurements of a table with a row for each case."""
    emulator: dict[str, float] = Field(default_factory=dict)
    """Keys of the emulated bench that the plan alters, such as `inverter.u_dc_V`."""
    faults: Array[str] = ()
    """Faults of the emulated bench, `NAME[:key=value,...][@SECONDS]`, the seconds from the beginning of the
    capture on; `benchtool emulate --faults` lists them."""

    @field_validator("limits", mode="before")
    @classmethod
    def _limits_by_measurement(cls, limits: Any) -> Any:
        return with_units(limits)

    @field_validator("case_limits", mode="before")
    @classmethod
    def _case_limits_by_measurement(cls, by_case: Any) -> Any:
        if not isinstance(by_case, Mapping):
            return by_case
        return {case: with_units(limits, case) for case, limits in by_case.items()}

    @field_validator("published", mode="before")
    @classmethod
    def _published_by_measurement(cls, by_case: Any) -> Any:
        if not isinstance(by_case, Mapping):
            return by_case
        return {case: without_units(numbers) for case, numbers in by_case.items()}

    @field_validator("figure")
    @classmethod
    def _figure_is_known(cls, figure: str) -> str:
        if figure not in _ALWAYS and figure not in (known := (*_ALWAYS, *catalogue().comparisons)):
            raise ValueError(f"there is no such figure: {closest(figure, known)}")
        return figure

    @model_validator(mode="after")
    def _figure_is_made(self) -> Plan:
        if self.figure in _ALWAYS:
            return self
        drawing, declared = catalogue().comparisons[self.figure]
        if drawing.of_recording or any(self.analyses.made(each) for each in declared):
            return self
        off = declared[0].of_steady_state and not self.analyses.steady
        key = "steady" if off else declared[0].name
        reason = ValueError(f"figure = '{self.figure}' needs analyses.{key} = true")
        error = InitErrorDetails(
            type="value_error", loc=("figure",), input=self.figure, ctx={"error": reason}
        )
        raise ValidationError.from_exception_data(type(self).__name__, [error])

    @model_validator(mode="after")
    def _sections_fit(self) -> Plan:
        point = self.operating_point
        if other := set[str](self.sweep.operating_point) - _OF_MODE[point.mode]:
            raise ValueError(f"{point.mode} mode has no {', '.join(sorted(other))} to sweep")
        if self.judge != "each" and self.repetitions < 2:
            raise ValueError(
                f"judge = '{self.judge}' is over repetitions, of which there is one: set repetitions"
            )
        if self.stimulus is None:
            return self
        if point.mode_of_operation not in self.stimulus.modes:
            raise ValueError(f"a {self.stimulus.quantity} stimulus does not play in {point.mode} mode")
        if self.analyses.steady and not self.analyses.steady_from_s:
            raise ValueError(
                "a capture with a stimulus is no steady state: set analyses.steady = false, or steady_from_s"
            )
        if self.record.pretrigger_s >= self.record.duration_s:
            raise ValueError("record.pretrigger_s leaves nothing of record.duration_s for the stimulus")
        return self


def plan_path(name: str) -> Path:
    """Return the file of a shipped plan's name (`zhu2011/ripple`), or of a path.

    Raises:
        PlanError: neither exists.
    """
    path = shipped("profiles") / f"{name}.toml"
    place = path if path.name != "profile.toml" else None
    return document_path(name, place, FileKind.PLAN, shipped_plans, PlanError)


def plan_names(name: str) -> tuple[str, ...]:
    """Return plans of a folder, a shipped profile's (`zhu2011`) or another; a single plan's name as it is.

    Raises:
        PlanError: a folder without any.
    """
    for folder, prefix in ((shipped("profiles") / name, name), (Path(name), "")):
        if folder.is_dir() and folder != shipped("profiles"):
            files = sorted(path for path in folder.glob("*.toml") if path.name != "profile.toml")
            if not files:
                why = mistaken(folder, FileKind.PLAN)
                raise PlanError(why or f"folder {name} holds no plans: TOML files are expected, one a plan")
            return tuple(f"{prefix}/{path.stem}" if prefix else str(path) for path in files)
    return (name,)


def recorded_plan(document: Mapping[str, Any]) -> Plan:
    """Return the plan that a recording carries, of this version or an earlier one.

    Raises:
        ValidationError: this version does not understand it.
    """
    return Plan.model_validate(upgraded(document))


_STAND_IN: Final = {
    "title": "-",
    "operating_point": {"omega_m_rad_s": 1e4},  # of which every record has many periods
    "record": {"duration_s": 3600.0, "channels": ["torque"]},
}
"""What a plan needs, with values by which nothing else in it is wrong."""
Change = Callable[[Mapping[str, Any]], Mapping[str, Any]]


def load_plan(
    name: str,
    change: Change = lambda content: content,
    further: Callable[[Plan, frozenset[Path_]], Faults] | None = None,
) -> Plan:
    """Return the plan of a name or of a file.

    Args:
        name: of a plan that ships, or a file.
        change: may alter what the file has before that is checked.
        further: what else is wrong in the rest of a plan of which a key is wrong, in which some places are
            left out.

    Raises:
        PlanError: unknown, unreadable, or a key is wrong.
    """
    rest = None if further is None else Further(further, _STAND_IN)
    return load_document(plan_path(name), Plan, PlanError, change, rest, kind=FileKind.PLAN)


def profiles_of(name: str, plan: Plan) -> tuple[str, ...]:
    """Return the profiles that the plan of that name asks for: names of shipped ones, or files beside the
    plan's.

    Raises:
        PlanError: none fits its pattern.
    """
    asked = plan.profile
    if not any(each in asked for each in "*?["):
        return (str(plan_path(name).parent / asked) if asked.endswith(".toml") else asked,)
    if asked.endswith(".toml"):
        found = tuple(str(path) for path in sorted(plan_path(name).parent.glob(asked)))
    else:
        found = tuple(each for each in shipped_profiles() if fnmatch.fnmatchcase(each, asked))
    if not found:
        raise PlanError(f"{name}: no profile fits '{asked}': name one, or another pattern")
    return found


def shipped_plans() -> list[str]:
    """Return the names of the plans that ship."""
    root = shipped("profiles")
    plans = (path for path in root.glob("*/*.toml") if path.name != "profile.toml")
    return sorted(str(path.relative_to(root).with_suffix("")) for path in plans)
