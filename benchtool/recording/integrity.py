"""Integrity of the files of a recording, by size and SHA-256.

A bundle's manifest has the hashes of its files and a seal of its own, and is not touched after that. Files
made later, such as figures and reports, have their hashes in `hashes.json` in the same folder. In a folder of
several bundles that has those of their manifests, too, so that a bundle that was taken away is missed. If the
process was killed, `data/checkpoints.log` states how far each file was acknowledged.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from pydantic import Field, ValidationError

from benchtool.document import Section
from benchtool.errors import NoSuchRecording, RecordingError
from benchtool.recording.checkpoints import CHECKPOINTS, intact_prefix, read_checkpoints
from benchtool.recording.files import PART
from benchtool.recording.manifest import MANIFEST, Manifest, read_manifest
from benchtool.recording.seal import SEAL, FileHash, hash_of, read_sealed_json, write_json
from benchtool.recording.stream_file import DATA, FINISHED, RUNNING

HASHES: Final = "hashes.json"
COMMISSIONING: Final = "commissioning.json"
"""What a commissioning found, in its folder."""
SESSION: Final = "session.json"
"""The record of an acceptance session, in its folder."""

_MISSING: Final = "No such file"
_UNSEALED: Final = f"it has no hash in {HASHES}, so that it cannot be told from another"
_DIFFERS: Final = "its SHA-256 differs from that of the recorded file"
_BEFORE_ANOTHER: Final = (
    "new hashes would hide that, so nothing is written; restore it from a copy, move it away, or write "
    "elsewhere"
)
_DOCUMENTS: Final = (COMMISSIONING, SESSION)
_OWN: Final = (MANIFEST, HASHES, CHECKPOINTS.as_posix())


@dataclass(frozen=True)
class Integrity:
    """Result of a check; paths are relative to the folder that was checked.

    `damaged` has the reason for each file, half a sentence. `unlisted` files lie beside the recording without
    a hash. `extents` is the acknowledged size of files that may be longer. Bundles that are not `sealed`, of
    an older version, cannot be checked. A folder of an acceptance session may have no bundles.
    """

    sealed: bool
    damaged: Mapping[str, str] = field(default_factory=dict)
    unlisted: tuple[str, ...] = ()
    extents: Mapping[str, int] = field(default_factory=dict)
    compared: int = field(default=0, compare=False)
    has_bundles: bool = field(default=True, compare=False)


class _Hashes(Section):
    files: dict[str, FileHash] = Field(default_factory=dict)


def verify(folder: Path) -> Integrity:
    """Check every file of a bundle, or of a folder of bundles, and files made of them.

    Raises:
        RecordingError: the folder holds no recording.
    """
    bundles = [] if _has_documents_alone(folder) else bundles_in(folder)
    above = [] if folder in bundles else dict.fromkeys((folder, *(bundle.parent for bundle in bundles)))
    found = [(bundle, _check_recorded(bundle)) for bundle in bundles]
    made = [(place, _check_made(place)) for place in (*bundles, *above)]

    def name(place: Path, within: str) -> str:
        return (place / within).relative_to(folder).as_posix()

    damaged = {
        name(place, file): reason for place, each in (*found, *made) for file, reason in each.damaged.items()
    }
    known = {name(place, file) for place, each in made for file in each.extents}
    unlisted = {name(place, file) for place, each in (*found, *made) for file in each.unlisted}
    sealed = all(each.sealed for _, each in found)
    compared = sum(each.compared for _, each in (*found, *made)) - sum(
        name(bundle, MANIFEST) in known for bundle in bundles
    )
    return Integrity(
        sealed, damaged, tuple(sorted(unlisted - known)), compared=compared, has_bundles=bool(bundles)
    )


def _has_documents_alone(folder: Path) -> bool:
    """Return whether a folder has documents that are made of bundles, or hashes of them, and no bundle."""
    has_documents = any((folder / name).is_file() for name in (HASHES, *_DOCUMENTS))
    return has_documents and not _manifests(folder)


def _manifests(folder: Path) -> list[Path]:
    return sorted((*folder.glob(MANIFEST), *folder.glob(f"*/{MANIFEST}"), *folder.glob(f"*/*/{MANIFEST}")))


def bundles_in(folder: Path) -> list[Path]:
    """Return the folder if it is a bundle, and the bundles up to two levels below it.

    Raises:
        NoSuchRecording: there is none.
    """
    bundles = [path.parent for path in _manifests(folder)]
    if not bundles:
        there = "holds no run bundle" if folder.exists() else "does not exist"
        raise NoSuchRecording(f"{folder} {there}: give the folder of a run")
    return bundles


def check_bundle(directory: Path, manifest: Manifest, sealed: bool) -> Integrity:
    """Check the files of one bundle by its manifest, without files made later.

    Args:
        directory: of the bundle.
        manifest: its manifest, whose seal was checked.
        sealed: whether there was one.

    Raises:
        RecordingError: a file cannot be read, or the checkpoints are damaged.
    """
    if not sealed:
        return Integrity(sealed=False)
    if not manifest.files and not manifest.complete:
        return _check_running(directory)
    damaged = dict(_differing(directory, manifest.files))
    unlisted = [name for name in files_of(directory) if name not in manifest.files]
    for name in unlisted:
        if name.startswith(f"{DATA}/") and name.endswith((RUNNING, FINISHED)):
            damaged[name] = "it was not there when the recording was finished"
    others = tuple(name for name in unlisted if name not in damaged)
    return Integrity(True, damaged, others, compared=len(manifest.files) + 1)


def require_unchanged(folder: Path, paths: Iterable[Path]) -> None:
    """Require, before files are made in a folder, that those made there earlier are as they were written: new
    hashes would hide that one was changed. Files outside the folder are ignored, those taken away may be made
    again.

    Raises:
        RecordingError: one was changed, or the hashes cannot be read.
    """
    if _inside(folder, paths):
        _require_fitting(folder, _hashes(folder))


def require_listed(folder: Path, name: str) -> None:
    """Require that a file made of a recording is the one that was written, before it is read.

    Raises:
        RecordingError: it was changed, it has no hash, or the hashes cannot be read.
    """
    hashes = _hashes(folder)
    if name not in hashes:
        raise RecordingError(
            f"{folder / name} has no hash in {HASHES}, so that it cannot be told from another: restore both "
            f"from a copy"
        )
    _require_fitting(folder, {name: hashes[name]}, "restore it from a copy")


def enlist(folder: Path, paths: Iterable[Path]) -> None:
    """Store the hashes of files made of a recording in its folder; others are ignored. Of a folder among the
    paths they are those of the manifests of its bundles, which from then on belong to the recording.

    Raises:
        RecordingError: a file cannot be read, the hashes cannot be read or written, or another file does not
            fit its hash.
    """
    listed = itertools.chain.from_iterable(_manifests(path) if path.is_dir() else [path] for path in paths)
    inside = {name: path for name, path in _inside(folder, listed).items() if name != MANIFEST}
    files = {name: hash_of(path) for name, path in inside.items()}
    if files:
        _require_fitting(folder, {name: each for name, each in _hashes(folder).items() if name not in files})
        document = _Hashes(files=_hashes(folder) | files).model_dump()
        write_json(folder / HASHES, document, sealed=True)


def files_of(directory: Path) -> dict[str, Path]:
    """Return the files of a bundle by their names within it, without the files of hashes."""
    return {name: directory / name for name in _names(directory) if name not in _OWN}


def _check_recorded(bundle: Path) -> Integrity:
    try:
        return check_bundle(bundle, *read_manifest(bundle))
    except RecordingError as reason:
        return Integrity(sealed=True, damaged={MANIFEST: str(reason)}, compared=1)


def _check_made(folder: Path) -> Integrity:
    """Check the files made of the bundle or the bundles in a folder."""
    try:
        files = _hashes(folder)
    except RecordingError as reason:
        return Integrity(sealed=True, damaged={HASHES: str(reason)}, compared=1)
    made = (path for pattern in ("*", "plots/*") for path in sorted(folder.glob(pattern)) if path.is_file())
    names = (path.relative_to(folder).as_posix() for path in made)
    unlisted = () if (folder / MANIFEST).is_file() else tuple(name for name in names if name not in _OWN)
    sizes_B = {name: each.size_B for name, each in files.items()}
    compared = len(files) + (folder / HASHES).is_file()
    damaged = dict(_differing(folder, files)) | {
        name: _UNSEALED for name in _DOCUMENTS if name in unlisted and name not in files
    }
    return Integrity(True, damaged, unlisted, sizes_B, compared)


def _check_running(directory: Path) -> Integrity:
    """Check the acknowledged part of each file by the checkpoints."""
    states = read_checkpoints(directory)
    damaged, extents = {}, {}
    for name, noted in states.items():
        path = directory / name
        if path.is_file():
            prefix = intact_prefix(path, noted)
            if prefix is None:
                damaged[name] = _DIFFERS
            else:
                extents[name] = prefix.size_B
        elif not _was_replaced(directory, name, states):
            damaged[name] = _MISSING
    names = [name for name in _names(directory) if name not in _OWN and name not in states]
    return Integrity(True, damaged, tuple(names), extents, len(states))


def _inside(folder: Path, paths: Iterable[Path]) -> dict[str, Path]:
    """Return the paths within a folder by their names in it."""
    root = folder.resolve()
    inside = (path.resolve() for path in paths if path.resolve().is_relative_to(root))
    return {path.relative_to(root).as_posix(): path for path in inside}


def _require_fitting(folder: Path, files: Mapping[str, FileHash], remedy: str = _BEFORE_ANOTHER) -> None:
    there = {name: each for name, each in files.items() if (folder / name).exists()}
    for name, reason in _differing(folder, there):
        raise RecordingError(f"{folder / name} was changed after it was written ({reason}): {remedy}")


def _was_replaced(directory: Path, name: str, states: Mapping[str, object]) -> bool:
    """Return whether the process ended between two steps of finishing, when a stream exists in two forms."""
    path = directory / name
    other = path.with_suffix(FINISHED if path.suffix == RUNNING else RUNNING)
    return other.is_file() and other.relative_to(directory).as_posix() in states


def _differing(directory: Path, files: Mapping[str, FileHash]) -> Iterator[tuple[str, str]]:
    for name, recorded in files.items():
        path = directory / name
        if not path.is_file():
            yield name, _MISSING
            continue
        size_B = path.stat().st_size
        if size_B != recorded.size_B:
            yield name, f"it has {size_B} bytes, {recorded.size_B} were written"
        elif hash_of(path) != recorded:
            yield name, _DIFFERS


def _hashes(folder: Path) -> dict[str, FileHash]:
    path = folder / HASHES
    if not path.is_file():
        return {}
    document, fits = read_sealed_json(path)
    document.pop(SEAL, None)
    try:
        hashes = _Hashes.model_validate(document)
    except ValidationError:
        fits = False
    if not fits:
        raise RecordingError(
            f"{path} does not fit its seal, it was damaged or changed: restore it from a copy, or "
            f"move it away and write the report again"
        )
    return hashes.files


def _names(directory: Path) -> list[str]:
    found = (path for path in sorted(directory.rglob("*")) if path.is_file() and PART not in path.suffixes)
    return [path.relative_to(directory).as_posix() for path in found]
