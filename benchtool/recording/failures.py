"""What the file system and the file formats raise, as errors of this project."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa

from benchtool.errors import RecordingError


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn a failure to write `path` into a RecordingError."""
    try:
        yield
    except (OSError, pa.ArrowException) as failure:
        raise RecordingError(
            f"cannot write {path}: {_reason(failure)}; a writable folder with free space is needed: "
            f"make space or choose another folder"
        ) from None


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn a failure to read `path` into a RecordingError."""
    try:
        yield
    except (OSError, pa.ArrowException) as failure:
        raise RecordingError(
            f"cannot read {path}: {_reason(failure)}; a file written by benchtool is expected: restore it or "
            f"record again"
        ) from None


def _reason(failure: Exception) -> str:
    text = failure.strerror if isinstance(failure, OSError) and failure.strerror else str(failure)
    return " ".join(text.split())[:200].rstrip(".")
