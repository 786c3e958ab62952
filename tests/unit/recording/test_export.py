"""Exports read back, by the tools they are for, to the same numbers, names and units."""

from __future__ import annotations

import csv
import sys
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from benchtool.block import Block, Channel, Gap
from benchtool.errors import EnvironmentFailure, RecordingError
from benchtool.recording import Bundle, BundleWriter, Manifest
from benchtool.recording.export import Format, export

CHANNELS = (Channel("i_a", "A"), Channel("omega_m", "rad/s"), Channel("switching_count", ""))


@pytest.fixture
def block() -> Block:
    data = np.random.default_rng(5).standard_normal((1000, 3)) * np.logspace(-12, 12, 1000)[:, np.newaxis]
    data[:3, 0] = 0.1, -0.0, 5e-324
    return Block(CHANNELS, 700, 20, 1e-4, data, (Gap(300, 4), Gap(301, 1)))


@pytest.fixture
def bundle(block: Block, tmp_path: Path) -> Bundle:
    with BundleWriter(tmp_path / "run", Manifest(what="a test", when="2026-11-21T12:00:00+01:00")) as writer:
        writer.append("capture", block)
        writer.append("fast.2", block)
        return writer.finish()


def test_csv(bundle: Bundle, block: Block, tmp_path: Path) -> None:
    export(bundle, "capture", Format.CSV, tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["tick", "time_s [s]", "i_a [A]", "omega_m [rad/s]", "switching_count"]
    assert [int(row[0]) for row in rows] == block.ticks().tolist()
    read = np.array([[float(cell) for cell in row[1:]] for row in rows])
    assert read[:, 0].tobytes() == block.time_s().tobytes()
    assert read[:, 1:].tobytes() == np.ascontiguousarray(block.data).tobytes()


def test_mat(bundle: Bundle, block: Block, tmp_path: Path) -> None:
    export(bundle, "fast.2", Format.MAT, tmp_path / "a.mat")
    struct = loadmat(tmp_path / "a.mat", simplify_cells=True)["fast_2"]
    for channel in CHANNELS:
        assert struct[channel.name].tobytes() == np.ascontiguousarray(block.column(channel.name)).tobytes()
    assert struct["tick"].tolist() == block.ticks().tolist()
    assert struct["time_s"].tolist() == block.time_s().tolist()
    assert struct["units"]["omega_m"] == "rad/s"
    assert (struct["tick_s"], struct["stride"], struct["what"]) == (1e-4, 20, "a test")


def test_mdf4(bundle: Bundle, block: Block, tmp_path: Path) -> None:
    from asammdf import MDF

    export(bundle, "capture", Format.MDF4, tmp_path / "a.mf4")
    with MDF(tmp_path / "a.mf4") as file:
        assert file.version == "4.10"
        for channel in CHANNELS:
            signal = file.get(channel.name)
            assert signal.unit == channel.unit
            assert signal.samples.tobytes() == np.ascontiguousarray(block.column(channel.name)).tobytes()
            assert signal.timestamps.tobytes() == block.time_s().tobytes()
        assert file.get("tick").samples.tolist() == block.ticks().tolist()
        assert file.start_time == datetime.fromisoformat(bundle.manifest.when)


def test_without_its_package_mdf4_says_what_to_install(
    bundle: Bundle, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    with pytest.raises(EnvironmentFailure, match=r"pip install 'benchtool\[mdf\]'"):
        export(bundle, "capture", Format.MDF4, tmp_path / "a.mf4")
    assert list(tmp_path.glob("a*")) == []


@pytest.mark.parametrize("format_", list(Format))
def test_what_cannot_be_written_is_one_line_and_leaves_nothing(
    bundle: Bundle, tmp_path: Path, format_: Format
) -> None:
    with pytest.raises(RecordingError, match="cannot write"):
        export(bundle, "capture", format_, tmp_path / "none" / "a.x")
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    with pytest.raises(RecordingError, match="overwrites nothing"):
        export(bundle, "capture", format_, tmp_path / "mine")
    assert (tmp_path / "mine").read_text(encoding="utf-8") == "mine"
    with pytest.raises(RecordingError, match="has no stream 'captur', it has: capture, fast"):
        export(bundle, "captur", format_, tmp_path / "a.x")
    assert {path.name for path in tmp_path.iterdir()} == {"run", "mine"}


def test_a_recording_that_was_cut_short_is_exported_too(block: Block, tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", Manifest(what="x", when="2026-11-21T12:00:00+01:00")) as writer:
        writer.append("capture", block)
    export(Bundle.open(tmp_path / "run"), "capture", Format.CSV, tmp_path / "a.csv")
    assert len((tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()) == 1001
