"""Provenance in a report: the run, the drive, the data and the files."""

from __future__ import annotations

import hashlib
import itertools
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from benchtool.analysis import count_of, measurements_from_json, number, raw
from benchtool.block import Block
from benchtool.errors import BenchError
from benchtool.plan import JudgedLimit
from benchtool.profile import Choice, Profile
from benchtool.recording import MANIFEST, Bundle, Event, Level, Manifest, reading
from benchtool.report.content import Cell, Facts, Grid, Item, Section, Text
from benchtool.report.results import measurements_section

_RESULTS = (MANIFEST, "measurements.json", "tables.json", "certificate.json")
_SHOWN_EVENTS = 30


def run_facts(manifest: Manifest, plan_name: str = "") -> Facts:
    """Return facts of the run from the manifest; missing entries are left out."""
    identity, versions = manifest.identity, dict(manifest.versions)
    commit = versions.pop("commit", "")
    conditions = manifest.conditions
    temperature_degC = conditions.temperature_degC
    point = manifest.details.get("operating_point")
    words = manifest.command_line
    pairs = {
        "plan": plan_name,
        "begun": manifest.when,
        "profile": manifest.profile_name,
        "operating point": settings_line(point) if isinstance(point, dict) else "",
        "link": link_of(manifest),
        "drive": str(identity.get("device_name", "")),
        "drive's numbers": drive_numbers(identity),
        "hardware": str(identity.get("hardware_version", "")),
        "firmware": str(identity.get("firmware_version", "")),
        "dictionary": "" if manifest.dictionary_hash is None else f"0x{manifest.dictionary_hash:08X}",
        "seed": "" if manifest.seed is None else str(manifest.seed),
        "command line": f"benchtool {' '.join(words)}" if words else "",
        "operator": conditions.operator,
        "test object": conditions.test_object_serial_number,
        "temperature": "" if temperature_degC is None else f"{raw(temperature_degC)} °C",
        "instruments": "; ".join(conditions.instruments),
        "note": manifest.note,
        "software": ", ".join(f"{name} {version}" for name, version in versions.items()),
        "commit": commit,
    }
    return Facts(tuple((name, what) for name, what in pairs.items() if what))


def profile_of(manifest: Manifest) -> Profile | None:
    """Return the profile that a bundle carries; None if this version does not understand it."""
    return profile_of_text(manifest.profile_toml)


def profile_of_text(text: str) -> Profile | None:
    """Return the profile in a text; None if this version does not understand it."""
    try:
        return Profile.model_validate(tomllib.loads(text))
    except (ValueError, RecursionError):
        return None


def link_of(manifest: Manifest) -> str:
    """Return the address of the drive; as far as an older manifest tells."""
    emulated = manifest.identity.get("hardware_version") == "emulated"
    return manifest.link or _option(manifest.command_line, "--link") or "emulated" * emulated


def drive_numbers(identity: Mapping[str, object]) -> str:
    """Return the numbers of a drive's identity object, as far as they are known."""
    names = ("vendor_id", "product_code", "revision_number", "serial_number")
    known = (name for name in names if identity.get(name) is not None)
    return ", ".join(f"{name.replace('_', ' ')} {identity[name]}" for name in known)


def supervision_notes(manifests: Iterable[Manifest]) -> Iterator[Text]:
    """Yield the supervision of drives whose profile allows running without; each sentence once."""
    told: dict[str, bool] = {}
    for manifest in manifests:
        stated = manifest.details.get("supervision")
        if not isinstance(stated, dict):
            continue
        armed = stated.get("armed") is True
        told[
            "The profile lets the drive run without link supervision; it was supervised."
            if armed
            else "The drive ran without link supervision, as the profile allows: without its host it would "
            f"not have stopped by itself. Reason: {stated.get('reason')}."
        ] = armed
    for text, armed in told.items():
        yield Text(text, "note" if armed else "warning")


def _option(words: Sequence[str], name: str) -> str:
    for word, following in itertools.pairwise((*words, "")):
        if word == name:
            return following
        if word.startswith(f"{name}="):
            return word.partition("=")[2]
    return ""


def quality_section(bundle: Bundle, limits: Mapping[str, JudgedLimit]) -> Section:
    """Return the data-quality certificate: whether the data are complete, and each of its numbers."""
    certificate = bundle.certificate
    title = "Data quality"
    if certificate is None:
        return Section(title, (Text("The run ended before the quality of its data was known.", "warning"),))
    whole = bool(certificate.get("complete"))
    measured = measurements_from_json(certificate.get("measurements", {}))
    verdict = (
        Text("Complete: every row of every stream is there.")
        if whole
        else Text("Incomplete: rows are missing. Nothing was interpolated in their place.", "warning")
    )
    numbers = measurements_section("The certificate's numbers", measured, limits, {})
    return Section(title, (verdict, replace(numbers, paper=False)))


def events_section(events: Sequence[Event]) -> Section | None:
    """Return the log of a run: its steps, the drive's states and faults, at the drive's ticks; None without
    any."""
    if not events:
        return None
    rows = [
        (
            event.text,
            Cell(event.level.value, "fail" if event.level is Level.ERROR else ""),
            "–" if event.tick is None else number(event.tick),
        )
        for event in events
    ]
    return Section(
        "What happened",
        (Grid.of(("event", "level", ">tick of the drive"), rows, shown=_SHOWN_EVENTS),),
        paper=False,
    )


def parameters_section(
    parameters: Mapping[str, object], described: Mapping[str, tuple[str, str, object]], caption: str = ""
) -> Section:
    """Return the parameters of the drive during the run.

    Args:
        parameters: as the manifest keeps them.
        described: name, unit and default of a key, where the dictionary of the run is at hand.
    """
    rows = []
    for key, value in parameters.items():
        name, unit, default = described.get(key, (key, "", None))
        differs = default is not None and not _same(default, value)
        shown = "" if default is None else raw(default)
        rows.append((name, Cell(raw(value)), unit, shown, "differs" if differs else ""))
    if not rows:
        return Section("Drive parameters", (Text("The manifest contains none.", "note"),))
    if described:
        grid = Grid.of(("parameter", ">value", "unit", ">default", "from default"), rows, caption)
        *columns, told = grid.columns
        grid = replace(grid, columns=(*columns, replace(told, paper=False)))
    else:
        grid = Grid.of(("parameter, with its unit", ">value"), [row[:2] for row in rows], caption)
    return Section("Drive parameters", (grid,))


def _same(one: object, other: object) -> bool:
    if isinstance(one, int | float) and isinstance(other, int | float):
        return abs(one - other) <= 1e-6 * max(abs(one), abs(other))  # a drive holds 32-bit floats
    return one == other


def plan_section(plan: Mapping[str, Any]) -> Section:
    """Return every setting of a plan by its TOML key, without empty ones."""
    rows = [row for row in _settings(plan) if row[0] not in ("title", "readings")]
    items: list[Item] = [Grid.of(("key", "setting"), rows)]
    items += [Text(str(reading), "note") for reading in plan.get("readings", ())]
    return Section("Plan", tuple(items), paper=False)


def _settings(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _settings(value, f"{prefix}{key}.")
        elif value is None or value == "" or value == [] or value == ():
            continue
        elif isinstance(value, list | tuple):
            yield f"{prefix}{key}", ", ".join(_inline(each) for each in value)
        else:
            yield f"{prefix}{key}", raw(value)


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {what}" for key, what in _settings(value)) + " }"
    return raw(value)


def settings_line(table: Mapping[str, Any]) -> str:
    """Return the settings in one line, those that are zero left out."""
    return ", ".join(f"{key} = {value}" for key, value in _settings(table) if value != "0")


def choices_section(choices: Sequence[Choice]) -> Section | None:
    """Return the open points of the profile's sources, with the choices and reasons."""
    if not choices:
        return None
    rows = [(each.about, each.choice, each.reason, each.effect) for each in choices]
    return Section(
        "Choices of the profile", (Grid.of(("about", "choice", "reason", "effect"), rows),), paper=False
    )


def files_section(
    bundles: Iterable[tuple[str, Bundle, Mapping[str, Block]]],
    commands: Sequence[str],
    by: str = "the plan that the bundle carries",
) -> Section:
    """Return how to compute everything again: commands, files with their SHA-256, and columns of the streams.

    Args:
        bundles: with a prefix for the names of their files, and those of their streams that were read.
        commands: lines to type.
        by: by which the numbers were computed.

    Raises:
        RecordingError: a file cannot be read.
    """
    files: list[tuple[str, ...]] = []
    streams: dict[tuple[str, str], None] = {}
    for prefix, bundle, read in bundles:
        for path in _files(bundle):
            relative = path.relative_to(bundle.directory).as_posix()
            size = number(path.stat().st_size)
            files.append((f"{prefix}{relative}", size, _sha256(path)))
        for name in bundle.streams:
            streams[f"{prefix}data/{name}", _columns(bundle, name, read)] = None
    several = sum(row[0].endswith(MANIFEST) for row in files) > 1
    lines = [Text(line, "code") for line in commands]
    return Section(
        "How to compute this again",
        (
            Text(f"Every number above is computed from the recorded data by {by}:"),
            *lines,
            Section(
                "What the data files hold",
                (Grid.of(("stream", "rate, rows: columns"), list(streams)),),
                paper=False,
            ),
            *_hashes(files, several),
        ),
    )


def _hashes(files: Sequence[tuple[str, ...]], several: bool) -> Iterator[Item]:
    """Yield the files by their SHA-256; of `several` bundles on paper the manifests alone, which have those
    of the others."""
    headings = ("file", ">bytes", "SHA-256")
    every = Grid.of(headings, files, "The files that this report was made from.")
    if not several:
        yield every
        return
    manifests = [row for row in files if row[0].endswith(MANIFEST)]
    yield Grid.of(
        headings, manifests, "The manifests, each with the SHA-256 of the other files of its bundle."
    )
    yield Section("All files", (every,), paper=False)


def _columns(bundle: Bundle, name: str, read: Mapping[str, Block]) -> str:
    try:
        block = read[name] if name in read else bundle.block(name)
    except BenchError as unreadable:
        return str(unreadable)
    columns = ", ".join(f"{each.name} ({each.unit})" if each.unit else each.name for each in block.channels)
    return f"{raw(block.sample_rate_Hz)} Hz, {count_of(len(block.data), 'row')}: {columns}"


def _files(bundle: Bundle) -> list[Path]:
    data = bundle.directory / "data"
    results = [bundle.directory / name for name in _RESULTS]
    with reading(data):
        recorded = sorted(path for path in data.iterdir() if path.is_file() and path.suffix != ".part")
    return [*(path for path in results if path.is_file()), *recorded]


def _sha256(path: Path) -> str:
    with reading(path), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
