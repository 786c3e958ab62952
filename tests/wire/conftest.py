"""What every test of the wire starts from."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest

from tests.wire.ends import Served, Wire

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
