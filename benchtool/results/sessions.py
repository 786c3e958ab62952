"""Records of acceptance sessions: tests, what they measured, their verdicts, and earlier sessions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from benchtool.analysis import Measurement, Uncertainty, with_unit
from benchtool.document import Array, Section
from benchtool.errors import RecordingError
from benchtool.misfits import explain
from benchtool.plan import JudgedLimit, Limit, Verdict, worst
from benchtool.recording import SESSION, Conditions, read_sealed_json, write_json

_SCHEMA = 1


class Outcome(StrEnum):
    """Outcome of a test, from best to worst."""

    PASSED = "passed"
    WAIVED = "waived"
    """It failed, and a waiver holds."""
    NOT_RUN = "not run"
    FAILED = "failed"
    ERROR = "error"
    """It could not be carried out, or did not leave the drive as it should."""


class Judged(Section):
    """A value that was measured and held against a limit; null where it was not measured, which fails, or is
    only known to be less than `below`.

    `standard` is the standard uncertainty, with `dof` degrees of freedom, null of infinitely many, and
    `half_width` the expanded one where that is no multiple of it.
    """

    name: str
    value: float | None = None
    unit: str = ""
    limit: Limit
    standard: float | None = None
    dof: float | None = None
    half_width: float | None = None
    requirement: str = ""
    reason: str = ""
    verdict: str = ""
    below: float | None = None

    @property
    def uncertainty(self) -> Uncertainty | None:
        """Uncertainty of the value; None if it is not known."""
        if self.standard is None:
            return None
        dof = math.inf if self.dof is None else self.dof
        return Uncertainty(self.standard, "as it was stated", dof, half_width=self.half_width)

    @property
    def stated(self) -> str:
        """The value in all its digits, or what it is less than, with its unit."""
        if self.value is not None:
            return with_unit(f"{self.value}", self.unit)
        return "not measured" if self.below is None else with_unit(f"< {self.below}", self.unit)

    def judge(self) -> Verdict:
        """Return the verdict by value, uncertainty and limit."""
        return self.held.verdict

    @property
    def held(self) -> JudgedLimit:
        """The limit held against the value."""
        if self.value is None and self.below is None and not self.reason:
            return JudgedLimit.of(self.name, self.limit, None)
        value = math.nan if self.value is None else self.value
        measured = Measurement(
            self.name,
            value,
            self.unit,
            "",
            uncertainty=self.uncertainty,
            reason=self.reason,
            below=self.below,
        )
        return JudgedLimit.of(self.name, self.limit, measured)

    @property
    def conformance(self) -> float | None:
        """Probability that the true value lies within the limit; None without an uncertainty."""
        return self.held.conformance

    @property
    def complaint(self) -> str:
        """Why the limit is not met, in words; empty where it is."""
        told = self.held.told
        if told is None or self.judge().met:
            return ""
        if self.value is None and self.below is None:
            why = f" ({self.reason})" if self.reason else ""
            return f"{self.name} was not measured{why}, {self.limit.bounds} {self.unit} is asked for"
        return str(told)


class Attachment(Section):
    """A file that belongs to a test, relative to the folder of the session."""

    name: str
    path: str


class Waiver(Section):
    """Consent to a test that fails: of a test by its name or of all tests of a requirement, by whom, and
    until when (ISO 8601)."""

    reason: str
    by: str
    test: str = ""
    requirement: str = ""
    until: str = ""


class TestRecord(Section):
    """One test of a session."""

    __test__ = False  # no test of pytest's

    name: str
    title: str = ""
    outcome: Outcome = Field(strict=False)
    reason: str = ""
    requirements: Array[str] = ()
    judged: Array[Judged] = ()
    attachments: Array[Attachment] = ()
    notes: Array[str] = ()
    waiver: Waiver | None = None
    duration_s: float = 0.0

    @property
    def verdict(self) -> Verdict:
        """The worst of its limits; that of a test without any follows from its outcome."""
        found = worst(Verdict(each.verdict) for each in self.judged)
        if self.outcome in (Outcome.FAILED, Outcome.ERROR):
            return found if found is Verdict.UNDECIDED else Verdict.FAIL
        return (
            Verdict.NONE
            if self.outcome in (Outcome.NOT_RUN, Outcome.WAIVED)
            else worst((found, Verdict.PASS))
        )


class SuiteScore(Section):
    """How well a suite finds faults, as it was measured: mutants of drive and bench that it caught, and runs
    of an unchanged one that failed. `of` is the hash of the suite."""

    caught: int
    mutants: int
    missed: Array[str] = ()
    clean_runs: int
    false_failures: int
    when: str
    profiles: Array[str]
    of: str


class SessionRecord(Section):
    """A session: what was tested, on what, by whom, and each test.

    `sensors` are those of the bench with certificate and date of calibration. `suite` is the hash of the
    files that hold the tests.
    """

    when: str
    profile_name: str
    profile_toml: str
    link: str
    identity: dict[str, int | float | str] = Field(default_factory=dict)
    versions: dict[str, str] = Field(default_factory=dict)
    conditions: Conditions = Conditions()
    sensors: Array[str] = ()
    seed: int = 0
    emulator: dict[str, float] = Field(default_factory=dict)
    command_line: Array[str] = ()
    suite: str = ""
    score: SuiteScore | None = None
    tests: Array[TestRecord] = ()
    interrupted: str = ""
    schema_version: Annotated[int, Field(ge=1)] = _SCHEMA

    @property
    def counts(self) -> Mapping[Outcome, int]:
        """Number of tests by their outcome."""
        found = Counter(each.outcome for each in self.tests)
        return {each: found[each] for each in Outcome}

    @property
    def verdict(self) -> Verdict:
        """The worst of its tests; a session that was interrupted, or without any test that ran, fails."""
        told = worst(each.verdict for each in self.tests)
        ran = any(each.outcome is not Outcome.NOT_RUN for each in self.tests)
        return Verdict.FAIL if self.interrupted or not ran else told

    @property
    def requirements(self) -> Mapping[str, Outcome]:
        """Worst outcome of the tests of each requirement."""
        order = list(Outcome)
        found: dict[str, Outcome] = {}
        for test in self.tests:
            for each in test.requirements:
                found[each] = max(found.get(each, Outcome.PASSED), test.outcome, key=order.index)
        return dict(sorted(found.items()))


def write_session(folder: Path, record: SessionRecord) -> Path:
    """Write the record, sealed by its own hash; its path.

    Raises:
        RecordingError: it cannot be written.
    """
    path = folder / SESSION
    write_json(path, record.model_dump(mode="json"), sealed=True)
    return path


def read_session(folder: Path) -> SessionRecord:
    """Return the record of the session in a folder.

    Raises:
        RecordingError: there is none, or it is damaged or of a newer version.
    """
    path = folder / SESSION
    document, fits = read_sealed_json(path)
    if not fits:
        raise RecordingError(
            f"{path} does not fit its seal: it was changed or damaged; restore it from a copy"
        )
    document.pop("seal", None)
    try:
        return SessionRecord.model_validate(document)
    except ValidationError as failed:
        raise RecordingError(
            f"{path}: {explain(SessionRecord, failed)}; use the benchtool that wrote it"
        ) from None


def earlier_sessions(folder: Path, record: SessionRecord, most: int = 10) -> tuple[SessionRecord, ...]:
    """Return the last sessions beside `folder` of the same profile, drive and kind of link, oldest first;
    damaged ones are left out."""
    if not folder.parent.is_dir():
        return ()
    found: list[SessionRecord] = []
    for path in sorted(folder.parent.glob(f"*/{SESSION}")):
        if path.parent == folder:
            continue
        try:
            other = read_session(path.parent)
        except RecordingError:
            continue
        if other.when <= record.when and _same_drive(other, record):
            found.append(other)
    return tuple(sorted(found, key=lambda each: each.when)[-most:]) if most else ()


def _same_drive(one: SessionRecord, other: SessionRecord) -> bool:
    def key(record: SessionRecord) -> tuple[Any, ...]:
        numbers = (record.identity.get(name) for name in ("vendor_id", "product_code", "serial_number"))
        object_ = record.conditions.test_object_serial_number
        return record.profile_name, object_, record.link.partition(":")[0].partition("?")[0], *numbers

    return key(one) == key(other)


def differing_verdicts(record: SessionRecord) -> Iterator[tuple[str, str]]:
    """Yield the limits whose stored verdict does not follow from value, uncertainty and decision rule."""
    for test in record.tests:
        for each in test.judged:
            if each.verdict != (fresh := str(each.judge())):
                yield f"{test.name}: {each.name}", f"stored is {each.verdict}, value and limit give {fresh}"


def values_of(records: Sequence[SessionRecord], test: str, name: str) -> tuple[float | None, ...]:
    """Return the values that sessions measured of one limit of a test; None where one has none."""
    found = []
    for record in records:
        judged = [
            each for one in record.tests if one.name == test for each in one.judged if each.name == name
        ]
        found.append(judged[-1].value if judged else None)
    return tuple(found)
