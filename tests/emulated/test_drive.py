"""The host's view of the drive: values in SI, verified writes, captures, and their failures."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.drive import Capture, CaptureRequest
from benchtool.drive.parameters.transaction import snapshot, temporary
from benchtool.errors import CaptureError, DriveFault, SdoAbort, ValueRefused, WriteNotVerified
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.modes import Mode

from .conftest import Opener, Wire, over_both_wires

NODE = 1


@over_both_wires
def test_values_are_in_si_and_enumerations_are_names(wire: Wire) -> None:
    drive = wire.session.drive
    assert drive.read("psi_r") == 0.1685
    assert drive.read("producer_heartbeat") == 0.1
    assert drive.read("law") == "tpc"
    assert drive.read("device_name") == "benchtool reference drive"
    drive.write("R_s", 0.246)
    assert drive.read("R_s") == 0.246


def test_a_value_outside_its_limits_is_never_sent(wire: Wire) -> None:
    wire.frames()
    with pytest.raises(ValueRefused, match=r"R_s.*100"):
        wire.session.drive.write("R_s", 1e6)
    assert [frame for frame in wire.frames() if frame[0] == 0x600 + NODE] == []


@over_both_wires
def test_what_the_drive_refuses_is_named(wire: Wire) -> None:
    with pytest.raises(SdoAbort, match=r"writing 0 to 'statusword'.*0x06010002") as refused:
        wire.session.drive.write("statusword", 0)
    assert refused.value.code == Abort.READ_ONLY


@over_both_wires
def test_a_write_that_does_not_hold_is_noticed(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = wire.session.drive
    download = drive.link.download

    def meddled(index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        download(index, sub, data, block=block)
        download(index, sub, drive.dictionary["R_s"].encode(0.5), block=block)

    monkeypatch.setattr(drive.link, "download", meddled)
    with pytest.raises(WriteNotVerified, match=r"'R_s' reads back 0\.5 after 0\.2 was written"):
        drive.write("R_s", 0.2)


def test_temporary_values_are_restored_also_after_a_failure(wire: Wire) -> None:
    drive = wire.session.drive
    before = snapshot(drive)
    with pytest.raises(RuntimeError), temporary(drive, {"R_s_ohm": 0.5, "u_s_V": 10.0}):
        assert snapshot(drive) == {**before, "R_s_ohm": 0.5, "u_s_V": 10.0}
        raise RuntimeError
    assert snapshot(drive) == before


def test_one_wrong_key_and_nothing_is_written(wire: Wire) -> None:
    drive = wire.session.drive
    before = snapshot(drive)
    with pytest.raises(ValueRefused), temporary(drive, {"R_s_ohm": 0.5, "u_s": 10.0}):
        pytest.fail("entered")
    assert snapshot(drive) == before


@over_both_wires
def test_parameters_survive_a_reset_when_stored_and_only_then(wire: Wire) -> None:
    drive = wire.session.drive
    drive.write("R_s", 0.5)
    wire.send(0x000, 0x81, NODE)
    assert drive.read("R_s") == 0.123
    drive.write("R_s", 0.5)
    store = drive.dictionary["store_all"]
    drive.link.download(store.index, store.sub, b"save")
    drive.write("R_s", 0.7)
    wire.send(0x000, 0x81, NODE)
    assert drive.read("R_s") == 0.5


def test_setpoints_of_cia_402_and_of_si_are_the_same_variables(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.enable(Mode.TORQUE)
    drive.write("target_torque", 0.1)
    assert drive.number("torque_command") == pytest.approx(0.955)
    drive.write("target_velocity", 12.5)
    assert drive.number("omega_m_command") == 12.5


@over_both_wires
def test_a_capture_with_pretrigger_shows_the_setpoint_step(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.enable(Mode.TORQUE)
    request = CaptureRequest(
        ("tick", "torque", "torque_reference"), rows=100, pretrigger_rows=40, trigger="setpoint"
    )
    capture = Capture(drive, request)
    drive.wait(0.02)
    drive.write("torque_command", 0.5)
    capture.wait()
    block = capture.read()
    reference = block.column("torque_reference")
    assert np.all(reference[:40] == 0.0)
    assert np.all(reference[40:] == 0.5)
    assert block.ticks().tolist() == block.column("tick").tolist()


def test_a_stride_thins_the_rows(wire: Wire) -> None:
    capture = Capture(wire.session.drive, CaptureRequest(("tick",), rows=20, stride=7))
    capture.wait()
    block = capture.read()
    assert np.all(np.diff(block.column("tick")) == 7)
    assert block.sample_rate_Hz == pytest.approx(10_000 / 7)


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        (CaptureRequest(("R_s",), rows=10), Abort.NOT_MAPPABLE),
        (CaptureRequest(("i_a",) * 16, rows=100_000), Abort.PARAMETER_INCOMPATIBLE),
        (CaptureRequest(("i_a",), rows=10, pretrigger_rows=10), Abort.PARAMETER_INCOMPATIBLE),
    ],
)
def test_captures_that_the_drive_refuses(wire: Wire, request_: CaptureRequest, code: Abort) -> None:
    with pytest.raises(SdoAbort) as refused:
        Capture(wire.session.drive, request_)
    assert refused.value.code == code


@over_both_wires
def test_a_capture_that_is_reset_half_way_is_an_error(wire: Wire) -> None:
    drive = wire.session.drive
    capture = Capture(drive, CaptureRequest(("i_a",), rows=1000))
    wire.session.clock.wait(0.05)
    wire.send(0x000, 0x81, NODE)
    with pytest.raises(CaptureError, match="the capture is 'aborted' after 500 rows"):
        capture.wait()
    with pytest.raises(SdoAbort) as refused:
        capture.read()
    assert refused.value.code == Abort.DEVICE_STATE


def test_a_trigger_that_never_comes_is_an_error(wire: Wire) -> None:
    capture = Capture(wire.session.drive, CaptureRequest(("i_a",), rows=10, trigger="setpoint"))
    with pytest.raises(CaptureError, match="still 'armed'"):
        capture.wait()


@over_both_wires
def test_a_fault_during_a_capture_is_a_fault_and_the_rows_are_there(wire: Wire) -> None:
    drive = wire.session.drive
    drive.connect()
    drive.enable(Mode.TORQUE)
    capture = Capture(
        drive, CaptureRequest(("torque", "i_a"), rows=200, pretrigger_rows=100, trigger="fault")
    )
    drive.wait(0.05)
    drive.write("i_trip", 0.3)
    drive.write("torque_command", 5.0)
    with pytest.raises(DriveFault, match="0x2310"):
        capture.wait()
    wire.session.clock.wait(0.05)
    assert len(capture.read().data) == 200


def test_another_captures_data_are_refused(wire: Wire) -> None:
    drive = wire.session.drive
    first = Capture(drive, CaptureRequest(("i_a",), rows=10))
    first.wait()
    second = Capture(drive, CaptureRequest(("i_a",), rows=10))
    second.wait()
    with pytest.raises(CaptureError, match="capture 2, capture 1 was armed"):
        first.read()


def test_true_and_estimated_parameters_are_separate(open_wire: Opener) -> None:
    """The drive believes half the flux: its estimate is then half of what the shaft feels."""
    session = open_wire().session
    drive = session.drive
    assert session.transducer is not None
    drive.connect()
    with temporary(drive, {"psi_r_Wb": 0.1685 / 2.0}), drive.enabled(Mode.TORQUE):
        drive.write("torque_command", 0.3)
        drive.wait(0.05)
        capture = Capture(drive, CaptureRequest(("torque",), rows=200))
        session.transducer.start(0.02)
        capture.wait()
        estimate = capture.read().column("torque").mean()
        shaft = session.transducer.block().column("torque_transducer").mean()
    assert shaft == pytest.approx(2.0 * estimate, rel=0.05)
