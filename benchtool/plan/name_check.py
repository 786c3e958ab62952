"""Check of the names in a plan (cases, measurements, units, figures) against what it will run, measure and
draw."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from benchtool.analysis import Analysis, catalogue
from benchtool.document import Section, closest, unit_suffix
from benchtool.misfits import Path_
from benchtool.plan.cases import Case, cases
from benchtool.plan.former_names import present_name
from benchtool.plan.limits import Limit
from benchtool.plan.model import Plan
from benchtool.plan.not_made import few_revolutions
from benchtool.plan.operating_point import NAMES as REACHED, targets
from benchtool.profile import Motor
from benchtool.telemetry import certificate_units

Faults = Iterator[tuple[Path_, str]]


@dataclass(frozen=True)
class NameCheck:
    """The measurements that a plan will make.

    Args:
        plan: the plan.
        motor: its machine.
        transducer: whether the bench has a torque transducer.
        stream: whether the drive has a slow stream, which the certificate measures too.
        channels: that are recorded.
        units: of the signals that the drive has, as far as they are known before the run.
    """

    plan: Plan
    motor: Motor
    transducer: bool
    stream: bool
    channels: frozenset[str]
    units: Mapping[str, str] = field(default_factory=dict)

    def faults(self) -> Faults:
        """Yield every unknown name and every wrong unit, with its place in the plan."""
        plan = self.plan
        yield from self._analysis_faults()
        todo = cases(plan)
        for name, limit in plan.limits.items():
            yield from self._limit_fault(("limits", name), name, limit, todo)
        for case, limits in plan.case_limits.items():
            yield from self._case_fault("case_limits", case)
            for name, limit in limits.items():
                of_it = [each for each in todo if case in (each.group, each.name)]
                yield from self._limit_fault(("case_limits", case, name), name, limit, of_it)
        for case, figures in plan.published.items():
            yield from self._case_fault("published", case)
            for name in figures:
                yield from self._fault(("published", case, name), name)
        for name in plan.tabulate:
            yield from self._fault(("tabulate",), name)
        yield from self._figure_faults()

    def _analysis_faults(self) -> Faults:
        """Yield the requested analyses that the recorded channels do not allow."""
        for analysis, settings in self.plan.analyses.demanded():
            unknown = {key: getattr(settings, key) for key in analysis.channel_settings}
            unknown = {key: name for key, name in unknown.items() if name and name not in self.channels}
            for key, channel in unknown.items():
                yield (
                    ("analyses", analysis.name, key),
                    f"is '{channel}', which record.channels does not have: add it there, or choose one "
                    f"of {', '.join(self.plan.record.channels)}",
                )
            yield from self._unit_faults(analysis, settings)
            untold = set(analysis.missing(self.channels, settings)) - set(unknown.values())
            if (untold or not unknown) and not self._possible(analysis, settings):
                yield (
                    ("analyses", analysis.name),
                    f"analyses.{analysis.name} {self._lacks(analysis, settings)}",
                )

    def _unit_faults(self, analysis: Analysis[Section], settings: Section) -> Faults:
        """Yield the channels of an analysis that are not of the unit of the first that it needs in one."""
        named = {key: str(getattr(settings, key)) for key in analysis.one_unit}
        units = {key: self.units[name] for key, name in named.items() if name in self.units}
        for key, unit in units.items():
            first = next(iter(units))
            if unit == units[first]:
                continue
            alike = [
                name
                for name in self.plan.record.channels
                if self.units.get(name) == units[first] and name != named[first]
            ]
            remedy = f"choose {' or '.join(alike)}" if alike else "record one of that unit and name it"
            yield (
                ("analyses", analysis.name, key),
                f"is '{named[key]}', in {unit or 'no unit'}, and {first} is '{named[first]}', in "
                f"{units[first] or 'no unit'}: one unit is needed, {remedy}",
            )

    def _figure_faults(self) -> Faults:
        plan = self.plan
        if plan.figure == "sweep":
            if not plan.sweep.operating_point:
                yield ("figure",), "figure = 'sweep' needs a [sweep.operating_point] to draw against: add one"
            yield from self._fault(("figure_of",), plan.figure_of)
        elif "figure_of" in plan.model_fields_set:
            yield (
                ("figure_of",),
                f"figure_of is drawn by figure = 'sweep', which is '{plan.figure}': change one",
            )
        drawing, declared = catalogue().comparisons.get(plan.figure, (None, ()))
        if drawing is None:
            return
        settings = plan.analyses.settings(declared[0])
        needed = declared[0].needs(settings) if settings is not None and not drawing.of_recording else ()
        if lacking := [name for name in (*drawing.channels, *needed) if name not in self.channels]:
            yield (
                ("figure",),
                f"figure = '{plan.figure}' draws {', '.join(lacking)}, which record.channels does not have: "
                f"add them there",
            )
        elif needed and settings is not None and not self._possible(declared[0], settings):
            yield ("figure",), f"figure = '{plan.figure}' {self._lacks(declared[0], settings)}"

    def _case_fault(self, key: str, case: str) -> Faults:
        todo = cases(self.plan)
        names = list(dict.fromkeys((*(each.group for each in todo), *(each.name for each in todo))))
        if case not in names:
            yield (key, case), f"{key} names case '{case}', which the plan lacks: {closest(case, names)}"

    def _limit_fault(self, place: Path_, name: str, limit: Limit, among: Sequence[Case]) -> Faults:
        if reason := self.why_not(name, quality=True):
            yield place, reason
            return
        analysis = catalogue().measuring(name)
        if analysis is not None and (few := few_revolutions(self.plan, analysis, among)):
            yield place, f"'{name}' {few}"
        if limit.margin == "U" and self._is_never_uncertain(name):
            yield (
                place,
                f"the limit of '{name}' has margin = \"U\", and '{name}' never has an uncertainty: leave the "
                f"margin out, or state a number",
            )
        unit = self.unit_of(name)
        if limit.unit is None or unit is None or unit_suffix(limit.unit) == unit_suffix(unit):
            return
        is_in = f"in {unit}" if unit else "a pure number"
        remedy = f'convert it, and write unit = "{unit}"' if unit else "leave the unit out"
        yield place, f"the limit of '{name}' is in {limit.unit}, that is {is_in}: {remedy}"

    def _fault(self, place: Path_, name: str) -> Faults:
        if reason := self.why_not(name):
            yield place, reason

    def _is_never_uncertain(self, name: str) -> bool:
        """Return whether a measurement never has an uncertainty: a count of the certificate, or one that
        declares none."""
        if name in certificate_units(stream=self.stream):
            return True
        analysis = catalogue().measuring(name)
        quantity = None if analysis is None else analysis.quantity(name)
        return quantity is not None and quantity.never_uncertain

    def unit_of(self, name: str) -> str | None:
        """Return the unit of a measurement that the plan makes; None where it is not known before the run."""
        if name in self._reached:
            return self._reached[name]
        certified = certificate_units(stream=self.stream)
        if name in certified:
            return certified[name]
        analysis = catalogue().measuring(name)
        quantity = None if analysis is None else analysis.quantity(name)
        if analysis is None or quantity is None:
            return None
        if isinstance(quantity.unit, str):
            return quantity.unit
        settings = self.plan.analyses.settings(analysis)
        return None if settings is None else quantity.unit.resolve(settings, self.units)

    def why_not(self, name: str, *, quality: bool = False) -> str:
        """Return why no measurement of that name will be made; empty if one will.

        `quality` allows those of the recording's certificate, which limits may hold for.
        """
        certified = certificate_units(stream=self.stream)
        if name in self._reached or (quality and name in certified):
            return ""
        analysis = catalogue().measuring(name)
        if analysis is not None:
            return self._why_not_made(analysis, name)
        if (present := present_name(name)) != name:
            return f"no measurement is called '{name}' any more: it is called '{present}' now, write that"
        if name in REACHED:
            return f"'{name}' is no target of this operating point: leave it out"
        if name in certified:
            return f"'{name}' is of the data-quality certificate, which only limits may name: leave it out"
        if stated := catalogue().stated_unit(name):
            unit = self.unit_of(stated[0])
            correct = "" if not unit else f" or {stated[0]}_{unit_suffix(unit)}"
            return (
                f"no measurement is called '{name}', '{stated[0]}' is "
                f"{f'in {unit}' if unit else 'a pure number'}: convert it, and write {stated[0]}{correct}"
            )
        known = [
            *(each for analysis in self._made for each in analysis.names),
            *self._reached,
            *(certified if quality else ()),
        ]
        return f"no measurement is called '{name}': {closest(name, known)}"

    def _why_not_made(self, analysis: Analysis[Section], name: str) -> str:
        """Return why the analysis that gives a measurement is not made; empty if it is."""
        analyses = self.plan.analyses
        if not analyses.made(analysis):
            off = analysis.of_steady_state and not analyses.steady
            key = "steady" if off else analysis.name
            return f"'{name}' is measured with analyses.{key} = true, which is false: change it"
        settings = analyses.settings(analysis)
        assert settings is not None  # it is made
        if not self._possible(analysis, settings):
            return f"'{name}' {self._lacks(analysis, settings)}"
        quantity = analysis.quantity(name)
        assert quantity is not None  # the analysis was found by the name
        if number := quantity.unlisted(name, settings):
            key = f"analyses.{analysis.name}.{quantity.numbers}"
            return f"'{name}' is measured where {key} lists {number}: add it, {key} = [{number}]"
        return ""

    @property
    def _made(self) -> tuple[Analysis[Section], ...]:
        return tuple(each for each in catalogue().analyses if self.plan.analyses.made(each))

    @property
    def _reached(self) -> Mapping[str, str]:
        """Units of the measurements of the operating point."""
        wanted = (targets(case.operating_point, self.motor, None) for case in cases(self.plan))
        return {each.name: each.unit for point in wanted for each in point}

    def _possible(self, analysis: Analysis[Section], settings: Section) -> bool:
        stride = self.plan.record.stride
        return analysis.possible(self.channels, settings, transducer=self.transducer, stride=stride)

    def _lacks(self, analysis: Analysis[Section], settings: Section) -> str:
        """Return what keeps an analysis from being made."""
        if lacking := analysis.missing(self.channels, settings):
            return f"needs {', '.join(lacking)}, which record.channels does not have: add what is missing"
        if analysis.transducer and not self.transducer:
            return "needs a torque transducer, which the bench at this link does not have: leave it out"
        return f"needs every tick, record.stride is {self.plan.record.stride}: make it 1"
