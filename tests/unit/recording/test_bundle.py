"""Run bundles: data are read back exactly, and the same input gives the same bytes."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from pyarrow import parquet

from benchtool.block import Block, Channel, Gap
from benchtool.recording import Bundle, BundleWriter, StreamInfo
from tests.unit.recording.bundles import CHANNELS, MANIFEST, assert_same, block, cut_short


def test_a_finished_bundle_gives_back_blocks_manifest_and_measurements(tmp_path: Path) -> None:
    measurements = {"torque_mean": {"value": 0.65, "unit": "Nm", "definition": "mean"}}
    capture, transducer = block(), replace(block(5), stride=1, tick_s=5e-6)

    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", capture)
        writer.append("transducer", transducer)
        bundle = writer.finish(
            measurements, verdict="passed", quality={"frames_dropped": 0}, details={"plan": {"load_Nm": 0.65}}
        )

    assert bundle == Bundle.open(tmp_path / "run")
    assert bundle.complete
    assert bundle.streams == ("capture", "transducer")
    assert_same(bundle.block("capture"), capture)
    assert_same(bundle.block("transducer"), transducer)
    assert bundle.measurements == measurements
    whole = StreamInfo(rows=50, gaps=0, missing_rows=0)
    assert bundle.manifest == MANIFEST.model_copy(
        update={
            "verdict": "passed",
            "quality": {"frames_dropped": 0},
            "details": {"plan": {"load_Nm": 0.65}},
            "streams": {"capture": whole, "transducer": whole},
            "files": bundle.manifest.files,
            "complete": True,
        }
    )
    assert sorted(path.name for path in (tmp_path / "run" / "data").iterdir()) == [
        "capture.parquet",
        "transducer.parquet",
    ]


def test_values_keep_every_bit(tmp_path: Path) -> None:
    odd = np.array([[-0.0, np.nan, 2.0**32 - 1], [np.inf, 5e-324, 0.1], [-np.inf, 1e308, np.float32(0.1)]])

    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", Block(CHANNELS, 0, 1, 1 / 30e3, odd))
        read = writer.finish().block("capture")

    assert read.data.tobytes() == odd.tobytes()
    assert read.tick_s.hex() == (1 / 30e3).hex()


def test_appended_blocks_become_one_with_their_gaps(tmp_path: Path) -> None:
    first = block(100, 50, gaps=(Gap(10, 3),))
    # 50 rows and 3 missing ones end at tick 206; 4 strides are missing before the next
    second = block(100 + 2 * (53 + 4), 20, gaps=(Gap(5, 1),))

    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", first)
        writer.append("capture", second)
        bundle = writer.finish()

    read = bundle.block("capture")
    assert read.gaps == (Gap(10, 3), Gap(50, 4), Gap(55, 1))
    np.testing.assert_array_equal(read.ticks(), np.concatenate([first.ticks(), second.ticks()]))
    np.testing.assert_array_equal(read.data, np.concatenate([first.data, second.data]))
    assert bundle.manifest.streams["capture"] == StreamInfo(rows=70, gaps=3, missing_rows=8)


def test_units_and_time_base_stand_in_the_parquet_file(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block(gaps=(Gap(10, 3),)))
        writer.finish()

    schema = parquet.read_schema(tmp_path / "run" / "data" / "capture.parquet")
    assert {field.name: field.metadata[b"unit"] for field in schema} == {
        "time_s": b"s",
        "i_a": b"A",
        "torque": b"Nm",
        "switching_count": b"",
    }
    wanted = {b"first_tick": b"100", b"stride": b"2", b"tick_s": b"0.0001", b"gaps": b"[[10, 3]]"}
    assert wanted.items() <= schema.metadata.items()


def test_the_time_of_every_row_stands_beside_it_and_is_no_channel(tmp_path: Path) -> None:
    written = block(0, 140_000, stride=3, gaps=(Gap(10, 3), Gap(70_000, 1)))
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", written)
        bundle = writer.finish()
    assert_same(bundle.block("capture"), written)
    table = parquet.read_table(tmp_path / "run" / "data" / "capture.parquet")
    np.testing.assert_array_equal(table["time_s"].to_numpy(), written.time_s())
    for name in written.names:
        np.testing.assert_array_equal(table[name].to_numpy(), written.column(name))


def test_a_channel_that_is_called_time_s_is_recorded_as_it_is(tmp_path: Path) -> None:
    own = Block((Channel("time_s", "s"),), 0, 1, 1e-4, np.array([[0.0], [1.0], [5.0]]))
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("table", own)
        bundle = writer.finish()
    assert_same(bundle.block("table"), own)


def test_a_bundle_without_the_time_is_read_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written = block(gaps=(Gap(10, 3),))
    with monkeypatch.context() as older:
        older.setattr("benchtool.recording.stream_file.with_time", lambda schema: schema)
        with BundleWriter(tmp_path / "run", MANIFEST.model_copy(update={"schema_version": 1})) as writer:
            writer.append("capture", written)
            writer.finish()
    assert parquet.read_schema(tmp_path / "run" / "data" / "capture.parquet").names == list(written.names)
    assert_same(Bundle.open(tmp_path / "run").block("capture"), written)


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cuts=st.sets(st.integers(1, 139_999), max_size=6))
def test_data_files_are_the_same_bytes_however_the_rows_arrived(
    cuts: set[int], tmp_path_factory: pytest.TempPathFactory
) -> None:
    whole = block(0, 140_000, stride=1)
    edges = [0, *sorted(cuts), 140_000]
    pieces = [
        replace(whole, first_tick=begin, data=whole.data[begin:end])
        for begin, end in itertools.pairwise(edges)
    ]
    files = []
    for number, parts in enumerate(([whole], pieces)):
        directory = tmp_path_factory.mktemp(f"run{number}")
        with BundleWriter(directory, MANIFEST.model_copy(update={"when": str(number)})) as writer:
            for part in parts:
                writer.append("capture", part)
            writer.finish()
        files.append((directory / "data" / "capture.parquet").read_bytes())

    assert files[0] == files[1]
    assert_same(Bundle.open(directory).block("capture"), whole)


def test_a_finished_stream_may_be_empty(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block(rows=0))
        read = writer.finish().block("capture")

    assert read.data.shape == (0, len(CHANNELS))
    assert read.channels == CHANNELS


def test_the_manifest_is_readable_text_with_its_versions(tmp_path: Path) -> None:
    cut_short(tmp_path / "run", block())

    text = (tmp_path / "run" / "manifest.json").read_text(encoding="utf-8")
    assert "ψ" in text
    assert {"benchtool", "python", "numpy", "pyarrow"} <= json.loads(text)["versions"].keys()
