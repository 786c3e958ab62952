"""Check that a resumed run has the same provenance as the existing cases."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from benchtool.bench.wires import FarEnd, registry
from benchtool.drive import Identity
from benchtool.errors import UsageError
from benchtool.plan import Case, Plan, cases, recorded_plan
from benchtool.recording import Bundle, Manifest

_NONE: Final = "none"


@dataclass(frozen=True)
class Provenance:
    """Provenance of a run; None for what is not known yet."""

    plan: Plan
    link: str
    seed: int
    profile_toml: str | None = None
    identity: Identity | None = None
    parameters: Mapping[str, int | float | str] | None = None


def case_folder(plan: Plan, case: Case, folder: Path) -> Path:
    """Return the folder of a case's bundle: the run's folder, or a subfolder."""
    return folder if len(cases(plan)) == 1 else folder / case.folder


def require_same_provenance(folder: Path, provenance: Provenance) -> None:
    """Check the provenance of every complete case of `folder` against that of the remaining cases.

    Raises:
        UsageError: they differ; the message names the first difference.
        RecordingError: a bundle cannot be read.
    """
    for case in cases(provenance.plan):
        place = case_folder(provenance.plan, case, folder)
        if not place.exists():
            continue
        bundle = Bundle.open(place)
        if not bundle.complete:
            continue
        for what, there, here in _differences(bundle.manifest, case, provenance):
            raise UsageError(
                f"{place} was recorded with {what} {there}, and this run has {here}; the cases of a run are "
                f"of one bench, drive and plan: resume with what it was begun with, or run elsewhere"
            )


def _differences(manifest: Manifest, case: Case, provenance: Provenance) -> Iterator[tuple[str, str, str]]:
    """Yield the differences: what differs, the recorded value and the present one."""
    yield from _of_link(manifest, provenance)
    if manifest.seed != provenance.seed + case.repetition - 1:
        yield "seed", str(manifest.seed), str(provenance.seed + case.repetition - 1)
    yield from _of_plan(manifest, provenance.plan)
    if provenance.profile_toml is not None and manifest.profile_toml != provenance.profile_toml:
        then, now = _flat(_toml(manifest.profile_toml)), _flat(_toml(provenance.profile_toml))
        yield from _first("profile", then, now)
    if provenance.identity is not None:
        now = {name: value for name, value in asdict(provenance.identity).items() if value is not None}
        yield from _first("drive", manifest.identity, now)
    if provenance.parameters is not None and registry.far_end(provenance.link) is not FarEnd.EMULATED_DRIVE:
        set_by_plan = {*provenance.plan.setup, *case.setup}
        held = {key: value for key, value in manifest.parameters.items() if key not in set_by_plan}
        holds = {key: value for key, value in provenance.parameters.items() if key not in set_by_plan}
        yield from _first("parameter", held, holds)


def _of_link(manifest: Manifest, provenance: Provenance) -> Iterator[tuple[str, str, str]]:
    """Yield a different link, unless the serial number shows that it leads to the same drive."""
    if manifest.link == provenance.link:
        return
    if manifest.link:
        then, now = (registry.wire_of(registry.parse(link)) for link in (manifest.link, provenance.link))
        if then is now and then.far_end is FarEnd.DRIVE and manifest.identity.get("serial_number"):
            return
    yield "link", f"'{manifest.link}'" if manifest.link else "unknown to it", f"'{provenance.link}'"


def _of_plan(manifest: Manifest, plan: Plan) -> Iterator[tuple[str, str, str]]:
    recorded = manifest.details.get("plan", {})
    try:
        if recorded_plan(recorded) == plan:
            return
    except ValidationError:
        yield "plan", "that this version does not understand", f"'{plan.title}'"
        return
    yield from _first("plan", _flat(recorded), _flat(plan.model_dump(mode="json")))


def _first(what: str, then: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Yield the first key that differs, if any."""
    for key in dict.fromkeys((*then, *now)):
        if then.get(key) != now.get(key):
            yield f"{what} {key} =", repr(then.get(key, _NONE)), repr(now.get(key, _NONE))
            return


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in table.items():
        flat |= _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value}
    return flat


def _toml(text: str) -> Mapping[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError):
        return {"text": text}
