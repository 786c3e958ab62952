"""Values of a plan that a command changes for one run: `load_torque_Nm=1`, `omega_m=1500rpm`, `law=foc`.

A key is that of the file, its tables before it with dots, or alone where only one table has it. The unit that
ends it may be left out. A value may have another unit than its key, and is converted.
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, get_args, get_origin

from pydantic import BaseModel

from benchtool.document import unit_suffix
from benchtool.errors import PlanError, ValueRefused
from benchtool.plan.limits import Limit
from benchtool.plan.model import Plan
from benchtool.profile import Emulator
from benchtool.protocol.dictionary import Dictionary, parse_quantity, toml_key

_UNITS: Final = {
    unit_suffix(unit): unit
    for unit in (
        "A",
        "Nm",
        "V",
        "Wb",
        "H",
        "Hz",
        "ohm",
        "rad",
        "rad/s",
        "s",
        "kgm2",
        "Nms",
        "Nms/rad",
        "Nm/rad",
    )
}
_FLAT: Final = ("operating_point", "record", "stimulus")  # whose keys may stand alone
_SEVERAL: Final = ("variants", "readings")


@dataclass(frozen=True)
class Place:
    """A key that may be changed: its tables and itself as the file has them, and the unit of its numbers."""

    path: tuple[str, ...]
    unit: str = ""
    array: bool = False

    @property
    def key(self) -> str:
        """With its tables, as it may be given."""
        return ".".join(self.path)

    @property
    def spellings(self) -> tuple[str, ...]:
        """The key as it may be given: with or without its unit, and with or without its table."""
        bare = self.key.removesuffix(f"_{unit_suffix(self.unit)}") if self.unit else self.key
        with_table = (self.key, bare)
        if len(self.path) != 2 or self.path[0] not in (*_FLAT, "setup"):
            return with_table
        return (*with_table, *(each.partition(".")[2] for each in with_table))


@dataclass(frozen=True)
class Changes:
    """Changes by NAME=VALUE, as they were given.

    Args:
        given: each of them.
        dictionary: of the drive, whose parameters `[setup]` may have.
    """

    given: tuple[str, ...]
    dictionary: Dictionary = field(repr=False)

    def applied(self, content: Mapping[str, Any]) -> dict[str, Any]:
        """Return the content of a plan's file with the changes.

        Raises:
            PlanError: an unknown key, no value, or a value in a unit that is not that of its key; a line for
                each.
        """
        changed = _copied(content)
        places = list(places_of(self.dictionary))
        wrong: list[str] = []
        for text in self.given:
            try:
                place, value = self._read(text, places, content)
                _put(changed, place, value)
            except (PlanError, ValueRefused) as refused:
                wrong.append(f"--set {text}: {refused}")
        if wrong:
            raise PlanError.of_all(wrong)
        return changed

    def _read(self, text: str, places: Sequence[Place], content: Mapping[str, Any]) -> tuple[Place, Any]:
        key, equals, stated = (part.strip() for part in text.partition("="))
        if not (key and equals and stated):
            raise PlanError("KEY=VALUE is expected, such as load_torque_Nm=1 or omega_m=1500rpm")
        place = _place(key, stated, places, content)
        return place, _value(key, stated, place)


def places_of(dictionary: Dictionary) -> Iterator[Place]:
    """Yield every key of a plan that a command may change, those of measurements and of arrays of tables
    apart."""
    for path, annotation in _keys(Plan):
        if path[0] not in _SEVERAL:
            yield Place(path, _unit_of(path[-1]), _is_array(annotation))
    for variable in dictionary:
        if variable.role == "parameter" and variable.writable:
            key = toml_key(variable)
            yield Place(("setup", key), variable.unit)
            yield Place(("sweep", "setup", key), variable.unit, True)
    for path, _ in _keys(Emulator):
        yield Place(("emulator", ".".join(path)), _unit_of(path[-1]))
        yield Place(("sweep", "emulator", ".".join(path)), _unit_of(path[-1]), True)


def _keys(model: type[BaseModel], above: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], object]]:
    """Yield the keys of a model and of the tables in it, each with its annotation."""
    for name, stated in model.model_fields.items():
        path = (*above, name)
        inner = next((each for each in _types(stated.annotation) if _is_model(each)), None)
        if inner is not None and not _is_array(stated.annotation):
            yield from _keys(inner, path)
        elif get_origin(stated.annotation) is not dict:
            yield path, stated.annotation
        elif chosen := [each for key in get_args(stated.annotation)[:1] for each in get_args(key)]:
            yield from (((*path, str(each)), tuple[float, ...]) for each in chosen)


def _types(annotation: object) -> Iterator[Any]:
    yield annotation
    for each in get_args(annotation):
        yield from _types(each)


def _is_model(annotation: object) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _is_array(annotation: object) -> bool:
    return any(get_origin(each) is tuple for each in _types(annotation))


def _unit_of(key: str) -> str:
    """Return the unit that a key ends in; the longest that fits."""
    fitting = [suffix for suffix in _UNITS if key.endswith(f"_{suffix}")]
    return _UNITS[max(fitting, key=len)] if fitting else ""


def _place(key: str, stated: str, places: Sequence[Place], content: Mapping[str, Any]) -> Place:
    """Return the key that is meant; of several that of a table which the plan has, and of the unit of the
    value."""
    table, _, rest = key.partition(".")
    name, dot, bound = rest.rpartition(".")
    if table == "limits" and dot and bound.partition("_")[0] in Limit.model_fields:
        return Place(("limits", name, bound))
    found = [each for each in places if key in each.spellings]
    if table == "analyses" and rest and not found:
        return Place(("analyses", *rest.split(".")), _unit_of(key))
    if exact := [each for each in found if each.key == key]:
        found = exact
    if len(found) > 1 and (present := [each for each in found if each.path[0] in content]):
        found = present
    if len(found) > 1 and (fitting := [each for each in found if _fits(stated, each)]):
        found = fitting
    if len(found) == 1:
        return found[0]
    if found:
        raise PlanError(f"'{key}' may be {' or '.join(each.key for each in found)}: write one of these")
    known = [spelling for each in places for spelling in each.spellings]
    close = difflib.get_close_matches(key, known, n=1)
    hint = (
        f"did you mean '{close[0]}'?" if close else "a key of the plan is expected, with its table before it"
    )
    raise PlanError(f"no key '{key}': {hint}")


def _fits(stated: str, place: Place) -> bool:
    """Return whether a value with a unit is in that of a key."""
    try:
        parse_quantity(stated, place.unit, place.key)
    except ValueRefused:
        return False
    return not stated[-1:].isdigit()


def _value(key: str, text: str, place: Place) -> Any:
    """Return what is stated: a number in the unit of its key, or what TOML or plain text says."""
    try:
        literal = tomllib.loads(f"value = {text}")["value"]
    except ValueError:  # not TOML, or a whole number of thousands of digits
        literal = None
    if literal is not None:
        return [literal] if place.array and not isinstance(literal, list) else literal
    if place.array:
        return [_value(key, part.strip(), Place(place.path, place.unit)) for part in text.split(",")]
    return parse_quantity(text, place.unit, key) if place.unit else text


def _copied(content: Mapping[str, Any]) -> dict[str, Any]:
    return {key: _copied(value) if isinstance(value, Mapping) else value for key, value in content.items()}


def _put(content: dict[str, Any], place: Place, value: Any) -> None:
    """Set a value; a table that the file has not is added."""
    table: Any = content
    for name in place.path[:-1]:
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            raise PlanError(f"'{name}' is {table!r} in the plan, a table is expected: change it there")
    table[place.path[-1]] = value
