"""The reference page of the JSON documents, from their models."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any, Final, get_args

from pydantic import BaseModel, RootModel

from docs.generate.json_documents import DOCUMENTS
from docs.generate.models import descriptions, kind_of

_HEAD: Final = """# JSON documents

With `--json` a command prints one document on standard output and everything else on standard error. A
command that fails before it has a result prints no document; its [exit code](exit_codes.md) says why. Keys
end in their unit, or a key `unit` stands beside the value. What is undefined is null, as JSON has neither
nan nor infinity.

Later versions may add keys, so a program should ignore those that it does not know. A key that goes, or
takes another type, is a new minor version of benchtool before 1.0 and a new major version afterwards; a
test holds that. The tests hold real output of each command against this page, which is generated from
`docs/generate/json_documents.py`.

## Commands

| command | document |
|---|---|
"""


def page() -> str:
    """Every command with its document, then every object once."""
    lines = [f"| `benchtool {_shown(name)}` | {_link(model)} |" for name, model in DOCUMENTS.items()]
    for model in _models():
        lines += ["", f"## {model.__name__}", "", (inspect.getdoc(model) or "").split("\n\n")[0], ""]
        if issubclass(model, RootModel):
            lines += [f"An {_kind(model.model_fields['root'].annotation)}."]
            continue
        said = descriptions(model)
        lines += ["| key | value | meaning |", "|---|---|---|"]
        for name, field in model.model_fields.items():
            optional = "" if field.is_required() else ", may be left out"
            assert said.get(name), f"{model.__name__}.{name} has no description"
            kind = _kind(field.annotation) if field.is_required() else _kind(field.annotation, null="")
            lines.append(f"| `{name}` | {kind}{optional} | {said[name]} |")
    return _HEAD + "\n".join(lines) + "\n"


def _shown(name: str) -> str:
    return {
        "run of a folder": "run FOLDER",
        "live of a run": "live RUN",
        "analyze of a recording": "analyze RECORDING",
    }.get(name, name)


def _link(model: Any) -> str:
    return "object" if model is dict else f"[{model.__name__}](#{model.__name__.lower()})"


def _kind(annotation: Any, null: str = "null") -> str:
    return kind_of(annotation, null=null, table=_link)


def _models() -> Iterator[type[BaseModel]]:
    """Every model once: those of the commands, then what they are made of."""
    known: dict[type[BaseModel], None] = dict.fromkeys(DOCUMENTS.values())
    waiting = list(known)
    while waiting:
        for field in waiting.pop(0).model_fields.values():
            for each in _inside(field.annotation):
                if each not in known:
                    known[each] = None
                    waiting.append(each)
    yield from known


def _inside(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for each in get_args(annotation):
        yield from _inside(each)
