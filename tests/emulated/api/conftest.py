"""Benches with the emulated drive, closed with the test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import benchtool


@pytest.fixture
def bench() -> Iterator[benchtool.Bench]:
    """The paper's machine."""
    with benchtool.open_bench("zhu2011") as bench:
        yield bench
