"""What no bundle takes, and what is no bundle: one line that says so."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from pyarrow import parquet

from benchtool.block import Block
from benchtool.errors import RecordingError
from benchtool.recording import Bundle, BundleWriter
from benchtool.recording.failures import writing
from tests.unit.recording.bundles import CHANNELS, MANIFEST, block, cut_short


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


def test_a_failure_to_write_names_its_remedy(tmp_path: Path) -> None:
    with (
        pytest.raises(RecordingError, match="its folder does not exist"),
        writing(tmp_path / "no" / "a.toml"),
    ):
        (tmp_path / "no" / "a.toml").write_text("", encoding="utf-8")
    with pytest.raises(RecordingError, match="that you may write to"), writing(tmp_path):
        raise PermissionError(13, "Permission denied")
