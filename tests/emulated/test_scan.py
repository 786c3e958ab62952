"""Finding drives: results, requests sent, and reports on places without a drive."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from types import SimpleNamespace

import can
import pytest
from serial.tools import list_ports
from typer.testing import CliRunner, Result

from benchtool.bench.wires import registry
from benchtool.cli import app
from benchtool.clock import RealClock
from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.ports.pty import PtyPort
from benchtool.emulator.ports.tcp import TcpPort
from benchtool.emulator.servers.slcan import SlcanAdapter
from benchtool.errors import LinkClosed, LinkError, NoAnswer
from benchtool.link.canopen.discovery import scan_bus
from benchtool.link.canopen.virtual import VirtualTimeBus
from benchtool.link.discovery import Found, duplicates
from benchtool.link.pipe import pipe
from benchtool.link.port import DEFAULT_BAUDRATE, open_port
from benchtool.link.serial.discovery import scan_port
from benchtool.profile import load_profile
from benchtool.protocol.canopen.nmt import NmtState
from benchtool.protocol.serial import FrameSplitter, Identity, decode_request, encode_frame, encode_message

_numbers = itertools.count()
DRIVE = Found(
    link="serial:a?node=1",
    node_id=1,
    vendor_id=0xB7C,
    product_code=0x2011,
    serial_number=1,
    device_name="benchtool reference drive",
    firmware_version="0.1.0",
    nmt_state=NmtState.PRE_OPERATIONAL,
)


@pytest.fixture
def channel() -> str:
    return f"scan-{next(_numbers)}"


@pytest.fixture
def bench(channel: str) -> Iterator[EmulatedBench]:
    powered = EmulatedBench(load_profile("zhu2011"), channel)
    yield powered
    powered.close()


@pytest.fixture
def place(channel: str) -> str:
    return f"can:virtual:{channel}"


# ---- serial lines ----------------------------------------------------------------------------------------


@dataclass
class Answering:
    """A port behind which something answers the first question it understands."""

    answer: bytes
    closed: bool = False
    heard: bytes = b""

    def read(self) -> bytes:
        return self.answer if self.heard else b""

    def write(self, data: bytes) -> None:
        self.heard += data

    def close(self) -> None:
        self.closed = True


def test_a_drive_on_a_serial_line(bench: EmulatedBench) -> None:
    found = scan_port("a", bench.host_port(), DEFAULT_BAUDRATE, 1.0, bench.clock)
    assert found == DRIVE


def test_a_baud_rate_that_is_not_the_usual_is_part_of_the_link(bench: EmulatedBench) -> None:
    found = scan_port("a", bench.host_port(), 115_200, 1.0, bench.clock)
    assert found.link == "serial:a?baudrate=115200&node=1"
    assert registry.parse(found.link).number("baudrate") == 115_200


def test_a_drive_of_another_version_is_told_of_without_being_read() -> None:
    identity = Identity(tag=1, status=0x08000024, version=9, node_id=3, nmt_state=5, dictionary_hash=1)
    port = Answering(encode_frame(encode_message(identity)))
    found = scan_port("a", port, DEFAULT_BAUDRATE, 1.0, RealClock())
    assert (found.node_id, found.nmt_state, found.serial_number) == (3, NmtState.OPERATIONAL, None)
    assert found.device_name == "speaks version 9 of the protocol"
    assert {type(decode_request(payload)).__name__ for payload in _payloads(port.heard)} == {"Identify"}


def test_silence_and_babble_are_told_apart_and_the_port_given_back() -> None:
    silent, babbling = Answering(b""), Answering(b"OK\r\n")
    with pytest.raises(NoAnswer, match=r"^no answer from a within 0.1 s; check that the drive"):
        scan_port("a", silent, DEFAULT_BAUDRATE, 0.1, RealClock())
    with pytest.raises(NoAnswer, match=r"^\d+ bytes, but no answer came from a within"):
        scan_port("a", babbling, DEFAULT_BAUDRATE, 0.1, RealClock())
    assert silent.closed
    assert babbling.closed
    assert len(_payloads(silent.heard)) == 2, "asked twice"


def test_a_port_that_goes_while_it_is_asked(bench: EmulatedBench) -> None:
    host, other = pipe(bench.clock)
    other.close()
    with pytest.raises(LinkClosed, match="a stopped working: the other end hung up"):
        scan_port("a", host, DEFAULT_BAUDRATE, 1.0, bench.clock)


def _payloads(data: bytes) -> list[bytes]:
    return FrameSplitter().feed(data)


# ---- CAN -------------------------------------------------------------------------------------------------


def _host_bus(bench: EmulatedBench, *, of: EmulatedBench | None = None) -> VirtualTimeBus:
    bus = VirtualTimeBus(bench.channel, clock=bench.clock)
    bench.clock.register(bus.settle)
    (of or bench).add_can(bus)
    return bus


def test_a_drive_on_a_bus(bench: EmulatedBench, place: str) -> None:
    (found,) = scan_bus(place, bench.host_bus(), 500_000, 1.0, bench.clock)
    link = f"can:virtual:{bench.channel}?bitrate=500000&node=1"
    assert found == replace(DRIVE, link=link)
    assert bench.clock.now_s() < 2.0, "a search takes the time it was given, and 5 ms for each node"


def test_nothing_is_sent_but_reads(bench: EmulatedBench, place: str) -> None:
    with can.Bus(interface="virtual", channel=bench.channel) as observer:
        scan_bus(place, bench.host_bus(), 500_000, 1.0, bench.clock)
        sent: dict[int, set[int]] = {}
        times: list[float] = []
        while (frame := observer.recv(0.0)) is not None:
            if not 0x580 <= frame.arbitration_id < 0x600 and frame.arbitration_id != 0x701:
                sent.setdefault(frame.arbitration_id, set()).add(frame.data[0] >> 5)
                times.append(frame.timestamp)
    assert set(sent) == {0x600 + node for node in range(1, 128)}
    assert set().union(*sent.values()) <= {2, 3}, "initiate upload and upload segment (CiA 301, 7.2.4.3)"
    first = times[:127]
    gaps_s = [later - earlier for earlier, later in itertools.pairwise(first)]
    assert min(gaps_s) > 0.004, "no burst"


def test_two_nodes_of_one_number_are_seen(bench: EmulatedBench, place: str) -> None:
    copy = EmulatedBench(load_profile("zhu2011"))
    _host_bus(bench, of=copy)
    (found,) = scan_bus(place, bench.host_bus(), 500_000, 1.0, bench.clock)
    copy.close()
    assert found.answers == 2
    (line,) = duplicates([found])
    assert line.startswith("node 1 answered 2 times")


def test_a_node_that_is_only_heard_is_told_of(bench: EmulatedBench, place: str) -> None:
    with can.Bus(interface="virtual", channel=bench.channel) as other:
        beat = can.Message(arbitration_id=0x705, data=b"\x05", is_extended_id=False)
        timer = bench.clock.call_every(0.3, lambda: other.send(beat))
        found = scan_bus(place, bench.host_bus(), 500_000, 1.0, bench.clock)
        timer.cancel()
    assert [each.node_id for each in found] == [1, 5]
    assert found[1] == Found(
        f"can:virtual:{bench.channel}?bitrate=500000&node=5",
        *(5, None, None, None, None, None, NmtState.OPERATIONAL),
    )


class Unacknowledged(VirtualTimeBus):
    """A bus on which nothing can be sent."""

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise can.CanOperationError("no buffer space available")


def test_a_bus_that_takes_nothing_is_given_back(bench: EmulatedBench, place: str) -> None:
    bus = Unacknowledged(bench.channel, clock=bench.clock)
    with pytest.raises(LinkError, match="no buffer space"):
        scan_bus(place, bus, 500_000, 1.0, bench.clock)
    assert bus._is_shutdown


# ---- duplicates ------------------------------------------------------------------------------------------


def test_serial_numbers_that_are_there_twice() -> None:
    again = replace(DRIVE, link="serial:b?node=1")
    (line,) = duplicates([DRIVE, again, replace(DRIVE, link="serial:c?node=1", serial_number=2)])
    assert "serial:a?node=1 and serial:b?node=1" in line
    for other in ({"serial_number": 2}, {"product_code": 7}, {"vendor_id": 7}):
        assert duplicates([DRIVE, replace(again, **other)]) == []  # type: ignore[arg-type]  # of several types
    unnumbered = replace(DRIVE, serial_number=0)
    assert duplicates([unnumbered, unnumbered]) == [], "0 says that there is none"


# ---- the command -----------------------------------------------------------------------------------------


def scan(*arguments: str) -> Result:
    return CliRunner().invoke(app, ("scan", "--timeout", "0.3", *arguments))


def test_the_command_finds_a_drive_on_every_kind_of_place(bench: EmulatedBench) -> None:
    terminal, line, adapter = PtyPort(), TcpPort(), TcpPort()
    bench.add_serial(terminal)
    bench.add_serial(line)
    bench.add_can(SlcanAdapter(adapter))
    urls = [f"socket://127.0.0.1:{each.address[1]}" for each in (line, adapter)]
    places = ("--no-ports", terminal.path, urls[0], "--can", f"slcan:{urls[1]}?bitrate=500000")
    result = scan(*places, "--json")
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert [each["link"] for each in document["drives"]] == [
        f"serial:{terminal.path}?node=1",
        f"serial:{urls[0]}?node=1",
        f"can:slcan:{urls[1]}?bitrate=500000&node=1",
    ]
    assert document["silent"] == []
    assert [each["serial_number"] for each in document["drives"]] == [1, 1, 1]
    assert len(document["duplicates"]) == 1
    # Time stands still, so that no heartbeat is heard: on CAN the state is not known.
    assert [each["nmt_state"] for each in document["drives"]] == ["pre-operational"] * 2 + [None]

    people = scan(*places)
    for link in (each["link"] for each in document["drives"]):
        assert f"--link '{link}'\n" in people.stdout


def test_a_port_that_another_has_open_is_named_with_the_reason(bench: EmulatedBench) -> None:
    terminal, line = PtyPort(), TcpPort()
    bench.add_serial(terminal)
    bench.add_serial(line)
    url = f"socket://127.0.0.1:{line.address[1]}"
    others = [open_port(terminal.path), open_port(url)]
    result = scan("--no-ports", terminal.path, url, "/dev/does-not-exist", "--json")
    for other in others:
        other.close()
    assert result.exit_code == 3
    silent = {each["place"]: each["reason"] for each in json.loads(result.stdout)["silent"]}
    assert "another program has it open" in silent[f"serial:{terminal.path}"]
    assert "check who else has it open" in silent[f"serial:{url}"]
    assert "check that the adapter is plugged in" in silent["serial:/dev/does-not-exist"]


def test_the_ports_of_this_computer_are_asked_unless_told_otherwise(
    bench: EmulatedBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = PtyPort()
    bench.add_serial(terminal)
    monkeypatch.setattr(list_ports, "comports", lambda: [SimpleNamespace(device=terminal.path)])
    assert scan().exit_code == 0
    nothing = scan("--no-ports")
    assert nothing.exit_code == 3
    assert "benchtool: no drive answered at no place" in nothing.stderr
    assert "--can INTERFACE:CHANNEL?bitrate=500000" in nothing.stderr


def test_an_interface_that_cannot_be_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    result = scan("--no-ports", "--can", "nonsense:x")
    assert result.exit_code == 3
    assert "can:nonsense:x: cannot open" in result.stdout
    assert scan("--no-ports", "--can", "virtual").exit_code == 2
