"""What a kind of analysis declares: its settings, what it needs, what it measures and what it draws.

An `Analysis` is defined at the end of the module that computes it and listed once in
`benchtool.analysis.catalogue`, or registered by another package under the entry point group
`benchtool.analyses`. Validation of plans, assessment, figures, report, live view and the tables of
docs/reference/measurements.md are derived from it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.document import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from benchtool.analysis.steady_state import SteadyState
    from benchtool.analysis.window import Window
    from benchtool.block import Block


class Measured(StrEnum):
    """When an analysis is made."""

    STEADY_STATE = "steady state"
    """Of every steady state whose channels allow it, unless the plan sets `NAME = false`."""

    ON_REQUEST = "on request"
    """Of the whole capture, if the plan requests it by `NAME = true` or a table of settings."""


class NoSettings(Section):
    """The settings of an analysis that has none."""


@dataclass(frozen=True)
class UnitOf:
    """The unit of the channel that a setting names, over that of another where there is one."""

    setting: str
    over: str = ""

    def __str__(self) -> str:
        """As the documentation prints it: `of signal`, `output/input`."""
        return f"{self.setting}/{self.over}" if self.over else f"of {self.setting}"

    def resolve(self, settings: Section, units: Mapping[str, str]) -> str | None:
        """Return the unit, by the units of channels; None where one is not known."""
        of, over = (units.get(str(getattr(settings, key, ""))) for key in (self.setting, self.over))
        if of is None or (self.over and over is None):
            return None
        return ratio_of_units(of, over) if over is not None else of


def ratio_of_units(above: str, below: str) -> str:
    """Return the unit of a quotient; empty for a pure number."""
    if above == below:
        return ""
    return f"{above or '1'}/({below})" if "/" in below else f"{above or '1'}/{below or '1'}"


_EMPHASIS: Final = re.compile(r"(?<!\w)\*(\w[^*]*\w)\*(?!\w)")


@dataclass(frozen=True)
class Quantity:
    """Measurements that share a unit and a definition: a row of docs/reference/measurements.md.

    Attributes:
        names: of the measurements.
        unit: of the measurements, or the setting that names the channel whose unit it is.
        definition: formula or words that suffice to compute the same number.
        uncertainty: contributions to the standard uncertainty; empty where the page describes them, `none`
            where none is ever stated.
        pattern: regular expression of the names, where a number in them is free (`torque_order_24`); `names`
            is then what the documentation prints.
        numbers: the setting that lists these numbers, each a group of `pattern`: others are not measured.
        label: a short name for the value in a figure's title; empty to leave it out.
        headline: whether a table of many cases shows it by default.
    """

    names: tuple[str, ...]
    unit: str | UnitOf
    definition: str
    uncertainty: str = ""
    pattern: str = ""
    numbers: str = ""
    label: str = ""
    headline: bool = False

    @property
    def text(self) -> str:
        """The definition without the marks of Markdown that the documentation prints."""
        return _EMPHASIS.sub(r"\1", self.definition.replace("`", ""))

    @property
    def never_uncertain(self) -> bool:
        """Whether no uncertainty is ever stated."""
        return self.uncertainty == "none"

    def covers(self, name: str) -> bool:
        """Return whether a measurement of that name is one of these."""
        return re.fullmatch(self.pattern, name) is not None if self.pattern else name in self.names

    def unlisted(self, name: str, settings: Section) -> str:
        """Return the number in a name that the settings do not list; empty if they do, or if none is free."""
        found = re.fullmatch(self.pattern, name) if self.numbers else None
        listed = {str(number) for number in getattr(settings, self.numbers)} if self.numbers else set()
        return "" if found is None or found[1] in listed else found[1]

    def measured_names(self, settings: Section) -> tuple[str, ...]:
        """Return the names that are measured in any case: without a pattern, or with the numbers that a
        setting lists in it."""
        if not self.pattern:
            return self.names
        numbers = getattr(settings, self.numbers) if self.numbers else ()
        return tuple(re.sub(r"\(.*\)", str(number), self.pattern) for number in numbers)

    def to_json(self) -> list[dict[str, str]]:
        """As `benchtool analyze --list --json` has it, a measurement each."""
        pattern = {"pattern": self.pattern} if self.pattern else {}
        shared = {"unit": str(self.unit), "definition": self.text, **pattern}
        return [{"name": name, **shared} for name in self.names]


@dataclass(frozen=True)
class Findings:
    """Findings of an analysis; `result` holds what its figures draw besides the recorded channels, `refusal`
    says why it was not made, so that no measurement has a value."""

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...] = ()
    result: Any = None
    refusal: str = ""


@dataclass(frozen=True)
class Panel:
    """One case as a figure shows it.

    `label` is the case's name with its main results. `findings` are by the name of the analysis; `steady`
    holds those of the steady state. `limits` are the least and the greatest value allowed, by measurement.
    """

    label: str
    capture: Block
    steady: SteadyState | None = None
    name: str = ""
    transducer: Block | None = None
    findings: Mapping[str, Findings] = field(default_factory=dict)
    limits: Mapping[str, tuple[float | None, float | None]] = field(default_factory=dict)

    def result(self, analysis: str) -> Any:
        """Return what the figures of an analysis draw; None where it was not made."""
        found = self.findings.get(analysis)
        return None if found is None else found.result


@dataclass(frozen=True)
class Drawing:
    """A figure of an analysis.

    Attributes:
        name: of its file, and what `figure` of a plan calls it.
        title: the default title.
        caption: what it shows, a sentence or two.
        channels: further channels that it draws besides those that the analysis needs.
        of_recording: whether it draws recorded channels alone, so that the analysis need not be made.
        replaces: figures of other analyses that this one makes redundant.
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
        measure: analyses a window; raises AnalysisError where the data do not allow it.
        quantities: all quantities that it measures.
        settings: model of its table in a plan; every key has a default.
        measured: when it is made.
        channels: of the capture, all of which are required.
        channel_settings: the settings that each name one more channel that it needs; an empty one names none.
        one_unit: those of these settings whose channels have to be of one unit.
        transducer: whether it needs the torque transducer as well.
        every_tick: whether it needs a capture with stride 1.
        fewest_revolutions: mechanical revolutions that its window has to have; without them its measurements
            are undefined.
        of_spectra: whether its numbers are of ratios of spectra, each frequency by itself: then the response
            of a sensor can be divided out of a channel with its noise.
        figures: of one case.
        comparisons: of several cases side by side: what `figure` of a plan may name.
        source: the package that it comes from; empty for those of benchtool.
    """

    name: str
    title: str
    measure: Callable[[Window, Settings], Findings]
    quantities: tuple[Quantity, ...]
    settings: type[Settings]
    measured: Measured = Measured.STEADY_STATE
    channels: tuple[str, ...] = ()
    channel_settings: tuple[str, ...] = ()
    one_unit: tuple[str, ...] = ()
    transducer: bool = False
    every_tick: bool = False
    fewest_revolutions: float = 0.0
    of_spectra: bool = False
    figures: tuple[Drawing, ...] = ()
    comparisons: tuple[Drawing, ...] = ()
    source: str = ""

    @property
    def of_steady_state(self) -> bool:
        """Whether a steady state is measured by it."""
        return self.measured is Measured.STEADY_STATE

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its measurements, but for those with a number that a setting lists."""
        return tuple(name for each in self.quantities if not each.pattern for name in each.names)

    def quantity(self, name: str) -> Quantity | None:
        """Return the declaration of the measurement of that name; None if it is not measured here."""
        return next((each for each in self.quantities if each.covers(name)), None)

    def needs(self, settings: Section) -> tuple[str, ...]:
        """Return all channels that it needs with these settings."""
        named = (str(getattr(settings, key)) for key in self.channel_settings)
        return (*self.channels, *(name for name in named if name))

    def with_channels(self, findings: Findings, settings: Section) -> Findings:
        """Return findings whose measurements say what they are measured again of, where they declare no
        sensitivities."""
        rests_on = self.needs(settings) + (("torque_transducer",) if self.transducer else ())

        def on_channels(each: Measurement) -> Measurement:
            if each.sensitivities.channels is not None:
                return each
            sensed = replace(each.sensitivities, rests_on=rests_on, of_spectra=self.of_spectra)
            return replace(each, sensitivities=sensed)

        return replace(findings, measurements=tuple(map(on_channels, findings.measurements)))

    def undefined(self, block: Block, settings: Section, reason: str) -> Findings:
        """Return its measurements without values: those declared by name, and those that a setting lists."""
        units = {channel.name: channel.unit for channel in block.channels}
        rate_Hz = block.sample_rate_Hz
        basis = Basis(len(block.data), rate_Hz, len(block.data) / rate_Hz, gaps=len(block.gaps))
        found = []
        for quantity in self.quantities:
            unit = quantity.unit if isinstance(quantity.unit, str) else quantity.unit.resolve(settings, units)
            found += [
                Measurement.undefined(name, unit or "", quantity.text, reason, basis)
                for name in quantity.measured_names(settings)
            ]
        return Findings(tuple(found), refusal=reason)

    def missing(self, channels: Set[str], settings: Section) -> tuple[str, ...]:
        """Return the channels that it needs and that are not among these."""
        return tuple(name for name in self.needs(settings) if name not in channels)

    def possible(self, channels: Set[str], settings: Section, *, transducer: bool, stride: int = 1) -> bool:
        """Return whether a capture of these channels, every `stride` ticks, allows it."""
        has_all = not self.missing(channels, settings) and (transducer or not self.transducer)
        return has_all and (stride == 1 or not self.every_tick)

    @property
    def conditions(self) -> tuple[str, ...]:
        """Requirements besides channels, in words."""
        words = {
            "the torque transducer": self.transducer,
            "every control tick (stride 1)": self.every_tick,
            f"{self.fewest_revolutions:g} mechanical revolutions": self.fewest_revolutions > 0.0,
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
