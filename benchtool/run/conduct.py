"""Conducting one case: hold or load the shaft, enable, settle, capture or play, and disable again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from benchtool.bench.equipment import LoadMachine
from benchtool.bench.session import Session
from benchtool.block import Block
from benchtool.drive import Capture, CaptureRequest, Mode, play
from benchtool.drive.quantities import SPEED_SETPOINT, TORQUE_SETPOINT, in_si
from benchtool.plan.cases import Case
from benchtool.plan.model import OperatingPoint, Plan, Record
from benchtool.plan.operating_point import read, to_read
from benchtool.telemetry import ClockFit

_LOAD_RAMP = 0.25  # of the settling time
_LOAD_STEPS = 50

_Clock = Callable[[], ClockFit | None]


class Progress(Protocol):
    """Whoever watches a run."""

    def begin(self, case: str, number: int, count: int) -> None:
        """Case `number` of `count` begins."""

    def note(self, text: str) -> None:
        """A step within the case begins."""


@dataclass(frozen=True)
class Conducted:
    """What a case gave: the drive's capture, that of the torque transducer where the bench has one, and what
    was read from the drive just before, by signal."""

    capture: Block
    transducer: Block | None
    readings: Mapping[str, Sequence[float]]


def conduct(
    session: Session,
    plan: Plan,
    case: Case,
    progress: Progress,
    clock: _Clock = lambda: None,
) -> Conducted:
    """Run one case and return what was recorded.

    The drive is disabled and the load machine without load when this returns or raises. Where there is none,
    a person has done the case's `instruction` before.

    Args:
        clock: tells the drive's time on the host's clock, for a transducer with a clock of its own.

    Raises:
        BenchError: whatever went wrong.
    """
    point = case.operating_point
    try:
        _hold(session, point, progress)
        progress.note("enabling")
        with session.drive.enabled(point.mode_of_operation):
            _settle(session, point, progress)
            names = to_read(plan, session.drive.number("control_period"))
            readings = read(session.drive, names)
            capture = _play if plan.stimulus else _capture
            return Conducted(*capture(session, plan, progress, clock), readings)
    finally:
        if session.load is not None:
            session.load.apply(0.0)


def _hold(session: Session, point: OperatingPoint, progress: Progress) -> None:
    """Have the load machine turn the shaft, before the drive is switched on."""
    if point.hold_speed_rad_s is None:
        return
    if session.load is not None:
        progress.note(f"holding {point.hold_speed_rad_s:g} rad/s")
        session.load.hold(point.hold_speed_rad_s)
    session.drive.wait(point.settle_s / 2.0)


def _apply_load(session: Session, load: LoadMachine, point: OperatingPoint) -> None:
    """Ramp the load up: a step would be a test of the speed controller."""
    for step in range(1, _LOAD_STEPS + 1):
        load.apply(point.load_torque_Nm * step / _LOAD_STEPS)
        session.drive.wait(_LOAD_RAMP * point.settle_s / _LOAD_STEPS)


def _settle(session: Session, point: OperatingPoint, progress: Progress) -> None:
    """Take the setpoint, then load, then wait: half of the time for each."""
    if point.mode_of_operation is Mode.TORQUE:
        progress.note(f"making {point.torque_Nm:g} Nm")
        session.drive.write(in_si(session.drive, TORQUE_SETPOINT), point.torque_Nm)
    else:
        loaded = f" with {point.load_torque_Nm:g} Nm"
        progress.note(f"running at {point.omega_m_rad_s:g} rad/s{loaded}")
        session.drive.write(in_si(session.drive, SPEED_SETPOINT), point.omega_m_rad_s)
    session.drive.wait(point.settle_s / 2.0)
    if point.hold_speed_rad_s is not None:
        return
    if session.load is not None:
        _apply_load(session, session.load, point)
    session.drive.wait(point.settle_s / 2.0)


def _capture(session: Session, plan: Plan, progress: Progress, clock: _Clock) -> tuple[Block, Block | None]:
    progress.note(f"capturing {plan.record.duration_s:g} s on the drive")
    capture = Capture(session.drive, _request(session, plan.record))
    if session.transducer is not None:
        session.transducer.start(capture.duration_s)
    capture.wait()
    transducer = _recorded(session, clock)
    progress.note("reading the capture")
    return capture.read(), transducer


def _play(session: Session, plan: Plan, progress: Progress, clock: _Clock) -> tuple[Block, Block | None]:
    """Capture while the drive plays the plan's stimulus, from some rows before it on."""
    assert plan.stimulus is not None
    request = _request(session, plan.record)
    row_s = plan.record.duration_s / request.rows
    request = replace(request, pretrigger_rows=round(plan.record.pretrigger_s / row_s))
    progress.note(f"playing a {plan.stimulus.quantity} {plan.stimulus.shape} on the drive, and capturing")
    if session.transducer is not None:
        session.transducer.start(plan.record.duration_s)
    block = play(session.drive, plan.stimulus, request, motor=session.profile.motor)
    assert block is not None  # there was a request
    return block, _recorded(session, clock)


def _recorded(session: Session, clock: _Clock) -> Block | None:
    """What the transducer recorded, once the last of it has come."""
    if session.transducer is None:
        return None
    session.drive.wait(session.transducer.late_s)
    return session.transducer.block(clock())


def _request(session: Session, record: Record) -> CaptureRequest:
    period_s = session.drive.number("control_period")
    return CaptureRequest(
        record.channels, rows=round(record.duration_s / (period_s * record.stride)), stride=record.stride
    )
