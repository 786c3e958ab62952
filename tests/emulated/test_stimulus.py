"""Stimuli over the wire: what is played, when, and what ends it."""

from __future__ import annotations

import math

import can
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import chirp, max_len_seq

from benchtool.drive import Capture, CaptureRequest, RemoteDrive, Stimulus, play
from benchtool.errors import DriveFault, SdoAbort, StimulusError, ValueRefused
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.cia402 import State
from benchtool.protocol.dictionary.variable import Value
from benchtool.protocol.modes import Mode

from .conftest import Opener, Wire, over_both_wires

NODE = 1
SDO_REQUEST = 0x600 + NODE
T_S = 1e-4
STEP = Stimulus(quantity="torque", shape="step", amplitude_Nm=0.5, duration_s=0.02)
LONG: dict[str, Value] = {"stimulus_amplitude": 0.5, "stimulus_ticks": 100_000}


def _drive(wire: Wire, mode: Mode = Mode.TORQUE) -> RemoteDrive:
    wire.session.drive.connect()
    wire.session.drive.enable(mode)
    return wire.session.drive


def _column(
    wire: Wire, stimulus: Stimulus, name: str, *, rows: int, pretrigger: int = 0
) -> NDArray[np.float64]:
    request = CaptureRequest((name,), rows=rows, pretrigger_rows=pretrigger)
    block = play(wire.session.drive, stimulus, request, motor=wire.session.profile.motor)
    assert block is not None
    return block.column(name)


def _start(drive: RemoteDrive, **table: Value) -> None:
    drive.wait(T_S)
    for name, value in table.items():
        drive.write(name, value)
    drive.write("stimulus_control", "start")


# ---- what is played ------------------------------------------------------------------------------------


@over_both_wires
def test_a_torque_step_stands_in_the_reference_from_the_trigger_row_on(wire: Wire) -> None:
    drive = _drive(wire)
    request = CaptureRequest(("tick", "stimulus", "torque_reference"), rows=300, pretrigger_rows=40)
    block = play(drive, STEP, request, motor=wire.session.profile.motor)
    assert block is not None
    expected = np.repeat([0.0, 0.5, 0.0], [40, 100, 160])
    assert np.array_equal(block.column("torque_reference"), expected)
    assert np.array_equal(block.column("stimulus"), expected)
    assert block.unit("stimulus") == "Nm"
    start = drive.number("stimulus_start_tick")
    assert block.column("tick")[40] == start == drive.number("capture_trigger_tick")
    assert drive.read("stimulus_state") == "done"


def test_a_torque_stimulus_adds_to_the_setpoint_within_the_limit(wire: Wire) -> None:
    drive = _drive(wire)
    drive.write("torque_limit", 0.6)
    drive.write("torque_command", 0.3)
    reference = _column(wire, STEP, "torque_reference", rows=250, pretrigger=20)
    expected = np.float32(np.repeat([0.3, 0.6, 0.3], [20, 100, 130]))
    assert np.array_equal(reference, expected)


@pytest.mark.parametrize("shape", ["chirp_linear", "chirp_logarithmic"])
def test_a_chirp_is_its_closed_form_sample_by_sample(wire: Wire, shape: str) -> None:
    _drive(wire)
    stimulus = Stimulus.model_validate(
        {
            "quantity": "torque",
            "shape": shape,
            "amplitude_Nm": 0.25,
            "offset_Nm": 0.125,
            "frequency_start_Hz": 4.0,
            "frequency_end_Hz": 500.0,
            "duration_s": 0.5,
        }
    )
    method = shape.removeprefix("chirp_")
    phase = chirp(np.arange(5000) * T_S, 4.0, 0.5, 500.0, method=method, phi=-90.0)  # type: ignore[call-overload] # as literals
    captured = _column(wire, stimulus, "stimulus", rows=5001)
    assert captured[:5000] == pytest.approx(np.float32(0.125 + 0.25 * phase), abs=2e-8)
    assert captured[5000] == 0.0


def test_a_speed_stimulus_moves_the_shaft(wire: Wire) -> None:
    drive = _drive(wire, Mode.VELOCITY)
    drive.write("omega_m_command", 15.0)
    drive.wait(0.4)
    step = Stimulus(quantity="speed", shape="constant", amplitude_rad_s=3.0, duration_s=0.4)
    omega_m = _column(wire, step, "omega_m", rows=4100, pretrigger=100)
    assert omega_m[:100].mean() == pytest.approx(15.0, abs=0.2)
    assert omega_m[3900:4000].mean() == pytest.approx(18.0, abs=0.2)


@pytest.mark.parametrize(
    ("law", "psi_s"),
    [(law, 0.0) for law in ("tpc", "tpc_stator", "svm_dtc", "dtc", "fcs_mpc", "foc", "deadbeat")]
    + [("tpc", 0.18)],
)
def test_a_d_current_stimulus_shifts_i_d_by_its_amplitude_and_leaves_the_torque(
    wire: Wire, law: str, psi_s: float
) -> None:
    wire.session.drive.write("law", law)
    drive = _drive(wire, Mode.VELOCITY)
    drive.write("psi_s_command", psi_s)
    drive.write("omega_m_command", 15.0)
    drive.wait(0.4)
    request = CaptureRequest(("i_d", "torque"), rows=2500, pretrigger_rows=500)
    stimulus = Stimulus(quantity="d_current", shape="constant", amplitude_A=-2.0, duration_s=0.2)
    block = play(drive, stimulus, request, motor=wire.session.profile.motor)
    assert block is not None
    before, after = block.data[:500].mean(axis=0), block.data[700:].mean(axis=0)
    assert after[0] - before[0] == pytest.approx(-2.0, abs=0.05)
    assert after[1] == pytest.approx(before[1], abs=0.02)


@pytest.mark.parametrize(
    ("direction", "u"),
    [
        ({"angle_rad": 0.0}, (1.0, 0.0)),
        ({"angle_rad": math.pi / 2.0}, (0.0, 1.0)),
        ({"frame": "rotor", "angle_rad": math.pi / 2.0}, (1.0, 0.0)),
    ],
)
def test_a_voltage_has_the_direction_that_was_asked_for(
    wire: Wire, direction: dict[str, object], u: tuple[float, float]
) -> None:
    """The rotor of the emulated bench rests with its flux on phase a."""
    drive = _drive(wire, Mode.VOLTAGE)
    stimulus = Stimulus.model_validate(
        {"quantity": "voltage", "shape": "constant", "amplitude_V": 1.0, "duration_s": 0.01, **direction}
    )
    request = CaptureRequest(("u_alpha", "u_beta"), rows=110, pretrigger_rows=10)
    block = play(drive, stimulus, request, motor=wire.session.profile.motor)
    assert block is not None
    assert np.all(block.data[:10] == 0.0)
    assert block.data[10] == pytest.approx(u, abs=2e-3)


def test_a_standing_voltage_drives_the_current_of_the_resistance(wire: Wire) -> None:
    _drive(wire, Mode.VOLTAGE)
    stimulus = Stimulus(quantity="voltage", shape="constant", amplitude_V=0.5, duration_s=0.6)
    i_a = _column(wire, stimulus, "i_a", rows=6000)
    assert i_a[-100:].mean() == pytest.approx(0.5 / 0.123, rel=0.01)


def test_a_binary_sequence_is_played_bit_by_bit(wire: Wire) -> None:
    _drive(wire)
    stimulus = Stimulus(
        quantity="torque", shape="prbs", amplitude_Nm=0.5, prbs_clock_s=3e-4, prbs_length=9, seed=5
    )
    played = _column(wire, stimulus, "stimulus", rows=3 * 511 + 1)
    bits = max_len_seq(9, state=[1, 0, 1, 0, 0, 0, 0, 0, 0])[0].astype(float)
    assert np.array_equal(played, [*np.repeat(bits - 0.5, 3), 0.0])


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ({"shape": "ramp", "duration_s": 4e-4}, [0.0, 0.25, 0.5, 0.75]),
        ({"shape": "staircase", "steps": 2, "duration_s": 4e-4}, [0.5, 0.5, 1.0, 1.0]),
        ({"shape": "sine", "frequency_Hz": 2500.0, "duration_s": 4e-4}, [0.0, 1.0, 0.0, -1.0]),
    ],
)
def test_shapes_repeat(wire: Wire, table: dict[str, object], expected: list[float]) -> None:
    _drive(wire)
    stimulus = Stimulus.model_validate({"quantity": "torque", "amplitude_Nm": 1.0, "repetitions": 3, **table})
    played = _column(wire, stimulus, "stimulus", rows=14)
    assert played == pytest.approx(np.array([*expected * 3, 0.0, 0.0]), abs=1e-7)


def test_the_same_seed_gives_the_same_bits(open_wire: Opener) -> None:
    stimulus = Stimulus(
        quantity="torque", shape="prbs", amplitude_Nm=0.4, prbs_clock_s=1e-3, prbs_length=6, seed=5
    )
    columns = []
    for seed in (3, 3, 4):
        wire = open_wire(seed=seed)
        _drive(wire)
        request = CaptureRequest(("stimulus", "i_a"), rows=700, pretrigger_rows=20)
        block = play(wire.session.drive, stimulus, request, motor=wire.session.profile.motor)
        assert block is not None
        columns.append(block.data)
    assert np.array_equal(columns[0], columns[1])
    assert np.array_equal(columns[0][:, 0], columns[2][:, 0])
    assert not np.array_equal(columns[0][:, 1], columns[2][:, 1])


# ---- what is refused -----------------------------------------------------------------------------------


def test_beyond_the_profiles_rating_nothing_is_sent_at_all(wire: Wire) -> None:
    drive = _drive(wire)
    wire.frames()
    too_much = Stimulus(quantity="torque", shape="constant", amplitude_Nm=9.0, offset_Nm=1.0, duration_s=1.0)
    with pytest.raises(ValueRefused, match=r"reaches 10 Nm, the profile's rated torque T_N is 9\.55 Nm"):
        play(drive, too_much, motor=wire.session.profile.motor)
    assert [frame for frame in wire.frames() if frame[0] == SDO_REQUEST] == []


@pytest.mark.parametrize(
    ("mode", "stimulus", "complaint"),
    [
        (Mode.TORQUE, {"quantity": "torque", "amplitude_Nm": 0.7}, r"torque_limit is 0\.6 Nm"),
        (
            Mode.VELOCITY,
            {"quantity": "speed", "amplitude_rad_s": 150.0},
            r"less the setpoint is 147\.1 rad/s",
        ),
        (Mode.VELOCITY, {"quantity": "d_current", "amplitude_A": 13.0}, r"i_trip is 12 A"),
        (Mode.VOLTAGE, {"quantity": "voltage", "amplitude_V": 75.0}, r"u_dc / sqrt\(3\) is 70\.\d+ V"),
        (Mode.VELOCITY, {"quantity": "torque", "amplitude_Nm": 0.1}, "plays in torque mode"),
    ],
)
def test_beyond_the_drives_limits_or_in_another_mode_nothing_is_written(
    wire: Wire, mode: Mode, stimulus: dict[str, object], complaint: str
) -> None:
    drive = _drive(wire, mode)
    drive.write("torque_limit", 0.6)
    drive.write("omega_m_command", 10.0)
    wire.frames()
    with pytest.raises(ValueRefused, match=complaint):
        play(
            drive,
            Stimulus.model_validate({"shape": "constant", "duration_s": 1.0, **stimulus}),
            motor=wire.session.profile.motor,
        )
    requests = [data[0] for can_id, data in wire.frames() if can_id == SDO_REQUEST]
    assert requests
    assert set(requests) == {0x40}, "uploads only"


@pytest.mark.parametrize(
    ("mode", "table", "code"),
    [
        (Mode.TORQUE, {"stimulus_amplitude": 9.0, "stimulus_offset": -1.0}, Abort.VALUE_HIGH),
        (Mode.VELOCITY, {"stimulus_quantity": "speed", "stimulus_amplitude": 215.0}, Abort.VALUE_HIGH),
        (Mode.VELOCITY, {"stimulus_quantity": "d_current", "stimulus_amplitude": 12.1}, Abort.VALUE_HIGH),
        (Mode.VOLTAGE, {"stimulus_quantity": "voltage", "stimulus_amplitude": -71.5}, Abort.VALUE_HIGH),
        (Mode.VELOCITY, {}, Abort.PARAMETER_INCOMPATIBLE),
        (Mode.TORQUE, {"stimulus_quantity": "voltage"}, Abort.PARAMETER_INCOMPATIBLE),
        (
            Mode.TORQUE,
            {"stimulus_shape": "prbs", "stimulus_prbs_length": 4, "stimulus_seed": 16},
            Abort.PARAMETER_INCOMPATIBLE,
        ),
        (
            Mode.TORQUE,
            {"stimulus_shape": "chirp_logarithmic", "stimulus_frequency_start": 0.0},
            Abort.PARAMETER_INCOMPATIBLE,
        ),
        (
            Mode.TORQUE,
            {"stimulus_shape": "staircase", "stimulus_ticks": 5, "stimulus_steps": 6},
            Abort.PARAMETER_INCOMPATIBLE,
        ),
    ],
)
def test_the_drive_itself_refuses(wire: Wire, mode: Mode, table: dict[str, Value], code: Abort) -> None:
    drive = _drive(wire, mode)
    drive.write("omega_m_command", 10.0)
    with pytest.raises(SdoAbort) as refused:
        _start(drive, **table)
    assert refused.value.code == code
    assert drive.read("stimulus_state") == "idle"


def test_without_the_power_stage_nothing_starts_and_nothing_starts_twice(wire: Wire) -> None:
    drive = wire.session.drive
    with pytest.raises(SdoAbort) as refused:
        _start(drive, **LONG)
    assert refused.value.code == Abort.DEVICE_STATE
    _start(_drive(wire))
    with pytest.raises(SdoAbort) as refused:
        _start(drive)
    assert refused.value.code == Abort.DEVICE_STATE


# ---- what ends it --------------------------------------------------------------------------------------


def _reference(wire: Wire) -> float:
    wire.session.clock.wait(T_S)
    return wire.session.drive.number("stimulus")


def test_it_stops_on_demand(wire: Wire) -> None:
    drive = _drive(wire)
    _start(drive, **LONG)
    assert _reference(wire) == 0.5
    drive.write("stimulus_control", "stop")
    assert drive.read("stimulus_state") == "idle"
    assert _reference(wire) == 0.0
    assert drive.state() is State.OPERATION_ENABLED


def test_it_does_not_outlive_the_power_stage_not_even_within_a_tick(wire: Wire) -> None:
    drive = _drive(wire)
    _start(drive, **LONG)
    drive.wait(0.01)
    drive.disable()
    drive.enable(Mode.TORQUE)
    assert drive.read("stimulus_state") == "idle"
    assert _reference(wire) == 0.0


@over_both_wires
@pytest.mark.parametrize("action", ["fault", "disable_voltage", "quick_stop"])
def test_a_lost_link_stops_it(wire: Wire, action: str) -> None:
    drive = wire.session.drive
    drive.write("abort_connection_option", action)
    _drive(wire)
    _start(drive, **{**LONG, "stimulus_amplitude": 0.05})
    wire.session.clock.wait(0.1)
    drive.stop_heartbeat()
    wire.session.clock.wait(0.6)
    assert drive.read("stimulus_state") == "idle"
    assert _reference(wire) == 0.0


def test_quick_stop_and_another_mode_stop_it(wire: Wire) -> None:
    drive = _drive(wire)
    _start(drive, **LONG)
    drive.write("mode_of_operation", int(Mode.VELOCITY))
    assert drive.read("stimulus_state") == "idle"
    drive.write("mode_of_operation", int(Mode.TORQUE))
    _start(drive)
    wire.send(SDO_REQUEST, 0x2B, 0x40, 0x60, 0x00, 0x02, 0x00, 0, 0)
    assert drive.read("stimulus_state") == "idle"


@pytest.mark.parametrize("mode", [Mode.VELOCITY, Mode.TORQUE])
def test_none_starts_while_a_quick_stop_brakes(wire: Wire, mode: Mode) -> None:
    drive = _drive(wire, Mode.VELOCITY)
    drive.write("omega_m_command", 60.0)
    drive.wait(0.3)
    drive.write("mode_of_operation", int(mode))
    wire.send(SDO_REQUEST, 0x2B, 0x40, 0x60, 0x00, 0x02, 0x00, 0, 0)
    assert drive.state() is State.QUICK_STOP_ACTIVE
    drive.write("stimulus_quantity", "speed" if mode is Mode.VELOCITY else "torque")
    with pytest.raises(SdoAbort) as refused:
        _start(drive, stimulus_amplitude=0.1, stimulus_ticks=100)
    assert refused.value.code == Abort.DEVICE_STATE
    assert drive.read("stimulus_state") == "idle"
    assert drive.state() is State.QUICK_STOP_ACTIVE


def test_an_overcurrent_trips_in_voltage_mode_as_well(wire: Wire) -> None:
    drive = _drive(wire, Mode.VOLTAGE)
    stimulus = Stimulus(quantity="voltage", shape="constant", amplitude_V=30.0, duration_s=1.0)
    with pytest.raises(DriveFault, match="0x2310"):
        play(drive, stimulus, motor=wire.session.profile.motor)
    assert drive.state() is State.FAULT
    assert drive.read("stimulus_state") == "idle"


def test_who_plays_without_a_capture_waits_for_every_repetition(wire: Wire) -> None:
    drive = _drive(wire)
    began_s = wire.session.clock.now_s()
    stimulus = Stimulus(quantity="torque", shape="ramp", amplitude_Nm=0.05, duration_s=0.7, repetitions=3)
    assert play(drive, stimulus, motor=wire.session.profile.motor) is None
    assert drive.read("stimulus_state") == "done"
    assert wire.session.clock.now_s() - began_s == pytest.approx(2.1, abs=0.1)


def test_who_plays_learns_that_another_master_stopped_it(wire: Wire) -> None:
    drive = _drive(wire)
    control = drive.dictionary["stimulus_control"]
    stop = bytes([0x2F, control.index & 0xFF, control.index >> 8, control.sub, 0, 0, 0, 0])
    calls: list[int] = []

    def meddle() -> None:
        calls.append(len(calls))
        if len(calls) == 2:
            wire.bus.send(can.Message(arbitration_id=SDO_REQUEST, data=stop, is_extended_id=False))

    timer = wire.session.clock.call_every(0.2, meddle)
    stimulus = Stimulus(quantity="torque", shape="ramp", amplitude_Nm=0.1, duration_s=0.5)
    with pytest.raises(StimulusError, match="is 'idle', 'done' was expected"):
        play(drive, stimulus, motor=wire.session.profile.motor)
    timer.cancel()


def test_an_interruption_stops_it(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = _drive(wire)

    def interrupted(self: Capture) -> None:
        drive.wait(0.001)
        raise KeyboardInterrupt

    monkeypatch.setattr(Capture, "wait", interrupted)
    with pytest.raises(KeyboardInterrupt):
        play(drive, STEP, CaptureRequest(("i_a",), rows=10), motor=wire.session.profile.motor)
    assert drive.read("stimulus_state") == "idle"
