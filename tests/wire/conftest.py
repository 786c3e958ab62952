"""Fixtures of the tests of the wire."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest

from benchtool.clock import RealClock
from benchtool.emulator.bench import EmulatedBench
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.canopen.virtual import VirtualTimeBus
from benchtool.profile import load_profile
from tests.wire.endpoints import NODE, ScriptedBus, Served, Wire
from tests.wire.raw_host import RawHost

_numbers = itertools.count()


@pytest.fixture
def channel() -> str:
    return f"wire-{next(_numbers)}"


@pytest.fixture
def served(channel: str) -> Iterator[Served]:
    server = Served(channel)
    yield server
    server.close()


@pytest.fixture
def wire(served: Served) -> Iterator[Wire]:
    peer = Wire(served)
    yield peer
    peer.bus.shutdown()


@pytest.fixture
def link(served: Served, channel: str) -> Iterator[CanopenLink]:
    with CanopenLink(VirtualTimeBus(channel), NODE, RealClock()) as opened:
        yield opened


@pytest.fixture
def scripted() -> ScriptedBus:
    return ScriptedBus()


@pytest.fixture
def host(scripted: ScriptedBus) -> Iterator[CanopenLink]:
    with CanopenLink(scripted, NODE, RealClock(), sdo_timeout_s=30.0) as opened:
        yield opened


@pytest.fixture
def timing_out(scripted: ScriptedBus) -> Iterator[CanopenLink]:
    """A host for tests in which one answer comes in time and another one does not."""
    with CanopenLink(scripted, NODE, RealClock(), sdo_timeout_s=0.4) as opened:
        yield opened


@pytest.fixture
def impatient(scripted: ScriptedBus) -> Iterator[CanopenLink]:
    """A host for tests in which no answer is to come in time."""
    with CanopenLink(scripted, NODE, RealClock(), sdo_timeout_s=0.02) as opened:
        yield opened


@pytest.fixture
def bench() -> Iterator[EmulatedBench]:
    """An emulated drive without any wire yet."""
    powered = EmulatedBench(load_profile("zhu2011"), has_bus=False)
    yield powered
    powered.close()


@pytest.fixture
def raw(bench: EmulatedBench) -> RawHost:
    """A host on a serial line to it, which has heard it boot."""
    host = RawHost(bench)
    host.hear()
    return host
