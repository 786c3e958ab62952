"""What a resumed run must have in common with the cases that are there: one verdict is of one bench."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from benchtool.bench.wires import registry
from benchtool.bench.wires.wire import FarEnd
from benchtool.drive import Identity
from benchtool.errors import UsageError
from benchtool.plan.cases import Case, cases
from benchtool.plan.model import Plan
from benchtool.recording import Bundle, Manifest

_NONE: Final = "none"


@dataclass(frozen=True)
class Origin:
    """What a run is about to be made with; None where that is not known yet."""

    plan: Plan
    link: str
    seed: int
    profile_toml: str | None = None
    identity: Identity | None = None
    parameters: Mapping[str, int | float | str] | None = None


def case_folder(plan: Plan, case: Case, folder: Path) -> Path:
    """Where the bundle of a case is: in the run's folder, or in one of its own within it."""
    return folder if len(cases(plan)) == 1 else folder / case.folder


def require_same_origin(folder: Path, origin: Origin) -> None:
    """Check every complete case of `folder` against what the others are about to be made with.

    Raises:
        UsageError: they would be a mixture; the message names the first difference.
        RecordingError: a bundle cannot be read.
    """
    for case in cases(origin.plan):
        place = case_folder(origin.plan, case, folder)
        if not place.exists():
            continue
        bundle = Bundle.open(place)
        if not bundle.complete:
            continue
        for what, there, here in _differences(bundle.manifest, case, origin):
            raise UsageError(
                f"{place} was recorded with {what} {there}, and this run has {here}; the cases of a run are "
                f"of one bench, drive and plan: resume with what it was begun with, or run elsewhere"
            )


def _differences(manifest: Manifest, case: Case, origin: Origin) -> Iterator[tuple[str, str, str]]:
    """What it is that differs, how it was then and how it is now."""
    yield from _of_link(manifest, origin)
    if manifest.seed != origin.seed + case.repetition - 1:
        yield "seed", str(manifest.seed), str(origin.seed + case.repetition - 1)
    yield from _of_plan(manifest, origin.plan)
    if origin.profile_toml is not None and manifest.profile_toml != origin.profile_toml:
        then, now = _flat(_toml(manifest.profile_toml)), _flat(_toml(origin.profile_toml))
        yield from _first("profile", then, now)
    if origin.identity is not None:
        now = {name: value for name, value in asdict(origin.identity).items() if value is not None}
        yield from _first("drive", manifest.identity, now)
    if origin.parameters is not None and registry.far_end(origin.link) is not FarEnd.EMULATED_DRIVE:
        set_by_plan = {*origin.plan.setup, *case.setup}
        held = {key: value for key, value in manifest.parameters.items() if key not in set_by_plan}
        holds = {key: value for key, value in origin.parameters.items() if key not in set_by_plan}
        yield from _first("parameter", held, holds)


def _of_link(manifest: Manifest, origin: Origin) -> Iterator[tuple[str, str, str]]:
    """Another port of the same computer may lead to the same drive, which its serial number tells."""
    if manifest.link == origin.link:
        return
    if manifest.link:
        then, now = (registry.wire_of(registry.parse(link)) for link in (manifest.link, origin.link))
        if then is now and then.far_end is FarEnd.DRIVE and manifest.identity.get("serial_number"):
            return
    yield "link", f"'{manifest.link}'" if manifest.link else "unknown to it", f"'{origin.link}'"


def _of_plan(manifest: Manifest, plan: Plan) -> Iterator[tuple[str, str, str]]:
    recorded = manifest.details.get("plan", {})
    try:
        if Plan.model_validate(recorded) == plan:
            return
    except ValidationError:
        yield "plan", "that this version does not understand", f"'{plan.title}'"
        return
    yield from _first("plan", _flat(recorded), _flat(plan.model_dump(mode="json")))


def _first(what: str, then: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """The first key that differs; that of texts which say the same is none."""
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
    except (tomllib.TOMLDecodeError, RecursionError):
        return {"text": text}
