"""The example on a PC behind a serial CAN adapter, as one more link: the tests are those of its serial line.

Left out are those of what a serial line alone has: confirmations, sequence numbers, sixteen signals at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchtool.bench.session import Session
from benchtool.cli import app
from benchtool.drive import Capture, CaptureRequest
from benchtool.protocol.modes import Mode
from benchtool.recording import Bundle
from benchtool.telemetry import TelemetryStream
from tests.device.c_drive import lasting, make
from tests.device.test_posix_drive import (
    _until,
    test_a_capture_with_pretrigger_shows_the_setpoint_step,
    test_a_jog_turns_the_shaft,
    test_a_plan_runs_to_its_measurements,
    test_info_tells_the_identity_and_the_dictionary,
    test_parameters_are_listed_written_and_restored,
    test_parameters_survive_a_reset_when_stored_and_only_then,
    test_silence_stops_the_motor_and_is_latched,
    test_the_walk_to_enabled_and_back,
)
from tests.emulated.test_telemetry import Kept

__all__ = [
    "test_a_capture_with_pretrigger_shows_the_setpoint_step",
    "test_a_jog_turns_the_shaft",
    "test_a_plan_runs_to_its_measurements",
    "test_info_tells_the_identity_and_the_dictionary",
    "test_parameters_are_listed_written_and_restored",
    "test_parameters_survive_a_reset_when_stored_and_only_then",
    "test_silence_stops_the_motor_and_is_latched",
    "test_the_walk_to_enabled_and_back",
]

SIGNALS = (
    *("tick", "i_a", "i_b", "i_c", "i_d", "i_q", "torque", "torque_reference"),
    *("psi_s", "omega_m", "theta_m"),
)


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The link of a drive that lives as long as the module: one drive, one host after the other."""
    folder = tmp_path_factory.mktemp("can")
    make(folder, "drive-canopen")
    with lasting(folder / "posix_can_drive") as link:
        yield link


def test_process_data_of_every_tick_are_the_rows_of_a_capture(session: Session) -> None:
    drive = session.drive
    drive.connect()
    kept = Kept()
    with drive.enabled(Mode.VELOCITY):
        drive.write("omega_m_command", 10.0)
        with TelemetryStream(drive, [kept.sink], SIGNALS, 1000.0) as stream:
            capture = Capture(drive, CaptureRequest(SIGNALS, rows=300))
            _until(session, lambda: drive.read("capture_state") == "complete")
            _until(session, lambda: len(kept.data) >= 1000)
            stream.check()
        captured = capture.read()
    report = stream.report()
    assert report.expected == report.counters.received == len(kept.data)
    assert (report.gaps, report.drive_dropped) == ((), 0)
    first = int(captured.data[0, 0]) - kept.ticks[0]
    np.testing.assert_array_equal(kept.data[first : first + 300], captured.data)


def test_a_capture_of_many_blocks_comes_whole(session: Session) -> None:
    drive = session.drive
    capture = Capture(drive, CaptureRequest(SIGNALS, rows=1500))
    _until(session, lambda: drive.read("capture_state") == "complete")
    block = capture.read()
    assert block.column("tick").tolist() == block.ticks().tolist()
    assert len(block.data) == 1500


def test_a_recording_is_left_behind(url: str, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    result = CliRunner().invoke(
        app, ("record", "--link", url, "--duration", "1", "--rate", "200", "--out", str(folder))
    )
    assert result.exit_code == 0, result.output
    assert len(Bundle.open(folder).block("telemetry").data) >= 199
