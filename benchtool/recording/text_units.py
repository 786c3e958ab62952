"""Units as instruments and people write them in the head of a table: `(mA)`, `[N·m]`, `second`, `°`, `µs`."""

from __future__ import annotations

import re
from functools import cache

from benchtool.protocol.quantity import spellings

KNOWN = ("s", "A", "Nm", "rad", "rad/s", "V", "W", "Wb", "ohm", "Hz", "H", "F", "N", "kgm2")
"""Units that a head may state, each with its prefixes and synonyms."""

_CHARACTERS = str.maketrans(
    {"µ": "u", "μ": "u", "Ω": "ohm", "\N{OHM SIGN}": "ohm", "°": "deg", "²": "2", "·": "", "*": "", " ": ""}
)
_METRE = re.compile(r"(?<=N)[.-](?=m)")  # N.m and N-m
_PREFIXES = {"milli": "m", "micro": "u", "nano": "n", "kilo": "k", "mega": "M"}
_WORDS = {
    "s": ("second", "sec"),
    "A": ("ampere", "amp"),
    "V": ("volt",),
    "W": ("watt",),
    "Nm": ("newtonmetre", "newtonmeter"),
    "rad": ("radian",),
    "deg": ("degree",),
    "rev": ("revolution", "turn"),
    "rpm": ("1/min", "r/min", "min-1", "min^-1"),
    "Hz": ("hertz",),
}
_WORD_UNITS = {word: unit for unit, words in _WORDS.items() for word in words}


def unit_factor(text: str, unit: str) -> float | None:
    """How many of the SI unit `unit` one of the unit `text` is, or None where it is not a unit of that kind.

    `text` is as `protocol.quantity` reads it (mA, uNm, deg, rpm), or in words (`second`, `milliamps`).
    """
    known = spellings(unit)
    factor = known.get(_symbol(text))
    return None if factor is None else float(factor)


@cache
def is_unit(text: str) -> bool:
    """Whether `text` is any unit that a head may state."""
    return any(unit_factor(text, unit) is not None for unit in KNOWN)


def units_of(unit: str) -> str:
    """The unit and some others that stand for it, for a message."""
    names = list(spellings(unit))
    prefixed = [f"{prefix}{unit}" for prefix in "mu" if f"{prefix}{unit}" in names]
    others = [name for name in ("deg", "rev", "rpm", "deg/s", "rev/s") if name in names]
    return ", ".join([unit, *prefixed[: None if unit in ("s", "A", "Nm") else 1], *others])


def _symbol(text: str) -> str:
    symbol = _METRE.sub("", text.strip().translate(_CHARACTERS))
    word = symbol.lower()
    for name, prefix in _PREFIXES.items():
        if word.startswith(name) and (unit := _word(word.removeprefix(name))) is not None:
            return prefix + unit
    return _word(word) or {"nm": "Nm", "rpm": "rpm"}.get(word, symbol)


def _word(word: str) -> str | None:
    return _WORD_UNITS.get(word, _WORD_UNITS.get(word.removesuffix("s")))
