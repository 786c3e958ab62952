"""The emulated drive in its own time behind a device file, as with a real adapter: plugged in, pulled out."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.bench.session import open_session
from benchtool.cli import app
from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.ports.pty import HungUp, PtyPort
from benchtool.errors import LinkClosed, LinkError
from benchtool.profile import load_profile
from benchtool.protocol.modes import Mode
from benchtool.recording import Bundle


class Plugged(PtyPort):
    """A terminal that stays whether a host has it open or not."""

    def read(self) -> bytes:
        try:
            return super().read()
        except HungUp:
            return b""

    def write(self, data: bytes) -> None:
        with suppress(HungUp):
            super().write(data)


class Adapter:
    """A powered drive, and an adapter with a device file of one name whenever it is plugged in."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "ttyBENCH"
        self._bench = EmulatedBench(load_profile("zhu2011"), paced=True, step_s=0.002, has_bus=False)
        self._port: Plugged | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._live)
        self._thread.start()

    @property
    def url(self) -> str:
        return f"serial:{self.path}"

    def plug(self) -> None:
        self._port = Plugged()
        self._bench.add_serial(self._port)
        self.path.symlink_to(self._port.path)

    def pull(self) -> None:
        if self._port is not None:
            self.path.unlink()
            self._port.close()
            self._port = None

    def close(self) -> None:
        self.pull()
        self._stop.set()
        self._thread.join()
        self._bench.close()

    def _live(self) -> None:
        while not self._stop.is_set():
            self._bench.clock.wait(0.01)


@pytest.fixture
def adapter(tmp_path: Path) -> Iterator[Adapter]:
    opened = Adapter(tmp_path)
    opened.plug()
    yield opened
    opened.close()


def test_a_recording_accounts_for_every_record(adapter: Adapter, tmp_path: Path) -> None:
    options = ("record", "--duration", "0.5", "--rate", "1000", "--link", adapter.url, "--json")
    result = CliRunner().invoke(app, (*options, "--out", str(tmp_path / "a")))
    assert result.exit_code == 0, result.output
    measured = {
        name: each["value"] for name, each in json.loads(result.stdout)["certificate"]["measurements"].items()
    }
    assert measured["telemetry_rows_received"] > 0
    assert measured["telemetry_rows_missing"] == measured["telemetry_records_dropped"]
    assert measured["link_frames_dropped"] == measured["link_stale_answers"] == 0
    assert len(Bundle.open(tmp_path / "a").block("telemetry").data) == measured["telemetry_rows_received"]


def test_an_adapter_that_vanishes_and_returns(adapter: Adapter) -> None:
    with open_session("zhu2011", adapter.url) as session:
        drive = session.drive
        drive.connect()
        drive.enable(Mode.VELOCITY)
        drive.write("omega_m_command", 10.0)
        adapter.pull()
        with pytest.raises(LinkClosed, match="serial port of node 1 stopped working"):
            drive.wait(5.0)
        with pytest.raises(LinkError, match=f"cannot open {adapter.path}: .*check that the adapter"):
            drive.reconnect(0.7)
        adapter.plug()
        back = drive.reconnect(5.0)
        assert back.restarted is False
        assert not drive.state().power_stage_on
        assert drive.number("link_losses") == 1, "the drive's own supervision stopped the motor meanwhile"
        drive.reset_fault()
        with drive.enabled(Mode.VELOCITY):
            assert drive.read("link_state") == "alive"
