"""Current mode and calibration over the wire: what protects, and what ends them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.drive import CaptureRequest, RemoteDrive, Stimulus, play
from benchtool.errors import DriveFault, SdoAbort, ValueRefused
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.cia402 import State
from benchtool.protocol.dictionary.variable import Value
from benchtool.protocol.modes import Mode

from .conftest import Wire, over_both_wires

CURRENTS = ("i_a", "i_b", "i_c")
ASTRAY: dict[str, Value] = {"encoder_offset": 1.3, "encoder_direction": "reverse", "omega_current": 1000.0}
HALT, QUICK_STOP = 0x10F, 0x02


def _current(amplitude_A: float, angle_rad: float = 0.0) -> Stimulus:
    return Stimulus(
        quantity="current", shape="constant", amplitude_A=amplitude_A, duration_s=0.05, angle_rad=angle_rad
    )


def _drive(wire: Wire) -> RemoteDrive:
    """A drive in current mode whose encoder is of no use."""
    drive = wire.session.drive
    for name, value in ASTRAY.items():
        drive.write(name, value)
    drive.connect()
    drive.enable(Mode.CURRENT)
    return drive


def _started(wire: Wire) -> RemoteDrive:
    drive = _drive(wire)
    drive.wait(0.01)
    for name, value in _current(3.0).table(1e-4).items():
        drive.write(name, value)
    drive.write("stimulus_ticks", 1_000_000)
    drive.write("stimulus_control", "start")
    drive.wait(0.05)
    assert abs(drive.number("i_a")) > 2.9
    return drive


@over_both_wires
def test_a_current_is_played_at_its_angle_and_captured(wire: Wire) -> None:
    drive = _drive(wire)
    request = CaptureRequest((*CURRENTS, "stimulus"), rows=450, pretrigger_rows=20)
    block = play(drive, _current(3.0, angle_rad=1.0), request, motor=wire.session.profile.motor)
    assert block is not None
    assert block.unit("stimulus") == "A"
    phases = [3.0 * math.cos(1.0 - k * 2.0 * math.pi / 3.0) for k in range(3)]
    assert block.data[300:, :3].mean(axis=0) == pytest.approx(phases, abs=0.15), (
        "while the rotor swings into line"
    )
    assert np.abs(block.data[:20, :3]).max() < 0.03


@over_both_wires
@pytest.mark.parametrize("end", ["halt", "quick stop", "lost link", "disabled"])
def test_what_ends_a_current(wire: Wire, end: str) -> None:
    drive = _started(wire)
    match end:
        case "halt":
            drive.write("controlword", HALT)
        case "quick stop":
            drive.write("quick_stop_option", "disable")
            drive.write("controlword", QUICK_STOP)
        case "lost link":
            drive.stop_heartbeat()
            wire.session.clock.wait(0.6)
        case "disabled":
            drive.disable()
    wire.session.clock.wait(0.05)
    assert drive.read("stimulus_state") == "idle"
    assert max(abs(drive.number(name)) for name in CURRENTS) < 0.05
    left = {"halt": State.OPERATION_ENABLED, "lost link": State.FAULT}
    assert drive.state() is left.get(end, State.SWITCH_ON_DISABLED)


def test_a_current_beyond_its_trip_level_trips(wire: Wire) -> None:
    drive = _started(wire)
    drive.write("i_trip", 2.0)
    with pytest.raises(DriveFault, match="0x2310"):
        drive.wait(0.1)
    assert drive.state() is State.FAULT
    assert drive.read("stimulus_state") == "idle"


def test_neither_host_nor_drive_takes_too_much(wire: Wire) -> None:
    drive = _drive(wire)
    with pytest.raises(ValueRefused, match=r"1\.1 times the profile's rated current, peak, is 10\.42"):
        play(drive, _current(10.5), motor=wire.session.profile.motor)
    table: dict[str, Value] = {"stimulus_quantity": "current", "stimulus_amplitude": 12.1}
    for name, value in table.items():
        drive.write(name, value)
    with pytest.raises(SdoAbort) as refused:
        drive.write("stimulus_control", "start")
    assert refused.value.code == Abort.VALUE_HIGH


@over_both_wires
def test_the_offsets_are_calibrated_with_the_power_stage_off_only(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    for phase in "abc":
        drive.write(f"current_offset_{phase}", 0.3)
    drive.write("offset_calibration", "start")
    assert drive.read("offset_calibration_state") == "running"
    drive.wait(0.5)
    assert drive.read("offset_calibration_state") == "done"
    assert all(abs(drive.number(f"current_offset_{phase}")) < 0.01 for phase in "abc")
    drive.write("offset_calibration", "start")
    drive.enable(Mode.CURRENT)
    drive.wait(0.01)
    assert drive.read("offset_calibration_state") == "idle"
    with pytest.raises(SdoAbort) as refused:
        drive.write("offset_calibration", "start")
    assert refused.value.code == Abort.DEVICE_STATE
