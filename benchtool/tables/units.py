"""Units as written in the header of a table: `(mA)`, `[N·m]`, `second`, `°`, `µs`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from benchtool.protocol.dictionary import spellings

KNOWN = ("s", "A", "Nm", "rad", "rad/s", "V", "W", "Wb", "ohm", "Hz", "H", "F", "N", "kgm2")
"""Units that a head may state, each with its prefixes and synonyms."""

_CHARACTERS = str.maketrans(
    {
        "µ": "u",
        "μ": "u",
        "Ω": "ohm",
        "\N{OHM SIGN}": "ohm",
        "°": "deg",
        "²": "2",
        "⁻": "-",
        "¹": "1",
        **dict.fromkeys("·⋅*× ", ""),
    }
)
_METRE = re.compile(r"(?<=N)[.-](?=[mc])")  # N.m, N-m and N-cm
_POUND_N, _INCH_M = 0.45359237 * 9.80665, 0.0254  # exact: the international pound and inch, standard gravity
_ELSEWHERE: Mapping[str, Mapping[str, float]] = {
    "s": {"min": 60.0, "h": 3600.0},
    "Nm": {
        "Ncm": 1e-2,
        "Nmm": 1e-3,
        "lbf·ft": 12 * _POUND_N * _INCH_M,
        "lbf·in": _POUND_N * _INCH_M,
        "ozf·in": _POUND_N * _INCH_M / 16,
        "kgf·cm": 9.80665e-2,
    },
}
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
    "rpm": ("1/min", "r/min", "u/min", "rev/min", "min-1", "min^-1", "upm"),
    "Hz": ("hertz",),
    "min": ("minute",),
    "h": ("hour", "hr"),
    "Ncm": ("ncm",),
    "Nmm": ("nmm",),
    "lbf·ft": ("lbfft", "lbft", "ftlbf", "ftlb"),
    "lbf·in": ("lbfin", "lbin", "inlbf", "inlb"),
    "ozf·in": ("ozfin", "ozin", "inozf", "inoz"),
    "kgf·cm": ("kgfcm", "kgcm"),
}
PERCENT = ("%", "percent")
"""Percent of a rated value, which the table does not contain."""

_SCALES = frozenset(
    (
        *(
            "-",
            "raw",
            "%",
            "percent",
            "pu",
            "p.u.",
            "count",
            "counts",
            "cnt",
            "cnts",
            "lsb",
            "digit",
            "digits",
        ),
        *(
            "tick",
            "ticks",
            "inc",
            "step",
            "steps",
            "adc",
            "div",
            "q15",
            "q16",
            "db",
            "dbm",
            "degc",
            "degf",
            "k",
            "t",
        ),
        *("gauss", "m", "mm", "m/s", "m/s2", "g", "pa", "bar", "var", "va"),
    )
)
_WORD_UNITS = {word: unit for unit, words in _WORDS.items() for word in words}


def unit_factor(text: str, unit: str) -> float | None:
    """Return how many of the SI unit `unit` one of the unit `text` is, or None where it is not a unit of that
    kind.

    `text` is as `protocol.quantity` reads it (mA, uNm, deg, rpm), in words (`second`, `milliamps`), or a
    further unit of instruments (min, h, Ncm, lbf·ft, lb-ft, ozf·in).
    """
    symbol = _symbol(text)
    factor = spellings(unit).get(symbol, _ELSEWHERE.get(unit, {}).get(symbol))
    return None if factor is None else float(factor)


@cache
def is_unit(text: str) -> bool:
    """Return whether `text` is any unit that a head may state."""
    return any(unit_factor(text, unit) is not None for unit in KNOWN)


@cache
def is_scale(text: str) -> bool:
    """Return whether `text` is a scale that no column here may be in as it stands: counts, percent, another
    kind."""
    return text.strip().translate(_CHARACTERS).lower() in _SCALES


def units_of(unit: str) -> str:
    """Return the unit and some others that stand for it, for a message."""
    names = list(spellings(unit))
    prefixed = [f"{prefix}{unit}" for prefix in "mu" if f"{prefix}{unit}" in names]
    others: list[str] = [name for name in ("deg", "rev", "rpm", "deg/s", "rev/s") if name in names]
    others += _ELSEWHERE.get(unit, {})
    return ", ".join([unit, *prefixed[: None if unit in ("s", "A", "Nm") else 1], *others])


def _symbol(text: str) -> str:
    symbol = _METRE.sub("", text.strip().translate(_CHARACTERS))
    word = symbol.lower()
    for name, prefix in _PREFIXES.items():
        if word.startswith(name) and (unit := _word(word.removeprefix(name))) is not None:
            return prefix + unit
    return _word(word) or {"nm": "Nm", "rpm": "rpm"}.get(word, symbol)


def _word(word: str) -> str | None:
    joined = re.sub(r"[.-]", "", word)  # lb-ft, oz.in
    for spelt in (word, word.removesuffix("s"), joined, joined.removesuffix("s")):
        if (unit := _WORD_UNITS.get(spelt)) is not None:
            return unit
    return None
