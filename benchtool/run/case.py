"""Run one case: hold or load the shaft, enable, settle, capture or play, and disable again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from benchtool.bench import LoadMachine, Session
from benchtool.block import Block
from benchtool.drive import SPEED_SETPOINT, TORQUE_SETPOINT, Capture, CaptureRequest, Stimulus, in_si, play
from benchtool.errors import ValueRefused
from benchtool.plan import Case, OperatingPoint, Plan, Record, read, signals_to_read
from benchtool.protocol import Mode
from benchtool.telemetry import ClockFit

_LOAD_RAMP = 0.25  # of the settling time
_LOAD_STEPS = 50

Clock = Callable[[], ClockFit | None]
"""Tells the drive's time on the host's clock; None where that is not known."""


class Progress(Protocol):
    """Receives the progress of a run."""

    def begin(self, case: str, number: int, count: int) -> None:
        """Case `number` of `count` begins."""

    def note(self, text: str) -> None:
        """A step within the case begins."""


@dataclass(frozen=True)
class CaseRecording:
    """Recording of a case: the drive's capture, that of the torque transducer if the bench has one, readings
    of the drive just before, by signal, and the energies of a bench that keeps accounts of them."""

    capture: Block
    transducer: Block | None
    readings: Mapping[str, Sequence[float]]
    energies: Block | None


def run_case(
    session: Session,
    plan: Plan,
    case: Case,
    progress: Progress,
    clock: Clock = lambda: None,
) -> CaseRecording:
    """Run one case and return what was recorded.

    The drive is disabled and the load machine without load when this returns or raises. Without a load
    machine, the operator has done the case's `instruction` before.

    Args:
        clock: returns the fit of the drive's time on the host's clock, for a transducer with its own clock.

    Raises:
        BenchError: any failure.
    """
    point = case.operating_point
    try:
        _hold(session, point, progress)
        progress.note("enabling")
        with session.drive.enabled(point.mode_of_operation):
            _settle(session, point, progress)
            names = signals_to_read(plan, session.drive.number("control_period"))
            readings = read(session.drive, names)
            record = _play if plan.stimulus else _capture
            _inject(session, plan, progress)
            capture, transducer = record(session, plan, progress, clock)
            energies = None if session.energy_meter is None else session.energy_meter.block()
            return CaseRecording(capture, transducer, readings, energies)
    finally:
        if session.load is not None:
            session.load.apply(0.0)


def _inject(session: Session, plan: Plan, progress: Progress) -> None:
    """Arm the plan's faults, whose moments count from now on."""
    for fault in plan.faults:
        if session.faults is None:
            raise ValueRefused(f"fault '{fault}': this bench is not emulated; the drive was disabled")
        progress.note(f"injecting {session.faults.inject(fault)}")


def _hold(session: Session, point: OperatingPoint, progress: Progress) -> None:
    """Have the load machine turn the shaft, before the drive is switched on."""
    if point.hold_speed_rad_s is None:
        return
    if session.load is not None:
        progress.note(f"holding {point.hold_speed_rad_s:g} rad/s")
        session.load.hold(point.hold_speed_rad_s)
    session.drive.wait(point.settle_s / 2.0)


def _apply_load(session: Session, load: LoadMachine, point: OperatingPoint) -> None:
    """Ramp the load up; a step would disturb the speed controller."""
    for step in range(1, _LOAD_STEPS + 1):
        load.apply(point.load_torque_Nm * step / _LOAD_STEPS)
        session.drive.wait(_LOAD_RAMP * point.settle_s / _LOAD_STEPS)


def _settle(session: Session, point: OperatingPoint, progress: Progress) -> None:
    """Write the setpoint, then load, and wait half of the settling time after each."""
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


def _capture(session: Session, plan: Plan, progress: Progress, clock: Clock) -> tuple[Block, Block | None]:
    progress.note(f"capturing {plan.record.duration_s:g} s on the drive")
    return capture(session, plan.record, clock, lambda: progress.note("reading the capture"))


def _play(session: Session, plan: Plan, progress: Progress, clock: Clock) -> tuple[Block, Block | None]:
    """Return the capture while the drive plays the plan's stimulus, from some rows before it on."""
    assert plan.stimulus is not None
    progress.note(f"playing a {plan.stimulus.quantity} {plan.stimulus.shape} on the drive, and capturing")
    return capture_stimulus(session, plan.record, plan.stimulus, clock)


def capture(
    session: Session, record: Record, clock: Clock = lambda: None, reading: Callable[[], None] = lambda: None
) -> tuple[Block, Block | None]:
    """Return what drive and transducer, where the bench has one, record from now on, whatever the drive is
    doing.

    Args:
        clock: as of `conduct`.
        reading: called once all is recorded and before it is read from the drive.

    Raises:
        BenchError: any failure.
    """
    armed = Capture(session.drive, _request(session, record))
    _start(session, armed.duration_s)
    armed.wait()
    transducer = _recorded(session, clock)
    reading()
    return armed.read(), transducer


def capture_stimulus(
    session: Session, record: Record, stimulus: Stimulus, clock: Clock = lambda: None
) -> tuple[Block, Block | None]:
    """As `capture`, while the drive plays a stimulus, from `record.pretrigger_s` before it on."""
    request = _request(session, record)
    row_s = record.duration_s / request.rows
    request = replace(request, pretrigger_rows=round(record.pretrigger_s / row_s))
    _start(session, record.duration_s)
    block = play(session.drive, stimulus, request, motor=session.profile.motor)
    assert block is not None  # there was a request
    return block, _recorded(session, clock)


def _start(session: Session, duration_s: float) -> None:
    """Have what records beside the drive begin."""
    if session.transducer is not None:
        session.transducer.start(duration_s)
    if session.energy_meter is not None:
        session.energy_meter.start(duration_s)


def _recorded(session: Session, clock: Clock) -> Block | None:
    """Return the recording of the transducer, once its last sample has arrived."""
    if session.transducer is None:
        return None
    session.drive.wait(session.transducer.late_s)
    return session.transducer.block(clock())


def _request(session: Session, record: Record) -> CaptureRequest:
    period_s = session.drive.number("control_period")
    return CaptureRequest(
        record.channels, rows=round(record.duration_s / (period_s * record.stride)), stride=record.stride
    )
