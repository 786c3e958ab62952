"""Verification of recorded runs: every file by its hash, every number by measuring the raw data again."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from benchtool import __version__
from benchtool.analysis import measurements_to_json, tables_to_json
from benchtool.errors import AnalysisError, NoSuchRecording, RecordingError
from benchtool.file_kinds import FileKind, mistaken
from benchtool.recording import HASHES, MANIFEST, SESSION, Bundle, bundles_in, verify
from benchtool.results.assessment import Assessment
from benchtool.results.case_assessment import assess_bundle
from benchtool.results.incomplete import cut_short
from benchtool.results.runs import incomplete_runs, is_planned
from benchtool.results.sessions import differing_verdicts, read_session
from benchtool.results.tables import assess_table_again, is_measurable

_KEPT: Final = (MANIFEST, HASHES)


@dataclass(frozen=True)
class Verification:
    """Result of a verification; paths are relative to the folder.

    `damaged` files differ from their hashes, or have none that could be read; `different` results, by bundle
    and name, are not what the raw data give. `recomputed` counts the results that were measured again to the
    bit, and `files` those that fit their hashes. `not_recomputed` says of a bundle why its results were not.
    `unlisted` files have no hash. `incomplete` says of the runs that did not come to their end what is there.
    """

    folder: Path
    files: int
    recomputed: int
    damaged: Mapping[str, str]
    different: Mapping[str, str]
    not_recomputed: Mapping[str, str]
    unlisted: tuple[str, ...]
    sealed: bool
    incomplete: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether nothing was found: every file fits a hash, and every result its data."""
        return self.sealed and not self.damaged and not self.different


def verify_run(place: Path) -> Verification:
    """Verify a bundle, a folder of bundles, or a document that was written of them.

    Args:
        place: folder of one run or of several cases or plans; or a report, a figure or another file in it,
            which must have a hash there.

    Raises:
        RecordingError: there is no recording.
    """
    folder = place
    if place.is_file():
        above = list(place.parents)[:2]
        kept = [each for each in above if any((each / name).is_file() for name in _KEPT)]
        if not kept:
            why = f"{place} lies in no folder of a run: give that folder, or a document in it"
            raise NoSuchRecording(mistaken(place, FileKind.RUN) or why)
        folder = kept[0]
    integrity = verify(folder)
    damaged = dict(integrity.damaged)
    if folder != place and (name := place.relative_to(folder).as_posix()) in integrity.unlisted:
        damaged[name] = "it has no hash in its folder, so that it cannot be told from another: write it again"
    recomputed = 0
    different: dict[str, str] = {}
    not_recomputed: dict[str, str] = {}
    if (folder / SESSION).is_file() and SESSION not in damaged:
        record = read_session(folder)
        wrong = dict(differing_verdicts(record))
        different |= wrong
        recomputed += sum(len(test.judged) for test in record.tests) - len(wrong)
    for directory in bundles_in(folder) if integrity.has_bundles else ():
        name = directory.relative_to(folder).as_posix()
        try:
            bundle = Bundle.open(directory)
            if not bundle.complete and not bundle.measurements:
                not_recomputed[name] = f"it was cut short ({cut_short(bundle)}), and has no results"
                continue
            if is_planned(bundle) and "capture" in bundle.streams:
                found = assess_bundle(bundle)
            elif is_measurable(bundle):
                found = assess_table_again(bundle)
            else:
                not_recomputed[name] = (
                    "it has no capture of a plan and no table: its files were compared with their hashes"
                )
                continue
        except (RecordingError, AnalysisError) as failed:
            not_recomputed[name] = str(failed)
            continue
        stored = _stored(bundle)
        fresh = _fresh(found)
        recomputed += sum(stored.get(key) == value for key, value in fresh.items())
        by = bundle.manifest.versions.get("benchtool", "an unknown version")
        for key in _differing(stored, fresh):
            with_ = "" if by == __version__ else f" (recorded with benchtool {by}, this is {__version__})"
            different[key if name == "." else f"{name}: {key}"] = f"{_difference(stored, fresh, key)}{with_}"
    checked = integrity.compared - len(damaged)
    unfinished = integrity.has_bundles and not (folder / SESSION).is_file() and not damaged
    return Verification(
        folder,
        checked,
        recomputed,
        damaged,
        different,
        not_recomputed,
        integrity.unlisted,
        integrity.sealed,
        incomplete_runs(folder) if unfinished else (),
    )


def _stored(bundle: Bundle) -> dict[str, str]:
    return _texts(bundle.measurements, bundle.tables, bundle.manifest.verdict)


def _fresh(found: Assessment) -> dict[str, str]:
    return _texts(measurements_to_json(found.measurements), tables_to_json(found.tables), str(found.verdict))


def _texts(measurements: Mapping[str, Any], tables: Mapping[str, Any], verdict: str | None) -> dict[str, str]:
    """Return the results as JSON texts, in which floats have every bit."""
    results = {
        **measurements,
        **{f"table {name}": table for name, table in tables.items()},
        "verdict": verdict,
    }
    return {name: json.dumps(result, sort_keys=True) for name, result in results.items()}


def _differing(stored: Mapping[str, str], fresh: Mapping[str, str]) -> Iterator[str]:
    yield from (name for name in {**stored, **fresh} if stored.get(name) != fresh.get(name))


def _difference(stored: Mapping[str, str], fresh: Mapping[str, str], name: str) -> str:
    if name not in stored:
        return "the data give it, and it is not stored"
    if name not in fresh:
        return "it is stored, and the data do not give it"
    was, is_ = (json.loads(each[name]) for each in (stored, fresh))
    if isinstance(was, dict) and isinstance(is_, dict) and was.get("value") != is_.get("value"):
        return f"stored is {was.get('value')} {was.get('unit', '')}, the data give {is_.get('value')}"
    if name == "verdict":
        return f"stored is {was}, the data give {is_}"
    return "what is stored beside its value is not what the data give"
