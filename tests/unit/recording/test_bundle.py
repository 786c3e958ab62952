"""Run bundles: data are read back exactly, the same input gives the same bytes, and failures are one line."""

from __future__ import annotations

import itertools
import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from pyarrow import parquet

from benchtool.block import Block, Channel, Gap
from benchtool.errors import RecordingError
from benchtool.recording import Bundle, BundleWriter, Manifest, StreamInfo, software_versions
from benchtool.recording.failures import writing

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


def test_what_was_cut_short_says_why_and_takes_no_more(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block())
        writer.fail("DriveFault: overcurrent", verdict="fail", quality={"frames_dropped": 2})
        assert_same(Bundle.open(tmp_path / "run").block("capture"), block())
        with pytest.raises(RecordingError, match="is closed, nothing can be added"):
            writer.append("capture", block(300))
    bundle = Bundle.open(tmp_path / "run")
    assert not bundle.complete
    assert bundle.manifest.verdict == "fail"
    assert bundle.manifest.details["failure"] == "DriveFault: overcurrent"
    assert bundle.manifest.quality["frames_dropped"] == 2
    assert bundle.manifest.streams["capture"].rows == 50


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


def test_a_stream_cut_at_any_byte_keeps_every_whole_batch(tmp_path: Path) -> None:
    blocks = [block(100, 3), block(106, 4, gaps=(Gap(1, 2),)), block(118, 5)]
    path = cut_short(tmp_path / "run", *blocks)
    content = path.read_bytes()
    with pa.OSFile(str(path)) as file:
        stream = pa.ipc.open_stream(file)
        ends = [(stream.read_next_batch(), file.tell())[1] for _ in blocks]

    for length in range(ends[0], len(content) + 1):
        path.write_bytes(content[:length])
        kept = sum(length >= end for end in ends)
        read = Bundle.open(tmp_path / "run").block("capture")
        np.testing.assert_array_equal(read.data, np.concatenate([each.data for each in blocks[:kept]]))
        np.testing.assert_array_equal(read.ticks(), np.concatenate([each.ticks() for each in blocks[:kept]]))


def test_a_stream_cut_within_its_head_is_one_line(tmp_path: Path) -> None:
    path = cut_short(tmp_path / "run", block())
    content = path.read_bytes()
    for length in (0, 1, 8, 100):
        path.write_bytes(content[:length])
        with pytest.raises(RecordingError, match=r"capture\.arrows") as refused:
            Bundle.open(tmp_path / "run").block("capture")
        assert "\n" not in str(refused.value)


def test_a_killed_process_leaves_what_it_acknowledged(tmp_path: Path) -> None:
    code = f"""
import os, signal, numpy as np
from pathlib import Path
from benchtool.block import Block, Channel
from benchtool.recording import BundleWriter, Manifest
writer = BundleWriter(Path({str(tmp_path / "run")!r}), Manifest(what="killed", when="now"))
for number in range(3):
    rows = np.full((10, 1), float(number))
    writer.append("stream", Block((Channel("x", "A"),), 10 * number, 1, 1e-4, rows))
os.kill(os.getpid(), signal.SIGKILL)
"""
    ended = subprocess.run([sys.executable, "-c", code], check=False)

    assert ended.returncode == -signal.SIGKILL
    bundle = Bundle.open(tmp_path / "run")
    assert not bundle.complete
    assert bundle.streams == ("stream",)
    assert bundle.measurements == {}
    np.testing.assert_array_equal(bundle.block("stream").column("x"), np.repeat([0.0, 1.0, 2.0], 10))


def test_a_run_that_raises_keeps_its_data_and_its_error(tmp_path: Path) -> None:
    def run() -> None:
        with BundleWriter(tmp_path / "run", MANIFEST) as writer:
            writer.append("capture", block())
            raise KeyError("the run")

    with pytest.raises(KeyError, match="the run"):
        run()

    bundle = Bundle.open(tmp_path / "run")
    assert not bundle.complete
    assert_same(bundle.block("capture"), block())


def test_a_full_disk_is_one_line_and_keeps_what_was_acknowledged(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        os.symlink("/dev/full", tmp_path / "run" / "data" / "full.arrows")
        writer.append("capture", block())
        with pytest.raises(
            RecordingError, match=r"cannot write .*full\.arrows: No space left on device"
        ) as full:
            writer.append("full", block())
        assert "\n" not in str(full.value)
        with pytest.raises(RecordingError, match="ends in a write that failed"):
            writer.append("full", block())
        with pytest.raises(RecordingError, match="ends in a write that failed"):
            writer.finish()

    bundle = Bundle.open(tmp_path / "run")
    assert not bundle.complete
    assert_same(bundle.block("capture"), block())


@contextmanager
def no_file_may_grow(path: Path) -> Iterator[None]:
    """Let the operating system refuse every write past the present size of the file."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (path.stat().st_size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_stream_that_cannot_be_ended_is_reported_unless_something_else_failed_first(tmp_path: Path) -> None:
    def run(directory: Path, error: Exception | None) -> None:
        with BundleWriter(directory, MANIFEST) as writer:
            writer.append("capture", block())
            writer.append("other", block())
            stack.enter_context(no_file_may_grow(directory / "data" / "other.arrows"))
            if error is not None:
                raise error

    with ExitStack() as stack, pytest.raises(RecordingError, match=r"cannot write .*: File too large"):
        run(tmp_path / "a", None)
    with ExitStack() as stack, pytest.raises(KeyError, match="the run"):
        run(tmp_path / "b", KeyError("the run"))

    for name in ("capture", "other"):
        assert_same(Bundle.open(tmp_path / "a").block(name), block())


def test_a_finished_stream_may_be_empty(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block(rows=0))
        read = writer.finish().block("capture")

    assert read.data.shape == (0, len(CHANNELS))
    assert read.channels == CHANNELS


def test_a_disk_that_fills_up_while_finishing_keeps_the_stream(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block())
        os.symlink("/dev/full", tmp_path / "run" / "data" / "capture.parquet.part")
        with pytest.raises(RecordingError, match=r"cannot write .*capture\.parquet: .*No space left"):
            writer.finish()

    assert_same(Bundle.open(tmp_path / "run").block("capture"), block())


@pytest.mark.parametrize(
    ("wrong", "seen"),
    [
        (block(198), "tick 198 does not continue"),
        (block(201), "tick 201 does not continue"),
        (block(200, stride=4), "another rate"),
        (replace(block(200), tick_s=2e-4), "another rate"),
        (replace(block(200), channels=CHANNELS[:2], data=block().data[:, :2]), "other channels"),
    ],
)
def test_a_block_that_does_not_continue_its_stream_is_refused(
    tmp_path: Path, wrong: Block, seen: str
) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block())
        with pytest.raises(RecordingError, match=seen):
            writer.append("capture", wrong)
        writer.append("capture", block(200))
        assert len(writer.finish().block("capture").data) == 100


@pytest.mark.parametrize("name", ["", "../outside", "a/b", ".hidden", "a b", "a\n"])
def test_a_stream_name_that_is_no_file_name_is_refused(tmp_path: Path, name: str) -> None:
    with (
        BundleWriter(tmp_path / "run", MANIFEST) as writer,
        pytest.raises(RecordingError, match="cannot name"),
    ):
        writer.append(name, block())


def test_a_directory_with_content_is_refused_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    BundleWriter(tmp_path / "run", MANIFEST).close()  # an empty one is fine

    with pytest.raises(RecordingError, match="has content"):
        BundleWriter(tmp_path / "run", MANIFEST)
    assert Bundle.open(tmp_path / "run").manifest == MANIFEST


def test_a_directory_below_a_file_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")

    with pytest.raises(RecordingError, match="cannot write"):
        BundleWriter(tmp_path / "file" / "run", MANIFEST)
    with pytest.raises(RecordingError, match="cannot write"):
        BundleWriter(tmp_path / "file", MANIFEST)


def test_nothing_is_added_to_a_finished_bundle(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.finish()
        with pytest.raises(RecordingError, match="is closed"):
            writer.append("capture", block())
        with pytest.raises(RecordingError, match="is closed"):
            writer.finish()


def test_measurements_that_json_cannot_hold_are_refused(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block())
        with pytest.raises(RecordingError, match=r"measurements\.json.*write null"):
            writer.finish({"thd": {"value": float("nan")}})

    assert not Bundle.open(tmp_path / "run").complete


def test_what_is_not_a_bundle_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="is not a run bundle"):
        Bundle.open(tmp_path)
    with pytest.raises(RecordingError, match="absent does not exist: give the folder of a run"):
        Bundle.open(tmp_path / "absent")


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        ("{", "is not JSON"),
        ("\x00\ud800", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ("[]", "holds a list"),
        ({"schema_version": 4}, "schema version 4, this benchtool reads 1, 2, 3"),
        ({"schema_version": None}, "schema version None"),
        ({"seed": "x"}, "key 'seed'"),
        ({"colour": 1}, "key 'colour'"),
        ({"streams": {"capture": {"rows": 1}}}, r"key 'streams\.capture\.gaps'"),
    ],
)
def test_a_corrupt_manifest_is_one_line(tmp_path: Path, change: str | dict[str, Any], seen: str) -> None:
    cut_short(tmp_path / "run", block())
    path = tmp_path / "run" / "manifest.json"
    if isinstance(change, str):
        path.write_bytes(change.encode("utf-8", "surrogatepass"))
    else:
        path.write_text(json.dumps(json.loads(path.read_text()) | change))

    with pytest.raises(RecordingError, match=seen) as refused:
        Bundle.open(tmp_path / "run")
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 500


def test_a_stream_that_is_not_there_is_refused_with_those_that_are(tmp_path: Path) -> None:
    cut_short(tmp_path / "run", block())

    with pytest.raises(RecordingError, match="no stream 'slow', it has: capture"):
        Bundle.open(tmp_path / "run").block("slow")


@pytest.mark.parametrize("content", [b"", b"garbage", b"PAR1" + bytes(100) + b"PAR1", None])
def test_a_data_file_that_is_not_ours_is_one_line(tmp_path: Path, content: bytes | None) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block())
        bundle = writer.finish()
    path = tmp_path / "run" / "data" / "capture.parquet"
    if content is None:
        parquet.write_table(pa.table({"x": [1.0]}), path)
    else:
        path.write_bytes(content)

    with pytest.raises(RecordingError, match=r"capture\.parquet") as refused:
        bundle.block("capture")
    assert "\n" not in str(refused.value)


def test_a_data_file_that_was_deleted_is_one_line(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block())
        bundle = writer.finish()
    (tmp_path / "run" / "data" / "capture.parquet").unlink()

    with pytest.raises(RecordingError, match=r"cannot read .*capture\.parquet: No such file"):
        Bundle.open(tmp_path / "run").block("capture")
    assert bundle.plots == tmp_path / "run" / "plots"


def test_the_manifest_is_readable_text_with_its_versions(tmp_path: Path) -> None:
    cut_short(tmp_path / "run", block())

    text = (tmp_path / "run" / "manifest.json").read_text(encoding="utf-8")
    assert "ψ" in text
    assert {"benchtool", "python", "numpy", "pyarrow"} <= json.loads(text)["versions"].keys()


def test_a_failure_to_write_names_its_remedy(tmp_path: Path) -> None:
    with (
        pytest.raises(RecordingError, match="its folder does not exist"),
        writing(tmp_path / "no" / "a.toml"),
    ):
        (tmp_path / "no" / "a.toml").write_text("", encoding="utf-8")
    with pytest.raises(RecordingError, match="that you may write to"), writing(tmp_path):
        raise PermissionError(13, "Permission denied")
