"""Viewers as processes: on loopback only, without reports of usage; and when one is stuck or gone."""

from __future__ import annotations

import http.client
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from benchtool.block import Block, Channel
from benchtool.errors import EnvironmentFailure, UsageError
from benchtool.live import LiveView, Setup, Viewer, names
from benchtool.live.sinks import sink as sink_module, viewer as module
from benchtool.live.sinks.viewer import viewer_environment, viewer_program
from tests.unit.live.readback import Recording

linux = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
_PATIENCE_S = 0.2


def rows(number: int, count: int = 2000) -> Block:
    """Noise, which nothing compresses."""
    channels = tuple(Channel(f"signal_{k}", "A") for k in range(16))
    random = np.random.default_rng(number)
    return Block(channels, number * count, 1, 1e-4, random.standard_normal((count, 16)))


@pytest.fixture
def web() -> Iterator[Viewer]:
    with Viewer(web=True) as viewer:
        yield viewer
    assert viewer.process.returncode is not None


def _listening(inodes: set[str]) -> dict[str, set[str]]:
    """Addresses of the sockets that listen, in hexadecimal, by file of /proc."""
    found: dict[str, set[str]] = {}
    for name in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{name}").read_text(encoding="ascii").splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A" and fields[9] in inodes:
                found.setdefault(name, set()).add(fields[1])
    return found


def _sockets(process: int) -> set[str]:
    inodes = set()
    for path in Path(f"/proc/{process}/fd").iterdir():
        try:
            target = str(path.readlink())
        except OSError:
            continue
        if target.startswith("socket:["):
            inodes.add(target[8:-1])
    return inodes


@linux
def test_servers_listen_on_loopback_only(web: Viewer) -> None:
    listening = _listening(_sockets(web.process.pid))
    assert set(listening) == {"tcp"}
    assert len(listening["tcp"]) == 2
    assert {address.partition(":")[0] for address in listening["tcp"]} == {"0100007F"}
    assert f"0100007F:{web.port:04X}" in listening["tcp"]
    with socket.create_connection(("127.0.0.1", web.port), 5.0):
        pass
    with pytest.raises(ConnectionRefusedError), socket.create_connection(("127.0.0.2", web.port), 5.0):
        pass


@linux
def test_a_viewer_is_told_to_report_nothing(web: Viewer) -> None:
    environment = Path(f"/proc/{web.process.pid}/environ").read_bytes().split(b"\0")
    assert b"CI=true" in environment
    assert viewer_environment()["CI"] == "true"


def test_no_usage_data_are_collected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rerun notes them in files before it sends them: there must be none."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    with Viewer(web=True):
        pass
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_the_page_may_connect_to_its_viewer_only(web: Viewer) -> None:
    assert web.page.startswith("http://127.0.0.1:")
    assert f"url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{web.port}%2Fproxy" in web.page
    place = web.page.split("/")[2]
    connection = http.client.HTTPConnection(place, timeout=10.0)
    try:
        connection.request("GET", "/re_viewer.js")
        answer = connection.getresponse()
        policy = answer.getheader("Content-Security-Policy") or ""
        assert b"wasm" in answer.read()
    finally:
        connection.close()
    directives = dict(part.strip().split(" ", 1) for part in policy.split(";"))
    assert directives["connect-src"].split() == ["'self'", f"http://127.0.0.1:{web.port}", "data:", "blob:"]
    assert "http" not in directives["default-src"]


def test_a_port_in_use_is_named() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(
            EnvironmentFailure, match=f"cannot serve the live view at 127.0.0.1:{port}: .*in use"
        ):
            Viewer(web=True, web_port=port)
        with pytest.raises(
            EnvironmentFailure, match=f"did not start its gRPC server on port {port}: .*in use"
        ):
            Viewer(web=True, port=port)


def test_without_a_display_another_way_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(EnvironmentFailure, match=r"needs a display .*: serve the view to a browser"):
        Viewer(web=False)


def test_a_wheel_without_the_viewer_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def lost(name: str) -> object:
        spec = find_spec("json")
        assert spec is not None
        spec.origin = str(tmp_path / "__init__.py")
        return spec

    monkeypatch.setattr(module, "find_spec", lost)
    with pytest.raises(EnvironmentFailure, match=r"the Rerun viewer is missing: .* install rerun-sdk again"):
        Viewer(web=True)
    monkeypatch.setattr(module, "find_spec", lambda _: None)
    with pytest.raises(EnvironmentFailure, match="the Rerun viewer is missing"):
        Viewer(web=True)


def test_only_addresses_can_be_listened_on() -> None:
    with pytest.raises(UsageError, match="'everywhere' is no address to listen on"):
        Viewer(web=True, bind="everywhere")


def _held(viewer: Viewer, path: Path) -> Recording:
    """What a viewer was sent and would show."""
    saving = subprocess.Popen(
        [viewer_program(), "--bind", "127.0.0.1", "--port", "auto", "--save", path, "--connect",
         f"rerun+http://127.0.0.1:{viewer.port}/proxy"],
        env=viewer_environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        sizes = [0]

        def settled() -> bool:
            sizes.append(path.stat().st_size if path.exists() else 0)
            return sizes[-1] > 1000 and len(set(sizes[-50:])) == 1

        _until(settled)
    finally:
        saving.terminate()
        saving.wait(10.0)
    return Recording.read(path)


def _until(happened: Callable[[], bool]) -> None:
    deadline_s = time.monotonic() + 20.0
    while not happened():
        assert time.monotonic() < deadline_s, "it did not happen within 20 s"
        threading.Event().wait(0.01)


def test_a_viewer_that_was_killed_takes_nothing_and_holds_nothing_up(web: Viewer) -> None:
    noted: list[str] = []
    with LiveView(Setup("test", psi_Wb=0.1), [web], noted.append, patience_s=_PATIENCE_S) as view:
        view.add_block(rows(0))
        assert view.rows_dropped == {"the web viewer": 0}
        web.process.kill()
        web.process.wait()
        for number in range(1, 6):
            view.add_block(rows(number))
        assert view.rows_dropped["the web viewer"] >= 10_000
    assert len(noted) == 1
    assert noted[0].startswith("the web viewer is gone, the measurement goes on without it; ")


def test_a_viewer_that_is_ending_is_not_taken_for_one_that_is_back(
    web: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its process still seems to run, and its port to listen, for a while after the connection is lost."""
    noted: list[str] = []
    with LiveView(Setup("test", psi_Wb=0.1), [web], noted.append, patience_s=20.0) as view:
        view.add_block(rows(0))
        with socket.create_server((web.host, 0)) as listening:  # takes connections, and nothing else
            monkeypatch.setattr(web, "port", listening.getsockname()[1])
            monkeypatch.setattr(web.process, "poll", lambda: None)
            web.process.kill()
            web.process.wait()

            def gone() -> bool:
                view.add_block(rows(1))
                return bool(noted)

            _until(gone)
            for number in range(2, 5):
                view.add_block(rows(number))
        monkeypatch.undo()
    assert len(noted) == 1
    assert noted[0].startswith("the web viewer is gone")


def test_a_connection_that_is_cut_before_it_is_made_holds_up_no_end(
    web: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A viewer seems to be back, and is known to be gone before the SDK has connected."""
    connect = rr.RecordingStream.connect_grpc
    monkeypatch.setattr(sink_module, "_RELEASE_TIMEOUT_S", 4.0)

    def connect_late(stream: rr.RecordingStream, url: str) -> None:
        web.give_up()
        connect(stream, url)

    with LiveView(Setup("test", psi_Wb=0.1), [web], patience_s=_PATIENCE_S) as view:
        view.add_block(rows(0))
        monkeypatch.setattr(rr.RecordingStream, "connect_grpc", connect_late)
        monkeypatch.setattr(Viewer, "_answers", lambda _: True)
        web.process.kill()
        web.process.wait()
        for number in range(1, 4):
            view.add_block(rows(number))
    assert not view.sinks[0]._thread.is_alive()


@pytest.mark.skipif(sys.platform == "win32", reason="stops a process by a signal")
def test_a_stuck_viewer_costs_its_patience_once_and_may_come_back(web: Viewer) -> None:
    noted: list[str] = []
    with LiveView(Setup("test", psi_Wb=0.1), [web], noted.append, patience_s=_PATIENCE_S) as view:
        view.add_block(rows(0))
        web.process.send_signal(signal.SIGSTOP)
        try:
            for number in range(1, 400):
                view.add_block(rows(number))
                if view.rows_dropped["the web viewer"] >= 200_000:
                    break
            assert view.rows_dropped["the web viewer"] >= 200_000
            assert len(noted) == 1
            assert noted[0].startswith("the web viewer took nothing for 0.2 s")
        finally:
            web.process.send_signal(signal.SIGCONT)

        def back() -> bool:
            view.add_block(rows(500))
            return len(noted) > 1

        _until(back)
        assert noted[1].startswith("the web viewer is back; ")
        dropped = view.rows_dropped["the web viewer"]
        view.add_block(rows(501))
        assert view.rows_dropped["the web viewer"] == dropped


@pytest.mark.skipif(sys.platform == "win32", reason="stops a process by a signal")
def test_a_viewer_that_is_stuck_at_the_end_is_left_to_itself(
    web: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_CLOSING_S", 0.5)
    monkeypatch.setattr(module, "_ENDING_S", 0.3)
    noted: list[str] = []
    view = LiveView(Setup("test", psi_Wb=0.1), [web], noted.append, patience_s=_PATIENCE_S)
    view.add_block(rows(0))
    web.process.send_signal(signal.SIGSTOP)
    number = 1
    while not view.rows_dropped["the web viewer"]:
        view.add_block(rows(number))
        number += 1
    view.close()
    assert web.process.poll() is None
    assert len(noted) == 1  # that it is stuck, and nothing of its end


@pytest.mark.skipif(sys.platform == "win32", reason="stops a process by a signal")
def test_a_viewer_that_is_stuck_with_little_on_its_way_holds_up_no_end(
    web: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What fits the buffers on the way is flushed; it is the end of the recording that is waited for."""
    monkeypatch.setattr(module, "_CLOSING_S", 0.5)
    monkeypatch.setattr(module, "_ENDING_S", 0.3)
    view = LiveView(Setup("test", psi_Wb=0.1), [web], patience_s=_PATIENCE_S)
    view.add_block(rows(0, 20))
    _until(view.sinks[0]._batches.empty)
    web.process.send_signal(signal.SIGSTOP)
    view.add_block(rows(1, 20))
    view.close()
    assert not view.sinks[0]._thread.is_alive()


def test_other_addresses_are_served_as_well() -> None:
    with Viewer(web=True, bind="::1") as viewer:
        assert viewer.page.startswith("http://[::1]:")
        with LiveView(Setup("test", psi_Wb=0.1), [viewer]) as view:
            view.add_block(rows(0))
        assert view.rows_dropped == {"the web viewer": 0}
        port = int(viewer.page.split("]:")[1].split("/")[0])
        connection = http.client.HTTPConnection("::1", port, timeout=10.0)
        try:
            connection.request("GET", "/re_viewer.js")
            answer = connection.getresponse()
            policy = answer.getheader("Content-Security-Policy") or ""
            answer.read()
        finally:
            connection.close()
    assert f"http://[::1]:{viewer.port}" in policy


def test_the_page_is_gone_with_the_viewer() -> None:
    with Viewer(web=True) as viewer:
        place = viewer.page.split("/")[2].split(":")
    with pytest.raises(ConnectionRefusedError), socket.create_connection((place[0], int(place[1])), 5.0):
        pass
    assert isinstance(viewer.process, subprocess.Popen)
    assert viewer.process.returncode is not None


def test_another_viewer_in_the_place_of_a_killed_one_gets_the_rest(web: Viewer, tmp_path: Path) -> None:
    noted: list[str] = []
    with LiveView(Setup("test", psi_Wb=0.1), [web], noted.append, patience_s=20.0) as view:
        view.add_block(rows(0))
        web.process.kill()
        web.process.wait()
        view.add_block(rows(1))
        with Viewer(web=True, port=web.port) as another:
            number = 2

            def back() -> bool:
                nonlocal number
                view.add_block(rows(number))
                number += 1
                return "is back" in noted[-1]

            _until(back)
            dropped = view.rows_dropped["the web viewer"]
            view.add_block(rows(number))
            view.close()
            assert view.rows_dropped["the web viewer"] == dropped
            recording = _held(another, tmp_path / "held.rrd")
    assert noted == [
        f"the web viewer is gone, the measurement goes on without it; 'rerun --bind 127.0.0.1 --port "
        f"{web.port}' shows the rest",
        f"the web viewer is back; {dropped} rows were not shown",
    ]
    assert recording.series("/stream/current") == [f"signal_{k} (A)" for k in range(16)]
    assert recording.still[names.RESULTS]
    ticks = recording.ticks("/stream/current")
    assert ticks[-1] == (number + 1) * 2000 - 1
    assert ticks[0] >= 4000
