"""Units in the name of a column: `Iq_mA`, `time ms`, `omega_deg_s`, `Current_mA_filtered`, `MotorRPM`."""

from __future__ import annotations

import math
import re

from benchtool.tables.head import Column
from benchtool.tables.units import KNOWN, is_description, is_scale, is_unit, unit_factor

_UNIT_SIGNS = ":=@"  # between a name and its unit: t:ms, i=mA
_BLANKS = r"[_\s]+"
_JOINTS = rf"[_\s.,;{_UNIT_SIGNS}-]+"
_NO_LETTERS = r"(?:[^\w°/·^-]|_)+"
# behind m it may be that of mNm
_HUMP = r"(?<=[a-z0-9])(?<![mukn])[A-Z](?=[a-z])|(?<=[Rr]ad)S$"
_HUMP_OF_NEWTONS = r"(?<=[a-z0-9])(?<![mukn])(?=Nm\b)"  # whose letter stays
_LIMITS = ("min", "max")
_TIME = r"(?:t|time|timestamp|zeit|temps)"
_TIME_IN_SECONDS = re.compile(rf"{_TIME}{_BLANKS}s", re.IGNORECASE)
_GLUED = {
    "s": re.compile(rf"{_TIME}([mun]s)", re.IGNORECASE),
    "rad": re.compile(r".+(deg)", re.IGNORECASE),
    "rad/s": re.compile(r".+(rpm)", re.IGNORECASE),
}
_PERHAPS_GLUED = re.compile(r".*[A-Za-z0-9]([munk](?:A|Nm))")
_NUMBER_AND_UNIT = re.compile(r"(?<![A-Za-z0-9.,])([0-9]+(?:[.,][0-9]+)?)\s?([A-Za-zµ°]+)")
_BEHIND_A_COMMA = re.compile(r".+,\s*(\S{1,4})")
_OTHER_LETTERS = re.compile(r".+\s([^\x00-\x7f°µμ·Ωφθωψαβ]{1,4})")
_LAST_WORD = re.compile(r"(?P<name>.*[^_\s])(?P<between>[_\s])\s*(?P<last>\S+)")
_SIGNS = re.compile(r"[%‰]")
# of an oscilloscope's screen
_PER_DIVISION = re.compile(r"[A-Za-zµ°]+(?:/|_|\s)(?:div|skt)\b", re.IGNORECASE)
_OTHER_SCALES = (
    _PER_DIVISION,
    re.compile(r"\bp\.\s?u\b\.?", re.IGNORECASE),
    # of a rated or greatest value: T/Tn, i/i_N, Iq/Imax
    re.compile(r"(?<![^\W_])([^\W\d_])\w{0,2}\s*/\s*\1\w?_?[n0](?![^\W_])", re.IGNORECASE),
    re.compile(
        r"(?<![^\W_])([^\W\d_])\w*\s*/\s*\1\w*?_?(?:nom|nenn|rated|max|ref|base)(?![^\W_])", re.IGNORECASE
    ),
    # a drive's object in its own scale, as thousandths of the rated torque (CiA 402): 6077h, 0x6077
    re.compile(r"(?<![^\W_])(?:0x60[0-9a-f]{2}|60[0-9a-f]{2}h)(?![^\W_])", re.IGNORECASE),
)
_OTHER_PREFIXES = {
    "A": re.compile(r"(?:d|c|da|h)A"),
    "s": re.compile(r"[dc]s"),
    "rad": re.compile(r"[dc](?:rad|deg)"),
}
_SCALES = frozenset(
    (
        *("pu", "p.u", "percent", "pct", "prozent", "permille", "promille", "mille", "lsb", "adc"),
        *("digit", "digits", "count", "counts", "cnt", "cnts"),
        *("q8", "q12", "q14", "q15", "q16", "q24", "q31"),
    )
)
_SCALES_OF_VALUES = frozenset((*_SCALES, "raw", "rel", "relative", "norm", "normalized", "normalised"))
_SCALES_OF_TIME = frozenset(
    (
        *_SCALES,
        *("tick", "ticks", "sample", "samples", "index", "idx", "row", "rows", "points", "cycles", "days"),
    )
)


def unit_in_name(name: str, unit: str) -> str:
    """Return the unit of the kind of `unit` that a name ends in (`Iq_mA`, `time ms`, `omega_deg_s`, `i:mA`,
    `speedRpm`), else the one that it begins with (`ms_today`), is (`rpm`), or has as a word of its own
    (`Ia |mA| filtered`), or nothing.

    A letter alone is an index (i_s, u_h), but behind the time (time_s); and min at the beginning or within a
    name a least value. A part of a quotient or product of units is none (`rad` of `omega_rad_s`), and what is
    said per division of a screen is no unit of the values.
    """
    name = name.strip()
    if _PER_DIVISION.search(name):
        return ""
    spelt = re.sub(_HUMP_OF_NEWTONS, "_", name)
    joined = re.sub(_HUMP, lambda match: f"_{match[0].lower()}", spelt)
    split = [re.split(*each) for each in ((_BLANKS, name), (_JOINTS, name), (_JOINTS, joined))]
    splits = [_with_compounds(words, unit) for words in split]
    for words in splits:
        for count, between in ((2, "/"), (2, ""), (1, "")):
            if len(words) > count and (found := _joined(words[-count:], between, unit)):
                return found
    if unit == "s" and _TIME_IN_SECONDS.fullmatch(name):
        return "s"
    first = splits[0][0]
    if first.lower() not in _LIMITS and (found := _joined([first], "", unit)):
        return found
    glued = _GLUED[unit].fullmatch(splits[-1][-1]) if unit in _GLUED else None
    if glued is not None:
        return glued[1].lower()
    words = _with_compounds(re.split(_NO_LETTERS, joined), unit)
    words = [each for each in words if each.lower() not in _LIMITS]
    for end in range(len(words), 0, -1):
        for count, between in ((2, "/"), (2, ""), (1, "")):
            if found := _joined(words[max(0, end - count) : end], between, unit):
                return found
    return ""


def perhaps_in_name(name: str, unit: str) -> str:
    """Return what may be the unit in a name that has none of the kind of `unit`, or nothing.

    It is a quotient or product of units (`omega_rad_s` of an angle, `torque_Nm_per_s`), one with nothing
    before it (`ImA`, which may also be phase m of motor A), in other capitals (`i_ma`), with a prefix that is
    rare (`Ia_dA`), of another kind (`CH1 mV`), or with a number (`I 10mA`); a word or sign of another scale
    (`torque_pu`, `iq_counts`, `M %`, `T/Tn`, `6077h`); or a few letters behind a comma, or of another script,
    where units stand.
    """
    name = name.strip()
    for scale_in in _OTHER_SCALES:
        if (other_scale := scale_in.search(name)) is not None:
            return other_scale[0]
    for found in _NUMBER_AND_UNIT.finditer(name):
        if unit_factor(found[2], unit) is not None and float(found[1].replace(",", ".")) != 1.0:
            return found[0]
    match = _PERHAPS_GLUED.fullmatch(name)
    if match is not None and unit_factor(match[1], unit) is not None:
        return match[1]
    words = [each for each in re.split(_JOINTS, name) if each]
    for compound in _with_compounds(words, unit):
        if compound not in words and unit_factor(compound, unit) is None:
            return compound
    last, scales = words[-1] if len(words) > 1 else "", _SCALES_OF_TIME if unit == "s" else _SCALES_OF_VALUES
    if unit in _OTHER_PREFIXES and _OTHER_PREFIXES[unit].fullmatch(last):
        return last
    others = (kind for kind in KNOWN if kind != unit)
    if last.lower() not in _LIMITS and (
        _in_other_capitals(last, unit) or any(_joined([last], "", kind) for kind in others)
    ):
        return last
    scale = [each for each in words if each.lower() in scales] + _SIGNS.findall(name)
    if scale:
        return scale[0]
    other = _BEHIND_A_COMMA.fullmatch(name) or _OTHER_LETTERS.fullmatch(name)
    is_known = other is None or is_description(other[1]) or unit_factor(other[1], unit) is not None
    return "" if other is None or is_known else other[1]


def _in_other_capitals(word: str, unit: str) -> bool:
    """Return whether a word is a unit with a prefix in other capitals: ma, MA, MS."""
    spelt = (word.lower(), word[:1].lower() + word[1:].upper(), word[:1].lower() + word[1:].capitalize())
    return 2 <= len(word) <= 4 and any(unit_factor(each, unit) not in (None, 1.0) for each in spelt)


def name_before_unit(name: str) -> str:
    """Return a name without the sign of its unit and what is behind it (`t:ms`, `i=mA`)."""
    return re.split(f"[{_UNIT_SIGNS}]", name)[0].strip()


def name_before_last_unit(name: str) -> str:
    """Return a name without a unit that is its last word, or words: `Zeit s` is `Zeit`, `Iq_mA` is `Iq`,
    `omega_rad_s` is `omega`; a letter behind anything but a blank is an index (`i_s`)."""
    parts = re.split(rf"({_BLANKS})", name.strip())
    for count in (3, 2):
        last = parts[::2][-count:]
        if len(parts) > 2 * count and last[0] and len(_with_compounds(last, "")) == 1:
            return "".join(parts[: -2 * count])
    match = _LAST_WORD.fullmatch(name.strip())
    is_one = (
        match is not None and is_unit(match["last"]) and (match["between"] != "_" or len(match["last"]) > 1)
    )
    return match["name"] if match is not None and is_one else name


def quantity_of(column: Column, unit: str) -> str:
    """Return the name of a column without the unit of its cells, in brackets, behind a solidus or as its last
    word: what values in another unit are called."""
    words = column.in_brackets
    if words and (words in (unit, column.unit) or is_scale(words)):
        return column.name_before_brackets.removesuffix("/").rstrip()
    if "[" in column.name or "(" in column.name:
        return column.name
    bare = column.bare_name
    return name_before_last_unit(name_before_unit(bare)) if unit_in_name(bare, unit) == unit else bare


def _with_compounds(words: list[str], unit: str) -> list[str]:
    """Return words with those as one that are a quotient or a product of units, which is another unit than
    its parts are: of `omega`, `rad`, `s` the last two are rad/s."""
    found, place = [], 0
    while place < len(words):
        count, text = _compound(words[place : place + 3], unit)
        found.append(text)
        place += count
    return found


def _compound(words: list[str], unit: str) -> tuple[int, str]:
    """Return how many of the first words are one, and that.

    What is per a unit is a quotient. Where nothing says per, a letter alone is an index (`i_u_s`), unless it
    is a unit by itself (`psi_V_s`) or that of m/s (`v_m_s`), and min behind an angle is its least value.
    """
    first, second, third = (*words, "", "")[:3]
    if second.lower() == "per" and is_unit(third):
        return 3, f"{first}/{third}"
    quotient, product = f"{first}/{second}", f"{first}{second}"
    turn = unit_factor(first, "rad")
    is_least = second.lower() in _LIMITS and turn is not None and not math.isclose(turn, 2.0 * math.pi)
    if not first or not second or is_least:
        return 1, first
    if is_unit(quotient) and (len(first) > 1 or first.isdigit()):
        return 2, quotient
    if quotient == "m/s" and unit == "rad/s":  # of any other kind they are indices
        return 2, quotient
    return (2, product) if all(map(is_unit, (first, second, product))) else (1, first)


def _joined(words: list[str], between: str, unit: str) -> str:
    """Return words as one unit of the kind of `unit`, or nothing."""
    text = between.join(words)
    if len(text) < 2 and text.isalnum():
        return ""
    # i_m_A is the magnetizing current of phase A and T_m_Nm the motor's torque; N m and milli amps are units
    is_index = len(words[0]) < 2 and (unit != "Nm" or unit_factor(words[-1], unit) is not None)
    if len(words) > 1 and not between and is_index:
        return ""
    return text if unit_factor(text, unit) is not None else ""
