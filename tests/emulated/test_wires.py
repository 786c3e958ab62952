"""Wires: one that an installed package adds by one line, and links that are open already."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchtool.bench.serving import Endpoint, serve
from benchtool.bench.session import open_session
from benchtool.bench.wires import registry
from benchtool.bench.wires.address import AddressSyntax
from benchtool.bench.wires.wire import Wire
from benchtool.cli import app
from benchtool.clock import VirtualClock
from benchtool.emulator.bench import EmulatedBench
from benchtool.errors import EnvironmentFailure, LinkClosed, UsageError
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.serial.link import SerialLink
from benchtool.plan.model import load_plan
from benchtool.profile import load_profile
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode
from benchtool.recording import Bundle
from benchtool.run.runner import RunInfo, run_plan
from benchtool.telemetry import FrameLog

THE_LINE = "loopback = tests.emulated.loopback:WIRE"
DEMO = "zhu2011/ripple"


class Unseen:
    def begin(self, case: str, number: int, count: int) -> None: ...
    def note(self, text: str) -> None: ...


def install(folder: Path, monkeypatch: pytest.MonkeyPatch, line: str = THE_LINE) -> None:
    """Put a package on the path that declares one wire."""
    metadata = folder / "other_package_wire-1.0.dist-info"
    metadata.mkdir(exist_ok=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: other-package-wire\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[{registry.GROUP}]\n{line}\n")
    monkeypatch.syspath_prepend(str(folder))


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, monkeypatch)


def run_demo(link: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Bundle:
    plan = load_plan(DEMO)
    info = RunInfo("2020-01-01T00:00:00+00:00", 0, ("run",), link=link, wall_s=lambda: 0.0)
    result = run_plan(
        lambda case, seed: open_session(plan.profile, link, seed=seed, alter=case.emulator),
        plan,
        folder,
        info,
        Unseen(),
    )
    assert [str(each.verdict) for each in result.assessments] == ["pass"]
    return Bundle.open(folder)


@pytest.mark.usefixtures("installed")
def test_the_demo_over_the_wire_of_an_installed_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    links = {"loopback": "emulated?wire=loopback", "serial": "emulated?wire=serial", "can": "emulated"}
    ran = {name: run_demo(link, tmp_path / name, monkeypatch) for name, link in links.items()}
    loopback = ran["loopback"]
    assert loopback.complete
    assert loopback.manifest.link == "emulated?wire=loopback"
    # It is the same drive at the same moments as over the line within the process, to the last bit.
    for name in ("capture", "transducer", "telemetry"):
        ours, theirs = loopback.block(name), ran["serial"].block(name)
        assert (ours.names, ours.first_tick, ours.gaps) == (theirs.names, theirs.first_tick, theirs.gaps)
        np.testing.assert_array_equal(ours.data, theirs.data)
    for file in ("measurements.json", "certificate.json"):
        assert (tmp_path / "loopback" / file).read_bytes() == (tmp_path / "serial" / file).read_bytes()
    # Over CAN as well: the drive is given its commands at the same ticks.
    np.testing.assert_array_equal(loopback.block("capture").data, ran["can"].block("capture").data)
    assert loopback.measurements == ran["can"].measurements


@pytest.mark.usefixtures("installed")
def test_a_wire_of_another_package_has_what_the_others_have() -> None:
    names = [wire.name for wire in registry.wires()]
    assert names == ["emulated", "can", "serial", "replay", "loopback"]
    with open_session("zhu2011", "emulated?wire=loopback") as session:
        drive = session.drive
        drive.connect()
        drive.reconnect(1.0)
        with drive.enabled(Mode.VELOCITY):
            drive.wait(0.05)
        assert drive.state() is State.SWITCH_ON_DISABLED
    with (
        pytest.raises(UsageError, match=r"frames are those of CAN and the link is 'emulated\?wire=loopback'"),
        open_session("zhu2011", "emulated?wire=loopback", frames=FrameLog()),
    ):
        pass
    with pytest.raises(UsageError, match="wire 'usb' is not known, known are can, serial, loopback"):
        registry.parse("emulated?wire=usb")


@pytest.mark.usefixtures("installed")
def test_the_command_line_knows_an_installed_wire() -> None:
    arguments = ("params", "get", "u_s_V", "--link", "emulated?wire=loopback")
    got = CliRunner().invoke(app, arguments)
    assert got.exit_code == 0, got.output
    assert got.stdout == CliRunner().invoke(app, arguments[:3]).stdout


@pytest.mark.usefixtures("installed")
def test_an_emulated_drive_offers_the_wire_of_another_package() -> None:
    with serve("zhu2011", [Endpoint("loopback-serial")]) as drive:
        (wire,) = drive.wires
        assert (wire.wire, wire.link) == ("loopback-serial", f"elsewhere:{wire.place}")
    with (
        pytest.raises(UsageError, match="offers no 'usb': choose slcan, serial or loopback-serial"),
        serve("zhu2011", [Endpoint("usb")]),
    ):
        pass


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("broken = tests.emulated.loopback:NOTHING", "'broken' .* cannot be loaded: AttributeError"),
        ("absent = no_such_module:WIRE", "'absent' .* cannot be loaded: ModuleNotFoundError"),
        ("ending = ending_wire:WIRE", r"'ending' .* cannot be loaded: SystemExit\(0\)"),
        ("odd = tests.emulated.loopback:LoopbackPort", "'odd' .* is a type, a Wire is expected"),
    ],
)
def test_an_entry_point_that_is_not_a_wire_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str, complaint: str
) -> None:
    install(tmp_path, monkeypatch, line)
    (tmp_path / "ending_wire.py").write_text("raise SystemExit(0)\n", encoding="utf-8")
    assert registry.parse("emulated?wire=serial").scheme == "emulated", "those of this package work on"
    with pytest.raises(EnvironmentFailure, match=complaint):
        registry.parse("somewhere:else")


def test_a_wire_with_addresses_can_open_them() -> None:
    with pytest.raises(ValueError, match="'usb' has one of syntax and connect"):
        Wire("usb", AddressSyntax("usb", ("PORT",)))


# ---- links that are open already -------------------------------------------------------------------------


@pytest.mark.parametrize("wire", ["can", "serial"])
def test_a_session_over_an_open_link_leaves_the_link_open_and_the_drive_disabled(wire: str) -> None:
    bench = EmulatedBench(load_profile("zhu2011"))
    link = (
        CanopenLink(bench.host_bus(), 1, bench.clock)
        if wire == "can"
        else SerialLink(bench.host_port(), 1, bench.clock)
    )
    with link:
        with open_session("zhu2011", link) as session:
            assert session.clock is bench.clock
            session.drive.connect()
            session.drive.write("omega_m_command", 5.0)
            enabled = session.drive.enabled(Mode.VELOCITY)
            enabled.__enter__()  # and nothing leaves it but the session
            assert bench.status().state == State.OPERATION_ENABLED.value
        assert bench.status().state == State.SWITCH_ON_DISABLED.value
        assert len(link.upload(0x1018, 1)) == 4, "the link is its owner's"
    with pytest.raises(LinkClosed):
        link.upload(0x1018, 1)
    bench.close()


def test_an_open_link_cannot_be_altered_tapped_or_opened_again() -> None:
    bench = EmulatedBench(load_profile("zhu2011"), has_bus=False)
    assert isinstance(bench.clock, VirtualClock)
    with SerialLink(bench.host_port(), 1, bench.clock) as link:
        with (
            pytest.raises(UsageError, match=r"alters the emulated bench .* the link is an open link"),
            open_session("zhu2011", link, alter={"motor.R_s_ohm": 1.0}),
        ):
            pass
        with (
            pytest.raises(UsageError, match="give its address instead"),
            open_session("zhu2011", link, frames=FrameLog()),
        ):
            pass
        with open_session("zhu2011", link) as session:
            session.drive.connect()
            with pytest.raises(LinkClosed, match="cannot be opened again"):
                session.drive.reconnect(0.1)
    bench.close()


# ---- wires of other packages that fail when they are used --------------------------------------------------

BROKEN = """
from benchtool.bench.wires.address import AddressSyntax
from benchtool.bench.wires.wire import Connection, Wire
from benchtool.clock import VirtualClock

class Link:
    node_id, clock = 1, VirtualClock()
    def __getattr__(self, name):
        raise ZeroDivisionError(name)

def connect(stack, address, opening):
    if address.place[0] == "at-once":
        raise KeyError("adapter")
    return Connection(Link.clock, Link)

def ports():
    raise IndexError("no ports")

WIRE = Wire("broken", AddressSyntax("broken", ("HOW",)), connect, own_places=ports, discover=lambda *_: [][1])
"""


@pytest.mark.parametrize(
    "arguments",
    [
        ("info", "--link", "broken:at-once"),
        ("info", "--link", "broken:later"),
        ("params", "get", "u_s", "--link", "broken:later"),
        ("scan",),
    ],
    ids=lambda arguments: "-".join(arguments[:1] + arguments[-1:]),
)
def test_a_wire_that_fails_in_use_is_named_and_no_limit_has_failed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]
) -> None:
    (tmp_path / "broken_wire.py").write_text(BROKEN, encoding="utf-8")
    install(tmp_path, monkeypatch, "broken = broken_wire:WIRE")
    answer = CliRunner().invoke(app, arguments)
    assert answer.exit_code == 3, answer.output
    assert "the wire 'broken' (broken_wire:WIRE) failed: " in answer.stderr
    assert "repair or remove the package" in answer.stderr


def test_what_the_caller_raises_is_not_laid_at_the_wire(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path, monkeypatch)
    with (
        pytest.raises(ZeroDivisionError),
        open_session("zhu2011", "emulated?wire=loopback"),
    ):
        raise ZeroDivisionError
