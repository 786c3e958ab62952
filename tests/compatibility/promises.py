"""What a version promises of dictionary, JSON documents, bundle and serial protocol, and what breaks it.

A promise is a version and facts by name, each of which has properties. What is added is compatible, so that a
later version may know more facts and, where a rule says so, wider ones.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, get_args, get_origin

from pydantic import BaseModel, RootModel

from benchtool import __version__
from benchtool.block import Channel
from benchtool.block.arrow import TimeBase, schema_of
from benchtool.protocol.dictionary.objects import ObjectTable, table_from_toml
from benchtool.protocol.serial.messages import VERSION, MessageType, RejectReason, StreamFormat
from benchtool.recording.manifest import SCHEMA_VERSION, Manifest
from docs.generate.json_documents import DOCUMENTS
from docs.generate.models import kind_of
from firmware_protocol import vectors

ROOT: Final = Path(__file__).parents[2]
SNAPSHOTS: Final = Path(__file__).parent / "snapshots"

Properties = dict[str, Any]


@dataclass(frozen=True)
class Promise:
    """Facts of one version. Of a `closed` promise a new fact that is required breaks it as well."""

    version: list[int]
    facts: dict[str, Properties]
    closed: bool = False


def breaks(then: Promise, now: Promise) -> list[str]:
    """What was promised and no longer holds, a line each, whatever the versions."""
    return list(_breaks(then, now))


def unannounced(then: Promise, now: Promise) -> list[str]:
    """The breaks of a version that has not stepped; none if it has."""
    return [] if now.version > then.version else breaks(then, now)


def _breaks(then: Promise, now: Promise) -> Iterator[str]:
    for name, properties in then.facts.items():
        if name not in now.facts:
            yield f"{name} is gone"
            continue
        for key, old in properties.items():
            new = now.facts[name].get(key)
            if new != old and not _is_wider(key, old, new):
                yield f"{name}: {key} was {old!r}, is {new!r}"
    if now.closed:
        for name in now.facts.keys() - then.facts.keys():
            if now.facts[name].get("required"):
                yield f"{name} is new and required"


def _is_wider(key: str, old: Any, new: Any) -> bool:
    """Whether a property that changed allows everything that it did."""
    if key == "min":
        return _number(new, -math.inf) <= _number(old, -math.inf)
    if key == "max":
        return _number(new, math.inf) >= _number(old, math.inf)
    if key == "values":
        return isinstance(old, dict) and isinstance(new, dict) and old.items() <= new.items()
    if key == "access":
        return (old, new) in (("ro", "rw"), ("const", "ro"), ("const", "rw"), ("wo", "rw"))
    return key == "required" and old is True and new is False


def _number(value: Any, missing: float) -> float:
    return missing if value is None else float(value)


# ---- what this tree promises ------------------------------------------------------------------------------


def dictionary(table: ObjectTable | None = None) -> Promise:
    """Every entry of the object dictionary, by index and sub-index."""
    if table is None:
        text = (ROOT / "firmware_protocol" / "objects.toml").read_text(encoding="utf-8")
        table = table_from_toml(tomllib.loads(text))
    facts = {
        f"0x{entry.index:04X}:{entry.sub}": {
            "name": entry.name,
            "type": str(entry.type.value),
            "unit": entry.unit,
            "factor": entry.factor,
            "role": entry.role,
            "access": entry.access,
            "min": entry.minimum,
            "max": entry.maximum,
            "values": None if entry.values is None else {str(k): v for k, v in dict(entry.values).items()},
        }
        for each in table.objects
        for entry in each.entries
    }
    return Promise([int(table.device["revision"])], facts)


def json_documents(
    documents: Mapping[str, type[BaseModel]] = DOCUMENTS, version: str = __version__
) -> Promise:
    """Every key of every JSON document; a minor version may break them before 1.0."""
    facts = {
        f"{command}: {path}": {"kind": kind, "left out": optional}
        for command, model in documents.items()
        for path, kind, optional in _keys(model)
    }
    major, minor, *_ = (int(part) for part in version.split("."))
    return Promise([major, minor] if major == 0 else [major], facts)


def bundle(manifest: type[BaseModel] = Manifest, version: int = SCHEMA_VERSION) -> Promise:
    """Every key of a manifest, and the metadata of samples."""
    schema = schema_of([Channel("i_a", "A")], TimeBase(1, 1, 1e-4, 1e-6), gaps=())
    metadata = {f"metadata of samples: {key.decode()}": Properties(kind="text") for key in schema.metadata}
    column = {"a column of samples": {"kind": str(schema.field(0).type), "unit": "unit in its metadata"}}
    keys = {
        f"manifest: {path}": {"kind": kind, "required": not optional}
        for path, kind, optional in _keys(manifest)
    }
    return Promise([version], keys | metadata | column, closed=True)


def serial(golden: str | None = None, version: int = VERSION) -> Promise:
    """The codes of the serial protocol, and the frames of its golden vectors."""
    text = json.loads(vectors.render() if golden is None else golden)
    facts: dict[str, Properties] = {
        f"{kind.__name__}.{each.name}": {"code": int(each)}
        for kind in (MessageType, RejectReason, StreamFormat)
        for each in kind
    }
    facts |= {f"message {each['name']}": {"frame": each["frame"]} for each in text["messages"]}
    facts |= {f"CRC of {each['data']!r}": {"crc": each["crc"]} for each in text["crc"]}
    return Promise([version], facts)


PROMISES: Final[Mapping[str, Callable[[], Promise]]] = {
    "dictionary": dictionary,
    "json_documents": json_documents,
    "bundle": bundle,
    "serial": serial,
}


def promised(name: str) -> Promise:
    """What the snapshot of a name keeps."""
    return Promise(**json.loads((SNAPSHOTS / f"{name}.json").read_text(encoding="utf-8")))


def renew() -> None:
    """Write every snapshot as this tree has it."""
    for name, promise in PROMISES.items():
        text = json.dumps(asdict(promise()), indent=1, sort_keys=True, ensure_ascii=False)
        (SNAPSHOTS / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def _keys(model: type[BaseModel], path: str = "") -> Iterator[tuple[str, str, bool]]:
    """Path, kind and whether it may be left out, of every key of a document and of the objects in it."""
    if issubclass(model, RootModel):
        yield from _below(model.model_fields["root"].annotation, path)
        return
    for name, field in model.model_fields.items():
        place = f"{path}.{name}" if path else name
        optional = not field.is_required()
        yield place, kind_of(field.annotation, null="null", table=lambda _: "object"), optional
        yield from _below(field.annotation, place)


def _below(annotation: Any, path: str) -> Iterator[tuple[str, str, bool]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield from _keys(annotation, path)
        return
    many = get_origin(annotation) in (dict, list, tuple)
    for each in get_args(annotation):
        yield from _below(each, f"{path}.*".lstrip(".") if many else path)
