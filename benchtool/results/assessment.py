"""Assessment of a case: its measurements, and the verdicts on its limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from benchtool.analysis import (
    Findings,
    Measurement,
    SteadyState,
    Table,
    measurements_to_json,
    pulse_note,
    sensor_remarks,
    signal_remarks,
    tables_to_json,
)
from benchtool.block import Block
from benchtool.plan import Coordinates, JudgedLimit, Limit, Missed, Verdict, worst
from benchtool.results.agreement import Disagreement, disagreements
from benchtool.results.calibration import Overdue, stated_overdue
from benchtool.results.judged_repetitions import LimitsTogether
from benchtool.results.recorded import Recorded


@dataclass(frozen=True)
class Assessment:
    """Measurements of a case, verdicts on its limits, and published figures.

    `quality` is what the recording's certificate measured; limits hold for it as well. `limits` are the
    plan's for each case and, where it sets none, those of the operating point; `together` are those that hold
    for its repetitions together, and not for one by itself. `without` names analyses that lack channels, with
    these, `refused` those that the rows do not allow, with the reason. `parameter_check` is the result of
    `ParameterCheck.to_json`. `refusal` is the reason why only the operating point was measured, if that was
    not reached. `overdue` are the instruments whose calibration was due before the run. `findings` are those
    of each analysis, by its name, and `coordinates` those of the case in its plan. `recorded` says which rows
    of a recording without a plan these are.
    """

    case: str
    bundle: Path
    measurements: tuple[Measurement, ...]
    quality: tuple[Measurement, ...]
    limits: Mapping[str, Limit]
    published: Mapping[str, float]
    capture: Block
    transducer: Block | None
    steady: SteadyState | None
    tables: tuple[Table, ...] = ()
    findings: Mapping[str, Findings] = field(default_factory=dict)
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    parameter_check: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    refusal: str = ""
    overdue: tuple[Overdue, ...] = ()
    coordinates: Coordinates = field(default_factory=partial(Coordinates, ""))
    recorded: Recorded | None = None
    together: LimitsTogether | None = None
    refused: Mapping[str, str] = field(default_factory=dict)

    @property
    def stream(self) -> str:
        """The stream of the bundle that was measured."""
        return "capture" if self.recorded is None else self.recorded.stream

    @property
    def of_sensors(self) -> tuple[str, ...]:
        """Remarks on the sensors, each once, general ones first."""
        return tuple(sensor_remarks(self.measurements).values())

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on the recorded signals that do not prevent measurements, a sentence each."""
        return signal_remarks(self.measurements)

    @property
    def notes(self) -> tuple[str, ...]:
        """What bears on how its numbers are read, a sentence each."""
        return tuple(filter(None, (pulse_note(self.measurements),)))

    @property
    def refusals(self) -> dict[str, list[str]]:
        """Titles of the analyses that the rows do not allow, by the reason."""
        found: dict[str, list[str]] = {}
        for title, reason in self.refused.items():
            found.setdefault(reason, []).append(title)
        return found

    @property
    def found(self) -> Mapping[str, Measurement]:
        """Every measurement by name, those of the certificate among them."""
        return {each.name: each for each in (*self.quality, *self.measurements)}

    @cached_property
    def judged(self) -> Mapping[str, JudgedLimit]:
        """Each limit held against its measurement, by name; one on something that was not measured fails."""
        found = self.found
        return {name: JudgedLimit.of(name, limit, found.get(name)) for name, limit in self.limits.items()}

    @property
    def verdicts(self) -> Mapping[str, Verdict]:
        """Verdict of each limit."""
        return {name: each.verdict for name, each in self.judged.items()}

    @property
    def missed(self) -> tuple[Missed, ...]:
        """The limits that were not met and count, or were met within their margin only."""
        return tuple(told for each in self.judged.values() if (told := each.missed))

    @property
    def waived(self) -> tuple[Missed, ...]:
        """The limits that were not met, and are waived."""
        return tuple(told for each in self.judged.values() if (told := each.waived))

    @property
    def disagreements(self) -> tuple[Disagreement, ...]:
        """Numbers by the drive's estimate that the transducer contradicts."""
        return disagreements(self.measurements, self.limits)

    @property
    def contradicted(self) -> tuple[Disagreement, ...]:
        """Those of them by which the verdict on a limit is another."""
        verdicts = self.verdicts
        return tuple(each for each in self.disagreements if each.verdict is not verdicts.get(each.name))

    @property
    def verdict(self) -> Verdict:
        """The worst of its limits; none of one repetition that meets those of its own, where others hold for
        all repetitions together."""
        return self._whole(self.verdicts)

    def _whole(self, verdicts: Mapping[str, Verdict]) -> Verdict:
        """Return the worst verdict, limits that are waived aside."""
        found = worst(self.limits[name].counted(each) for name, each in verdicts.items())
        return Verdict.NONE if found is Verdict.PASS and self.together is not None else found

    @property
    def verdict_by_transducer(self) -> Verdict | None:
        """The verdict with the transducer's number wherever it contradicts the estimate; None without one."""
        if self.transducer is None:
            return None
        shaft = {each.name: each.verdict for each in self.disagreements if each.verdict is not None}
        return self._whole({**self.verdicts, **shaft})

    def to_json(self) -> dict[str, Any]:
        """Return the case as the JSON document of a run lists it."""
        document: dict[str, Any] = {
            "bundle": str(self.bundle),
            "coordinates": self.coordinates.to_json(),
            "verdict": str(self.verdict),
            "verdict_by_transducer": self.verdict_by_transducer,
            "missed": [str(each) for each in self.missed],
            "waived": {each.name: str(each) for each in self.waived},
            "limits": {name: each.to_json() for name, each in self.judged.items()},
            "disagreements": {each.name: each.to_json() for each in self.disagreements},
            "refusal": self.refusal,
            "not_measured": {title: list(channels) for title, channels in self.without.items()},
            "refused": dict(self.refused),
            "different_parameters": dict(self.parameter_check.get("contradicted", {})),
            "unstated_parameters": dict(self.parameter_check.get("unstated", {})),
            "measurements": measurements_to_json(self.measurements),
        }
        if self.recorded is not None:
            document["source"] = self.recorded.source(self.capture)
        if self.together is not None:
            document["limits_together"] = self.together.to_json()
        document |= stated_overdue(self.overdue)
        document |= {"remarks": list(self.remarks)} if self.remarks else {}
        return document | ({"tables": tables_to_json(self.tables)} if self.tables else {})
