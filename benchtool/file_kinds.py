"""What a file is that was given where another kind was expected, in a sentence with what to do with it."""

from __future__ import annotations

import itertools
import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Final

_MOST_BYTES: Final = 1 << 20  # of a file that is looked at
_MANIFEST: Final = "manifest.json"


class FileKind(StrEnum):
    """Kinds of files that a person gives to a command, as messages name them."""

    PLAN = "plan"
    PROFILE = "profile"
    BENCH = "bench file"
    PARAMETERS = "parameter file"
    WAIVERS = "file of waivers"
    EDS = "dictionary (EDS)"
    MANIFEST = "manifest of a recorded run"
    RUN = "folder of a recorded run"
    TABLE = "table of numbers"


_KEYS: Final[Mapping[FileKind, frozenset[str]]] = {
    FileKind.PLAN: frozenset(
        {"operating_point", "record", "setup", "sweep", "variants", "stimulus", "analyses"}
    ),
    FileKind.PROFILE: frozenset({"motor", "nameplate", "roles", "choices", "claims"}),
    FileKind.PARAMETERS: frozenset({"parameters"}),
    FileKind.WAIVERS: frozenset({"waiver"}),
}
"""Tables and keys at the top of a TOML document that no other kind has."""

_REMEDIES: Final[Mapping[FileKind, str]] = {
    FileKind.PLAN: "run it with 'benchtool run {path}'",
    FileKind.PROFILE: "run a plan with it, 'benchtool run PLAN --profile {path}', or write one, "
    "'benchtool plan new --profile {path}'",
    FileKind.BENCH: "copy its [bench] into a profile, or measure a table with it, "
    "'benchtool analyze --csv TABLE --bench {path}'",
    FileKind.PARAMETERS: "write it to a drive with 'benchtool params load {path}'",
    FileKind.WAIVERS: "give it as 'benchtool acceptance --waivers {path}'",
    FileKind.EDS: "name it in a profile, [drive] with eds = \"{path}\", or see 'benchtool info --eds {path}'",
    FileKind.MANIFEST: "its folder, {folder}, is for 'benchtool analyze', 'report' and 'compare'",
    FileKind.RUN: "measure it with 'benchtool analyze {path}'",
    FileKind.TABLE: "measure its columns with 'benchtool analyze --csv {path}'",
}

# no blanks but those of the line: of many empty ones each would be the first of all that follow
_SECTION_OF_AN_EDS: Final = re.compile(r"^[ \t]*\[(?:FileInfo|DeviceInfo)\]", re.IGNORECASE | re.MULTILINE)
_FEWEST_ROWS, _MOST_OF_ROWS = 2, 1 << 14  # characters at the end, by which rows are told


def kind_of(path: Path) -> FileKind | None:
    """Return what a file or folder is by what it holds; None if it is of no kind, of several, or cannot be
    read."""
    try:
        if path.is_dir():
            manifests = itertools.chain(path.glob(_MANIFEST), path.glob(f"*/{_MANIFEST}"))
            return FileKind.RUN if next(manifests, None) is not None else None
        if not path.is_file():  # a pipe would wait for its writer
            return None
        with path.open(encoding="utf-8") as file:
            text = file.read(_MOST_BYTES)
    except (OSError, UnicodeDecodeError):
        return None
    if _SECTION_OF_AN_EDS.search(text):
        return FileKind.EDS
    if text.lstrip().startswith("{"):
        return FileKind.MANIFEST if _is_manifest(text) else None
    try:
        content = tomllib.loads(text)
    except (ValueError, RecursionError):
        return FileKind.TABLE if _has_rows(text) else None
    found = [kind for kind, keys in _KEYS.items() if keys & content.keys()]
    if not found and "bench" in content:
        return FileKind.BENCH
    return found[0] if len(found) == 1 else None


def mistaken(path: Path, expected: FileKind) -> str:
    """Return that a file is of another kind than is expected, and what to do with it; empty if it is not, or
    of no kind that is known."""
    found = kind_of(path)
    if found is None or found is expected:
        return ""
    remedy = _REMEDIES[found].format(path=path, folder=path.parent)
    return f"{path} is a {found}, and a {expected} is expected: {remedy}"


def _has_rows(text: str) -> bool:
    """Return whether the last whole lines of a text are rows of numbers."""
    lines = [line for line in text[-_MOST_OF_ROWS:].splitlines() if line.strip()]
    if len(text) == _MOST_BYTES:
        del lines[-1:]  # it was cut
    last = lines[-_FEWEST_ROWS:]
    return len(last) == _FEWEST_ROWS and all(
        any(_are_numbers(line.split(between)) for between in (";", "\t", ",")) for line in last
    )


def _are_numbers(cells: Sequence[str]) -> bool:
    try:
        return len([float(cell.replace(",", ".")) for cell in cells]) > 1
    except ValueError:
        return False


def _is_manifest(text: str) -> bool:
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        return False
    return isinstance(content, dict) and {"what", "when"} <= content.keys()
