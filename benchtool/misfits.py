"""What does not fit the model of a document: where, what was seen, what is expected."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Sequence
from typing import get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from benchtool.errors import MOST_REASONS

Path_ = tuple[int | str, ...]

_SHOWN = reprlib.Repr()
_SHOWN.maxstring = _SHOWN.maxother = 120

_UNION_MEMBERS = frozenset({"float", "int", "str"})  # that pydantic appends to where a value stands
_EXPECTED = {  # in the words of TOML, by the type of pydantic's complaint
    "dict_type": "a table is expected",
    "model_type": "a table is expected",
    "model_attributes_type": "a table is expected",
    "tuple_type": "an array is expected",
    "list_type": "an array is expected",
    "float_type": "it should be a valid number, without quotes",
}
_TABLE_EXPECTED = frozenset({"dict_type", "model_type", "model_attributes_type"})
_SHORT_LIST = 24


def explain(model: type[BaseModel], failed: ValidationError) -> str:
    """Return half a line on why content does not fit `model`: the first key, what was seen, what to do."""
    (_, first), *others = misfits(model, failed)
    told = described(model, first)
    return f"{told} (and {len(others)} more)" if others else told


def misfits(model: type[BaseModel], failed: ValidationError) -> list[tuple[Path_, ErrorDetails]]:
    """Return what is wrong, each thing once with its place: misspelt keys before what is missing because of
    them, which is told of the first `MOST_REASONS`."""
    details = sorted(failed.errors(), key=lambda each: not is_misspelt(each))
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
        if is_misspelt(detail) and len(found) <= MOST_REASONS and (key := key_meant(model, detail)):
            meant.add((*place[:-1], key))
    return list(found.items())


def key_meant(model: type[BaseModel], detail: ErrorDetails) -> str:
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


def described(model: type[BaseModel], detail: ErrorDetails) -> str:
    location = _location(model, detail)
    key = ".".join(str(part) for part in location)
    if is_misspelt(detail):
        known = ", ".join(_allowed_keys(model, detail["loc"][:-1]))
        hint = f"did you mean '{meant}'?" if (meant := key_meant(model, detail)) else f"known here: {known}"
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


def is_misspelt(detail: ErrorDetails) -> bool:
    return detail["type"] == "extra_forbidden"
