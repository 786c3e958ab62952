"""The manifest of a run bundle: what was run, with what, and how it ended."""

from __future__ import annotations

import platform
from functools import cache
from importlib import metadata
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Annotated, Any

from pydantic import Field, ValidationError, field_validator

from benchtool import __version__
from benchtool.document import Array, Section, defaults
from benchtool.errors import NoSuchRecording, RecordingError
from benchtool.file_kinds import FileKind, mistaken
from benchtool.recording.seal import SEAL, FileHash, read_sealed_json, write_json

SCHEMA_VERSION = 3
"""Of the bundles that are written. 1 had other names of measurements in its plan (`plan.former_names`), and
neither 1 nor 2 a column `time_s` in the Parquet files."""
READABLE = (1, 2, 3)
MANIFEST = "manifest.json"
MEASUREMENTS = "measurements.json"
CERTIFICATE = "certificate.json"
TABLES = "tables.json"

_LONGEST_NAME = 240
_SHOWN = 60
_BLANK = 32

_PACKAGES = ("canopen", "cantools", "matplotlib", "numba", "numpy", "pyarrow", "python-can", "scipy")


class StreamInfo(Section):
    """How complete one stream of the bundle is."""

    rows: int
    gaps: int
    missing_rows: int


class Conditions(Section):
    """Conditions of a test as the operator states them, not measured by benchtool; all are optional.

    `test_object_serial_number` is that of the motor, `instruments` name the instruments used, one each, with
    serial number or certificate. The temperature is that of the surroundings.
    """

    operator: str = ""
    test_object_serial_number: str = ""
    temperature_degC: Annotated[float, Field(ge=-273.15)] | None = None
    instruments: Array[str] = ()


class Manifest(Section):
    """Metadata of a run: everything except samples and results.

    `when` is the ISO 8601 wall time of the start, given by the caller, `note` and `conditions` are the
    operator's, `link` the address of the drive. `verdict`, `quality` (data-quality counters), `streams`,
    `files` (hashes by path within the bundle) and `complete` are known at the end; `details` takes whatever
    else is JSON.
    """

    what: str
    when: str
    profile_name: str = ""
    profile_toml: str = ""
    link: str = ""
    identity: dict[str, int | float | str] = Field(default_factory=dict)
    dictionary_hash: int | None = None
    parameters: dict[str, int | float | str] = Field(default_factory=dict)
    versions: dict[str, str] = Field(default_factory=dict)
    seed: int | None = None
    command_line: Array[str] = ()
    note: str = ""
    conditions: Conditions = defaults(Conditions)
    verdict: str | None = None
    quality: dict[str, int] = Field(default_factory=dict)
    details: dict[str, Any] = Field(default_factory=dict)
    streams: dict[str, StreamInfo] = Field(default_factory=dict)
    files: dict[str, FileHash] = Field(default_factory=dict)
    complete: bool = False
    schema_version: int = SCHEMA_VERSION

    @field_validator("streams", "files")
    @classmethod
    def _names_are_within_the_bundle(cls, named: dict[str, Any]) -> dict[str, Any]:
        """Refuse names that lead out of the folder of the bundle, or that no file can have."""
        for name in named:
            path = PurePosixPath(name)
            if path.is_absolute() or PureWindowsPath(name).drive or not path.parts or ".." in path.parts:
                raise ValueError(f"'{name[:_SHOWN]}' is no name within the bundle")
            if any(ord(each) < _BLANK for each in name) or len(name) > _LONGEST_NAME:
                raise ValueError(f"{name[:_SHOWN]!r} cannot be the name of a file")
        return named


def software_versions() -> dict[str, str]:
    """Return the versions of benchtool, Python and the packages that results depend on; in a checkout, its
    commit."""
    versions = {"benchtool": __version__, "python": platform.python_version()}
    versions |= {package: _version(package) for package in _PACKAGES}
    commit = checkout_commit(Path(__file__).resolve().parents[2])
    return versions if commit is None else versions | {"commit": commit}


@cache
def _version(package: str) -> str:
    return metadata.version(package)


def checkout_commit(root: Path) -> str | None:
    """Return commit that is checked out at `root`, read from git's own files; None if it is no checkout."""
    git = root / ".git"
    try:
        if git.is_file():  # a worktree's, which names its folder
            git = root / git.read_text(encoding="utf-8").removeprefix("gitdir:").strip()
        head = (git / "HEAD").read_text(encoding="utf-8").strip()
        if not head.startswith("ref:"):
            return head
        ref = head.removeprefix("ref:").strip()
        shared = git / "commondir"
        if shared.is_file():
            git = (git / shared.read_text(encoding="utf-8").strip()).resolve()
        if (git / ref).is_file():
            return (git / ref).read_text(encoding="utf-8").strip()
        packed = (git / "packed-refs").read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return None
    return next((line.split()[0] for line in packed if line.endswith(f" {ref}")), None)


def write_manifest(directory: Path, manifest: Manifest) -> None:
    """Write the manifest atomically: a reader sees the old or the new one.

    Raises:
        RecordingError: it cannot be written, or `details` holds what JSON cannot.
    """
    write_json(directory / MANIFEST, manifest.model_dump(), sealed=True)


def read_manifest(directory: Path) -> tuple[Manifest, bool]:
    """Return the manifest of the bundle in `directory`, and whether it has a seal: those of older versions
    have none.

    Raises:
        NoSuchRecording: there is none.
        RecordingError: it is not one of this schema version, or its seal does not fit.
    """
    path = directory / MANIFEST
    if not directory.exists():
        raise NoSuchRecording(f"{directory} does not exist: give the folder of a run")
    if not path.is_file():
        why = f"{directory} is not a run bundle: it has no {MANIFEST}; give the folder of a run"
        raise NoSuchRecording(mistaken(directory, FileKind.RUN) or why)
    document, fits = read_sealed_json(path)
    document.pop(SEAL, None)
    version = document.get("schema_version")
    if version not in READABLE:
        raise RecordingError(
            f"{path}: schema version {version!r}, this benchtool reads {', '.join(map(str, READABLE))}: "
            f"use the benchtool that recorded it"
        )
    try:
        manifest = Manifest.model_validate(document)
    except ValidationError as failed:
        first = failed.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise RecordingError(
            f"{path}: key '{key}': {first['msg'].lower()}; a manifest written by benchtool is expected: "
            f"restore it"
        ) from None
    if fits is False:
        raise RecordingError(
            f"{path} does not fit its seal, so it was damaged or changed since it was written: restore it "
            f"from a copy, or record again"
        )
    return manifest, fits is not None
