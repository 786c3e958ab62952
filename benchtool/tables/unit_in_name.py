"""Units in the name of a column: `Iq_mA`, `time ms`, `omega_deg_s`, `Current_mA_filtered`, `MotorRPM`."""

from __future__ import annotations

import re

from benchtool.tables.units import unit_factor

_UNIT_SIGNS = ":=@"  # between a name and its unit: t:ms, i=mA
_BLANKS = r"[_\s]+"
_JOINTS = rf"[_\s.,;{_UNIT_SIGNS}-]+"
_NO_LETTERS = r"(?:[^\w°/·^-]|_)+"
_HUMP = r"(?<=[a-z0-9])(?<![mukn])[A-Z](?=[a-z])"  # behind m it may be that of mNm
_LIMITS = ("min", "max")
_GLUED = {
    "s": re.compile(r"(?:t|time|timestamp|zeit|temps)([mun]s)", re.IGNORECASE),
    "rad": re.compile(r".+(deg)", re.IGNORECASE),
    "rad/s": re.compile(r".+(rpm)", re.IGNORECASE),
}
_PERHAPS_GLUED = re.compile(r".*[A-Za-z0-9]([munk](?:A|Nm))")


def unit_in_name(name: str, unit: str) -> str:
    """Return the unit of the kind of `unit` that a name ends in (`Iq_mA`, `time ms`, `omega_deg_s`, `i:mA`,
    `speedRpm`), else the one that it begins with (`ms_today`), is (`rpm`), or has as a word of its own
    (`Ia |mA| filtered`), or nothing.

    A letter alone is an index (i_s, u_h), and min at the beginning or within a name a least value.
    """
    name = name.strip()
    joined = re.sub(_HUMP, lambda match: f"_{match[0].lower()}", name)
    splits = [re.split(*each) for each in ((_BLANKS, name), (_JOINTS, name), (_JOINTS, joined))]
    for words in splits:
        for count, between in ((3, "/"), (2, "/"), (2, ""), (1, "")):
            if len(words) > count and (found := _joined(words[-count:], between, unit)):
                return found
    first = splits[0][0]
    if first.lower() not in _LIMITS and (found := _joined([first], "", unit)):
        return found
    glued = _GLUED[unit].fullmatch(splits[-1][-1]) if unit in _GLUED else None
    if glued is not None:
        return glued[1].lower()
    words = [each for each in re.split(_NO_LETTERS, joined) if each.lower() not in _LIMITS]
    for end in range(len(words), 0, -1):
        for count, between in ((2, "/"), (2, ""), (1, "")):
            if found := _joined(words[max(0, end - count) : end], between, unit):
                return found
    return ""


def perhaps_in_name(name: str, unit: str) -> str:
    """Return the unit of the kind of `unit` that a name may end in with nothing before it, or nothing: that
    of `ImA` may be a current in mA, and that of `IuA` phase u of motor A."""
    match = _PERHAPS_GLUED.fullmatch(name.strip())
    return match[1] if match is not None and unit_factor(match[1], unit) is not None else ""


def name_before_unit(name: str) -> str:
    """Return a name without the sign of its unit and what is behind it (`t:ms`, `i=mA`)."""
    return re.split(f"[{_UNIT_SIGNS}]", name)[0].strip()


def _joined(words: list[str], between: str, unit: str) -> str:
    """Return words as one unit of the kind of `unit`, or nothing."""
    kept = [each for each in words if each != "per"]
    text = between.join(kept)
    if len(text) < 2 and text.isalnum():
        return ""
    # i_m_A is the magnetizing current of phase A; N m and milli amps are units
    if len(kept) > 1 and not between and unit != "Nm" and len(kept[0]) < 2:
        return ""
    is_mega = text.startswith("M") and unit in ("A", "Nm")  # a moving average
    return text if not is_mega and unit_factor(text, unit) is not None else ""
