"""SHA-256 of files, and JSON documents sealed by their own hash."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from pydantic import Field

from benchtool.document import Section
from benchtool.errors import RecordingError
from benchtool.recording.failures import reading
from benchtool.recording.files import write_whole

SEAL: Final = "seal"


class FileHash(Section):
    """Size and hash of a file when it was written."""

    size_B: int = Field(ge=0)
    sha256: str = Field(pattern=r"^[0-9a-f]{64}$")


def hash_of(path: Path) -> FileHash:
    """Return the size and SHA-256 of a file as it is now.

    Raises:
        RecordingError: it cannot be read.
    """
    with reading(path), path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        return FileHash(size_B=file.tell(), sha256=digest)


def write_json(path: Path, document: Mapping[str, Any], *, sealed: bool = False) -> None:
    """Write a document in one step, keys in their order, without nan and infinity.

    A `sealed` one ends with the key `seal`: the SHA-256 of its own text while that key is empty.

    Raises:
        RecordingError: it cannot be written or is not JSON.
    """
    try:
        text = _text({**document, SEAL: ""} if sealed else document)
    except (TypeError, ValueError) as failure:
        raise RecordingError(
            f"cannot write {path}: {failure}; numbers that are finite, text, lists and mappings are "
            f"expected: write null for what is undefined"
        ) from None
    if sealed:
        text = _text({**document, SEAL: hashlib.sha256(text.encode("utf-8")).hexdigest()})
    write_whole(path, text.encode("utf-8"))


def read_json(path: Path) -> dict[str, Any]:
    """Return the JSON mapping in a file.

    Raises:
        RecordingError: it cannot be read or is not a JSON mapping.
    """
    document, _ = read_sealed_json(path)
    return document


def read_sealed_json(path: Path) -> tuple[dict[str, Any], bool | None]:
    """Return the JSON mapping in a file, and whether its seal fits; None of a document without a seal.

    Raises:
        RecordingError: it cannot be read or is not a JSON mapping.
    """
    try:
        with reading(path):
            content = path.read_bytes()
        document = json.loads(content)
    except (ValueError, RecursionError) as failure:
        raise RecordingError(
            f"{path} is not JSON: {failure}; a file written by benchtool is expected: restore it"
        ) from None
    if not isinstance(document, dict):
        raise RecordingError(
            f"{path} holds a {type(document).__name__}, a JSON mapping is expected: restore the file"
        )
    if SEAL not in document:
        return document, None
    seal = str(document[SEAL]).encode("utf-8")
    head, _, tail = content.rpartition(b'"' + seal + b'"')
    fits = hashlib.sha256(head + b'""' + tail).hexdigest().encode() == seal
    return document, fits


def _text(document: Mapping[str, Any]) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
