"""The example on a PC as one more link: a process of its own, in real time, on a terminal or a port."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchtool.bench.session import Session, open_session
from benchtool.cli import app
from benchtool.drive import Capture, CaptureRequest
from benchtool.drive.parameters.transaction import snapshot, temporary
from benchtool.errors import DriveFault, SdoAbort, WriteNotVerified
from benchtool.link.serial.link import SerialLink
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.canopen.nmt import NmtCommand, NmtState
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode
from benchtool.recording import Bundle
from benchtool.run.jog import jog
from benchtool.run.runner import run_plan
from benchtool.telemetry import TelemetryStream
from tests.device.c_drive import lasting
from tests.emulated.test_runs import CHANNELS, INFO, RunObserver, _plan
from tests.emulated.test_telemetry import Kept

RATE_Hz = 1000.0
SIXTEEN = (
    *("tick", "i_a", "i_b", "i_c", "i_d", "i_q", "torque", "torque_reference"),
    *("psi_s", "omega_m", "theta_m", "u_dc", "switching_count", "law_clipped", "adc_saturated", "psi_alpha"),
)
PATIENCE_S = 20.0


@pytest.fixture(params=[(), ("--tcp", "0")], ids=["pty", "tcp"], scope="module")
def url(build: Path, request: pytest.FixtureRequest) -> Iterator[str]:
    """The link of a drive that lives as long as the module: one drive, one host after the other."""
    with lasting(build / "posix_drive", *request.param) as link:
        yield link


def _until(session: Session, holds: Callable[[], bool]) -> None:
    """Wait for a condition, however busy the machine is."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < deadline_s, "it did not come"
        session.clock.wait(0.01)


def test_info_tells_the_identity_and_the_dictionary(url: str) -> None:
    with open_session("zhu2011", url) as before:
        before.drive.link.nmt(NmtCommand.RESET_NODE)
    result = CliRunner().invoke(app, ("info", "--link", url, "--json"))
    assert result.exit_code == 0, result.output
    facts = json.loads(result.stdout)
    assert (facts["vendor_id"], facts["product_code"], facts["serial_number"]) == (0xB7C, 0x2011, 1)
    assert facts["hardware_version"] == "posix"
    assert facts["state"] == "switch on disabled"


def test_parameters_are_listed_written_and_restored(session: Session) -> None:
    drive = session.drive
    before = snapshot(drive)
    assert len(before) > 30
    with temporary(drive, {"R_s_ohm": 0.5, "u_s_V": 10.0}):
        assert snapshot(drive) == {**before, "R_s_ohm": 0.5, "u_s_V": 10.0}
    assert snapshot(drive) == before
    with pytest.raises(SdoAbort) as refused:
        drive.write("statusword", 0)
    assert refused.value.code == Abort.READ_ONLY


def test_parameters_survive_a_reset_when_stored_and_only_then(session: Session) -> None:
    drive = session.drive
    default = drive.number("R_s")
    drive.write("R_s", 0.5)
    drive.link.nmt(NmtCommand.RESET_NODE)
    assert drive.number("R_s") == default
    drive.write("R_s", 0.5)
    store, restore = drive.dictionary["store_all"], drive.dictionary["restore_all"]
    drive.link.download(store.index, store.sub, b"save")
    drive.write("R_s", 0.7)
    drive.link.nmt(NmtCommand.RESET_NODE)
    assert drive.number("R_s") == 0.5
    drive.link.download(restore.index, restore.sub, b"load")
    drive.link.nmt(NmtCommand.RESET_NODE)
    assert drive.number("R_s") == default


def test_the_walk_to_enabled_and_back(session: Session) -> None:
    drive = session.drive
    drive.connect()
    with drive.enabled(Mode.VELOCITY):
        assert drive.state() is State.OPERATION_ENABLED
        drive.write("omega_m_command", 10.0)
        _until(session, lambda: abs(drive.number("omega_m") - 10.0) < 0.5)
        with pytest.raises(SdoAbort) as refused:
            drive.write("pole_pairs", 3)
        assert refused.value.code == Abort.DEVICE_STATE
    assert drive.state() is State.SWITCH_ON_DISABLED
    assert drive.number("omega_m_command") == 0.0


def test_silence_stops_the_motor_and_is_latched(session: Session) -> None:
    drive = session.drive
    drive.connect()
    drive.enable(Mode.TORQUE)
    drive.write("torque_command", 0.01)
    drive.stop_heartbeat()
    with pytest.raises(DriveFault, match="0x8130"):
        drive.wait(PATIENCE_S)
    assert drive.state() is State.FAULT
    assert drive.read("link_state") == "lost"
    assert drive.number("torque") == 0.0
    drive.link.send_heartbeat()
    assert drive.read("link_state") == "lost"
    drive.reset_fault()
    drive.link.send_heartbeat()
    drive.enable(Mode.TORQUE)
    drive.disable()


def test_an_overcurrent_is_a_fault_with_its_event(session: Session) -> None:
    drive = session.drive
    link = drive.link
    assert isinstance(link, SerialLink)
    drive.write("i_trip", 0.5)
    drive.write("torque_limit", 10.0)
    drive.connect()
    with pytest.raises(DriveFault, match="0x2310"), drive.enabled(Mode.TORQUE):
        link.send_setpoint(5.0, 0.0)  # a write would be read back as 0: the trip is faster
        drive.wait(PATIENCE_S)
    assert drive.state() is State.FAULT
    drive.reset_fault()
    assert drive.number("error_1") == 0x2310
    assert drive.number("error_code") == 0


def test_sixteen_signals_at_the_control_rate_have_no_gap_and_are_those_of_a_capture(session: Session) -> None:
    drive = session.drive
    drive.connect()
    kept = Kept()
    with drive.enabled(Mode.VELOCITY):
        drive.write("omega_m_command", 10.0)
        with TelemetryStream(drive, [kept.sink], SIXTEEN, RATE_Hz) as stream:
            capture = Capture(drive, CaptureRequest(SIXTEEN, rows=500))
            _until(session, lambda: drive.read("capture_state") == "complete")
            _until(session, lambda: len(kept.data) >= 1500)
            stream.check()
        captured = capture.read()
    report = stream.report()
    assert report.expected == report.counters.received == len(kept.data)
    assert (report.gaps, report.drive_dropped) == ((), 0)
    assert np.diff(kept.ticks).tolist() == [1] * (len(kept.data) - 1)
    first = int(captured.data[0, 0]) - kept.ticks[0]
    np.testing.assert_array_equal(kept.data[first : first + 500], captured.data)


def test_a_capture_with_pretrigger_shows_the_setpoint_step(session: Session) -> None:
    drive = session.drive
    drive.connect()
    with drive.enabled(Mode.TORQUE):
        request = CaptureRequest(
            ("tick", "torque", "torque_reference"), rows=100, pretrigger_rows=40, trigger="setpoint"
        )
        capture = Capture(drive, request)
        _until(session, lambda: drive.number("capture_rows_done") == 40)
        drive.write("torque_command", 0.02)
        _until(session, lambda: drive.read("capture_state") == "complete")
        block = capture.read()
    reference = block.column("torque_reference")
    assert np.all(reference[:40] == 0.0)
    assert np.all(reference[40:] == pytest.approx(0.02))
    assert block.ticks().tolist() == block.column("tick").tolist()


def test_network_states_are_confirmed(session: Session) -> None:
    link = session.drive.link
    assert isinstance(link, SerialLink)
    for command, state in (
        (NmtCommand.START, NmtState.OPERATIONAL),
        (NmtCommand.STOP, NmtState.STOPPED),
        (NmtCommand.ENTER_PRE_OPERATIONAL, NmtState.PRE_OPERATIONAL),
    ):
        link.nmt(command)
        _until(session, lambda state=state: link.heartbeat_state() is state)  # type: ignore[misc]


def test_a_setpoint_that_comes_again_is_ignored(session: Session) -> None:
    drive = session.drive
    link = drive.link
    assert isinstance(link, SerialLink)
    link.nmt(NmtCommand.START)
    link.send_setpoint(0.01, 1.0)
    assert drive.number("torque_command") == pytest.approx(0.01)
    link._setpoint_sequence -= 1
    link.send_setpoint(0.02, 2.0)
    assert drive.number("torque_command") == pytest.approx(0.01)
    assert drive.number("rpdo_dropped") == 1


def test_a_jog_turns_the_shaft(session: Session) -> None:
    drive = session.drive
    drive.connect()
    jog(drive, session.profile.motor, Mode.VELOCITY, lambda _: 8.0, duration_s=0.5, rate_Hz=100.0)
    assert drive.state() is State.SWITCH_ON_DISABLED
    assert drive.number("rpdo_dropped") == 0
    assert drive.number("omega_m") > 1.0


def test_a_plan_runs_to_its_measurements(session: Session, tmp_path: Path) -> None:
    plan = _plan(
        operating_point={"omega_m_rad_s": 31.42, "load_torque_Nm": 0.0, "settle_s": 0.8},
        record={"duration_s": 0.5, "channels": CHANNELS},
    )
    with temporary(session.drive, session.profile.stated_parameters):
        result = run_plan(lambda *_: nullcontext(session), plan, tmp_path, INFO, RunObserver())
    (assessment,) = result.assessments
    block = Bundle.open(assessment.bundle).block("capture")
    assert len(block.data) == 500
    assert np.ptp(block.column("theta_m")) > 1.0, "the motor turned"


def test_a_write_that_another_undoes_is_noticed(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    drive = session.drive
    download = drive.link.download

    def meddled(index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        download(index, sub, data, block=block)
        download(index, sub, drive.dictionary["R_s"].encode(0.5), block=block)

    monkeypatch.setattr(drive.link, "download", meddled)
    with pytest.raises(WriteNotVerified):
        drive.write("R_s", 0.2)
