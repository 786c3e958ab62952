"""Fixtures of the tests of the C library."""

from __future__ import annotations

import fcntl
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from benchtool.bench.session import Session, open_session
from benchtool.emulator.bench import EmulatedBench
from benchtool.profile import load_profile
from benchtool.protocol.canopen.nmt import NmtCommand
from tests.device.c_drive import CHost, Library, make, raw_parameters
from tests.device.can_endpoints import Pair
from tests.wire.raw_host import RawHost

Maker = Callable[..., Path]


@pytest.fixture(scope="session")
def made(pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory) -> Maker:
    """Makes targets in a folder, and returns it; what one worker has made the others find there."""
    place = tmp_path_factory.getbasetemp()
    if hasattr(pytestconfig, "workerinput"):
        place = place.parent  # that of the run, with one for each worker

    def made(*targets: str) -> Path:
        folder = place / "_".join(targets)
        folder.mkdir(exist_ok=True)
        with (folder / "making.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            make(folder, *targets)
        return folder

    return made


@pytest.fixture(scope="session")
def build(made: Maker) -> Path:
    """The folder that the library and the example are built in."""
    return made("library", "drive")


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
def can_library(made: Maker) -> Path:
    """The drive on a CAN bus, advanced by a test."""
    return made("library-canopen") / "libbenchtool_can.so"


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
