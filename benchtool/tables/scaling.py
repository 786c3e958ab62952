"""Unit, gain and offset of a column's values, stated behind its name: `Iq:mA`, `CH1:A*10-0.2`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from benchtool.errors import AnalysisError
from benchtool.tables.units import unit_factor, units_of

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_SCALING = re.compile(
    rf"(?P<unit>[^*]*?)\s*(?:\*\s*(?P<gain>[+-]?{_NUMBER}))?\s*(?P<offset>[+-]\s*{_NUMBER})?"
)
_VALUE = re.compile(rf"(?P<number>[+-]?{_NUMBER})(?:\s*(?P<unit>[^\d\s.+-].*)|\s+(?P<per>1\s*/.*))?")


@dataclass(frozen=True)
class Scaling:
    """A value is (cell x gain + offset) in `unit`; the unit is empty where none is stated."""

    unit: str
    gain: float = 1.0
    offset: float = 0.0


def scaling(text: str, si_unit: str) -> Scaling:
    """Parse the scaling behind the colon of a column: `mA`, `A*10`, `mA*0.5+0.1`, `*-1`, `A-0.2`.

    Text that is a unit as a whole (min-1) is taken as a unit.

    Raises:
        AnalysisError: the gain is zero or not finite, or the offset not finite.
    """
    match = None if unit_factor(text, si_unit) is not None else _SCALING.fullmatch(text.strip())
    if match is None:
        return Scaling(text.strip())
    gain = float(match["gain"] or 1.0)
    offset = float((match["offset"] or "0").replace(" ", ""))
    if gain == 0.0 or not (math.isfinite(gain) and math.isfinite(offset)):
        raise AnalysisError(
            f"'{text}' scales by {gain:g} and adds {offset:g}, a gain other than zero and finite numbers are "
            f"expected: as A*10-0.2, a value is cell x gain + offset in that unit"
        )
    return Scaling(match["unit"].strip(), gain, offset)


def quantity(text: str, si_unit: str) -> float | None:
    """Return a number with its unit, as `1500rpm` or `750 1/min`, in `si_unit`; None where it is not one, or
    may be another one (`7501/min`)."""
    match = _VALUE.fullmatch(text.strip())
    if match is not None and _is_joined(match):
        return None
    factor = None if match is None else unit_factor(match["unit"] or match["per"] or "", si_unit)
    return None if match is None or factor is None else float(match["number"]) * factor


def _is_joined(match: re.Match[str]) -> bool:
    """Return whether the last digit of a number may be the one of a unit 1/min."""
    return match["number"].endswith("1") and (match["unit"] or "").startswith("/")


def speed_hint(text: str) -> str:
    """Return how a constant speed is stated, where a text that names no column may have been meant as one;
    empty where it does not begin with a number."""
    match = _VALUE.fullmatch(text.strip())
    if match is None:
        return ""
    number, unit = match["number"], match["unit"] or match["per"] or ""
    if _is_joined(match):
        blank = f", or a constant speed with a blank before its unit, as '{number[:-1]} 1{unit}'"
        return f"{blank} or '{number} 1{unit}'"
    if unit and unit_factor(unit, "Hz") is not None:
        turns = float(number) * float(unit_factor(unit, "Hz") or 1.0)
        return (
            f", or a constant speed, as '{turns:.12g}rev/s' or '{60.0 * turns:.12g}rpm' if '{unit}' counts "
            f"the shaft's revolutions and not the current's periods"
        )
    units = f": one of {units_of('rad/s')}, 1/min" if unit else ""
    return f", or a constant speed with its unit, as '{number}rpm'{units}"
