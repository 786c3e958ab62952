"""Two hosts at one drive: the second is refused, and does not disturb the first."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from benchtool.drive.remote import RemoteDrive
from benchtool.emulator.bench import EmulatedBench
from benchtool.errors import StateError
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.interface import Link
from benchtool.link.serial.link import SerialLink
from benchtool.profile import load_profile
from benchtool.protocol.cia402 import State
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.modes import Mode
from benchtool.shipped import shipped

_EDS = shipped("firmware_protocol") / "drive.eds"


class _Hosts:
    """Hosts of one emulated drive."""

    def __init__(self, stack: ExitStack) -> None:
        self.bench = EmulatedBench(load_profile("zhu2011"))
        self._stack = stack
        stack.callback(self.bench.close)

    def host(self, wire: str) -> RemoteDrive:
        clock = self.bench.clock
        link: Link
        if wire == "serial":
            link = SerialLink(self.bench.host_port(), 1, clock)
        else:
            link = CanopenLink(self.bench.host_bus(), 1, clock, arrival_s=lambda frame: frame.timestamp)
        self._stack.callback(link.close)
        return self._stack.enter_context(RemoteDrive(link, Dictionary.from_eds(_EDS, 1), _EDS.name, clock))


@pytest.fixture
def hosts() -> Iterator[_Hosts]:
    with ExitStack() as stack:
        yield _Hosts(stack)


@pytest.mark.parametrize(
    "wires", [("can", "can"), ("can", "serial"), ("serial", "can"), ("serial", "serial")]
)
@pytest.mark.parametrize("enabled", [False, True])
def test_the_second_is_told_of_the_first(hosts: _Hosts, wires: tuple[str, str], enabled: bool) -> None:
    first, second = (hosts.host(wire) for wire in wires)
    first.connect()
    first.wait(0.2)
    if enabled:
        first.enable(Mode.VELOCITY)
    before = first.read("host_heartbeat")
    state = State.OPERATION_ENABLED if enabled else State.SWITCH_ON_DISABLED
    with pytest.raises(StateError) as told:
        second.connect()
    assert str(told.value).startswith(
        f"another host supervises this drive (node 127, timeout 500 ms), which is in '{state.value}'"
    )
    first.wait(1.0)
    assert first.read("host_heartbeat") == before
    assert first.read("link_state") == "alive"
    assert first.state() is state


def test_a_host_that_died_a_moment_ago_is_no_other_host(hosts: _Hosts) -> None:
    first = hosts.host("can")
    first.connect()
    first.wait(0.2)
    first.stop_heartbeat()
    assert first.read("link_state") == "alive"
    second = hosts.host("can")
    second.connect()
    second.wait(0.2)
    assert second.read("link_state") == "alive"
