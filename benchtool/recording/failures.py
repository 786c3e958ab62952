"""Conversion of exceptions of the file system and of file formats to errors of this project."""

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
        raise RecordingError(f"cannot write {path}: {_reason(failure)}; {_remedy(failure)}") from None


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


def _remedy(failure: Exception) -> str:
    if isinstance(failure, FileNotFoundError):
        return "its folder does not exist: make that folder or choose another one"
    if isinstance(failure, PermissionError):
        return "a folder that you may write to is needed: choose another one"
    return "a writable folder with free space is needed: make space or choose another folder"


def _reason(failure: Exception) -> str:
    text = failure.strerror if isinstance(failure, OSError) and failure.strerror else str(failure)
    return " ".join(text.split())[:200].rstrip(".")
