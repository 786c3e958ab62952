"""TOML documents checked against a pydantic model, with errors that name file, line and key."""

from __future__ import annotations

import difflib
import itertools
import json
import re
import reprlib
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Strict, ValidationError
from pydantic_core import ErrorDetails

from benchtool.errors import MOST_REASONS, UsageError

_OF_64_BITS = 1 << 63
_SHOWN = reprlib.Repr()
_SHOWN.maxstring = _SHOWN.maxother = 120

Path_ = tuple[int | str, ...]
Item = TypeVar("Item")
Array = Annotated[tuple[Item, ...], Strict(False)]
"""An array of TOML or JSON, which is a list when it is read, as a tuple."""

_UNION_MEMBERS = frozenset({"float", "int", "str"})  # that pydantic appends to where a value stands
_SHORT_LIST = 24
_WIDEST = 44  # column of comments
_EXPECTED = {  # in the words of TOML, by the type of pydantic's complaint
    "dict_type": "a table is expected",
    "model_type": "a table is expected",
    "model_attributes_type": "a table is expected",
    "tuple_type": "an array is expected",
    "list_type": "an array is expected",
    "float_type": "it should be a valid number, without quotes",
}
_TABLE_EXPECTED = frozenset({"dict_type", "model_type", "model_attributes_type"})
_PART = r"""(?:"[^"]*"|'[^']*'|[\w-]+)"""
_KEYS = rf"{_PART}(?:\s*\.\s*{_PART})*"


class Section(BaseModel):
    """A table of a document: unknown keys are refused, values cannot be changed afterwards.

    Values are of the type that is asked for: `true` and `"15.71"` are not numbers. A whole number is a float.
    """

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        arbitrary_types_allowed=True,
        strict=True,
        defer_build=True,
    )


Model = TypeVar("Model", bound=Section)


def defaults(model: type[Model]) -> Model:
    """Return a table without keys, as `model()`, whose check is not built for it: that takes longest of all
    that a document's modules do when they are imported."""
    return model.model_construct()


def document_path(
    name: str,
    place: Path | None,
    kind: str,
    names: Callable[[], Sequence[str]],
    error: type[UsageError],
) -> Path:
    """Return the file that `name` names: a path ending in .toml, else `place`, where a document of that name
    ships.

    Raises:
        error: there is none; the message names the nearest of `names()`, and all of them.
    """
    given = Path(name)
    if given.suffix == ".toml":
        if given.is_file():
            return given
        raise error(f"no {kind} file {given}: give an existing TOML file or a name ({', '.join(names())})")
    if place is None or not place.is_file():
        if (beside := Path(f"{name}.toml")).is_file():
            raise error(f"no {kind} ships by the name '{name}': did you mean the file '{beside}'?")
        raise error(f"no {kind} '{name}': {closest(name, names())}; or give a TOML file")
    return place


def closest(name: str, names: Sequence[str]) -> str:
    """`did you mean 'x'?` where one of `names` is like `name`, and all of them unless that makes it long."""
    close = difflib.get_close_matches(name, names, n=1)
    meant = f"did you mean '{close[0]}'? " if close else ""
    if close and len(names) > _SHORT_LIST:
        return meant.rstrip()
    return f"{meant}the names are {', '.join(names)}"


def load_document(
    path: Path,
    model: type[Model],
    error: type[UsageError],
    change: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda content: content,
) -> Model:
    """Return the document at `path` as `model`; `change` may alter what the file has before that is checked.

    Raises:
        error: the file cannot be read, is not TOML, or does not fit the model; one line each.
    """
    return parse_document(read_document(path, error), path, model, error, change)


def read_document(path: Path, error: type[UsageError]) -> str:
    """Return the text of the document at `path`.

    Raises:
        error: the file cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as reason:
        raise error(f"cannot read {path}: {_reason(reason)}; a readable TOML file is expected") from None


def parse_document(
    text: str,
    path: Path,
    model: type[Model],
    error: type[UsageError],
    change: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda content: content,
) -> Model:
    """As `load_document`, of a text that has been read from `path`."""
    try:
        content = tomllib.loads(text)
        _require_64_bits(content)
    except tomllib.TOMLDecodeError as reason:
        raise error(f"{path}: not TOML: {reason}; correct that line") from None
    except ValueError:  # of thousands of digits, which Python does not convert, or of more than 64 bits
        raise error(
            f"{path}: a whole number has more digits than can be read, 18 at most are expected: correct it"
        ) from None
    except RecursionError:
        raise error(
            f"{path}: tables or lists lie deeper in each other than can be read, some levels are expected: "
            f"take the nesting out"
        ) from None
    try:
        return model.model_validate(change(content))
    except ValidationError as failed:
        wrong = _wrong(model, failed)
        told = [
            f"{path}{line_of(text, place)}: {_explain(model, detail)}"
            for place, detail in wrong[:MOST_REASONS]
        ]
        raise error.of_all(told, len(wrong)) from None


def _require_64_bits(content: object) -> None:
    """Raise ValueError where a whole number is outside the range of TOML (v1.0.0, integer)."""
    left = [content]
    while left:
        match left.pop():
            case Mapping() as table:
                left += table.values()
            case list() as values:
                left += values
            case int() as number if not -_OF_64_BITS <= number < _OF_64_BITS:
                raise ValueError


def explain(model: type[BaseModel], failed: ValidationError) -> str:
    """Return half a line on why content does not fit `model`: the first key, what was seen, what to do."""
    (_, first), *others = _wrong(model, failed)
    told = _explain(model, first)
    return f"{told} (and {len(others)} more)" if others else told


def _wrong(model: type[BaseModel], failed: ValidationError) -> list[tuple[Path_, ErrorDetails]]:
    """Return what is wrong, each thing once with its place: misspelt keys before what is missing because of
    them, which is told of the first `MOST_REASONS`."""
    details = sorted(failed.errors(), key=lambda each: each["type"] != "extra_forbidden")
    found: dict[Path_, ErrorDetails] = {}
    around: set[Path_] = set()  # places that have one of these, and the arrays and tables about them
    meant: set[Path_] = set()
    for detail in details:
        place = _location(model, detail)
        # pydantic reports every member of a union, and then the array or table around them
        if place in meant or place in around:
            continue
        found[place] = detail
        around.update(place[:depth] for depth in range(len(place) + 1))
        misspelt = detail["type"] == "extra_forbidden" and len(found) <= MOST_REASONS
        if misspelt and (key := _key_meant(model, detail)):
            meant.add((*place[:-1], key))
    return list(found.items())


def _key_meant(model: type[BaseModel], detail: ErrorDetails) -> str:
    """Return the known key that an unknown one is like; empty if there is none."""
    close = difflib.get_close_matches(
        str(detail["loc"][-1]), _allowed_keys(model, detail["loc"][:-1]), n=1, cutoff=0.5
    )
    return close[0] if close else ""


def _location(model: type[BaseModel], detail: ErrorDetails) -> Path_:
    """Return where in the document a value is wrong."""
    location = _without_kinds(model, detail["loc"])
    return location[:-1] if location and location[-1] in _UNION_MEMBERS else location


def _without_kinds(model: type[BaseModel], location: Path_) -> Path_:
    """Return a location without the kinds of tables that pydantic puts into it where a table is one of
    several."""
    kept: list[int | str] = []
    models = [model]
    for part in location:
        if len(models) > 1 and (chosen := [each for each in models if _is_kind(each, part)]):
            models = chosen
            continue
        kept.append(part)
        models = _models_at(models, part)
    return tuple(kept)


def _is_kind(model: type[BaseModel], part: int | str) -> bool:
    field = model.model_fields.get("kind")
    return field is not None and part in get_args(field.annotation)


def _models_at_location(model: type[BaseModel], location: Path_) -> list[type[BaseModel]]:
    """Return the models that the table at a location may have; none where a value is expected."""
    models = [model]
    for part in location:
        models = _models_at(models, part)
    return models[:1]


def _required(model: type[BaseModel]) -> list[str]:
    return [name for name, field in model.model_fields.items() if field.is_required()]


def _models_at(models: Sequence[type[BaseModel]], part: int | str) -> list[type[BaseModel]]:
    """Return the models that a key of some models may have; those of an array's items are the array's own."""
    if isinstance(part, int):
        return list(models)
    fields = [each.model_fields[part] for each in models if part in each.model_fields]
    return [found for field in fields for found in _models_in(field.annotation)]


def _models_in(annotation: object) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [found for each in get_args(annotation) for found in _models_in(each)]


def _reason(reason: OSError | UnicodeDecodeError) -> str:
    return reason.strerror or str(reason) if isinstance(reason, OSError) else "it is not UTF-8 text"


def _explain(model: type[BaseModel], detail: ErrorDetails) -> str:
    location = _location(model, detail)
    key = ".".join(str(part) for part in location)
    if detail["type"] == "extra_forbidden":
        known = ", ".join(_allowed_keys(model, detail["loc"][:-1]))
        hint = f"did you mean '{meant}'?" if (meant := _key_meant(model, detail)) else f"known here: {known}"
        return f"unknown key '{key}': {hint}"
    if detail["type"] == "missing":
        needed = [each for found in _models_at_location(model, location) for each in _required(found)]
        return f"key '{key}' is missing: add it" + (f", a table with {', '.join(needed)}" if needed else "")
    if detail["type"] == "union_tag_not_found":
        return f"key '{key}.kind' is missing: add it"
    if detail["type"] == "union_tag_invalid":
        context = detail["ctx"]
        return f"key '{key}.kind' is '{context['tag']}': {context['expected_tags']} are the kinds known here"
    message = _EXPECTED.get(detail["type"], detail["msg"].removeprefix("Value error, "))
    message = message[:1].lower() + message[1:]
    if detail["type"] in _TABLE_EXPECTED and (keys := _allowed_keys(model, detail["loc"])):
        message += f", of {', '.join(keys[:_SHORT_LIST])}"
    if isinstance(detail["input"], dict):  # a whole table, of which only the keys together are wrong
        return f"[{key}]: {message}" if key else message
    return f"key '{key}' is {_SHOWN.repr(detail['input'])}: {message}"


def _allowed_keys(model: type[BaseModel], location: Path_) -> list[str]:
    """Return the keys of the table at a location as pydantic tells it, with the kinds of tables."""
    models = [model]
    parts = iter(location)
    for part in parts:
        chosen = [each for each in models if _is_kind(each, part)] if len(models) > 1 else []
        if _of_chosen_keys(models, part):
            next(parts, None)  # a key that the document chooses
        models = chosen or _models_at(models, part)
    return list(models[0].model_fields) if models else []


def _of_chosen_keys(models: Sequence[type[BaseModel]], part: int | str) -> bool:
    """Return whether a key holds tables under names that the document chooses."""
    fields = [each.model_fields.get(str(part)) for each in models]
    return any(field is not None and get_origin(field.annotation) is dict for field in fields)


def line_of(text: str, location: Path_) -> str:
    """`, line N` of the assignment or the table that `location` names; empty where it is not in the text.

    A number in `location` counts the tables of an array (`[[variants]]`) from 0.
    """
    wanted = [part for part in location if isinstance(part, str)]
    counts = {str(name): at for name, at in itertools.pairwise(location) if isinstance(at, int)}
    table: list[str] = []
    seen: dict[str, int] = {}
    best: tuple[int, int] | None = None
    for number, line in enumerate(text.splitlines(), start=1):
        header = re.match(rf"\s*(\[\[?)\s*({_KEYS})\s*\]", line)
        key = re.match(rf"\s*({_KEYS})\s*=", line)
        if header:
            table = _parts(header[2])
            if header[1] == "[[":
                seen[table[-1]] = seen.get(table[-1], -1) + 1
        elif not key:
            continue
        parts = table if header else table + _parts(key[1])  # type: ignore[index] # one of the two matched
        depth = min(len(parts), len(wanted))
        passed = any(seen.get(name, at) != at for name, at in counts.items() if name in parts)
        if parts[:depth] == wanted[:depth] and not passed and (best is None or depth > best[0]):
            best = (depth, number)
    return f", line {best[1]}" if best else ""


def _parts(keys: str) -> list[str]:
    """Return the parts of a dotted key, without their quotes."""
    return [part.strip("\"'") for part in re.findall(_PART, keys)]


def unit_suffix(unit: str) -> str:
    """Return a unit as a key ends with it: `Nm`, `rad_s`, `percent`; empty of a pure number (`""` or
    `"1"`)."""
    return re.sub(r"\W+", "_", unit.replace("%", "percent")).strip("_").removeprefix("1")


Row = Sequence[float]
Literal = (
    float
    | str
    | bool
    | Sequence[str]
    | Row
    | Sequence[Row]
    | Mapping[str, float]
    | Mapping[str, Row | Sequence[Row]]
)


def commented_table(name: str, rows: Sequence[tuple[str, Literal, str]]) -> str:
    """Return a table of TOML, each key with its value and a comment; a key that begins with `#` is left
    out."""
    lines = [(f"{key.replace('#', '# ')} = {_literal(value)}", comment) for key, value, comment in rows]
    width = min(max(len(line) for line, _ in lines), _WIDEST) if lines else 0
    header = [f"[{name}]"] if name else []
    return "\n".join(
        (*header, *(f"{line:<{width}}  # {comment}" if comment else line for line, comment in lines), "")
    )


def _literal(value: Literal) -> str:
    """Return a value as TOML has it; numbers to six digits."""
    match value:
        case bool():
            return str(value).lower()
        case int():
            return str(value)
        case float():
            return f"{value:.6g}"
        case str():
            return json.dumps(value, ensure_ascii=False)
        case Mapping():
            return f"{{ {', '.join(f'{key} = {_literal(each)}' for key, each in value.items())} }}"
        case _:
            return f"[{', '.join(_literal(each) for each in value)}]"
