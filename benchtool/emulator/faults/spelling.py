"""Faults as they are spelled: `NAME[:key=value,...][@SECONDS]`."""

from __future__ import annotations

import math

from benchtool.document import closest
from benchtool.emulator.faults.catalogue import FAULTS
from benchtool.emulator.faults.declaration import Fault, Kind, Parameter, Setting
from benchtool.errors import ValueRefused

_FORM = "NAME[:key=value,...][@SECONDS]"


def parse_fault(text: str) -> Fault:
    """Return the fault that a text spells, such as `frames_lost:share=0.2@1.5`.

    Raises:
        ValueRefused: no such fault or parameter, or a value that it cannot have.
    """
    before, at, moment = text.strip().partition("@")
    name, _, rest = before.partition(":")
    kind = FAULTS.get(name.strip())
    if kind is None:
        raise ValueRefused(
            f"fault '{text}': there is no '{name}', {_FORM} is expected: {closest(name, sorted(FAULTS))}"
        )
    values = kind.defaults
    for pair in filter(None, (each.strip() for each in rest.split(","))):
        key, equals, value = (part.strip() for part in pair.partition("="))
        values[key] = _value(text, _parameter(text, kind, key), value if equals else "")
    return Fault(kind, values, _moment(text, moment) if at else 0.0)


def _parameter(text: str, kind: Kind, key: str) -> Parameter:
    found = next((each for each in kind.parameters if each.name == key), None)
    if found is None:
        known = [each.name for each in kind.parameters]
        hint = closest(key, known) if known else "it takes no parameter, leave it out"
        raise ValueRefused(f"fault '{text}': '{kind.name}' has no '{key}': {hint}")
    return found


def _value(text: str, parameter: Parameter, value: str) -> Setting:
    if isinstance(parameter.default, str):
        if parameter.choices and value not in parameter.choices:
            raise ValueRefused(
                f"fault '{text}': {parameter.name} = '{value}', one of {', '.join(parameter.choices)} is "
                f"expected: choose one"
            )
        return value
    number = _number(value)
    if number is None or not parameter.least <= number <= parameter.most:
        unit = f" {parameter.unit}" if parameter.unit else ""
        raise ValueRefused(
            f"fault '{text}': {parameter.name} = '{value}', a number from {parameter.least:g} to "
            f"{parameter.most:g}{unit} is expected: correct it"
        )
    return number


def _moment(text: str, moment: str) -> float:
    at_s = _number(moment)
    if at_s is None or at_s < 0.0:
        raise ValueRefused(f"fault '{text}': '@{moment}', seconds of 0 or more are expected: correct it")
    return at_s


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None
