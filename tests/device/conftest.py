"""Fixtures of the tests of the C library."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from benchtool.bench.session import Session, open_session
from benchtool.emulator.bench import EmulatedBench
from benchtool.profile import load_profile
from benchtool.protocol.canopen.nmt import NmtCommand
from tests.device.c_drive import CHost, Library, make, raw_parameters
from tests.device.can_endpoints import Pair
from tests.wire.raw_host import RawHost


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that the library and the example are built in."""
    folder = tmp_path_factory.mktemp("c")
    make(folder, "library", "drive")
    return folder


@pytest.fixture(scope="session")
def library(build: Path) -> Library:
    return Library(build / "libbenchtool.so")


@pytest.fixture(scope="session")
def parameters(build: Path) -> list[int]:
    """Those that the emulated drive of the paper keeps."""
    bench = EmulatedBench(load_profile("zhu2011"), has_bus=False)
    try:
        return raw_parameters(RawHost(bench))
    finally:
        bench.close()


@pytest.fixture(scope="session")
def can_library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The drive on a CAN bus, advanced by a test."""
    folder = tmp_path_factory.mktemp("can")
    make(folder, "library-canopen")
    return folder / "libbenchtool_can.so"


@pytest.fixture
def pair(can_library: Path, parameters: list[int]) -> Iterator[Pair]:
    """The C library's drive and the emulated drive, just switched on."""
    both = Pair(can_library, parameters)
    yield both
    both.close()


@pytest.fixture
def session(url: str) -> Iterator[Session]:
    """A session with the drive at `url`, of the module that asks, as it is after a reset."""
    with open_session("zhu2011", url) as opened:
        opened.drive.link.nmt(NmtCommand.RESET_NODE)
        yield opened


@pytest.fixture
def raw(library: Library, parameters: list[int]) -> CHost:
    """A host on a serial line to the C library's drive, which has heard it boot."""
    host = CHost(library, parameters)
    host.hear()
    return host
