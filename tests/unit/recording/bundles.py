"""Bundles with a manifest and blocks of three channels, whole and cut short."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchtool.block import Block, Channel, Gap
from benchtool.recording import BundleWriter, Manifest, software_versions

CHANNELS = (Channel("i_a", "A"), Channel("torque", "Nm"), Channel("switching_count", ""))
MANIFEST = Manifest(
    what="run steady state",
    when="2026-11-21T12:00:00+00:00",
    profile_name="zhu2011",
    profile_toml='title = "ψ"\n',
    identity={"vendor_id": 0xB7C, "device_name": "drive"},
    dictionary_hash=0xDEADBEEF,
    parameters={"R_s": 0.123, "law": "tpc", "pole_pairs": 4},
    versions=software_versions(),
    seed=7,
    command_line=("benchtool", "run", "steady"),
)


def block(first_tick: int = 100, rows: int = 50, stride: int = 2, gaps: tuple[Gap, ...] = ()) -> Block:
    data = np.random.default_rng(first_tick).standard_normal((rows, len(CHANNELS)))
    return Block(CHANNELS, first_tick, stride, 1e-4, data, gaps)


def assert_same(read: Block, written: Block) -> None:
    assert replace(read, data=written.data) == written
    np.testing.assert_array_equal(read.data, written.data)
    np.testing.assert_array_equal(read.ticks(), written.ticks())


def cut_short(directory: Path, *blocks: Block) -> Path:
    """A bundle whose process wrote these blocks and ended without finishing; the path of its stream."""
    with BundleWriter(directory, MANIFEST) as writer:
        for each in blocks:
            writer.append("capture", each)
    return directory / "data" / "capture.arrows"
