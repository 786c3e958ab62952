"""Numbers in a report, with significant digits by their uncertainty."""

from __future__ import annotations

import math
from typing import Final

from benchtool.analysis.uncertainty import Uncertainty

NOTHING: Final = "–"
_MINUS: Final = "−"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_DIGITS = 4
_MOST_DIGITS = 10
_GIVEN_DIGITS = 7
_DIGITS_OF_A_PERSON = 12  # beyond these are the rounding errors of binary numbers
_OF_ONE_SIZE = 1e3
_LEAST_PROBABILITY = 0.001
_SMALLEST, _LARGEST = 1e-3, 1e6  # outside, powers of ten are set apart
_PLAIN = 1e9  # whole numbers below it are written out
_ROUNDING = 1e-30  # in SI units: smaller numbers are what rounding leaves of zero
_WHOLE = 100.0  # from so many degrees of freedom on, parts of one do not show in k


def number(value: float, digits: int = _DIGITS) -> str:
    """Return a number to so many significant digits, whole numbers in full; a dash for what has no value."""
    if not math.isfinite(value):
        return NOTHING
    if abs(value) < _ROUNDING:
        return "0"
    if float(value).is_integer() and abs(value) < _PLAIN:
        return _signed(f"{value:.0f}")
    exponent = _exponent(value, digits)
    if not _SMALLEST <= abs(value) < _LARGEST:
        return _signed(f"{value / 10.0**exponent:.{digits - 1}f} × {_power(exponent)}")
    return _signed(f"{value:.{max(0, digits - 1 - exponent)}f}")


def stated(value: float, uncertainty: float | None) -> str:
    """Return a value with its uncertainty, standard or expanded as the heading says: the uncertainty to two
    digits and the value to the same place (JCGM 100:2008, 7.2.6), up to ten digits, to the last of which a
    smaller uncertainty is rounded up; without one, four significant digits."""
    if uncertainty is None or not (math.isfinite(value) and _ROUNDING <= uncertainty < math.inf):
        return number(value)
    largest = max(abs(value), uncertainty)
    scaled = 0 if _SMALLEST <= largest < _LARGEST else _exponent(largest, 2)
    value, uncertainty = value / 10.0**scaled, uncertainty / 10.0**scaled
    place = _exponent(uncertainty, 2) - 1
    most = _MOST_DIGITS - 1 - _exponent(max(abs(value), uncertainty), 2)
    decimals = max(0, min(-place, most))
    if place > 0:
        value, uncertainty = round(value, -place), round(uncertainty, -place)
    if decimals < -place:  # it is of the last of these digits or less, and is rounded up
        uncertainty = math.ceil(uncertainty * 10.0**decimals) / 10.0**decimals
    text = f"{_signed(f'{value:z.{decimals}f}')} ± {uncertainty:.{decimals}f}"
    return f"({text}) × {_power(scaled)}" if scaled else text


def with_expanded(value: float, uncertainty: Uncertainty | None) -> str:
    """Return a value ± its expanded uncertainty for 95 %, which is the default meaning of ±."""
    return stated(value, None if uncertainty is None else uncertainty.expanded)


def with_unit(text: str, unit: str) -> str:
    """Return a number as it is written, and its unit behind it; without a blank where there is none."""
    return f"{text} {unit}" if unit else text


def placed(value: float, uncertainty: float | None) -> str:
    """Return a value alone, to the place of its uncertainty as `stated` has it."""
    text, sign, rest = stated(value, uncertainty).partition(" ± ")
    return text.removeprefix("(") + rest.partition(")")[2] if sign else text


def signed(value: float, digits: int = 3) -> str:
    """Return a difference, with its sign."""
    return f"+{number(value, digits)}" if value > 0 else number(value, digits)


def probability(value: float) -> str:
    """Return a probability to three decimals; one that rounds to 0 or 1 as beyond the last of them."""
    if value < _LEAST_PROBABILITY:
        return f"< {_LEAST_PROBABILITY}"
    return f"> {1.0 - _LEAST_PROBABILITY}" if value > 1.0 - _LEAST_PROBABILITY else f"{value:.3f}"


def count_of(count: int, one: str, several: str = "") -> str:
    """Return a number of things: `1 row`, `2 rows`, with `several` if that is not `one` and an s."""
    return f"{count} {one if count == 1 else several or f'{one}s'}"


def degrees(dof: float) -> str:
    """Return degrees of freedom to three digits, and to the whole where they are many."""
    if not math.isfinite(dof):
        return "∞"
    return number(round(dof) if dof >= _WHOLE else float(f"{dof:.3g}"), 3)


def raw(value: object, digits: int = _GIVEN_DIGITS) -> str:
    """Return a number or a setting as it was given, without further digits; powers of ten set apart."""
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, float):
        return str(value)
    factor, _, exponent = f"{value:.{digits}g}".partition("e")
    if not exponent:
        return _signed(factor)
    if 1.0 < abs(value) < _PLAIN:
        return _signed(f"{float(f'{factor}e{exponent}'):.0f}")
    return _signed(f"{factor} × {_power(int(exponent))}")


def as_written(*values: float) -> tuple[str, ...]:
    """Return numbers with the digits that a person has written, ten at most, of a computed one seven; those
    of one size in one style, all plain or all with the power of ten of the largest."""
    texts = [raw(value, _DIGITS_OF_A_PERSON) for value in values]
    texts = [
        text
        if sum(each.isdigit() for each in text.partition(" ")[0].lstrip("−0.")) <= _MOST_DIGITS
        else raw(value)
        for value, text in zip(values, texts, strict=True)
    ]
    sizes = [abs(value) for value in values if value]
    has_power = [" × " in text for value, text in zip(values, texts, strict=True) if value]
    if not any(has_power) or all(has_power) or max(sizes) > _OF_ONE_SIZE * min(sizes):
        return tuple(texts)
    exponent = _exponent(max(sizes), _GIVEN_DIGITS)
    return tuple(f"{raw(value / 10.0**exponent)} × {_power(exponent)}" if value else "0" for value in values)


def _exponent(value: float, digits: int) -> int:
    """Return the power of ten of the first digit, once rounded to `digits`."""
    return int(f"{abs(value):.{digits - 1}e}".partition("e")[2])


def _signed(text: str) -> str:
    return text.replace("-", _MINUS)


def _power(exponent: int) -> str:
    return "10" + str(exponent).translate(_SUPERSCRIPT)
