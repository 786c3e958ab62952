"""What every test of the C library starts from."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchtool.emulator.bench import EmulatedBench
from benchtool.profile import load_profile
from tests.device.c_drive import CHost, Library, make, raw_parameters
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
    bench = EmulatedBench(load_profile("zhu2011"), wire="serial")
    try:
        return raw_parameters(RawHost(bench))
    finally:
        bench.close()


@pytest.fixture
def raw(library: Library, parameters: list[int]) -> CHost:
    """A host on a serial line to the C library's drive, which has heard it boot."""
    host = CHost(library, parameters)
    host.hear()
    return host
