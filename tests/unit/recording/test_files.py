"""Documents are written atomically, and never replace other files."""

from __future__ import annotations

import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from benchtool.errors import RecordingError
from benchtool.recording.files import replacing, require_free, require_own, write_whole


@contextmanager
def _disk_of(size_B: int) -> Iterator[None]:
    """Let the operating system refuse every file longer than this."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size_B, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("before", [None, b"earlier"])
def test_a_disk_that_fills_up_leaves_what_was_there(tmp_path: Path, before: bytes | None) -> None:
    path = tmp_path / "report.html"
    if before is not None:
        path.write_bytes(before)
    with pytest.raises(RecordingError, match=r"cannot write .*report\.html: File too large"), _disk_of(1000):
        write_whole(path, bytes(100_000))
    assert [each.name for each in tmp_path.iterdir()] == ([] if before is None else ["report.html"])
    if before is not None:
        assert path.read_bytes() == before


def test_an_error_while_writing_leaves_nothing(tmp_path: Path) -> None:
    def written() -> None:
        with replacing(tmp_path / "a.csv", ".csv") as part:
            part.write_text("half", encoding="utf-8")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        written()
    assert list(tmp_path.iterdir()) == []


def test_content_is_on_the_disk_before_its_name_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, flushed = tmp_path / "report.html", list[tuple[int, bool]]()
    monkeypatch.setattr(os, "fsync", lambda file: flushed.append((os.fstat(file).st_size, path.exists())))
    write_whole(path, b"content")
    assert flushed == [(7, False)]
    assert path.read_bytes() == b"content"


def test_permissions_and_links_stay(tmp_path: Path) -> None:
    target, link = tmp_path / "real.html", tmp_path / "link.html"
    target.write_text("old", encoding="utf-8")
    target.chmod(0o640)
    link.symlink_to(target)
    write_whole(link, b"new")
    assert link.is_symlink()
    assert (target.read_bytes(), target.stat().st_mode & 0o777) == (b"new", 0o640)


def test_a_device_is_written_and_not_replaced(tmp_path: Path) -> None:
    write_whole(Path("/dev/null"), b"content")
    assert not Path("/dev/null").is_file()
    with pytest.raises(RecordingError, match="cannot write /dev/full: No space left"):
        write_whole(Path("/dev/full"), b"content")
    os.mkfifo(tmp_path / "pipe")
    require_free(tmp_path / "pipe")


def test_only_what_has_the_mark_may_be_replaced(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    require_own(path, b"mark")
    for content, is_own in (
        (b"", False),
        (b"mine", False),
        (b"x" * 100_000 + b"mark" + b"x" * 100_000, True),
    ):
        path.write_bytes(content)
        if is_own:
            require_own(path, b"mark")
        else:
            with pytest.raises(RecordingError, match="was not written by this command"):
                require_own(path, b"mark")
    with pytest.raises(RecordingError, match="is a folder"):
        require_own(tmp_path, b"mark")
    with pytest.raises(RecordingError, match="overwrites nothing"):
        require_free(path)
