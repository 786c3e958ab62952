"""What a kind of analysis declares: its settings, what it needs, what it measures and what it draws.

An `Analysis` stands at the end of the module that computes it and once in `benchtool.analysis.catalogue`, or
in another package under the entry point group `benchtool.analyses`. Validation of plans,
assessment, figures, report, live view and the tables of docs/measurements.md come from it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from benchtool.analysis.measurement import Measurement, Table
from benchtool.document import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from benchtool.analysis.steady_state import SteadyState
    from benchtool.analysis.window import Window
    from benchtool.block import Block


class Measured(StrEnum):
    """When an analysis is made."""

    STEADY_STATE = "steady state"
    """Of every steady state whose channels allow it, unless the plan says `NAME = false`."""

    ASKED = "asked"
    """Of the whole capture, where the plan asks for it: `NAME = true`, or a table of settings."""


class NoSettings(Section):
    """Of an analysis that has nothing to set."""


@dataclass(frozen=True)
class UnitOf:
    """The unit of the channel that a setting names, over that of another where there is one."""

    setting: str
    over: str = ""

    def __str__(self) -> str:
        """As the documentation prints it: `of signal`, `output/input`."""
        return f"{self.setting}/{self.over}" if self.over else f"of {self.setting}"

    def resolve(self, settings: Section, units: Mapping[str, str]) -> str | None:
        """The unit, by the units of channels; None where one is not known."""
        of, over = (units.get(str(getattr(settings, key, ""))) for key in (self.setting, self.over))
        if of is None or (self.over and over is None):
            return None
        return ratio_of_units(of, over) if over is not None else of


def ratio_of_units(above: str, below: str) -> str:
    """Unit of a quotient; empty for a pure number."""
    if above == below:
        return ""
    return f"{above or '1'}/({below})" if "/" in below else f"{above or '1'}/{below or '1'}"


@dataclass(frozen=True)
class Quantity:
    """Measurements that share a unit and a definition: a row of docs/measurements.md.

    Attributes:
        names: of the measurements.
        unit: theirs, or whose it is.
        definition: formula or words from which another person computes the same.
        uncertainty: what the standard uncertainty is made of; empty where the text beside the table says it.
        pattern: regular expression of the names, where these depend on the data (`torque_order_24`); `names`
            is then what the documentation prints.
        label: a short name, with which a figure's title states the value; empty to leave it out.
        foremost: whether a table of many cases shows it, unless the plan says what to tabulate.
    """

    names: tuple[str, ...]
    unit: str | UnitOf
    definition: str
    uncertainty: str = ""
    pattern: str = ""
    label: str = ""
    foremost: bool = False

    def covers(self, name: str) -> bool:
        """Whether a measurement of that name is one of these."""
        return re.fullmatch(self.pattern, name) is not None if self.pattern else name in self.names

    def to_json(self) -> list[dict[str, str]]:
        """As `benchtool analyze --list --json` has it, a measurement each."""
        pattern = {"pattern": self.pattern} if self.pattern else {}
        shared = {"unit": str(self.unit), "definition": self.definition, **pattern}
        return [{"name": name, **shared} for name in self.names]


@dataclass(frozen=True)
class Findings:
    """What an analysis found; `result` is what its figures draw besides the recorded channels."""

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...] = ()
    result: Any = None


@dataclass(frozen=True)
class Panel:
    """One case as a figure shows it.

    `label` is the case's name with what it comes to. `findings` are by the name of the analysis; `steady` are
    those of the steady state.
    """

    label: str
    capture: Block
    steady: SteadyState | None = None
    name: str = ""
    transducer: Block | None = None
    findings: Mapping[str, Findings] = field(default_factory=dict)

    def result(self, analysis: str) -> Any:
        """What the figures of an analysis draw; None where it was not made."""
        found = self.findings.get(analysis)
        return None if found is None else found.result


@dataclass(frozen=True)
class Drawing:
    """A figure of an analysis.

    Attributes:
        name: of its file, and what `figure` of a plan calls it.
        title: above it where no plan has one.
        caption: what it shows, a sentence or two.
        channels: that it draws besides those that the analysis needs.
        of_recording: whether it draws recorded channels alone, so that the analysis need not be made.
        replaces: figures of other analyses that say no more beside this one.
        draw: draws panels, one or several on the same axes, into an empty figure that has its title; None for
            a figure that `benchtool.report.figures.drawings` sets by hand.
    """

    name: str
    title: str
    caption: str
    channels: tuple[str, ...] = ()
    of_recording: bool = False
    replaces: tuple[str, ...] = ()
    draw: Callable[[Figure, Sequence[Panel]], None] | None = None


Settings = TypeVar("Settings", bound=Section)


@dataclass(frozen=True, kw_only=True)
class Analysis(Generic[Settings]):
    """A kind of analysis.

    Attributes:
        name: its key under `[analyses]` of a plan, an identifier.
        title: what it measures, in words.
        measure: makes it of a window; raises AnalysisError where the data do not allow it.
        quantities: all that it measures.
        settings: model of its table in a plan; every key has a default.
        measured: when it is made.
        channels: of the capture, all of which it needs.
        channel_settings: the settings that each name one more channel that it needs.
        transducer: whether it needs the torque transducer as well.
        every_tick: whether it needs a capture with stride 1.
        figures: of one case.
        comparisons: of several cases side by side: what `figure` of a plan may name.
        source: the package that it comes from; empty of benchtool's own.
    """

    name: str
    title: str
    measure: Callable[[Window, Settings], Findings]
    quantities: tuple[Quantity, ...]
    settings: type[Settings]
    measured: Measured = Measured.STEADY_STATE
    channels: tuple[str, ...] = ()
    channel_settings: tuple[str, ...] = ()
    transducer: bool = False
    every_tick: bool = False
    figures: tuple[Drawing, ...] = ()
    comparisons: tuple[Drawing, ...] = ()
    source: str = ""

    @property
    def of_steady_state(self) -> bool:
        """Whether a steady state is measured by it."""
        return self.measured is Measured.STEADY_STATE

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its measurements, but of those that depend on the data."""
        return tuple(name for each in self.quantities if not each.pattern for name in each.names)

    def quantity(self, name: str) -> Quantity | None:
        """What it declares of the measurement of that name; None if it does not measure that."""
        return next((each for each in self.quantities if each.covers(name)), None)

    def needs(self, settings: Section) -> tuple[str, ...]:
        """All channels that it needs with these settings."""
        return (*self.channels, *(str(getattr(settings, key)) for key in self.channel_settings))

    def missing(self, channels: Set[str], settings: Section) -> tuple[str, ...]:
        """The channels that it needs and that are not among these."""
        return tuple(name for name in self.needs(settings) if name not in channels)

    def possible(self, channels: Set[str], settings: Section, *, transducer: bool, stride: int = 1) -> bool:
        """Whether a capture of these channels, every `stride` ticks, allows it."""
        has_all = not self.missing(channels, settings) and (transducer or not self.transducer)
        return has_all and (stride == 1 or not self.every_tick)

    @property
    def conditions(self) -> tuple[str, ...]:
        """What it needs besides channels, in words."""
        words = {
            "the torque transducer": self.transducer,
            "every control tick (stride 1)": self.every_tick,
        }
        return tuple(text for text, needed in words.items() if needed)

    def to_json(self) -> dict[str, Any]:
        """As `benchtool analyze --list --json` has it."""
        return {
            "title": self.title,
            "measured": str(self.measured),
            "channels": list(self.channels),
            "channel_settings": list(self.channel_settings),
            "conditions": list(self.conditions),
            "settings": self.settings().model_dump(mode="json"),
            "measurements": [entry for each in self.quantities for entry in each.to_json()],
            "figures": [each.name for each in self.figures],
            "comparisons": [each.name for each in self.comparisons],
            "source": self.source or "benchtool",
        }
