"""The emulated drive as a process: clients of every wire connect and disconnect, and a signal ends it."""

from __future__ import annotations

import io
import json
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import can
import pytest
from rich.console import Console
from typer.testing import CliRunner

from benchtool.bench.serving import Endpoint, ServedDrive, serve
from benchtool.bench.session import Session, open_session
from benchtool.cli import app
from benchtool.cli.emulate import _status
from benchtool.errors import LinkClosed, LinkError, StateError
from benchtool.protocol.canopen.nmt import NmtCommand
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode
from benchtool.recording import Bundle

PATIENCE_S = 30.0
SPEED = 0.4
WIRES = ("serial pty", "slcan pty", "serial tcp", "slcan tcp")


@dataclass(frozen=True)
class Child:
    """A running `benchtool emulate`, and the link of each wire."""

    process: subprocess.Popen[str]
    links: dict[str, str]
    folder: Path

    def end(self, number: signal.Signals) -> tuple[int, str, str]:
        """Exit code, and what it printed after its first line."""
        self.process.send_signal(number)
        out, err = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, out, err


@contextmanager
def started(folder: Path, *options: str) -> Iterator[Child]:
    command = (sys.executable, "-m", "benchtool", "emulate", "--json", *options)
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder)
    document = json.loads(_line(process.stdout))
    links = {
        f"{each['wire']} {'tcp' if 'socket:' in each['place'] else 'pty'}": each["link"]
        for each in document["wires"]
    }
    try:
        yield Child(process, links, folder)
    finally:
        if process.poll() is None:
            process.kill()
            process.communicate()


def _line(stream: IO[str] | None) -> str:
    assert stream is not None
    return stream.readline()


@pytest.fixture(scope="module")
def child(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Child]:
    folder = tmp_path_factory.mktemp("emulate")
    (folder / "serial").symlink_to("/dev/pts/left-behind")
    wires = ("--serial-at", "serial", "--slcan-at", "slcan", "--tcp", "0", "--slcan-tcp", "0")
    # Slowly, so that a busy machine's pauses are not taken for a host that has gone.
    with started(folder, *wires, "--load-torque", "0.65", "--speed", str(SPEED)) as running:
        yield running


@contextmanager
def observer(child: Child) -> Iterator[Session]:
    with open_session("zhu2011", child.links["serial tcp"]) as session:
        yield session


def until(session: Session, condition: Callable[[], bool]) -> None:
    """Wait for something to happen; how long it may take is no matter of this test."""
    deadline_s = session.clock.now_s() + PATIENCE_S
    while not condition():
        assert session.clock.now_s() < deadline_s, "it did not happen"
        session.clock.wait(0.01)


def invoke(*arguments: str) -> str:
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_every_wire_leads_to_the_drive(child: Child) -> None:
    assert set(child.links) == set(WIRES)
    for link in child.links.values():
        document = json.loads(invoke("info", "--link", link, "--json"))
        assert (document["device_name"], document["state"]) == (
            "benchtool reference drive",
            "switch on disabled",
        )
    assert f"socket://127.0.0.1:{_port(child)}" in child.links["serial tcp"]


def _port(child: Child) -> int:
    return int(child.links["serial tcp"].rpartition(":")[2].partition("?")[0])


def test_it_is_one_drive(child: Child) -> None:
    invoke("params", "set", "T_k_ratio=0.65", "--link", child.links["serial pty"])
    kept = [invoke("params", "get", "T_k_ratio", "--link", child.links[wire]) for wire in WIRES[1:]]
    invoke("params", "set", "T_k_ratio=0.7", "--link", child.links["slcan tcp"])
    assert all("0.65" in each for each in kept)


def test_a_plan_runs_on_it_and_leaves_it_to_the_next(child: Child, tmp_path: Path) -> None:
    link = child.links["slcan pty"]
    to = ("--out", str(tmp_path / "a"), "--yes", "--json")  # the load is put on where the drive is emulated
    output = invoke("run", "zhu2011/ripple", "--link", link, *to)
    (case,) = json.loads(output)["cases"].values()
    assert case["measurements"]["torque_mean"]["value"] == pytest.approx(0.65, abs=0.05)
    with observer(child) as session:
        session.clock.wait(0.6 / SPEED)  # longer than the supervision of the host that has left
        assert session.drive.state() is State.SWITCH_ON_DISABLED
        assert session.drive.read("link_state") == "off"
    for wire in ("serial pty", "slcan tcp", "serial tcp"):
        turning = invoke("jog", "--speed", "10", "--duration", "0.3", "--link", child.links[wire], "--json")
        assert json.loads(turning)["pacing"]["sent"] > 0


def test_a_jog_does_not_turn_the_drive_of_another_profile(child: Child) -> None:
    link = child.links["serial tcp"]
    held = json.loads(invoke("params", "get", "psi_r", "--link", link, "--json"))["psi_r"]["value"]
    invoke("params", "set", "psi_r=0.05", "--link", link)
    try:
        jog = ("jog", "--speed", "10", "--duration", "0.1", "--link", link, "--json")
        refused = CliRunner().invoke(app, jog)
        assert refused.exit_code == 3
        assert "psi_r_Wb = 0.05 (the profile states" in refused.stderr
        assert "--allow-different" in refused.stderr
        with observer(child) as session:
            assert session.drive.state() is State.SWITCH_ON_DISABLED
        assert json.loads(invoke(*jog, "--allow-different"))["pacing"]["sent"] > 0
    finally:
        invoke("params", "set", f"psi_r={held}", "--link", link)


def test_what_is_recorded_follows_the_wall_clock(child: Child, tmp_path: Path) -> None:
    options = ("--duration", "0.5", "--rate", "1000", "--out", str(tmp_path / "a"), "--json")
    output = invoke("record", "--link", child.links["slcan tcp"], *options)
    measured = json.loads(output)["certificate"]["measurements"]
    rows = measured["telemetry_rows_received"]["value"]
    assert rows == len(Bundle.open(tmp_path / "a").block("telemetry").data)
    assert rows >= 100, "half a second are 200 records at this speed; a busy machine may fall behind"


@pytest.mark.parametrize("wire", WIRES)
def test_clients_come_and_go(child: Child, wire: str) -> None:
    for _ in range(5):
        with open_session("zhu2011", child.links[wire]) as session:
            assert session.drive.read("device_name") == "benchtool reference drive"


def test_a_second_client_is_turned_away(child: Child) -> None:
    for wire in ("serial pty", "serial tcp"):
        with (
            open_session("zhu2011", child.links[wire]) as first,
            pytest.raises(LinkError, match=r"another program has it open|closed the connection"),
            ExitStack() as stack,
        ):
            first.drive.identify()
            stack.enter_context(open_session("zhu2011", child.links[wire])).drive.identify()


@pytest.mark.parametrize("wire", ["serial pty", "slcan pty", "slcan tcp"])
def test_the_motor_stops_when_its_host_is_gone(child: Child, wire: str) -> None:
    with observer(child) as watching:
        losses = watching.drive.number("link_losses")
        with pytest.raises(LinkClosed), open_session("zhu2011", child.links[wire]) as session:
            drive = session.drive
            drive.connect()
            drive.enable(Mode.VELOCITY)
            drive.write("omega_m_command", 10.0)
            until(watching, lambda: watching.drive.number("omega_m") > 5.0)
            drive.close_link()
        until(watching, lambda: not watching.drive.state().power_stage_on)
        assert watching.drive.number("link_losses") == losses + 1
    with open_session("zhu2011", child.links[wire]) as session:
        session.drive.connect()
        session.drive.reset_fault()
        with session.drive.enabled(Mode.VELOCITY):
            assert session.drive.read("link_state") == "alive"


JOG = ("-m", "benchtool", "jog", "--speed", "10", "--duration", "600", "--link")
THINKING = """
import sys, threading, benchtool
with benchtool.open_bench("zhu2011", sys.argv[1]) as bench, bench.drive.enabled("velocity") as drive:
    drive.omega_m_command = 10.0
    threading.Event().wait(600.0)
"""


@pytest.mark.parametrize("host_of", [JOG, ("-c", THINKING)], ids=["jog", "python"])
def test_a_host_that_is_killed_stops_the_motor(child: Child, host_of: tuple[str, ...]) -> None:
    command = (sys.executable, *host_of, child.links["slcan pty"])
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as host, observer(child) as watching:
        try:
            until(watching, lambda: watching.drive.state().power_stage_on)
        finally:
            host.kill()
        host.wait()
        until(watching, lambda: not watching.drive.state().power_stage_on)
    answer = json.loads(invoke("reset", "--link", child.links["serial pty"], "--json"))
    assert answer == {"before": "fault", "error_code": "0x8130", "after": "switch on disabled"}


def test_a_reset_starts_a_drive_that_nmt_has_stopped(child: Child) -> None:
    with observer(child) as watching:
        watching.drive.link.nmt(NmtCommand.STOP)
        until(watching, lambda: watching.drive.is_stopped)
    with observer(child) as watching, pytest.raises(StateError, match="benchtool reset"):
        watching.drive.check()
    answer = json.loads(invoke("reset", "--link", child.links["serial pty"], "--json"))
    assert answer["after"] == "switch on disabled"


def test_python_cans_own_slcan_client(child: Child) -> None:
    place = child.folder / "slcan"
    with can.Bus(interface="slcan", channel=str(place), bitrate=500_000, sleep_after_open=0.0) as bus:
        frame = bus.recv(PATIENCE_S)
        assert frame is not None
        assert frame.arbitration_id == 0x701
        bus.send(can.Message(arbitration_id=0x601, data=b"\x40\x18\x10\x04\0\0\0\0", is_extended_id=False))
        while (frame := bus.recv(PATIENCE_S)) is not None and frame.arbitration_id != 0x581:
            pass
        assert frame is not None
        assert bytes(frame.data) == b"\x43\x18\x10\x04\x01\0\0\0"


def test_the_end_is_clean(child: Child) -> None:
    """The last test of the module's child."""
    assert child.process.poll() is None
    assert (child.folder / "serial").is_symlink()
    with open_session("zhu2011", child.links["serial pty"]) as session:
        session.drive.identify()
        code, out, err = child.end(signal.SIGTERM)
        with pytest.raises(LinkError, match="stopped working"):
            session.drive.identify()
    assert (code, out) == (0, ""), err
    assert "Traceback" not in err
    assert list(child.folder.iterdir()) == [], "no symbolic link is left"


def test_ctrl_c_is_the_way_to_end_it(tmp_path: Path) -> None:
    with started(tmp_path, "--tcp", "0", "--speed", "2") as child:
        with open_session("zhu2011", child.links["serial tcp"]) as session:
            before = session.drive.number("tick")
            start_s = session.clock.now_s()
            until(session, lambda: session.drive.number("tick") > before + 10_000)
            spent_s = session.clock.now_s() - start_s
        code, out, err = child.end(signal.SIGINT)
    assert (code, out) == (0, ""), err
    assert spent_s > 0.4, "1 s of drive time is half a second"


# ---- in this process ---------------------------------------------------------------------------------------


def served(
    *wires: str, load_torque_Nm: float = 0.0, hold: float | None = None
) -> AbstractContextManager[ServedDrive]:
    endpoints = [Endpoint("serial" if wire == "serial" else "slcan", ("127.0.0.1", 0)) for wire in wires]
    return serve("zhu2011", endpoints, speed=50.0, load_torque_Nm=load_torque_Nm, hold_omega_m_rad_s=hold)


def test_the_load_machine_holds_a_speed() -> None:
    with served(hold=12.0) as drive:
        drive.run(0.01)
        assert drive.status().omega_m_rad_s == pytest.approx(12.0, rel=0.01)
        assert drive.status().drive_s == pytest.approx(0.5)


def test_a_load_pulls_only_while_the_drive_holds_against_it() -> None:
    with served("serial", load_torque_Nm=0.65) as drive:
        drive.run(0.02)
        assert drive.status().omega_m_rad_s == pytest.approx(0.0, abs=0.01)
        with open_session("zhu2011", drive.wires[0].link) as session:
            session.drive.enable(Mode.TORQUE)  # of no torque
            drive.run(0.004)
            assert drive.status().state == "operation enabled"
            speed = drive.status().omega_m_rad_s
            assert speed < -10.0
            session.drive.disable()
            drive.run(0.002)
            coasting = drive.status().omega_m_rad_s
        drive.run(0.002)
        assert drive.status().omega_m_rad_s == pytest.approx(coasting, rel=0.1)


def test_frames_are_counted_for_each_wire() -> None:
    with served("serial", "slcan") as drive:
        nothing = [each.traffic() for each in drive.wires]
        for wire in drive.wires:
            with open_session("zhu2011", wire.link) as session:
                session.drive.identify()
        for wire, before in zip(drive.wires, nothing, strict=True):
            now = wire.traffic()
            assert now.received - before.received >= 8, "as many objects were read"
            assert now.sent - before.sent >= 8
            assert now.dropped == 0


def test_the_screen_says_what_the_drive_does() -> None:
    with served("serial", "slcan") as drive:
        drive.run(0.002)
        screen = io.StringIO()
        Console(file=screen, width=100).print(_status(drive))
        lines = screen.getvalue().splitlines()
    assert lines[0].startswith("0.1 s, switch on disabled, pre-operational, ")
    for wire in drive.wires:
        assert any(wire.wire in line and wire.place in line for line in lines)


# ---- what cannot be ---------------------------------------------------------------------------------------


def refused(code: int, *options: str) -> str:
    result = CliRunner().invoke(app, ("emulate", *options))
    assert result.exit_code == code, result.output
    assert result.stdout == ""
    return result.stderr


def test_a_tcp_port_that_is_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        assert f"cannot listen at 127.0.0.1, port {port}: " in refused(3, "--tcp", str(port))


def test_a_name_that_is_a_file_is_left_alone(tmp_path: Path) -> None:
    taken = tmp_path / "drive"
    taken.write_text("mine", encoding="utf-8")
    assert f"cannot make the symbolic link {taken}: File exists" in refused(3, "--serial-at", str(taken))
    assert taken.read_text(encoding="utf-8") == "mine"
    elsewhere = tmp_path / "elsewhere"
    elsewhere.symlink_to(taken)
    refused(3, "--slcan-at", str(elsewhere))
    assert elsewhere.readlink() == taken


def test_options_that_contradict_or_cannot_be() -> None:
    assert "does one of the two" in refused(2, "--load-torque", "1", "--hold-speed", "1")
    assert "a speed of 0 cannot be" in refused(2, "--speed", "0")
    assert "cannot listen at 203.0.113.1" in refused(3, "--tcp", "0", "--bind", "203.0.113.1")
