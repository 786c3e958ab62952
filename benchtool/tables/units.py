"""Units as written in the header of a table: `(mA)`, `[N·m]`, `second`, `°`, `µs`."""

from __future__ import annotations

import math
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
_POUND_N, _INCH_M = 0.45359237 * 9.80665, 0.0254  # exact: the international pound and inch, standard gravity
_POUNDS_N: Mapping[str, float] = {
    **dict.fromkeys(("lbf", "lb", "lbs"), _POUND_N),
    **dict.fromkeys(("ozf", "oz"), _POUND_N / 16),
}
_FORCES_N: Mapping[str, float] = {
    "N": 1.0,
    **dict.fromkeys(("kgf", "kp", "kg"), 9.80665),
    **dict.fromkeys(("gf", "g", "p"), 9.80665e-3),
    **_POUNDS_N,
    "dyn": 1e-5,
}
_LENGTHS_M: Mapping[str, float] = {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3}
_INCHES_M: Mapping[str, float] = {"ft": 12 * _INCH_M, "in": _INCH_M}
_AMBIGUOUS = frozenset(("gm", "pm"))  # gram and picometre
_NO_UNITS = ("MA", "Ms")  # of a motor: milliamperes and milliseconds in capitals, or a moving average
_CYRILLIC = {
    f"{prefix}{unit}": f"{latin}{symbol}"
    for prefix, latin in (("", ""), ("м", "m"), ("мк", "u"), ("н", "n"), ("к", "k"))
    for unit, symbol in (("А", "A"), ("с", "s"), ("Нм", "Nm"), ("В", "V"), ("Вт", "W"), ("рад", "rad"))
} | {"град": "deg", "рад/с": "rad/s", "град/с": "deg/s"}
_PREFIXES_10: Mapping[str, float] = {"d": 0.1, "c": 1e-2, "da": 10.0, "h": 100.0}
_ELSEWHERE: Mapping[str, Mapping[str, float]] = {
    # of a time, S is no siemens; MS is left open
    "s": {"min": 60.0, "h": 3600.0, "d": 86400.0, "S": 1.0, "mS": 1e-3, "uS": 1e-6, "nS": 1e-9},
    "rad": {
        "gon": math.pi / 200,
        "arcmin": math.pi / 10_800,
        "arcsec": math.pi / 648_000,
        "mdeg": math.pi / 180e3,
    },
    "Nm": {
        **{
            force + length: newton * metre
            for force, newton in _FORCES_N.items()
            for length, metre in _LENGTHS_M.items()
            if force + length not in _AMBIGUOUS
        },
        **{
            spelt: newton * metre
            for force, newton in _POUNDS_N.items()
            for length, metre in _INCHES_M.items()
            for spelt in (force + length, length + force)
        },
        **{f"{prefix}Nm": factor for prefix, factor in _PREFIXES_10.items()},
    },
    "Hz": {
        prefix + samples: factor
        for prefix, factor in (("", 1.0), ("k", 1e3), ("M", 1e6), ("G", 1e9))
        for samples in ("S/s", "Sa/s", "SPS", "sps")
    },
}
_SHOWN: Mapping[str, tuple[str, ...]] = {
    "s": ("min", "h"),
    "Nm": ("cNm", "Ncm", "Nmm", "lbf·ft", "lbf·in", "ozf·in", "kgf·cm"),
    "rad/s": ("1/s",),
}
_PREFIXES = {"milli": "m", "micro": "u", "mikro": "u", "nano": "n", "kilo": "k", "mega": "M"}
_WORDS = {
    "s": ("second", "sec", "sek", "sekunde", "sekunden", "seconde", "secondi", "segundo", "сек"),
    "ms": ("msec", "msek", "millisec", "milli", "millisek"),
    "us": ("usec", "usek", "microsec", "micro", "mikro", "mikrosek"),
    "A": ("ampere", "amp", "ampère", "amperio"),
    "V": ("volt",),
    "W": ("watt",),
    "Nm": ("newtonmetre", "newtonmeter"),
    "rad": ("radian", "radiant"),
    "deg": ("degree",),
    "rev": ("revolution", "turn"),
    "Hz": ("hertz",),
    "min": ("minute", "minuten", "mins", "мин"),
    "h": ("hour", "hr"),
    "Ncm": ("ncm",),
    "Nmm": ("nmm",),
}
_LONGEST = 40
_REVOLUTIONS = frozenset(
    (
        *("", "1", "r", "u", "tr", "ot", "rot", "rev", "giri", "obr", "об", "turn", "tour"),
        *("umdr", "umdrehung", "umdrehungen"),
    )
)
_PER = re.compile(r"(?P<above>.*?)(?:/|per)(?P<below>[a-zа-я]+)")  # deg/min, 1/s, tr/min
_POWER = re.compile(r"(?P<above>.*?)(?P<below>s|min)(?:-1|\^-1|\^\(-1\))")  # min-1, s^-1
_ROTATIONS = {
    **dict.fromkeys(("rpm", "upm", "umin"), "1/min"),
    **dict.fromkeys(("rps", "revps"), "1/s"),
    **dict.fromkeys(("dps", "degps"), "deg/s"),
    "radps": "rad/s",
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

_DESCRIPTIONS = frozenset(
    (
        *("phase", "axis", "channel", "ch", "kanal", "motor", "load", "shaft", "drive", "inverter", "line"),
        *("measured", "filtered", "unfiltered", "estimated", "calculated", "actual", "reference", "target"),
        *("meas", "filt", "est", "calc", "act", "ref", "ist", "soll", "set", "setpoint", "demand", "raw"),
        *("mean", "average", "avg", "side", "left", "right", "input", "output", "in", "out", "sensor"),
        *("alpha", "beta", "torque", "current", "speed", "angle", "time", "elapsed", "relative", "absolute"),
        *("strom", "moment", "drehmoment", "drehzahl", "winkel", "zeit", "gemessen", "gefiltert", "links"),
        *("rechts", "mechanical", "encoder", "probe", "unit", "test", "new", "old", "signal", "electrical"),
    )
)
_QUALIFIERS = re.compile(r"(?:rms|eff|pk|peak|pp|p|avg|mean|dc|ac|max|min)$", re.IGNORECASE)
_NAMES = frozenset(
    (
        *("newton", "pound", "ounce", "gram", "metre", "meter", "inch", "foot", "feet", "joule", "pascal"),
        *(
            "ampere",
            "volt",
            "watt",
            "weber",
            "tesla",
            "henry",
            "farad",
            "hertz",
            "radian",
            "kelvin",
            "celsius",
        ),
        *("horsepower", "second", "minute", "knot", "mile", "decibel", "neper", "grad", "poise", "stokes"),
        *(
            "sample",
            "pulse",
            "cycle",
            "incr",
            "inkrem",
            "impuls",
            "strich",
            "digit",
            "count",
            "point",
            "tick",
        ),
        *("index", "number", "nummer", "rotation", "stroke", "mark", "frame", "level", "norm", "scale"),
        *("skal", "relativ", "prozent", "pourcent", "percent", "schritt", "umdreh", "takt", "kilo", "milli"),
        *("micro", "mikro", "nano", "mega"),
    )
)
"""What names of units, of counts and of scales begin with or are made of."""
_FEWEST_LETTERS = 5  # of a word that no unit is mistaken for: lbfin and kgfcm are one letter off
_NEAR = {5: 1, 8: 2}  # edits by which a word of so many letters or more is a misspelt one of a unit
_ATTENUATION = re.compile(r"[xX×*:/]\s*1(?:0+)(?:\.0*)?|10+\s*(?:[xX×*]|:\s*1)|1\s*:\s*10+")  # of a probe
_INDEX = re.compile(r"[0-9]+|[a-z]{0,3}[0-9]{1,3}|[abcdiqruvwxyz]|[0-9:,;]+", re.IGNORECASE)


def unit_factor(text: str, unit: str) -> float | None:
    """Return how many of the SI unit `unit` one of the unit `text` is, or None where it is not a unit of that
    kind.

    `text` is as `protocol.quantity` reads it (mA, uNm, deg, rpm), in words (`second`, `milliamps`), or a
    further unit of instruments: min, h; a force times a length (Ncm, lbf·ft, lb-ft, kp·cm); an angle per time
    (deg/min, 1/s, tr/min), where what is counted are revolutions.
    """
    if len(text) > _LONGEST:
        return None
    symbol = _symbol(text)
    if symbol in _NO_UNITS:
        return None
    if (factor := spellings(unit).get(symbol)) is not None:
        return float(factor)
    if unit == "rad/s":
        return _rotation(text)
    known = _ELSEWHERE.get(unit, {})
    joined = re.sub(r"[.-]", "", symbol)
    return next((known[each] for each in (symbol, joined, joined.lower()) if each in known), None)


@cache
def is_unit(text: str) -> bool:
    """Return whether `text` is any unit that a head may state; d is an axis and S a phase, and none."""
    return text.strip() not in ("d", "S") and any(unit_factor(text, unit) is not None for unit in KNOWN)


@cache
def is_scale(text: str) -> bool:
    """Return whether `text` is a scale that no column here may be in as it stands: counts, percent, another
    kind."""
    symbol = text.strip().translate(_CHARACTERS).lower()
    return symbol in _SCALES or _ATTENUATION.fullmatch(text.strip()) is not None


@cache
def is_description(text: str) -> bool:
    """Return whether a text in brackets is an index (`0`, `a`, `CH1`) or words that say what a column is, and
    so no unit.

    One word, of any language, is enough for a text of nothing but words and indices, unless it may be a unit
    misspelt or with what qualifies it (`Newtonmeeter`, `mArms`). What is shorter than five
    letters is known, or no word.
    """
    if is_unit(text) or is_scale(text):
        return False
    words = [word for word in re.split(r"[\s_-]+", text.strip()) if word]
    return all(_INDEX.fullmatch(word) or word.lower() in _DESCRIPTIONS or _is_word(word) for word in words)


def is_listed(text: str) -> bool:
    """Return whether every word of a description is known to be one, or is an index."""
    words = re.split(r"[\s_-]+", text.strip())
    return all(_INDEX.fullmatch(each) or each.lower() in _DESCRIPTIONS or not each for each in words)


def _is_word(word: str) -> bool:
    """Return whether a text of letters is none that a unit may have been meant by: a word is all in one case
    but for its first letter."""
    if len(word) < _FEWEST_LETTERS or not word.isalpha():
        return False
    if word[1:] not in (word[1:].lower(), word[1:].upper()) or is_scale(word):
        return False
    if any(name in word.lower() for name in _NAMES):
        return False
    stem = _QUALIFIERS.sub("", word)
    if stem != word and (is_unit(stem) or is_scale(stem) or is_unit(stem.lower())):
        return False
    return not any(_near(word.lower(), spelt) for spelt in _spelt())


@cache
def _spelt() -> frozenset[str]:
    """Every spelling of a unit in small letters, also behind the name of a prefix."""
    symbols = (name for unit in KNOWN for name in (*spellings(unit), *_ELSEWHERE.get(unit, ())))
    bare = {name.lower() for name in symbols} | {*_WORD_UNITS, *_ROTATIONS, *_REVOLUTIONS, *_SCALES, *_NAMES}
    return frozenset(each + end for each in bare for end in ("", "s")) | {
        prefix + word for prefix in _PREFIXES for word in _WORD_UNITS
    }


def _near(word: str, spelt: str) -> bool:
    """Return whether a few edits, fewer of a short word, make a unit's spelling of a word (Levenshtein)."""
    most = max((edits for length, edits in _NEAR.items() if length <= len(word)), default=0)
    if abs(len(word) - len(spelt)) > most:
        return False
    row = list(range(len(spelt) + 1))
    for place, letter in enumerate(word, 1):
        before, row[0] = row[0], place
        for at, other in enumerate(spelt, 1):
            kept = before + (letter != other)
            before = row[at]
            row[at] = min(kept, row[at] + 1, row[at - 1] + 1)
    return row[-1] <= most


def is_reciprocal_second(text: str) -> bool:
    """Return whether a unit of speed is 1/s, which is that of revolutions and, in SI, of rad/s as well."""
    symbol = text.strip().translate(_CHARACTERS).lower()
    return symbol in ("1/s", "/s", "s-1", "s^-1", "s^(-1)", "1/sec")


def units_of(unit: str) -> str:
    """Return the unit and some others that stand for it, for a message."""
    names = list(spellings(unit))
    prefixed = [f"{prefix}{unit}" for prefix in "mu" if f"{prefix}{unit}" in names]
    others: list[str] = [name for name in ("deg", "rev", "rpm", "deg/s", "rev/s") if name in names]
    others += _SHOWN.get(unit, ())
    return ", ".join([unit, *prefixed[: None if unit in ("s", "A", "Nm") else 1], *others])


def _rotation(text: str) -> float | None:
    """Return how many rad/s an angle per time is, revolutions where no angle is named."""
    symbol = text.strip().translate(_CHARACTERS)
    kilo = 1000.0 if symbol[:1] == "k" and symbol[1:].lower() in _ROTATIONS else 1.0
    word = (symbol[1:] if kilo > 1.0 else symbol).lower()
    word = _ROTATIONS.get(word, word)
    match = _PER.fullmatch(word) or _POWER.fullmatch(word)
    if match is None:
        return None
    seconds = unit_factor(match["below"], "s")
    above = match["above"].rstrip(".-")
    angle = 2.0 * math.pi if above.removesuffix("s") in _REVOLUTIONS else unit_factor(above, "rad")
    return None if seconds is None or angle is None else kilo * angle / seconds


def _symbol(text: str) -> str:
    symbol = re.sub(r"(?<=[Nn])[.-](?=[mc])", "", text.strip().translate(_CHARACTERS))  # N.m, N-m, N-cm
    symbol = _CYRILLIC.get(symbol, symbol)
    word = re.sub(r"(?<=newton)[.-](?=met)", "", symbol.lower())
    for name, prefix in _PREFIXES.items():
        if word.startswith(name) and (unit := _word(word.removeprefix(name))) is not None:
            return prefix + unit
    return _word(word) or {"nm": "Nm", "rpm": "rpm"}.get(word, symbol)


def _word(word: str) -> str | None:
    singular = word if word in ("ncms", "nmms") else word.removesuffix("s")  # amps; newton metre seconds
    for spelt in (word, singular, word.removesuffix(".")):
        if (unit := _WORD_UNITS.get(spelt)) is not None:
            return unit
    return None
