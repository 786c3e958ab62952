"""Parsing of typed values, `0.123`, `123 mohm`, `5deg`, `150 rpm`, into the dictionary's unit.

A number without a unit is in the dictionary's. Prefixes n, u (or µ), m, k and M go with the SI's
units, not with kgm2, deg and rpm. `Ω`, `°`, `²` and `·` may be written. The arithmetic is decimal: 9.52 mH is
exactly the 0.00952 that a file would state; angles use pi as a double.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from decimal import Decimal
from functools import cache

from benchtool.errors import ValueRefused
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.variable import Value, Variable

_PI = Decimal(math.pi)
_PREFIXES = {"": 0, "m": -3, "u": -6, "n": -9, "k": 3, "M": 6}
_PREFIXED = frozenset(
    (
        *("A", "F", "H", "Hz", "N", "Nm", "Nm/A", "Nm/rad", "Nms", "Nms/rad", "V", "Vs/rad", "W", "Wb"),
        *("ohm", "rad", "rad/s", "s"),
    )
)
_SYNONYMS = {"Nms/rad": ("Nms",), "Nms": ("Nms/rad",), "Wb": ("Vs",), "Vs/rad": ("Vs",)}
_OTHERS: Mapping[str, Mapping[str, Decimal]] = {
    "rad": {"deg": _PI / 180, "rev": 2 * _PI},
    "rad/s": {"rpm": _PI / 30, "deg/s": _PI / 180, "rev/s": 2 * _PI},
    "rad/s/V": {"rpm/V": _PI / 30},
    "Vs/rad": {"V/rpm": 30 / _PI, "V/krpm": 30 / _PI / 1000, "mV/rpm": 30 / _PI / 1000},
    "kgm2": {"gm2": Decimal("1e-3"), "kgcm2": Decimal("1e-4"), "gcm2": Decimal("1e-7")},
}

_NUMBER = re.compile(r"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>.*)", re.DOTALL)
_PLAIN = str.maketrans(
    {"Ω": "ohm", "\N{OHM SIGN}": "ohm", "°": "deg", "µ": "u", "μ": "u", "²": "2", "·": "", " ": ""}
)


@cache
def spellings(unit: str) -> Mapping[str, Decimal]:
    """Return every unit that a value of `unit` may be given in, and how many of `unit` it is; `unit` comes
    first."""
    if not unit:
        return {}
    prefixes = _PREFIXES if unit in _PREFIXED else {"": 0}
    scaled = {
        prefix + name: Decimal(1).scaleb(power)
        for name in (unit, *_SYNONYMS.get(unit, ()))
        for prefix, power in prefixes.items()
    }
    return {**scaled, **_OTHERS.get(unit, {})}


def parse_value(variable: Variable, text: str) -> Value:
    """Return what `text` states, in the variable's unit; `encode` checks limits, names and whole numbers.

    Raises:
        ValueRefused: neither a number nor a name, or a unit that the variable cannot be given in.
    """
    text = text.strip()
    if variable.values is not None or variable.type in (DataType.STRING, DataType.DOMAIN):
        return text
    if re.fullmatch(r"[+-]?0[xX][0-9a-fA-F]+", text):
        return int(text, 16)
    number, unit = _split(text, variable.unit, variable.name)
    if not unit:
        return int(number) if re.fullmatch(r"[+-]?\d{1,20}", number) else float(number)
    return _converted(number, unit, variable.unit, variable.name, text)


def parse_quantity(text: str, unit: str, name: str) -> float:
    """Return what `text` states of `name`, in `unit`; a number without a unit is in it already.

    Raises:
        ValueRefused: it is no number, or in a unit that this quantity cannot be given in.
    """
    number, stated = _split(text.strip(), unit, name)
    return _converted(number, stated, unit, name, text) if stated else float(number)


def _split(text: str, unit: str, name: str) -> tuple[str, str]:
    """Return the number and the unit behind it."""
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise _refusal(name, unit, text, "a number")
    return match["number"], match["unit"].translate(_PLAIN)


def _converted(number: str, stated: str, unit: str, name: str, text: str) -> float:
    if stated not in (known := spellings(unit)):
        raise _refusal(name, unit, text, "a plain number" if not unit else "")
    try:
        return float(Decimal(number) * known[stated])
    except ArithmeticError:
        raise _refusal(name, unit, text, "a finite number") from None


def shown(value: Value) -> str:
    """Return a value for people."""
    if isinstance(value, bytes):
        return value.hex(" ")
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def plain(value: Value) -> int | float | str:
    """Return a value for JSON, which has neither bytes nor nan."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value.hex() if isinstance(value, bytes) else value


def _refusal(name: str, unit: str, text: str, wanted: str) -> ValueRefused:
    names = list(spellings(unit))
    units = ""
    if names:
        others = names[1:3] + [each for each in _OTHERS.get(unit, {}) if each not in names[1:3]]
        units = f" in {names[0]}" + (f" (or {', '.join(others)}, ...)" if others else "")
    return ValueRefused(
        f"{name} = {text[:40]!r}: {wanted or 'a value'}{units} is expected; nothing was sent: give one"
    )
