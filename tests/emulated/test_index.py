"""A drive whose incremental encoder knows no angle until its index has passed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from benchtool.bench.session import Session, open_session
from benchtool.drive import find_index
from benchtool.drive.quantities import TORQUE_SETPOINT, in_si
from benchtool.emulator.bench import EmulatedBench
from benchtool.errors import SdoAbort, StateError, WriteNotVerified
from benchtool.protocol import Command, Mode
from benchtool.protocol.cia402 import State
from benchtool.protocol.dictionary import Role

POWER_UP_RAD = 2.0
COUNT_RAD = 2.0 * math.pi / 10_000


@contextmanager
def opened(monkeypatch: pytest.MonkeyPatch, *, index: bool = True) -> Iterator[tuple[Session, Any]]:
    """A session with a drive that is told to wait for the index, and the core behind it."""
    cores: list[Any] = []
    begin = EmulatedBench.__init__

    def remembering(self: EmulatedBench, *arguments: Any, **named: Any) -> None:
        begin(self, *arguments, **named)
        cores.append(self._core)

    monkeypatch.setattr(EmulatedBench, "__init__", remembering)
    flaws = {
        "sensors.encoder.relative": 1.0,
        "sensors.encoder.index": float(index),
        "motor.power_up_angle_rad": POWER_UP_RAD,
    }
    with open_session("zhu2011", alter=flaws) as session:
        session.drive.connect()
        session.drive.write("encoder_reference", "index")
        yield session, cores[0]


def error_rad(session: Session, core: Any) -> float:
    """What the drive's angle is off by, within half a revolution."""
    theta_m = float(core.shaft.theta_e) / core.motor.pole_pairs
    return abs(math.remainder(float(core.memory["theta_m"][0]) - theta_m, 2.0 * math.pi))


def test_it_is_not_enabled_before_the_index_has_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    with opened(monkeypatch) as (session, core):
        drive = session.drive
        assert drive.read("angle_known") == "no"
        with pytest.raises(StateError, match=r"turn the shaft by hand.*index_search_A"):
            drive.enable(Mode.TORQUE)
        drive.write(Role.MODE_OF_OPERATION, int(Mode.TORQUE))
        for command in (Command.SHUTDOWN, Command.SWITCH_ON):
            drive._ask(command)
        with pytest.raises(SdoAbort, match="08000022"):  # nor by a host that does not ask first
            drive._ask(Command.ENABLE_OPERATION)
        session.clock.wait(0.01)
        assert error_rad(session, core) == pytest.approx(POWER_UP_RAD, abs=COUNT_RAD)
        # Nor does it take a mode that needs the angle, or brake by its laws, once it is enabled without.
        with drive.enabled(Mode.CURRENT):
            with pytest.raises((SdoAbort, WriteNotVerified)):
                drive.write(Role.MODE_OF_OPERATION, int(Mode.VELOCITY))
            drive._ask(Command.QUICK_STOP)
            assert drive.state() is State.SWITCH_ON_DISABLED


def test_it_is_enabled_once_the_rotor_was_turned_past_the_index(monkeypatch: pytest.MonkeyPatch) -> None:
    with opened(monkeypatch) as (session, core):
        drive = session.drive
        drive.index_search = lambda: find_index(drive, session.profile.motor, 4.0)
        with drive.enabled(Mode.TORQUE):
            assert drive.read("angle_known") == "yes"
            assert error_rad(session, core) <= 1.01 * COUNT_RAD
            session.load.hold(20.0)  # type: ignore[union-attr]
            drive.write(in_si(drive, TORQUE_SETPOINT), 2.0)
            drive.wait(0.05)
            shaft, motor = core.shaft, core.motor
            true_Nm = 1.5 * motor.pole_pairs * motor.psi_r_Wb * float(shaft.i_q)
            assert true_Nm == pytest.approx(2.0, abs=0.3)


def test_an_encoder_without_an_index_is_not_waited_for_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    with opened(monkeypatch, index=False) as (session, _):
        with pytest.raises(StateError, match=r"cable of the index"):
            find_index(session.drive, session.profile.motor, 4.0)
        assert session.drive.state() is State.SWITCH_ON_DISABLED
