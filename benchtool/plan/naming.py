"""The measurements that a plan names, against those that it will make."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from benchtool.analysis.catalogue import STEADY, Analysis, analyses_of, response_names, step_names
from benchtool.document import Path_, closest
from benchtool.plan.cases import cases
from benchtool.plan.model import Plan
from benchtool.plan.operating_point import NAMES as REACHED
from benchtool.plan.operating_point import asked
from benchtool.profile import Motor
from benchtool.telemetry.certificate import certificate_names

_DRAWN: Final[Mapping[str, tuple[str, ...]]] = {
    "torque": ("torque",),
    "steady": ("torque", "i_a", "psi_s"),
    "spectra": ("i_a",),
}
"""The channels that a figure of all cases draws."""


@dataclass(frozen=True)
class Naming:
    """What a plan will measure.

    Args:
        plan: the plan.
        motor: its machine.
        transducer: whether the bench has a torque transducer.
        stream: whether the drive has a slow stream, which the certificate measures too.
    """

    plan: Plan
    motor: Motor
    transducer: bool
    stream: bool

    def faults(self) -> Iterator[tuple[Path_, str]]:
        """Every name that matches nothing, with its place in the plan."""
        plan = self.plan
        for name in plan.limits:
            yield from self._fault(("limits", name), name, quality=True)
        for case, limits in plan.case_limits.items():
            yield from self._case_fault("case_limits", case)
            for name in limits:
                yield from self._fault(("case_limits", case, name), name, quality=True)
        for case, figures in plan.published.items():
            yield from self._case_fault("published", case)
            for name in figures:
                yield from self._fault(("published", case, name), name)
        for name in plan.tabulate:
            yield from self._fault(("tabulate",), name)
        yield from self._figure_faults()

    def _figure_faults(self) -> Iterator[tuple[Path_, str]]:
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
        needed = _DRAWN.get(plan.figure, ())
        if lacking := [name for name in needed if name not in plan.record.channels]:
            yield (
                ("figure",),
                f"figure = '{plan.figure}' draws {', '.join(lacking)}, which record.channels does not have: "
                f"add them there",
            )
        if plan.figure == "spectra" and not plan.analyses.steady:
            yield ("figure",), "figure = 'spectra' needs analyses.steady = true"

    def _case_fault(self, key: str, case: str) -> Iterator[tuple[Path_, str]]:
        todo = cases(self.plan)
        names = list(dict.fromkeys((*(each.group for each in todo), *(each.name for each in todo))))
        if case not in names:
            yield (key, case), f"{key} names case '{case}', which the plan has not: {closest(case, names)}"

    def _fault(self, place: Path_, name: str, *, quality: bool = False) -> Iterator[tuple[Path_, str]]:
        if reason := self.why_not(name, quality=quality):
            yield place, reason

    def why_not(self, name: str, *, quality: bool = False) -> str:
        """Why no measurement of that name will be made; empty if one will.

        `quality` allows those of the recording's certificate, which limits may hold for.
        """
        certified = certificate_names(stream=self.stream)
        if name in self._reached or (quality and name in certified):
            return ""
        found = list(analyses_of(name)) if self.plan.analyses.steady else []
        if any(self._possible(analysis) for analysis in found):
            return ""
        if self.plan.analyses.step and name in step_names():
            return ""
        if self.plan.analyses.frequency_response and name in response_names():
            return ""
        if found:
            return f"'{name}' {self._lacks(found[0])}"
        return self._unknown(name, certified, quality=quality)

    def _unknown(self, name: str, certified: tuple[str, ...], *, quality: bool) -> str:
        """Why a name is none of an analysis that the plan asks for."""
        analyses = self.plan.analyses
        off = [
            key
            for key, has in (
                ("steady", any(analyses_of(name)) and not analyses.steady),
                ("step", name in step_names() and not analyses.step),
                ("frequency_response", name in response_names() and not analyses.frequency_response),
            )
            if has
        ]
        if off:
            return f"'{name}' is measured with analyses.{off[0]} = true, which is false: change it"
        if name in REACHED:
            return f"'{name}' is nothing that this operating point asks for: leave it out"
        if name in certified:
            return f"'{name}' is of the quality of the data, which limits alone may name: leave it out"
        steady = [each for analysis in STEADY for each in analysis.names] if analyses.steady else []
        known = [
            *steady,
            *(step_names() if analyses.step else ()),
            *(response_names() if analyses.frequency_response else ()),
            *self._reached,
            *(certified if quality else ()),
        ]
        return f"no measurement is called '{name}': {closest(name, known)}"

    @property
    def _reached(self) -> tuple[str, ...]:
        wanted = (asked(case.operating_point, self.motor, None) for case in cases(self.plan))
        return tuple(dict.fromkeys(each.name for point in wanted for each in point))

    def _possible(self, analysis: Analysis) -> bool:
        record = self.plan.record
        channels = frozenset(record.channels)
        return analysis.possible(channels, transducer=self.transducer, stride=record.stride)

    def _lacks(self, analysis: Analysis) -> str:
        """What keeps an analysis from being made."""
        channels = frozenset(self.plan.record.channels)
        if lacking := analysis.missing(channels):
            return f"needs {', '.join(lacking)}, which record.channels does not have: add what is missing"
        if analysis.transducer and not self.transducer:
            return "needs a torque transducer, which the bench at this link has not: leave it out"
        return f"needs every tick, record.stride is {self.plan.record.stride}: make it 1"
