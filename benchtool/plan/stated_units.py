"""Units in the keys of a plan: `torque_mean_Nm = { max = 1.0 }`, by measurement and stated unit."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Final

from pydantic import ValidationError
from pydantic_core import InitErrorDetails

from benchtool.document import unit_suffix
from benchtool.plan.lazy_catalogue import catalogue
from benchtool.plan.limits import Limit

_MAY_END_WITH_A_UNIT: Final = re.compile(r"\w*_(percent|deg|rad|m?s|us|rpm|ppm|\w*[A-Z]\w*)")


def with_units(limits: Any, *place: str) -> Any:
    """Return the limits by measurement, the unit that a key ends with as that of its limit.

    A wrong unit stays in the key, and is reported by the check of names. `place` is where the table is, for
    messages.
    """
    if not isinstance(limits, Mapping):
        return limits
    found: dict[Any, Any] = {}
    for key, limit in limits.items():
        name, unit = _split(key)
        if name in found or (unit and name in limits):
            raise ValueError(f"the limit of {name} appears twice, once is expected: leave one out")
        found[name] = _in_unit(limit, unit, (*place, str(key))) if unit else limit
    return found


def without_units(numbers: Any) -> Any:
    """Return the published numbers by measurement; a unit that a key ends with, the measurement's, is left
    out."""
    if not isinstance(numbers, Mapping):
        return numbers
    return {_split(key)[0]: value for key, value in numbers.items()}


def _split(key: Any) -> tuple[Any, str]:
    """Return the measurement and unit of a key; the key and no unit where it does not end with its
    measurement's."""
    may = isinstance(key, str) and _MAY_END_WITH_A_UNIT.fullmatch(key)
    stated = catalogue().stated_unit(key) if may else None
    if stated is None:
        return key, ""
    name, unit = stated
    quantity = catalogue().quantity(name)
    assert quantity is not None  # stated_unit knows it
    fixed = unit_suffix(quantity.unit) if isinstance(quantity.unit, str) else unit
    return (name, unit) if unit == fixed else (key, "")


def _in_unit(limit: Any, unit: str, place: tuple[str, ...]) -> Any:
    """Return a limit with the unit that its key states; errors refer to the key as it is written."""
    if isinstance(limit, Limit):
        return limit if limit.unit is not None else limit.model_copy(update={"unit": unit})
    if not isinstance(limit, Mapping):
        return limit
    try:
        return Limit.model_validate({"unit": unit, **limit})
    except ValidationError as failed:
        errors = [
            InitErrorDetails(
                type=each["type"], loc=(*place, *each["loc"]), input=each["input"], ctx=each.get("ctx", {})
            )
            for each in failed.errors()
        ]
        raise ValidationError.from_exception_data(Limit.__name__, errors) from None
