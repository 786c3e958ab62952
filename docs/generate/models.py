"""The reference pages of profile and plan, from the pydantic models that read them.

The description of a key is the string literal below it in its class. Its example is what the shipped profiles
and plans, or a document in docs/generate/examples, set it to: all of these are documents that load.
"""

from __future__ import annotations

import ast
import inspect
import itertools
import textwrap
import tomllib
import types
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any, Final, Literal, Union, get_args, get_origin

import annotated_types
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from benchtool.analysis.catalogue import BUILT_IN
from benchtool.document import Section
from benchtool.plan.analyses import Analyses
from benchtool.profile import Sensor

ROOT: Final = Path(__file__).parents[2]
EXAMPLES: Final = ROOT / "docs" / "generate" / "examples"

_NOT_WRITTEN: Final = {(Sensor, "unit"), (Analyses, "kinds")}
"""Fields that a document does not have: a validator makes them of other keys."""

_NAMES: Final = {"channels": "CHANNEL", "roles": "ROLE", "limits": "MEASUREMENT"}
"""What the document chooses as a name of a table, by the key that holds such tables."""

_UNITS: Final = {
    "_A_rms": "A rms", "_V_rms": "V rms", "_K_rms": "K rms", "_A_K": "A/K", "_per_K": "1/K",
    "_rad_s": "rad/s", "_kgm2": "kg m²", "_Nms": "Nm s/rad", "_Nm": "Nm", "_ohm": "Ω",
    "_degC": "°C", "_percent": "%", "_ppm": "ppm", "_Hz": "Hz", "_Wb": "Wb", "_rad": "rad", "_H": "H",
    "_V": "V", "_A": "A", "_K": "K", "_s": "s",
}  # fmt: skip
_PLAIN: Final = {
    float: "number", int: "whole number", str: "text", bool: "`true` or `false`", date: "date",
    Any: "any value",
}  # fmt: skip


@dataclass(frozen=True)
class Key:
    """One key of a table as its page shows it."""

    name: str
    kind: str
    unit: str
    default: str
    example: str
    description: str


@dataclass(frozen=True)
class Table:
    """One table of a document: its heading, what its class says of it, its keys."""

    heading: str
    text: str
    keys: tuple[Key, ...]


def page(title: str, introduction: str, model: type[Section], documents: Sequence[Mapping[str, Any]]) -> str:
    """The page of a document: every table with every key."""
    lines = [f"# {title}", "", introduction.strip(), ""]
    for table in tables(model, documents):
        lines += [f"## {table.heading}", ""]
        lines += [table.text, ""] if table.text else []
        lines += ["| key | value | unit | default | example | meaning |", "|---|---|---|---|---|---|"]
        lines += [
            f"| `{key.name}` | {key.kind} | {key.unit} | {key.default} | {key.example} | {key.description} |"
            for key in table.keys
        ]
        lines.append("")
    return "\n".join(lines)


def tables(model: type[Section], documents: Sequence[Mapping[str, Any]]) -> Iterator[Table]:
    """Every table that a document of this model may have, the document's own keys first."""
    yield from _tables("", model, (), documents)


def documents_of(kind: Literal["profile", "plan"]) -> list[Mapping[str, Any]]:
    """The documents of docs/generate/examples, then the shipped ones, each read as TOML."""
    shipped = (path for path in sorted((ROOT / "profiles").glob("*/*.toml")))
    fitting = [path for path in shipped if (path.stem == "profile") == (kind == "profile")]
    found = (*sorted(EXAMPLES.glob(f"{kind}*.toml")), *fitting)
    return [tomllib.loads(path.read_text(encoding="utf-8")) for path in found]


def descriptions(model: type[BaseModel]) -> dict[str, str]:
    """The string literal below each field of a model, those of its base classes with them."""
    found: dict[str, str] = {}
    for each in reversed(model.__mro__):
        if not (issubclass(each, BaseModel) and each.__module__.split(".")[0] in ("benchtool", "docs")):
            continue
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(each))).body
        assert isinstance(tree, ast.ClassDef)
        for field, below in zip(tree.body, tree.body[1:], strict=False):
            if (
                isinstance(field, ast.AnnAssign)
                and isinstance(field.target, ast.Name)
                and isinstance(below, ast.Expr)
                and isinstance(below.value, ast.Constant)
                and isinstance(below.value.value, str)
            ):
                found[field.target.id] = " ".join(below.value.value.split())
    return found


def _tables(
    heading: str, model: type[BaseModel], path: tuple[str, ...], documents: Sequence[Mapping[str, Any]]
) -> Iterator[Table]:
    said, fields = descriptions(model), model.model_fields
    keys = [
        _key(name, field, said.get(name, ""), (*path, name), documents)
        for name, field in fields.items()
        if (model, name) not in _NOT_WRITTEN
    ]
    text = inspect.getdoc(model) or ""
    yield Table(heading or "The document", _sentences(text), tuple(keys))
    if model is Analyses:
        yield from _analyses(documents)
    for name, annotation in _alike(fields).items():
        if (model, name) in _NOT_WRITTEN or name == "case_limits":  # a limit is the same for a case
            continue
        for found, inner, many in _sections(annotation, (*path, name), name):
            dotted = [".".join((*path, *each)) for each in _each_of(found[len(path) :])]
            shown = ", ".join(f"`[[{each}]]`" if many else f"`[{each}]`" for each in dotted)
            kind = inner.model_fields.get("kind")
            which = f', `kind = "{get_args(kind.annotation)[0]}"`' if kind is not None else ""
            yield from _tables(f"{shown}{which}", inner, found, documents)


def _alike(fields: Mapping[str, FieldInfo]) -> dict[str, Any]:
    """The annotations of fields; tables of one model stand together, their names with | between."""
    found: dict[str, Any] = {}
    for name, field in fields.items():
        stated = field.annotation
        if isinstance(stated, type) and issubclass(stated, BaseModel):
            together = next((each for each, other in found.items() if other is stated), "")
            found.pop(together, None)
            found[f"{together}|{name}" if together else name] = stated
        else:
            found[name] = stated
    return found


def _each_of(path: Sequence[str]) -> list[tuple[str, ...]]:
    """The paths that one with alternatives stands for."""
    return list(itertools.product(*(part.split("|") for part in path)))


def _analyses(documents: Sequence[Mapping[str, Any]]) -> Iterator[Table]:
    """The tables of the analyses that have settings, by the catalogue."""
    for analysis in BUILT_IN:
        settings = analysis.settings
        if settings.model_fields:
            path = ("analyses", analysis.name)
            yield from _tables(f"`[{'.'.join(path)}]`", settings, path, documents)


def _sections(
    annotation: Any, path: tuple[str, ...], name: str
) -> Iterator[tuple[tuple[str, ...], type[BaseModel], bool]]:
    """The tables below a key: path, model, and whether there are many of them in an array."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield path, annotation, False
        return
    origin = get_origin(annotation)
    for each in get_args(annotation):
        inner = path
        if origin is dict:
            inner = (*path, _NAMES.get(name, "NAME"))
        for found, model, _ in _sections(each, inner, name):
            yield found, model, origin is tuple


def _key(
    name: str, field: FieldInfo, said: str, path: tuple[str, ...], documents: Sequence[Mapping[str, Any]]
) -> Key:
    assert said, f"{'.'.join(path)} has no description: write a string literal below the field"
    kind = kind_of(field.annotation, list(field.metadata))
    found = (value for document in documents for value in _values(document, path))
    tables_below = any(True for _ in _sections(field.annotation, path, name))
    example = "" if tables_below else next((_toml(value) for value in found), "")
    return Key(name, kind, _unit(name), _default(field), example, said.replace("|", "\\|"))


def kind_of(
    annotation: Any,
    metadata: Sequence[Any] = (),
    *,
    null: str = "",
    table: Callable[[Any], str] = lambda _: "table",
) -> str:
    """What a key takes, in words, with its bounds.

    Args:
        annotation: of the field.
        metadata: its constraints.
        null: what None is called; empty where a document cannot have it.
        table: what a model is called.
    """

    def kind(each: Any, more: Sequence[Any] = ()) -> str:
        return kind_of(each, more, null=null, table=table)

    origin, inside = get_origin(annotation), get_args(annotation)
    if origin is typing.Annotated:
        return kind(inside[0], [*inside[1:], *metadata])
    if origin in (Union, types.UnionType):
        kinds = [kind(each, metadata) for each in inside if each is not types.NoneType]
        return " or ".join(dict.fromkeys([*kinds, *([null] if null and types.NoneType in inside else [])]))
    bounds = _bounds(metadata)
    if origin is Literal:
        return ", ".join(f"`{each}`" for each in inside)
    if origin in (tuple, list):
        return f"array of {_plural(kind(inside[0]))}{bounds}"
    if origin is dict:
        return f"{table(dict)} by name: {kind(inside[1])}"
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return table(annotation)
    return f"{_PLAIN[annotation]}{bounds}"


def _bounds(metadata: Sequence[Any]) -> str:
    found = []
    for each in metadata:
        if isinstance(each, FieldInfo):
            found += [_bounds(each.metadata).strip(" ,")]
        for kind, sign in (("gt", ">"), ("ge", "≥"), ("lt", "<"), ("le", "≤")):
            if isinstance(each, getattr(annotated_types, kind.capitalize())):
                found.append(f"{sign} {getattr(each, kind):g}")
        if isinstance(each, annotated_types.MinLen):
            found.append(f"at least {each.min_length}")
        if isinstance(each, annotated_types.MaxLen):
            found.append(f"at most {each.max_length}")
    shown = " ".join(each for each in found if each)
    return f", {shown}" if shown else ""


def _plural(kind: str) -> str:
    return " or ".join(f"{each}s" if each[-1].isalpha() else each for each in kind.split(" or "))


def _unit(name: str) -> str:
    return next((unit for ending, unit in _UNITS.items() if name.endswith(ending)), "")


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if value is None or value in ("", (), {}) or isinstance(value, BaseModel):
        return ""
    return _toml(value)


def _values(document: Any, path: Sequence[str]) -> Iterator[Any]:
    """What a document has at a path; a part in capitals is any name, | stands between several.

    Tables of an array are gone through.
    """
    if isinstance(document, list):
        for each in document:
            yield from _values(each, path)
    elif not path:
        yield document
    elif isinstance(document, Mapping):
        name, *rest = path
        below = list(document.values()) if name.isupper() and name in _NAMES.values() else []
        if name == "offset_U" or name in ("offset_limit", "resolution"):
            below = [value for key, value in document.items() if key.startswith(name + "_")]
        else:
            below += [document[each] for each in name.split("|") if each in document]
        for each in below:
            yield from _values(each, rest) if rest else iter([each])


def _toml(value: Any) -> str:
    """A value as TOML has it, in a cell."""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, str):
        shown = value if len(value) < 60 else value[:57] + "..."
        return f'`"{shown}"`'.replace("|", "\\|")
    if isinstance(value, Mapping):
        first, inside = next(iter(value.items()))
        name = first if first.isidentifier() else f'"{first}"'
        more = ", ..." if len(value) > 1 else ""
        return f"`{{ {name} = {_toml(inside).strip('`')}{more} }}`"
    if isinstance(value, list):
        return f"`[{', '.join(_toml(each).strip('`') for each in value[:4])}{', ...' if value[4:] else ''}]`"
    return f"`{value}`"


def _sentences(docstring: str) -> str:
    return "\n\n".join(" ".join(part.split()) for part in docstring.split("\n\n"))
