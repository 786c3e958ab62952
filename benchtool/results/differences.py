"""In what runs differ besides their numbers: drive, operating point, plan, profile, and what was recorded.

Told before the numbers of a comparison, since a number that differs because its limit, its law or its rows do
says nothing of the machine. `not_compared` is what only one of the runs has.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Self

from pydantic import ValidationError

from benchtool.plan import recorded_plan
from benchtool.profile import Profile
from benchtool.recording import Manifest, read_manifest
from benchtool.results.assessment import Assessment
from benchtool.results.comparison import Comparison, MeasuredCase, SideBySide


class Kind(StrEnum):
    """What a circumstance is of."""

    PARAMETERS = "drive parameters"
    PLAN = "plan"
    OPERATING_POINT = "operating point"
    REACHED = "operating point reached"
    LIMITS = "limits"
    ANALYSES = "analysis options"
    RECORDED = "recorded rows"
    DRIVE = "drive and firmware"
    PROFILE = "profile"
    SOFTWARE = "link, seed and software"


@dataclass(frozen=True)
class Circumstance:
    """A key with its values by the label of the run; None where a run has none."""

    kind: Kind
    key: str
    values: Mapping[str, object]


@dataclass(frozen=True)
class NotCompared:
    """A measurement that only one of the runs has, or in another unit."""

    label: str
    name: str
    reason: str


@dataclass(frozen=True)
class Differences:
    """What is not the same in all runs of a comparison; `labels` are of the runs, the reference first."""

    labels: tuple[str, ...]
    circumstances: tuple[Circumstance, ...]
    not_compared: tuple[NotCompared, ...]

    @classmethod
    def of(cls, comparison: Comparison) -> Differences:
        """By the manifests of the bundles and by what was measured.

        Raises:
            RecordingError: a manifest cannot be read.
        """
        held = {label: dict(_circumstances(result)) for label, result in comparison.results.items()}
        found = [
            each
            for kind in Kind
            for each in _differing(kind, {label: tables[kind] for label, tables in held.items()})
        ]
        found += _reached(comparison)
        return cls(tuple(held), tuple(found), tuple(_not_compared(comparison)))

    def of_kind(self, kind: Kind) -> tuple[Circumstance, ...]:
        """Return those of one kind."""
        return tuple(each for each in self.circumstances if each.kind is kind)

    @property
    def same(self) -> tuple[Kind, ...]:
        """The kinds in which the runs do not differ."""
        return tuple(kind for kind in Kind if not self.of_kind(kind))

    @property
    def reasons(self) -> Mapping[tuple[str, str], tuple[str, ...]]:
        """Names of measurements that are not compared, by the label of the run and the reason."""
        found: dict[tuple[str, str], tuple[str, ...]] = {}
        for each in self.not_compared:
            key = each.label, each.reason
            found[key] = (*found.get(key, ()), each.name)
        return found

    def to_json(self) -> dict[str, Any]:
        """By kind and key, the values in the order of the runs; what is not compared by run."""
        return {
            "runs": list(self.labels),
            "differing": {
                str(kind): {each.key: list(each.values.values()) for each in self.of_kind(kind)}
                for kind in Kind
                if self.of_kind(kind)
            },
            "same": [str(kind) for kind in self.same],
            "not_compared": {
                label: {each.name: each.reason for each in self.not_compared if each.label == label}
                for label in self.labels[1:]
            },
        }


def _differing(kind: Kind, tables: Mapping[str, Mapping[str, object]]) -> Iterator[Circumstance]:
    """Yield the keys in which tables differ; of a table that a run has not at all, that alone."""
    if not all(tables.values()) and any(tables.values()):
        counts = {label: f"{len(table)} stated" if table else None for label, table in tables.items()}
        yield Circumstance(kind, "all keys", counts)
        return
    for key in dict.fromkeys(key for table in tables.values() for key in table):
        values = {label: table.get(key) for label, table in tables.items()}
        first, *others = map(_stated, values.values())
        if any(each != first for each in others):
            yield Circumstance(kind, key, values)


def _stated(value: object) -> object:
    """Return a value; None of a text that is left empty, as of a key that is not there."""
    return None if value == "" else value


def _reached(comparison: Comparison) -> Iterator[Circumstance]:
    """Yield the speed, torque and dc link where a run is off the reference by more than an operating point
    may be."""
    tolerances = {label: _tolerances(result) for label, result in comparison.results.items()}
    found = {
        label: {each.name: each.value for each in result.measurements}
        for label, result in comparison.results.items()
    }
    first, *others = found
    for name, (share, least) in tolerances[first].items():
        values = {label: found[label].get(name, math.nan) for label in found}
        reference = values[first]
        allowed = max(share * abs(reference), least)
        if any(abs(values[label] - reference) > allowed for label in others):
            known = {label: value if math.isfinite(value) else None for label, value in values.items()}
            yield Circumstance(Kind.REACHED, name, known)


def _tolerances(result: Assessment) -> dict[str, tuple[float, float]]:
    """By which share, and by how much at least, a level may differ."""
    speed, torque = 0.0, 0.0
    with suppress(KeyError, TypeError):
        motor = _profile(read_manifest(result.bundle)[0])["motor"]
        speed, torque = float(motor["omega_m_N_rad_s"]), float(motor["T_N_Nm"])
    return {
        "omega_m_reached": (0.02, 0.005 * speed),
        "torque_mean": (0.05, 0.01 * torque),
        "u_dc_reached": (0.1, 0.0),
    }


def valued(comparison: SideBySide[MeasuredCase]) -> list[str]:
    """Return the measurements that have a value or a bound in one of the runs."""
    found = {
        each.name for result in comparison.results.values() for each in result.measurements if each.is_told
    }
    return [name for name in comparison.names if name in found]


def _circumstances(result: Assessment) -> Iterator[tuple[Kind, Mapping[str, object]]]:
    manifest = read_manifest(result.bundle)[0]
    plan, table = _plan(manifest), _OfTable.of(manifest)
    yield Kind.PARAMETERS, manifest.parameters
    own = ("limits", "case_limits", "analyses", "record", "operating_point")
    yield Kind.PLAN, _flat({key: value for key, value in plan.items() if key not in own})
    yield Kind.OPERATING_POINT, _flat(manifest.details.get("operating_point", {}))
    yield Kind.REACHED, {}
    limits = dict(result.limits) | ({} if result.together is None else dict(result.together.limits))
    yield Kind.LIMITS, {name: limit.bounds for name, limit in limits.items()}
    yield Kind.ANALYSES, {**_flat(plan.get("analyses", {})), **table.options}
    yield Kind.RECORDED, {**_rows(result), **table.columns}
    yield Kind.DRIVE, {"dictionary": manifest.dictionary_hash, **manifest.identity}
    yield Kind.PROFILE, {"name": manifest.profile_name, **_flat(_profile(manifest)), **table.bench}
    yield Kind.SOFTWARE, {"link": manifest.link, "seed": manifest.seed, **manifest.versions}


@dataclass(frozen=True)
class _OfTable:
    """What the numbers of a table of another tool rest on; nothing of other recordings."""

    options: Mapping[str, object] = field(default_factory=dict)
    columns: Mapping[str, object] = field(default_factory=dict)
    bench: Mapping[str, object] = field(default_factory=dict)

    @classmethod
    def of(cls, manifest: Manifest) -> Self:
        details = manifest.details
        kept, source = details.get("table", {}), details.get("source", {})
        if not isinstance(kept, Mapping) or not isinstance(source, Mapping):
            return cls()
        options = {key: value for key, value in kept.items() if key not in ("columns", "lost", "bench")}
        told = ("name", "unit", "gain", "offset")
        columns = {
            f"columns.{what}.{key}": each.get(key)
            for what, each in source.get("columns", {}).items()
            for key in told
        }
        return cls(options, columns, _flat(kept.get("bench", {}), "bench."))


def _rows(result: Assessment) -> dict[str, object]:
    """Of what the numbers are made; how long it was is told with the numbers."""
    block = result.capture
    return {
        "stream": result.stream,
        "rate_Hz": round(block.sample_rate_Hz, 6),
        "stride": block.stride,
        "channels": ", ".join(sorted(block.names)),
        "transducer": result.transducer is not None,
    }


def _plan(manifest: Manifest) -> Mapping[str, Any]:
    """Return the plan of a bundle as this version writes it, so that an older form is no difference."""
    recorded: Mapping[str, Any] = manifest.details.get("plan", {})
    try:
        return recorded_plan(recorded).model_dump(mode="json") if recorded else {}
    except ValidationError:
        return recorded


def _profile(manifest: Manifest) -> Mapping[str, Any]:
    """Return the profile of a bundle with its defaults, so that one that is written out is no difference; of
    the bench what is stated, since sensors have many keys."""
    try:
        content = tomllib.loads(manifest.profile_toml)
    except (ValueError, RecursionError):
        return {"content": manifest.profile_toml}
    try:
        profile = Profile.model_validate(content)
        whole = profile.model_dump(mode="json", exclude={"choices", "claims", "bench"})
        return whole | {"bench": profile.bench.model_dump(mode="json", exclude_defaults=True)}
    except ValidationError:
        return content


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, object]:
    flat: dict[str, object] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{prefix}{key}.")
        elif isinstance(value, list | tuple):
            flat[f"{prefix}{key}"] = ", ".join(str(each) for each in value)
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _not_compared(comparison: Comparison) -> Iterator[NotCompared]:
    (reference, one), *others = comparison.results.items()
    for label, two in others:
        yield from _between(reference, one, label, two)


def _between(reference: str, one: Assessment, label: str, two: Assessment) -> Iterator[NotCompared]:
    first, second = ({each.name: each for each in result.measurements} for result in (one, two))
    for name in dict.fromkeys((*first, *second)):
        a, b = first.get(name), second.get(name)
        if a is None or b is None:
            yield NotCompared(label, name, f"{reference if a is None else label} has none")
        elif a.unit != b.unit:
            yield NotCompared(label, name, f"in {a.unit or 'no unit'} and in {b.unit or 'no unit'}")
