"""A byte that changes in any file of a recording, finished, failed or killed, is found and named."""

from __future__ import annotations

import hashlib
import json
import random
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from benchtool.block import Block, Channel
from benchtool.errors import RecordingError
from benchtool.recording import (
    COMMISSIONING,
    SESSION,
    Bundle,
    BundleWriter,
    Event,
    EventFile,
    Manifest,
    enlist,
    require_listed,
    require_unchanged,
    verify,
)
from benchtool.recording.manifest import write_manifest
from benchtool.recording.seal import write_json

_ROWS = 40


def _block(first_tick: int = 0) -> Block:
    rows = np.random.default_rng(first_tick).standard_normal((_ROWS, 2))
    return Block((Channel("i_a", "A"), Channel("torque", "Nm")), first_tick, 1, 1e-4, rows)


def _begin(folder: Path) -> BundleWriter:
    writer = BundleWriter(folder, Manifest(what="ψ", when="2026-01-01T12:00:00+00:00", link="emulated"))
    events = EventFile(folder)
    for number in range(3):
        writer.append("capture", _block(number * _ROWS))
        events.append(Event(text=f"step {number}", tick=number))
    return writer


def _finished(folder: Path) -> None:
    with _begin(folder) as writer:
        (folder / "data" / "frames.log").write_text("(0.0) can0 181#00\n")
        writer.finish(
            {"ripple": {"value": 1.0, "unit": "Nm"}}, certificate={"complete": True}, tables={"t": {}}
        )
    (folder / "plots").mkdir()
    (folder / "plots" / "waveforms.png").write_bytes(b"picture")
    (folder / "report.html").write_bytes(b"page")
    enlist(folder, [folder / "plots" / "waveforms.png", folder / "report.html"])


def _failed(folder: Path) -> None:
    with _begin(folder) as writer:
        writer.fail("DriveFault: over-current", certificate={"complete": False})


def _killed(folder: Path) -> None:
    writer = _begin(folder)
    state = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    writer.close()  # whose writes the process did not live to make
    for path, content in state.items():
        path.write_bytes(content)


_KINDS = pytest.mark.parametrize("record", [_finished, _failed, _killed])


@_KINDS
def test_a_flipped_byte_in_any_file_is_found_and_named(
    record: Callable[[Path], None], tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    record(folder)
    assert verify(folder).sealed
    assert not verify(folder).damaged
    assert not verify(folder).unlisted
    chosen = random.Random(1)
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    assert len(files) >= 4
    for path in files:
        whole = path.read_bytes()
        places = [0, len(whole) - 1, *(chosen.randrange(len(whole)) for _ in range(98))]
        for place in places:
            damaged = bytearray(whole)
            damaged[place] ^= chosen.randrange(1, 256)
            path.write_bytes(damaged)
            found = verify(folder).damaged
            assert found, (path.name, place)
            assert path.name in " ".join((*found, *found.values()))
        path.write_bytes(whole)
    assert not verify(folder).damaged


@_KINDS
def test_a_byte_that_changed_in_the_data_is_never_read(
    record: Callable[[Path], None], tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    record(folder)
    (path,) = folder.glob("data/capture.*")
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    bundle = Bundle.open(folder)
    for read in (lambda: bundle.block("capture"), bundle.require_intact):
        with pytest.raises(RecordingError, match=rf"cannot read .*{path.name}: its SHA-256 differs"):
            read()
    assert len(bundle.events) == 3  # of another file


@_KINDS
def test_a_file_that_was_taken_away_is_missed(record: Callable[[Path], None], tmp_path: Path) -> None:
    folder = tmp_path / "run"
    record(folder)
    for path in sorted(folder.glob("data/*")):
        whole = path.read_bytes()
        path.unlink()
        if path.name != "checkpoints.log":
            assert f"data/{path.name}" in verify(folder).damaged
        path.write_bytes(whole)


def test_a_stream_that_was_put_there_is_not_taken_for_recorded(tmp_path: Path) -> None:
    _finished(tmp_path / "run")
    data = tmp_path / "run" / "data"
    (data / "other.parquet").write_bytes((data / "capture.parquet").read_bytes())
    with pytest.raises(RecordingError, match=r"other\.parquet: it was not there"):
        Bundle.open(tmp_path / "run").require_intact()


def test_a_file_beside_a_recording_is_no_damage(tmp_path: Path) -> None:
    _finished(tmp_path / "run")
    (tmp_path / "run" / "remarks.txt").write_text("cold")
    found = verify(tmp_path / "run")
    assert (found.damaged, found.unlisted) == ({}, ("remarks.txt",))
    Bundle.open(tmp_path / "run").require_intact()


def test_a_changed_picture_is_found_and_the_data_stay_readable(tmp_path: Path) -> None:
    _finished(tmp_path / "run")
    (tmp_path / "run" / "plots" / "waveforms.png").write_bytes(b"cropped")
    assert list(verify(tmp_path / "run").damaged) == ["plots/waveforms.png"]
    assert len(Bundle.open(tmp_path / "run").block("capture").data) == 3 * _ROWS


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60, deadline=None)
@given(cut=st.integers(0, 10_000))
def test_what_a_power_cut_left_is_read_up_to_the_last_checkpoint_that_it_reaches(
    cut: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("cut") / "run"
    _killed(folder)
    path = folder / "data" / "capture.arrows"
    whole = path.read_bytes()
    path.write_bytes(whole[: max(0, len(whole) - cut)])
    bundle = Bundle.open(folder)
    bundle.require_intact()
    try:
        read = bundle.block("capture")
    except RecordingError:
        assert bundle.integrity.extents["data/capture.arrows"] == 0
        return
    assert len(read.data) % _ROWS == 0
    np.testing.assert_array_equal(read.data[:_ROWS], _block().data)


def test_checkpoints_that_were_cut_short_still_hold_for_what_they_say(tmp_path: Path) -> None:
    _killed(tmp_path / "run")
    path = tmp_path / "run" / "data" / "checkpoints.log"
    whole = path.read_bytes()
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        assert not verify(tmp_path / "run").damaged


def test_a_process_that_ends_within_finishing_leaves_a_bundle_that_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(directory: Path, manifest: Manifest) -> None:
        raise KeyboardInterrupt

    writer = _begin(tmp_path / "run")
    monkeypatch.setattr("benchtool.recording.writer.write_manifest", killed)
    with pytest.raises(KeyboardInterrupt):
        writer.finish({})
    assert not verify(tmp_path / "run").damaged
    bundle = Bundle.open(tmp_path / "run")
    assert not bundle.complete
    assert len(bundle.block("capture").data) == 3 * _ROWS
    path = tmp_path / "run" / "data" / "capture.parquet"
    path.write_bytes(path.read_bytes()[:-1] + b"\0")
    with pytest.raises(RecordingError, match=r"capture\.parquet: its SHA-256"):
        Bundle.open(tmp_path / "run").block("capture")


def test_a_recording_of_an_older_version_is_read_and_nothing_is_said_of_its_files(tmp_path: Path) -> None:
    _finished(tmp_path / "run")
    path = tmp_path / "run" / "manifest.json"
    document = json.loads(path.read_text(encoding="utf-8"))
    for added in ("seal", "files", "link"):
        del document[added]
    write_json(path, document)
    bundle = Bundle.open(tmp_path / "run")
    assert not bundle.integrity.sealed
    assert len(bundle.block("capture").data) == 3 * _ROWS


def test_the_seal_is_the_hash_of_the_text_without_it(tmp_path: Path) -> None:
    write_manifest(tmp_path, Manifest(what="ψ", when="now"))
    text = (tmp_path / "manifest.json").read_text(encoding="utf-8")
    seal = json.loads(text)["seal"]
    assert hashlib.sha256(text.replace(seal, "").encode("utf-8")).hexdigest() == seal


def test_what_was_made_of_several_bundles_has_hashes_of_its_own(tmp_path: Path) -> None:
    for name in ("one", "two"):
        _finished(tmp_path / name)
    page, plot = tmp_path / "report.html", tmp_path / "plots" / "cases.png"
    plot.parent.mkdir()
    for path in (page, plot):
        path.write_bytes(b"drawn")
        enlist(tmp_path, [path])
    assert not verify(tmp_path).damaged
    for path in (page, plot, tmp_path / "hashes.json", tmp_path / "two" / "data" / "capture.parquet"):
        whole = path.read_bytes()
        path.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
        assert list(verify(tmp_path).damaged) == [path.relative_to(tmp_path).as_posix()]
        path.write_bytes(whole)
    with pytest.raises(RecordingError, match="holds no run bundle"):
        verify(plot.parent)


def test_a_bundle_that_belongs_to_a_folder_is_missed(tmp_path: Path) -> None:
    for name in ("one", "two/first"):
        _finished(tmp_path / name)
    without = verify(tmp_path).compared
    enlist(tmp_path, [tmp_path / "one", tmp_path / "two"])
    assert not verify(tmp_path).damaged
    assert verify(tmp_path).compared == without + 1  # each file once, and the hashes
    shutil.rmtree(tmp_path / "two")
    assert list(verify(tmp_path).damaged) == ["two/first/manifest.json"]
    shutil.rmtree(tmp_path / "one")
    assert len(verify(tmp_path).damaged) == 2


def test_a_lone_bundle_has_no_hash_of_its_manifest(tmp_path: Path) -> None:
    """Which has a seal, and bears the hashes of all others."""
    _finished(tmp_path)
    stored = (tmp_path / "hashes.json").read_bytes()
    enlist(tmp_path, [tmp_path])
    assert (tmp_path / "hashes.json").read_bytes() == stored


@pytest.mark.parametrize("name", [COMMISSIONING, SESSION])
def test_a_document_of_bundles_without_a_hash_is_not_told_from_another(tmp_path: Path, name: str) -> None:
    _finished(tmp_path / "one")
    (tmp_path / name).write_bytes(b"{}")
    assert "no hash" in verify(tmp_path).damaged[name]
    enlist(tmp_path, [tmp_path / name])
    assert not verify(tmp_path).damaged


def test_hashes_of_new_files_never_hide_that_another_was_changed(tmp_path: Path) -> None:
    page, picture = tmp_path / "report.html", tmp_path / "plots" / "waveforms.png"
    _finished(tmp_path)
    require_unchanged(tmp_path, [page])
    picture.write_bytes(b"cropped")
    stored = (tmp_path / "hashes.json").read_bytes()
    with pytest.raises(RecordingError, match=r"waveforms\.png was changed .*SHA-256 differs"):
        require_unchanged(tmp_path, [page])
    require_unchanged(tmp_path, [tmp_path.parent / "elsewhere.html"])
    page.write_bytes(b"another page")
    with pytest.raises(RecordingError, match="restore it from a copy, move it away"):
        enlist(tmp_path, [page])
    assert (tmp_path / "hashes.json").read_bytes() == stored
    picture.unlink()
    enlist(tmp_path, [page])
    assert list(verify(tmp_path).damaged) == ["plots/waveforms.png"]


def test_a_file_is_read_as_it_was_written_or_not_at_all(tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    _finished(tmp_path)
    require_listed(tmp_path, page.name)
    page.write_bytes(b"another page")
    with pytest.raises(RecordingError, match=r"report\.html was changed after it was written"):
        require_listed(tmp_path, page.name)
    with pytest.raises(RecordingError, match=r"remarks\.txt has no hash"):
        require_listed(tmp_path, "remarks.txt")
