"""Run a plan on a session: every case in turn, each with its own bundle."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from benchtool.analysis import measurements_to_json, tables_to_json
from benchtool.bench import UNLOAD, Done, Prompt, Session, ask, instruction, no_operator
from benchtool.block import Block
from benchtool.drive import Capability, Identity
from benchtool.drive.parameters import snapshot, temporary
from benchtool.errors import ValueRefused
from benchtool.plan import Case, CaseReadings, Plan, Setting, Verdict, cases, require_in_si, require_rated
from benchtool.recording import (
    Bundle,
    BundleWriter,
    Conditions,
    EventFile,
    Level,
    Manifest,
    require_empty,
)
from benchtool.results import (
    Assessment,
    Calibration,
    RunResult,
    assess,
    assess_bundle,
    over_repetitions,
    stated_overdue,
)
from benchtool.run.case import Progress, run_case
from benchtool.run.equipment import facts, readings, remarks
from benchtool.run.failure import fail_bundle
from benchtool.run.observers import NullRunObserver, RunObserver
from benchtool.run.parameter_check import ParameterCheck, check_parameters
from benchtool.run.recording import manifest_of
from benchtool.run.requirements import require_capable
from benchtool.run.resumption import Provenance, case_folder, require_same_provenance
from benchtool.telemetry import (
    ClockFit,
    FanOut,
    Journal,
    Sink,
    TelemetryStream,
    certify_recording,
    keep_journal,
    record_stream,
)


@dataclass(frozen=True)
class RunInfo:
    """Information on a run from the caller.

    `when` is wall time in ISO 8601, `wall_s` returns the present time. `allow_different` permits a drive
    whose parameters contradict the profile. `profile_toml` is the text of the profile, None if it is not
    known before the bench is open. `note` and `conditions` go into the manifest unchanged. `prompt` asks the
    operator for actions without equipment, None where there is no operator to ask.
    """

    when: str
    seed: int
    command_line: tuple[str, ...]
    allow_different: bool = False
    wall_s: Callable[[], float] = time.time
    link: str = "emulated"
    profile_toml: str | None = None
    note: str = ""
    conditions: Conditions = field(default_factory=Conditions)
    prompt: Prompt | None = None


Opener = Callable[[Case, int], AbstractContextManager[Session]]


def run_plan(
    opener: Opener,
    plan: Plan,
    folder: Path,
    info: RunInfo,
    progress: Progress,
    *,
    resume: bool = False,
    observer: RunObserver | None = None,
) -> RunResult:
    """Run every case of `plan`; a plan of one case has its bundle in `folder`, others in folders within it.

    When this returns or raises, the drive is disabled and its parameters are restored.

    Args:
        opener: opens the session of a case; on an emulated bench as the case alters it, with the seed given.
        resume: skip the cases that `folder` already holds complete.
        observer: is notified of every case.

    Raises:
        UsageError: those cases have another provenance.
        BenchError: any failure; a bundle that was begun states it, and holds the data until then.
    """
    require_in_si(plan)
    todo = cases(plan)
    results = run_cases(opener, plan, todo, folder, info, progress, resume=resume, observer=observer)
    measured = {each.case: each.measurements for each in results}
    return RunResult(tuple(results), over_repetitions(plan, measured))


def run_cases(
    opener: Opener,
    plan: Plan,
    todo: Sequence[Case],
    folder: Path,
    info: RunInfo,
    progress: Progress,
    *,
    resume: bool = False,
    observer: RunObserver | None = None,
) -> list[Assessment]:
    """Run some of a plan's cases, each in a session of its own, so that none depends on those before it."""
    results: list[Assessment] = []
    put_on = ""
    provenance = Provenance(plan, info.link, info.seed, info.profile_toml)
    if resume:
        require_same_provenance(folder, provenance)
    else:
        for case in todo:
            require_empty(case_folder(plan, case, folder))
    for number, case in enumerate(todo, start=1):
        progress.begin(case.name, number, len(todo))
        place = case_folder(plan, case, folder)
        done = _finished(place) if resume else None
        if done is not None:
            progress.note("already there")
            results.append(assess_bundle(done))
            continue
        with opener(case, _seed(info, case)) as session:
            require_capable(session.drive.capabilities, plan, case)
            progress.note("checking identity and dictionary")
            identity = session.drive.connect()
            if unsupervised := session.drive.supervision.unsupervised:
                progress.note(f"without link supervision, as the profile allows: {unsupervised}")
            if resume:
                here = replace(
                    provenance,
                    profile_toml=session.profile_toml,
                    identity=identity,
                    parameters=snapshot(session.drive),
                )
                require_same_provenance(folder, here)
            _require_rated(session, plan, case)
            _require_person(session, todo, info)
            setup = {**plan.setup, **case.setup}
            check = _checked(session, setup, info, progress)
            todo_by_hand = "" if session.load is not None else instruction(case.operating_point)
            done_by_hand = ask(info.prompt, todo_by_hand or (UNLOAD if put_on else ""))
            put_on = todo_by_hand
            observing = observer or NullRunObserver()
            with _freed(todo_by_hand, progress), temporary(session.drive, setup):
                results.append(
                    _record_case(
                        session, plan, case, place, info, identity, check, done_by_hand, progress, observing
                    )
                )
    return results


def _seed(info: RunInfo, case: Case) -> int:
    """Return the seed of a case: repetitions differ in the noise of an emulated bench only."""
    return info.seed + case.repetition - 1


def _finished(place: Path) -> Bundle | None:
    """Return the complete bundle at `place`; an incomplete one is renamed."""
    if not place.exists():
        return None
    bundle = Bundle.open(place)
    if bundle.complete:
        return bundle
    aside = next(
        candidate
        for n in range(1, 1000)
        if not (candidate := place.with_name(f"{place.name}.cut-{n}")).exists()
    )
    place.rename(aside)
    return None


def _require_rated(session: Session, plan: Plan, case: Case) -> None:
    """Refuse cases beyond the motor's rating, or that the bench cannot record, before anything is set up."""
    parameters = {**session.profile.drive.parameters, **plan.setup, **case.setup}
    require_rated(case.operating_point, plan.stimulus, session.profile.motor, parameters)
    for name, beside in (
        ("the torque transducer records", session.transducer),
        ("energies are recorded for", session.energy_meter),
    ):
        if beside is not None and plan.record.duration_s > beside.longest_s:
            raise ValueRefused(
                f"record.duration_s is {plan.record.duration_s:g} s, {name} "
                f"{beside.longest_s:g} s at most: shorten it; the drive was not enabled"
            )


@contextmanager
def _freed(by_hand: str, progress: Progress) -> Iterator[None]:
    """Ask the operator at every exit to undo the manual actions."""
    try:
        yield
    finally:
        if by_hand:
            progress.note(f"to the operator: {UNLOAD}")


def _require_person(session: Session, todo: Sequence[Case], info: RunInfo) -> None:
    """Refuse a run that needs an operator without a prompt, before the drive is enabled for any case."""
    if session.load is None and info.prompt is None:
        for case in todo:
            if what := instruction(case.operating_point):
                raise no_operator(what)


def _checked(
    session: Session, setup: Mapping[str, Setting], info: RunInfo, progress: Progress
) -> ParameterCheck:
    """Return the drive's parameters against the profile's; differences are reported, or refused if not
    allowed."""
    check = check_parameters(session.drive, session.profile, setup)
    check.require_known()
    if not info.allow_different:
        check.require_equal()
    for line in check.lines():
        progress.note(line)
    return check


def _record_case(
    session: Session,
    plan: Plan,
    case: Case,
    place: Path,
    info: RunInfo,
    identity: Identity,
    check: ParameterCheck,
    by_hand: Done | None,
    progress: Progress,
    observer: RunObserver,
) -> Assessment:
    link = session.drive.link
    before = readings(session)
    manifest = _manifest(session, plan, case, info, identity, facts(session, before, by_hand))
    with BundleWriter(place, manifest) as writer:
        stream = None
        takers = (EventFile(place).append, observer.happened)
        try:
            sinks = observer.opened(session, case, manifest)
            with keep_journal(session.drive, takers) as journal:
                if by_hand is not None:
                    journal.note(str(by_hand))
                with _telemetry(session, writer, sinks) as stream:
                    clock = partial(_drive_clock, stream)
                    recorded = run_case(session, plan, case, _Steps(progress, journal), clock)
                for line in remarks(session):
                    progress.note(line)
                    journal.note(line, Level.WARN)
                capture, transducer = recorded.capture, recorded.transducer
                writer.append("capture", capture)
                if transducer is not None:
                    writer.append("transducer", transducer)
                if recorded.energies is not None:
                    writer.append("energies", recorded.energies)
                observer.captured(capture, transducer, _trigger_row(plan, capture))
                progress.note("analysing")
                certificate, stated = certify_recording(stream, {"capture": capture}, link.counters)
                motor, quality = session.profile.motor, certificate.measurements
                seen = CaseReadings(
                    recorded.readings, _dc_link_V(session), check.to_json(), _driven_Nm(session, case)
                )
                calibration = Calibration.at(session.profile.bench, info.when)
                result = assess(
                    plan, case.name, motor, place, capture, transducer, quality, seen, calibration
                )
        except BaseException as failure:
            details = facts(session, before, by_hand) | {"parameter_check": check.to_json()}
            reason = fail_bundle(
                writer, failure, stream, link.counters, verdict=Verdict.FAIL, details=details
            )
            observer.closed(None, reason)
            raise
        progress.note(certificate.summary)
        writer.finish(
            measurements_to_json(result.measurements),
            tables=tables_to_json(result.tables),
            verdict=result.verdict,
            quality=asdict(link.counters),
            details=stated
            | facts(session, before, by_hand)
            | seen.to_json()
            | {"verdicts": {name: str(verdict) for name, verdict in result.verdicts.items()}},
            certificate=certificate.to_json() | stated_overdue(result.overdue),
        )
    observer.closed(result, "")
    return result


def _supervision(session: Session) -> dict[str, Mapping[str, bool | str]]:
    """Return the supervision of a drive whose profile allows it to run unsupervised; empty for others."""
    stated = session.drive.supervision.to_json()
    return {"supervision": stated} if stated else {}


def _drive_clock(stream: TelemetryStream | None) -> ClockFit | None:
    """Return the fit of the drive's time on the host's clock; None without a stream."""
    return None if stream is None else stream.report().clock


def _dc_link_V(session: Session) -> float | None:
    """Return the voltage of the dc link of the bench that the profile describes."""
    emulator = session.profile.emulator
    return None if emulator is None else emulator.inverter.u_dc_V


def _driven_Nm(session: Session, case: Case) -> float:
    """Return the torque that the driven machine of an emulated bench takes at the speed of a case."""
    emulator, point = session.profile.emulator, case.operating_point
    if emulator is None or session.load is None or point.mode != "velocity":
        return 0.0
    return emulator.load.mean_torque_Nm(point.omega_m_rad_s)


class _Steps:
    """Pass the steps of a case to the observer and into the case's log."""

    def __init__(self, progress: Progress, journal: Journal) -> None:
        self._progress = progress
        self._journal = journal

    def begin(self, case: str, number: int, count: int) -> None:
        """See `Progress.begin`."""
        self._progress.begin(case, number, count)

    def note(self, text: str) -> None:
        """See `Progress.note`."""
        self._progress.note(text)
        self._journal.note(text)


def _trigger_row(plan: Plan, capture: Block) -> int | None:
    """Return the row at which the drive began to play; None without a stimulus."""
    return round(plan.record.pretrigger_s * capture.sample_rate_Hz) if plan.stimulus else None


@contextmanager
def _telemetry(
    session: Session, writer: BundleWriter, others: Sequence[Sink]
) -> Iterator[TelemetryStream | None]:
    """Record the slow stream into the bundle, if the drive has one; its failure ends the run."""
    if Capability.STREAM not in session.drive.capabilities:
        FanOut(others).close()
        yield None
        return
    with (
        record_stream(session.drive, writer, others=others) as stream,
        session.drive.watched(stream.check),
    ):
        yield stream


def _manifest(
    session: Session,
    plan: Plan,
    case: Case,
    info: RunInfo,
    identity: Identity,
    equipment: Mapping[str, Any],
) -> Manifest:
    return manifest_of(
        session,
        identity,
        what=plan.title,
        when=info.when,
        wall_s=info.wall_s(),
        note=info.note,
        conditions=info.conditions,
        seed=_seed(info, case),
        link=info.link,
        command_line=info.command_line,
        details={
            "case": case.name,
            "coordinates": case.coordinates.to_json(),
            "operating_point": case.operating_point.model_dump(mode="json"),
            "plan": plan.model_dump(mode="json"),
            "motor": session.profile.motor.model_dump(mode="json"),
            **_supervision(session),
            **equipment,
        },
    )
