"""Runs a plan on a session: every case in turn, each kept as a bundle of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

from benchtool.bench import Session
from benchtool.block import Block
from benchtool.drive import Capture, CaptureRequest, Identity, Mode
from benchtool.drive.parameters import snapshot, temporary
from benchtool.errors import RecordingError
from benchtool.experiment.assessment import Assessment, RunResult, assess, assess_bundle
from benchtool.experiment.cases import Case, cases
from benchtool.experiment.limits import Verdict
from benchtool.experiment.plan import OperatingPoint, Plan, Record
from benchtool.recording import Bundle, BundleWriter, Manifest, software_versions
from benchtool.report import draw_steady_state, save_figures


class Progress(Protocol):
    """Whoever watches a run."""

    def begin(self, case: str, number: int, count: int) -> None:
        """Case `number` of `count` begins."""

    def note(self, text: str) -> None:
        """A step within the case begins."""


@dataclass(frozen=True)
class RunInfo:
    """What only the caller knows of a run; `when` is wall time in ISO 8601."""

    when: str
    seed: int
    command_line: tuple[str, ...]


def run_plan(
    session: Session, plan: Plan, folder: Path, info: RunInfo, progress: Progress, *, resume: bool = False
) -> RunResult:
    """Run every case of `plan`; a plan of one case has its bundle in `folder`, others in folders within it.

    When this returns or raises, the drive is disabled and its parameters are what they were.

    Args:
        resume: take the cases that `folder` already holds complete from there.

    Raises:
        BenchError: whatever went wrong; a bundle that was begun says where, and holds what came till then.
    """
    progress.note("checking identity and dictionary")
    identity = session.drive.connect()
    todo = cases(plan)
    results = []
    with temporary(session.drive, plan.setup):
        for number, case in enumerate(todo, start=1):
            progress.begin(case.name, number, len(todo))
            place = folder if len(todo) == 1 else folder / case.folder
            done = _finished(place) if resume else None
            if done is not None:
                progress.note("already there")
                results.append(assess_bundle(done))
                continue
            with temporary(session.drive, case.setup):
                results.append(_run_case(session, plan, case, place, info, identity, progress))
    return RunResult(tuple(results))


def _finished(place: Path) -> Bundle | None:
    """The complete bundle at `place`; a half-done one is put aside under a name of its own."""
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


def _run_case(
    session: Session,
    plan: Plan,
    case: Case,
    place: Path,
    info: RunInfo,
    identity: Identity,
    progress: Progress,
) -> Assessment:
    link = session.drive.link
    with BundleWriter(place, _manifest(session, plan, case, info, identity)) as writer:
        try:
            capture, transducer = _record(session, plan, case, progress)
            writer.append("capture", capture)
            if transducer is not None:
                writer.append("transducer", transducer)
            progress.note("analysing")
            result = assess(plan, case.name, session.profile.motor, place, capture, transducer)
        except BaseException as failure:
            try:
                reason = f"{type(failure).__name__}: {failure}".rstrip(": ")
                writer.fail(reason, verdict=Verdict.FAIL, quality=asdict(link.counters))
            except RecordingError as also:
                failure.add_note(str(also))
            raise
        writer.finish(
            result.steady.to_json(),
            verdict=result.verdict,
            quality=asdict(link.counters),
            details={"verdicts": {name: str(verdict) for name, verdict in result.verdicts.items()}},
        )
    progress.note("drawing")
    figures = draw_steady_state(capture, result.steady, transducer, title=plan.title)
    save_figures(figures, place / "plots")
    return result


def _record(session: Session, plan: Plan, case: Case, progress: Progress) -> tuple[Block, Block | None]:
    drive = session.drive
    progress.note("enabling")
    with drive.enabled(Mode.VELOCITY):
        _settle(session, case.operating_point, progress)
        progress.note(f"capturing {plan.record.duration_s:g} s on the drive")
        capture = Capture(drive, _request(session, plan.record))
        if session.transducer is not None:
            session.transducer.start(capture.duration_s)
        capture.wait()
        transducer = session.transducer.block() if session.transducer is not None else None
        progress.note("reading the capture")
        return capture.read(), transducer


def _settle(session: Session, point: OperatingPoint, progress: Progress) -> None:
    """Run up, then load, then wait: half of the time for each."""
    progress.note(f"running at {point.omega_m_rad_s:g} rad/s with {point.load_torque_Nm:g} Nm")
    session.drive.write("omega_m_command", point.omega_m_rad_s)
    session.drive.wait(point.settle_s / 2.0)
    if session.load is not None:
        session.load.apply(point.load_torque_Nm)
    elif point.load_torque_Nm:
        progress.note(
            f"this bench has no load machine: load the shaft with {point.load_torque_Nm:g} Nm yourself"
        )
    session.drive.wait(point.settle_s / 2.0)


def _request(session: Session, record: Record) -> CaptureRequest:
    period_s = session.drive.number("control_period")
    return CaptureRequest(
        record.channels, rows=round(record.duration_s / (period_s * record.stride)), stride=record.stride
    )


def _manifest(session: Session, plan: Plan, case: Case, info: RunInfo, identity: Identity) -> Manifest:
    facts: Mapping[str, int | float | str | None] = asdict(identity)
    return Manifest(
        what=plan.title,
        when=info.when,
        profile_name=session.profile_name,
        profile_toml=session.profile_toml,
        identity={key: value for key, value in facts.items() if value is not None},
        dictionary_hash=identity.dictionary_hash,
        parameters=snapshot(session.drive),
        versions=software_versions(),
        seed=info.seed,
        command_line=info.command_line,
        details={
            "case": case.name,
            "operating_point": case.operating_point.model_dump(mode="json"),
            "plan": plan.model_dump(mode="json"),
            "motor": session.profile.motor.model_dump(mode="json"),
        },
    )
