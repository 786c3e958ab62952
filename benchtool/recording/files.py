"""Atomic files: written beside their place, flushed to the disk, and renamed."""

from __future__ import annotations

import mmap
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

from benchtool.errors import RecordingError
from benchtool.recording.failures import writing

PART = ".part"


@contextmanager
def replacing(path: Path, suffix: str = "") -> Iterator[Path]:
    """Yield a temporary file that replaces `path` when the `with` block ends without an error.

    Its name ends as that of `path` does, or in `suffix` for a writer that goes by that.

    The file at `path` is unchanged until then, and after a failure. A symbolic link stays, its target is
    replaced; a device or a pipe is written directly.

    Raises:
        RecordingError: it cannot be written.
    """
    with writing(path):
        target = path.resolve()
        if target.exists() and not target.is_file():
            yield target
            return
        part = target.with_name(f".{secrets.token_hex(8)}{PART}{suffix or target.suffix}")
        try:
            os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            if target.exists():
                part.chmod(target.stat().st_mode & 0o777)
            yield part
            flush_to_disk(part)
            part.replace(target)
        except BaseException:
            with suppress(OSError):
                part.unlink(missing_ok=True)
            raise


def write_whole(path: Path, content: bytes) -> None:
    """Write a file atomically: a reader sees the old or the new one.

    Raises:
        RecordingError: it cannot be written; the earlier file is unchanged.
    """
    with replacing(path) as part:
        part.write_bytes(content)


def require_free(path: Path) -> None:
    """Refuse a path that exists, for commands that do not overwrite; devices and pipes are accepted.

    Raises:
        RecordingError: a file or a folder is there.
    """
    if path.is_file() or path.is_dir():
        raise RecordingError(
            f"{path} exists, and this command overwrites nothing: choose another name or remove it"
        )


def require_empty(directory: Path) -> None:
    """Refuse a directory that a run cannot have to itself.

    Raises:
        RecordingError: it has content, or cannot be read.
    """
    if directory.is_file():
        raise RecordingError(
            f"cannot write {directory}: it is a file, and a run needs a directory: choose another name"
        )
    with writing(directory):
        if directory.is_dir() and any(directory.iterdir()):
            raise RecordingError(
                f"{directory} has content, a run is recorded into a directory of its own: choose another name"
            )


def require_file(path: Path) -> None:
    """Refuse a folder in place of a file to write.

    Raises:
        RecordingError: it is one.
    """
    if path.is_dir():
        raise RecordingError(f"{path} is a folder: name a file")


def require_own(path: Path, mark: bytes) -> None:
    """Refuse to replace a file that does not contain `mark`.

    Raises:
        RecordingError: the file lacks `mark`, or cannot be read.
    """
    require_file(path)
    if not path.is_file():
        return
    with writing(path), path.open("rb") as file:
        empty = not path.stat().st_size
        with nullcontext(b"") if empty else mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            found = content.find(mark) >= 0
    if not found:
        raise RecordingError(
            f"{path} exists and was not written by this command, so it is not overwritten: choose another "
            f"name or remove it"
        )


def flush_to_disk(path: Path) -> None:
    """Flush the file to the disk, so that the rename cannot precede its content."""
    file = os.open(path, os.O_RDONLY)
    try:
        os.fsync(file)
    finally:
        os.close(file)
