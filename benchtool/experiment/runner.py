"""Runs one plan on a session and keeps what came of it as a bundle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from benchtool.bench import Session
from benchtool.block import Block
from benchtool.drive import Capture, CaptureRequest, Identity, Mode
from benchtool.drive.parameters import snapshot, temporary
from benchtool.experiment.assessment import Assessment, assess
from benchtool.experiment.limits import Verdict
from benchtool.experiment.plan import OperatingPoint, Plan, Record
from benchtool.recording import BundleWriter, Manifest, software_versions
from benchtool.report import draw_steady_state, save_figures

Note = Callable[[str], None]


@dataclass(frozen=True)
class RunInfo:
    """What only the caller knows of a run; `when` is wall time in ISO 8601."""

    when: str
    seed: int
    command_line: tuple[str, ...]


def run_plan(session: Session, plan: Plan, directory: Path, info: RunInfo, note: Note) -> Assessment:
    """Run `plan` and write its bundle to `directory`.

    When this returns or raises, the drive is disabled and its parameters are what they were.

    Args:
        note: takes a line at every step.

    Raises:
        BenchError: whatever went wrong; a bundle that was begun says where, and holds what came till then.
    """
    drive = session.drive
    note("checking identity and dictionary")
    identity = drive.connect()
    with (
        temporary(drive, plan.setup),
        BundleWriter(directory, _manifest(session, plan, info, identity)) as writer,
    ):
        try:
            capture, transducer = _record(session, plan, note)
            writer.append("capture", capture)
            if transducer is not None:
                writer.append("transducer", transducer)
            note("analysing")
            result = assess(plan, session.profile.motor, directory, capture, transducer)
        except BaseException as failure:
            reason = f"{type(failure).__name__}: {failure}"
            quality = asdict(drive.link.counters)
            writer.finish(verdict=Verdict.FAIL, quality=quality, details={"failure": reason})
            raise
        writer.finish(
            result.steady.to_json(),
            verdict=result.verdict,
            quality=asdict(drive.link.counters),
            details={"verdicts": {name: str(verdict) for name, verdict in result.verdicts.items()}},
        )
    note("drawing")
    save_figures(draw_steady_state(capture, result.steady, transducer, title=plan.title), directory / "plots")
    return result


def _record(session: Session, plan: Plan, note: Note) -> tuple[Block, Block | None]:
    drive = session.drive
    note("enabling")
    with drive.enabled(Mode.VELOCITY):
        _settle(session, plan.operating_point, note)
        note(f"capturing {plan.record.duration_s:g} s on the drive")
        capture = Capture(drive, _request(session, plan.record))
        if session.transducer is not None:
            session.transducer.start(capture.duration_s)
        capture.wait()
        transducer = session.transducer.block() if session.transducer is not None else None
        note("reading the capture")
        return capture.read(), transducer


def _settle(session: Session, point: OperatingPoint, note: Note) -> None:
    """Run up, then load, then wait: half of the time for each."""
    note(f"running at {point.omega_m_rad_s:g} rad/s")
    session.drive.write("omega_m_command", point.omega_m_rad_s)
    session.drive.wait(point.settle_s / 2.0)
    if session.load is not None:
        session.load.apply(point.load_torque_Nm)
    elif point.load_torque_Nm:
        note(f"this bench has no load machine: load the shaft with {point.load_torque_Nm:g} Nm yourself")
    session.drive.wait(point.settle_s / 2.0)


def _request(session: Session, record: Record) -> CaptureRequest:
    period_s = session.drive.number("control_period")
    return CaptureRequest(
        record.channels, rows=round(record.duration_s / (period_s * record.stride)), stride=record.stride
    )


def _manifest(session: Session, plan: Plan, info: RunInfo, identity: Identity) -> Manifest:
    return Manifest(
        what=plan.title,
        when=info.when,
        profile_name=session.profile_name,
        profile_toml=session.profile_toml,
        identity={key: value for key, value in asdict(identity).items() if value is not None},
        dictionary_hash=identity.dictionary_hash,
        parameters=snapshot(session.drive),
        versions=software_versions(),
        seed=info.seed,
        command_line=info.command_line,
        details={
            "plan": plan.model_dump(mode="json"),
            "motor": session.profile.motor.model_dump(mode="json"),
        },
    )
