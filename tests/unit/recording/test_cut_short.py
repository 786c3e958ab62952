"""Bundles of runs that ended early: what was acknowledged is kept, and the failure is one line."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from benchtool.block import Gap
from benchtool.errors import RecordingError
from benchtool.recording import Bundle, BundleWriter
from tests.unit.recording.bundles import MANIFEST, assert_same, block, cut_short


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


def test_a_disk_that_fills_up_while_finishing_keeps_the_stream(tmp_path: Path) -> None:
    with BundleWriter(tmp_path / "run", MANIFEST) as writer:
        writer.append("capture", block())
        os.symlink("/dev/full", tmp_path / "run" / "data" / "capture.parquet.part")
        with pytest.raises(RecordingError, match=r"cannot write .*capture\.parquet: .*No space left"):
            writer.finish()

    assert_same(Bundle.open(tmp_path / "run").block("capture"), block())
