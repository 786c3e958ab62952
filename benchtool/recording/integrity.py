"""Whether the files of a recording are what they were when they were written, by size and SHA-256.

A bundle's manifest has the hashes of its files and a seal of its own; figures and reports that are added
later are entered into it. A folder of several bundles has `hashes.json` for what was made of all of them. Of
a bundle whose process was killed, `data/checkpoints.log` says how far each file was acknowledged.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from pydantic import Field, ValidationError

from benchtool.document import Section
from benchtool.errors import RecordingError
from benchtool.recording.checkpoints import CHECKPOINTS, intact_prefix, read_checkpoints
from benchtool.recording.files import PART
from benchtool.recording.manifest import MANIFEST, Manifest, read_manifest, write_manifest
from benchtool.recording.seal import SEAL, FileHash, hash_of, read_sealed_json, write_json
from benchtool.recording.stream import DATA, FINISHED, RUNNING

HASHES: Final = "hashes.json"
_DRAWN: Final = (".png", ".html", ".pdf", ".md")
_MISSING: Final = "No such file"
_DIFFERS: Final = "its SHA-256 is not that of what was written"
_OWN: Final = (MANIFEST, HASHES, CHECKPOINTS.as_posix())


@dataclass(frozen=True)
class Integrity:
    """What a check has found; paths are relative to the folder that was checked.

    `damaged` has the reason for each file, half a sentence. `unlisted` files are beside the recording and
    nothing is known of them. `extents` is how many bytes of the files of a bundle under way are acknowledged.
    Of what is not `sealed`, recorded by an older version, nothing can be said.
    """

    sealed: bool
    damaged: Mapping[str, str] = field(default_factory=dict)
    unlisted: tuple[str, ...] = ()
    extents: Mapping[str, int] = field(default_factory=dict)


class _Hashes(Section):
    files: dict[str, FileHash] = Field(default_factory=dict)


def verify(folder: Path) -> Integrity:
    """Check every file of a bundle, or of a folder of bundles and what was made of them.

    Raises:
        RecordingError: the folder holds no recording.
    """
    if (folder / MANIFEST).is_file():
        try:
            return check_bundle(folder, *read_manifest(folder), drawn=True)
        except RecordingError as reason:
            return Integrity(sealed=True, damaged={MANIFEST: str(reason)})
    bundles = [
        path.parent for path in sorted((*folder.glob(f"*/{MANIFEST}"), *folder.glob(f"*/*/{MANIFEST}")))
    ]
    if not bundles:
        raise RecordingError(f"{folder} holds no run bundle: give the folder of a run")
    places = dict.fromkeys((folder, *(bundle.parent for bundle in bundles)))
    found = {
        **{bundle: verify(bundle) for bundle in bundles},
        **{place: _check_made(place) for place in places},
    }
    return Integrity(
        all(each.sealed for each in found.values()),
        {
            (place / name).relative_to(folder).as_posix(): reason
            for place, each in found.items()
            for name, reason in each.damaged.items()
        },
        tuple(
            (place / name).relative_to(folder).as_posix()
            for place, each in found.items()
            for name in each.unlisted
        ),
    )


def check_bundle(directory: Path, manifest: Manifest, sealed: bool, *, drawn: bool = False) -> Integrity:
    """Check the files of one bundle by its manifest.

    Args:
        directory: of the bundle.
        manifest: its manifest, whose seal was checked.
        sealed: whether there was one.
        drawn: look at figures and reports as well, on which nothing rests that is computed.

    Raises:
        RecordingError: a file cannot be read, or the checkpoints are damaged.
    """
    if not sealed:
        return Integrity(sealed=False)
    if not manifest.files and not manifest.complete:
        return _check_running(directory)
    wanted = {name: each for name, each in manifest.files.items() if drawn or not _is_drawn(name)}
    damaged = dict(_differing(directory, wanted))
    unlisted = [name for name in _names(directory) if name not in manifest.files and name not in _OWN]
    for name in unlisted:
        if name.startswith(f"{DATA}/") and name.endswith((RUNNING, FINISHED)):
            damaged[name] = "it was not there when the recording was finished"
    return Integrity(True, damaged, tuple(name for name in unlisted if name not in damaged))


def enlist(folder: Path, paths: Iterable[Path]) -> None:
    """Enter files that were made of a recording into its manifest, or into the hashes of a folder of several.

    Files elsewhere are left alone, and so is a bundle that is not sealed.

    Raises:
        RecordingError: a file cannot be read, or the hashes cannot be written.
    """
    inside = [path for path in paths if path.resolve().is_relative_to(folder.resolve())]
    files = {path.resolve().relative_to(folder.resolve()).as_posix(): hash_of(path) for path in inside}
    if not files:
        return
    if not (folder / MANIFEST).is_file():
        document = _Hashes(files=_hashes(folder) | files).model_dump()
        write_json(folder / HASHES, document, sealed=True)
        return
    manifest, sealed = read_manifest(folder)
    if sealed and (manifest.files or manifest.complete):
        write_manifest(folder, manifest.model_copy(update={"files": manifest.files | files}))


def files_of(directory: Path) -> dict[str, Path]:
    """Files of a bundle by their names within it, without those that say what the others are."""
    return {name: directory / name for name in _names(directory) if name not in _OWN}


def _check_made(folder: Path) -> Integrity:
    """Check what was made of the bundles within a folder."""
    try:
        files = _hashes(folder)
    except RecordingError as reason:
        return Integrity(sealed=True, damaged={HASHES: str(reason)})
    made = (path for pattern in ("*", "plots/*") for path in sorted(folder.glob(pattern)) if path.is_file())
    names = (path.relative_to(folder).as_posix() for path in made)
    unlisted = tuple(name for name in names if name not in files and name != HASHES)
    return Integrity(True, dict(_differing(folder, files)), unlisted)


def _check_running(directory: Path) -> Integrity:
    """By the checkpoints: what is acknowledged of each file is what was written."""
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
    return Integrity(True, damaged, tuple(names), extents)


def _was_replaced(directory: Path, name: str, states: Mapping[str, object]) -> bool:
    """Whether the process ended between two steps of finishing: one form of a stream stands for the other."""
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
            f"{path} does not fit its seal, it was damaged or changed: write the report again"
        )
    return hashes.files


def _names(directory: Path) -> list[str]:
    found = (path for path in sorted(directory.rglob("*")) if path.is_file() and PART not in path.suffixes)
    return [path.relative_to(directory).as_posix() for path in found]


def _is_drawn(name: str) -> bool:
    return not name.startswith(f"{DATA}/") and name.endswith(_DRAWN)
