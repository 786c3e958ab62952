"""Setpoints timed by the host, for moving a shaft by hand or by a script, not for experiments.

An experiment's setpoints are played by the drive (`benchtool.drive.play`); `Pacing` states how even the
host's timer was.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from benchtool.clock import Clock
from benchtool.drive import (
    SPEED,
    SPEED_SETPOINT,
    TORQUE,
    TORQUE_SETPOINT,
    Capability,
    Quantity,
    RemoteDrive,
    in_si,
    is_own,
)
from benchtool.errors import BenchError, CapabilityMissing, ValueRefused
from benchtool.profile import Motor
from benchtool.protocol import Mode
from benchtool.protocol.dictionary import Role, Variable
from benchtool.telemetry import Setpoints

HIGHEST_RATE_HZ = 1000.0
_LATE = 1.5  # periods


@dataclass(frozen=True)
class Pacing:
    """How evenly frames were sent, by the host's clock.

    `period_rms_s` is the rms deviation of the periods from the one asked for; a period is late from one and a
    half of that on. Missed frames are skipped, never sent in a burst.
    """

    sent: int
    period_s: float
    period_mean_s: float
    period_rms_s: float
    period_max_s: float
    late: int


@dataclass(frozen=True)
class Jog:
    """Result of a jog: the pacing, and the drive's measurements at the end, before it was disabled.

    A measurement that the drive lacks in SI units is None.
    """

    pacing: Pacing
    omega_m_rad_s: float | None
    torque_Nm: float | None


def jog(
    drive: RemoteDrive,
    motor: Motor,
    mode: Mode,
    setpoint: Callable[[float], float],
    *,
    duration_s: float,
    rate_Hz: float = 100.0,
) -> Jog:
    """Enable the drive, send it setpoints for `duration_s`, and disable it on every exit.

    Everything that can be checked is checked before enabling, and the PDO of the setpoints is restored.

    Args:
        drive: connected.
        motor: whose rated torque and speed no setpoint may exceed.
        mode: VELOCITY or TORQUE.
        setpoint: of the seconds since the start, in rad/s or Nm.
        rate_Hz: frames per second, 1000 at most; each is one RPDO, which also feeds the link supervision.

    Raises:
        CapabilityMissing: the drive has no such mode, target or supervision, or not in SI units.
        ValueRefused: a setpoint is beyond the rating or the limits of the drive, the rate or the mode is
            invalid, or the drive takes no such setpoints; nothing was sent.
        DriveFault, LinkError: the drive is disabled or will stop by itself.
    """
    if not 0.0 < rate_Hz <= HIGHEST_RATE_HZ:
        raise ValueRefused(
            f"a rate of {rate_Hz:g} Hz: more than 0 and at most {HIGHEST_RATE_HZ:g} Hz is possible: change it"
        )
    if mode not in (Mode.VELOCITY, Mode.TORQUE):
        raise ValueRefused(f"{mode.name.lower()} mode takes no setpoints: choose velocity or torque")
    name = "omega_m_rad_s" if mode is Mode.VELOCITY else "torque_Nm"
    drive.capabilities.require(
        Capability.VELOCITY if mode is Mode.VELOCITY else Capability.TORQUE, purpose="a jog"
    )
    first = within_rating(setpoint(0.0), mode, motor)
    require_mode(drive, mode)
    measured = [_measured(drive, quantity) for quantity in (SPEED, TORQUE)]
    with _setpoints(drive, mode) as setpoints:
        setpoints.check(**{name: first})
        with drive.enabled(mode):

            def send(time_s: float) -> None:
                setpoints.send(**{name: within_rating(setpoint(time_s), mode, motor)})
                drive.raise_emergencies()

            pacing = pace(drive.clock, send, duration_s=duration_s, period_s=1.0 / rate_Hz)
            return Jog(pacing, *(None if each is None else drive.number(each) for each in measured))


def _measured(drive: RemoteDrive, quantity: Quantity) -> Variable | None:
    """Return the object of a measurement; None if the drive has none, or its scale is unknown."""
    try:
        return in_si(drive, quantity)
    except CapabilityMissing:
        return None


def pace(clock: Clock, action: Callable[[float], None], *, duration_s: float, period_s: float) -> Pacing:
    """Call `action` with the seconds since the start, every `period_s` for `duration_s`; return the
    pacing."""
    start_s = clock.now_s()
    slots = max(1, round(duration_s / period_s))
    slot, last_s, sent, late = 0, start_s, 0, 0
    total_s, squares_s2, longest_s = 0.0, 0.0, 0.0
    while slot < slots:
        clock.wait(start_s + slot * period_s - clock.now_s())
        now_s = clock.now_s()
        if sent:
            period = now_s - last_s
            total_s += period
            squares_s2 += (period - period_s) ** 2
            longest_s = max(longest_s, period)
            late += period > _LATE * period_s
        action(now_s - start_s)
        last_s, sent = now_s, sent + 1
        slot = max(slot + 1, math.floor((clock.now_s() - start_s) / period_s))
    clock.wait(start_s + slots * period_s - clock.now_s())
    periods = max(1, sent - 1)
    return Pacing(sent, period_s, total_s / periods, math.sqrt(squares_s2 / periods), longest_s, late)


def require_mode(drive: RemoteDrive, mode: Mode) -> None:
    """Check the mode against the drive's supported drive modes (CiA 402-2, 0x6502), where it has them.

    Raises:
        ValueRefused: it has not this one; nothing was sent.
    """
    supported = drive.optional_number(Role.SUPPORTED_MODES)
    if supported is not None and mode.supported_code(supported) is None:
        known = [each.name.lower() for each in Mode if each.supported_code(supported) is not None]
        raise ValueRefused(
            f"the drive has no {mode.name.lower()} mode "
            f"({drive.dictionary[Role.SUPPORTED_MODES].label} is 0x{supported:X}, "
            f"{', '.join(known) or 'none'} of those known here): choose another mode; nothing was enabled"
        )


def within_rating(value: float, mode: Mode, motor: Motor) -> float:
    """Return a setpoint of velocity mode in rad/s, or of torque mode in Nm, that the motor is rated for.

    Raises:
        ValueRefused: it is beyond the rating, or no number.
    """
    limit, unit = (motor.omega_m_N_rad_s, "rad/s") if mode is Mode.VELOCITY else (motor.T_N_Nm, "Nm")
    if not abs(value) <= limit:
        raise ValueRefused(
            f"the setpoint is {value:g} {unit}, the profile rates the motor at {limit:g} {unit}: "
            f"stay within; it was not sent"
        )
    return value


@contextmanager
def _setpoints(drive: RemoteDrive, mode: Mode) -> Iterator[Setpoints]:
    """Set the setpoint frame up for the length of a `with` block."""
    if all(is_own(drive.dictionary, each) for each in (TORQUE_SETPOINT, SPEED_SETPOINT)):
        setpoints = Setpoints(drive)
    elif mode is Mode.TORQUE:
        setpoints = Setpoints(drive, torque=in_si(drive, TORQUE_SETPOINT))
    else:
        setpoints = Setpoints(drive, speed=in_si(drive, SPEED_SETPOINT))
    try:
        yield setpoints
    except BaseException as error:
        try:
            setpoints.close()
        except BenchError as failed:
            error.add_note(str(failed))
        raise
    else:
        setpoints.close()
