"""What the tests of the suite have in common: what they need of a bench, where they run, what they record."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Final

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.bench import LoadMachine, Session
from benchtool.block import Block
from benchtool.drive import TORQUE_SETPOINT, Capture, CaptureRequest, in_si
from benchtool.errors import SdoAbort
from benchtool.plan import Record
from benchtool.protocol import Mode
from benchtool.protocol.canopen import NmtCommand
from benchtool.protocol.dictionary import Role
from benchtool.run import capture

SETTLE_S: Final = 0.15
_MOST_ROWS: Final = 4000
_OF_FIXED_VOLTAGE: Final = 0.85  # of what such a law can make in the steady state
_OF_MODULATOR: Final = 0.8


@dataclass(frozen=True)
class Rating:
    """What the machine can do on this bench.

    Attributes:
        torque_Nm: rated torque, or the drive's torque limit if that is lower.
        omega_m_rad_s: speed up to which the dc link suffices for `torque_Nm`, at most the rated one.
        current_A: rated current, peak.
        T_N_Nm, omega_m_N_rad_s: of the nameplate.
        pole_pairs: of the motor.
        control_period_s: of the drive.
    """

    torque_Nm: float
    omega_m_rad_s: float
    current_A: float
    T_N_Nm: float
    omega_m_N_rad_s: float
    pole_pairs: int
    control_period_s: float

    def period_s(self, omega_m_rad_s: float) -> float:
        """Return an electrical period at a speed."""
        return 2.0 * math.pi / (self.pole_pairs * abs(omega_m_rad_s))


def rating(session: Session) -> Rating:
    """Return what the machine can do, by profile, dc link and law.

    The speed is where the voltage of the steady state, R i + omega psi along and omega L i across the EMF,
    reaches what the law can make.
    """
    drive, motor = session.drive, session.profile.motor
    session.clock.wait(0.01)  # signals are those of a tick
    torque = min(motor.T_N_Nm, number(session, "torque_limit", motor.T_N_Nm))
    i_q = torque / (1.5 * motor.pole_pairs * motor.psi_r_Wb)
    law = drive.read("law") if "law" in drive.dictionary else ""
    if law in ("tpc", "tpc_stator"):
        U = _OF_FIXED_VOLTAGE * drive.number("u_s") * drive.number("T_k_ratio")
    else:
        U = _OF_MODULATOR * number(session, "u_dc", 0.0) / math.sqrt(3.0)
    a = motor.psi_r_Wb**2 + (motor.L_q_H * i_q) ** 2
    half_b = motor.R_s_ohm * i_q * motor.psi_r_Wb
    c = (motor.R_s_ohm * i_q) ** 2 - U**2
    omega_e = (math.sqrt(max(0.0, half_b**2 - a * c)) - half_b) / a
    if omega_e <= 0.0:
        pytest.skip(f"the dc link does not suffice for {torque:g} Nm at any speed: raise it")
    return Rating(
        torque,
        min(omega_e / motor.pole_pairs, motor.omega_m_N_rad_s),
        math.sqrt(2.0) * motor.I_N_A_rms,
        motor.T_N_Nm,
        motor.omega_m_N_rad_s,
        motor.pole_pairs,
        number(session, "control_period", session.profile.control_period_s),
    )


def number(session: Session, name: str, otherwise: float) -> float:
    """Return the value of an object, or another one for a drive without it."""
    return session.drive.number(name) if name in session.drive.dictionary else otherwise


def require_objects(session: Session, *names: str) -> None:
    """Skip the test on a drive without these objects."""
    if lacking := [name for name in names if name not in session.drive.dictionary]:
        pytest.skip(f"the drive's dictionary has no {', '.join(lacking)}")


def load_machine(session: Session) -> LoadMachine:
    """Return the load machine; a bench without one skips the test."""
    if session.load is None:
        pytest.skip("this bench has no load machine, and an unattended test asks no person to turn the shaft")
    return session.load


def require_transducer(session: Session) -> None:
    """Skip the test on a bench without torque transducer."""
    if session.transducer is None:
        pytest.skip("this bench has no torque transducer: the torque of the shaft is not known")


@contextmanager
def making_torque(session: Session, torque_Nm: float, omega_m_rad_s: float) -> Iterator[None]:
    """Have the drive make a torque while the load machine holds the shaft at a speed."""
    load, drive = load_machine(session), session.drive
    try:
        load.hold(omega_m_rad_s)
        drive.wait(SETTLE_S / 3.0)
        with drive.enabled(Mode.TORQUE):
            drive.write(in_si(drive, TORQUE_SETPOINT), torque_Nm)
            drive.wait(SETTLE_S)
            yield
    finally:
        load.apply(0.0)


def recorded(session: Session, duration_s: float, channels: Sequence[str]) -> tuple[Block, Block | None]:
    """Return what the drive captures from now on, some thousand rows at most, and the transducer beside."""
    record = Record.model_construct(
        duration_s=duration_s, channels=tuple(channels), stride=_stride(session, duration_s)
    )
    return capture(session, record)


def armed(session: Session, duration_s: float, channels: Sequence[str], **trigger: object) -> Capture:
    """Return a capture that has begun, or waits for its trigger; `Capture.read` reads it."""
    stride = _stride(session, duration_s)
    period_s = session.drive.number("control_period")
    rows = round(duration_s / (period_s * stride))
    return Capture(session.drive, CaptureRequest(tuple(channels), rows, stride, **trigger))  # type: ignore[arg-type]


def _stride(session: Session, duration_s: float) -> int:
    return max(1, math.ceil(duration_s / (session.drive.number("control_period") * _MOST_ROWS)))


def quiet(session: Session, duration_s: float) -> None:
    """Let time pass; emergencies wait to be looked at."""
    session.clock.wait(duration_s)


def starts(session: Session) -> bool:
    """Return whether the drive starts by the commands of CiA 402 alone, of a host that neither resets faults
    nor sends a heartbeat; it is disabled again."""
    drive = session.drive
    word = drive.dictionary[Role.CONTROLWORD]
    drive.link.nmt(NmtCommand.START)
    for command in (0x06, 0x07, 0x0F):
        with suppress(SdoAbort):
            drive.link.download(word.index, word.sub, word.encode(command))
        quiet(session, 0.005)
    on = drive.state().power_stage_on
    drive.link.download(word.index, word.sub, word.encode(0x00))
    return on


def torque_ends_s(block: Block, threshold_Nm: float, tick: int) -> float | None:
    """Return when the torque falls below a threshold for good, after a tick; None if it does not."""
    above = np.flatnonzero(np.abs(block.column("torque")) > threshold_Nm)
    if not len(above) or above[-1] == len(block.data) - 1:
        return None
    return float(times_s(block, tick)[above[-1] + 1])


def times_s(block: Block, tick: int) -> NDArray[np.float64]:
    """Return the times of the rows from a tick on."""
    found: NDArray[np.float64] = np.asarray((block.ticks() - tick) * block.tick_s, dtype=np.float64)
    return found


def phasor(values: NDArray[np.float64], theta_e: NDArray[np.float64]) -> complex:
    """Return the fundamental of a signal over whole periods of an angle, peak."""
    inside = _whole_periods(theta_e)
    if inside.sum() < 10:
        return complex(math.nan, math.nan)
    return complex(2.0 * np.mean(values[inside] * np.exp(-1j * theta_e[inside])))


def mean_of_periods(values: NDArray[np.float64], theta_e: NDArray[np.float64]) -> float:
    """Return the mean of a signal over whole periods of an angle."""
    inside = _whole_periods(theta_e)
    return float(np.mean(values[inside])) if inside.sum() >= 10 else math.nan


def _whole_periods(theta_e: NDArray[np.float64]) -> NDArray[np.bool_]:
    turns = np.abs(theta_e - theta_e[0]) / (2.0 * np.pi)
    inside: NDArray[np.bool_] = turns < math.floor(float(turns[-1]))
    return inside


def electrical_angle(block: Block, pole_pairs: int) -> NDArray[np.float64]:
    """Return the electrical angle of the rows, without steps."""
    return pole_pairs * np.unwrap(block.column("theta_m"))
