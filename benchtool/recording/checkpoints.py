"""Checkpoints of a recording in progress: SHA-256 of the acknowledged part of each file.

`data/checkpoints.log` has a line for each write: the hash, how many bytes it is of, the file, and a CRC-32 of
the line. It is there while a run is recorded, and after the process was killed; a bundle that was closed has
its hashes in the manifest.
"""

from __future__ import annotations

import hashlib
import io
import threading
import zlib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from benchtool.errors import RecordingError
from benchtool.recording.failures import reading, writing
from benchtool.recording.seal import FileHash

CHECKPOINTS: Final = Path("data", "checkpoints.log")
_CHUNK_B: Final = 1 << 20
_NOTHING: Final = FileHash(size_B=0, sha256=hashlib.sha256().hexdigest())


class Checkpoints:
    """Appends to the checkpoints of a bundle, from any thread."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._path = directory / CHECKPOINTS
        self._lock = threading.Lock()

    def note(self, path: Path, state: FileHash) -> None:
        """Note that the first bytes of the file at `path`, within the bundle, are with the operating system.

        Raises:
            RecordingError: it cannot be written.
        """
        name = path.relative_to(self._directory).as_posix()
        line = f"{state.sha256} {state.size_B} {name}".encode()
        with self._lock, writing(self._path), self._path.open("ab") as file:
            file.write(b"%s %08x\n" % (line, zlib.crc32(line)))

    def end(self) -> None:
        """Remove the file, as the manifest has the hashes now.

        Raises:
            RecordingError: it cannot be removed.
        """
        with writing(self._path):
            self._path.unlink(missing_ok=True)


class HashedFile(io.BufferedIOBase):
    """A binary file that is written from its beginning to its end, and hashed meanwhile."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = path.open("wb")
        self._hash = hashlib.sha256()
        self._size_B = 0

    @property
    def state(self) -> FileHash:
        """Hash of everything written."""
        return FileHash(size_B=self._size_B, sha256=self._hash.hexdigest())

    def writable(self) -> bool:
        return True

    def write(self, data: bytes | bytearray | memoryview) -> int:  # type: ignore[override] # as mypy has Buffer
        content = memoryview(data).cast("B")
        self._file.write(content)
        self._hash.update(content)
        self._size_B += len(content)
        return len(content)

    def tell(self) -> int:
        return self._size_B

    def flush(self) -> None:
        if not self._file.closed:
            self._file.flush()

    def close(self) -> None:
        try:
            self._file.close()
        finally:
            super().close()


def read_checkpoints(directory: Path) -> Mapping[str, Sequence[FileHash]]:
    """Return the states of each file of a bundle, in the order in which they were noted; empty for a bundle
    without checkpoints.

    Raises:
        RecordingError: they cannot be read, or a line other than a last one that was cut short is damaged.
    """
    path = directory / CHECKPOINTS
    with reading(path):
        lines = path.read_bytes().split(b"\n") if path.is_file() else [b""]
    *whole, last = lines
    if _is_whole(last[:-1]):  # a damaged line feed
        whole.append(last)
    states: dict[str, list[FileHash]] = defaultdict(list)
    for number, line in enumerate(whole, start=1):
        if not _is_whole(line):
            raise RecordingError(
                f"{path}, line {number}: its CRC-32 does not fit, the file was damaged since it was written: "
                f"restore it from a copy"
            )
        sha256, size_B, name = line.rpartition(b" ")[0].decode().split(" ", 2)
        states[name].append(FileHash(size_B=int(size_B), sha256=sha256))
    return states


def _is_whole(line: bytes) -> bool:
    content, _, check = line.rpartition(b" ")
    return check == b"%08x" % zlib.crc32(content)


def intact_prefix(path: Path, states: Sequence[FileHash]) -> FileHash | None:
    """Return the longest state that the file is long enough for, if the file begins with it.

    Raises:
        RecordingError: the file cannot be read.
    """
    with reading(path), path.open("rb") as file:
        there_B = path.stat().st_size
        fitting = [each for each in states if each.size_B <= there_B]
        longest = max(fitting, key=lambda each: each.size_B, default=_NOTHING)
        digest, left_B = hashlib.sha256(), longest.size_B
        while left_B and (chunk := file.read(min(left_B, _CHUNK_B))):
            digest.update(chunk)
            left_B -= len(chunk)
    return longest if digest.hexdigest() == longest.sha256 else None
