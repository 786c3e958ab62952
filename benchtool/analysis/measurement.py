"""A number with its unit and its definition, and its form in JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from benchtool.errors import AnalysisError

MeasurementJson = dict[str, float | str | None]


@dataclass(frozen=True)
class Measurement:
    """One result: `definition` is a line that lets another person compute the same number.

    `value` is nan where the quantity is undefined; the definition then ends with the reason.
    """

    name: str
    value: float
    unit: str
    definition: str

    @classmethod
    def undefined(cls, name: str, unit: str, definition: str, reason: str) -> Measurement:
        """A quantity that these samples do not define."""
        return cls(name, math.nan, unit, f"{definition}; undefined here: {reason}")

    def to_json(self) -> MeasurementJson:
        """`value`, `unit` and `definition`; JSON has no nan and no infinity, so these become null."""
        value = float(self.value) if math.isfinite(self.value) else None
        return {"value": value, "unit": self.unit, "definition": self.definition}


def measurements_to_json(measurements: Iterable[Measurement]) -> dict[str, MeasurementJson]:
    """Measurements by name, in their order."""
    return {each.name: each.to_json() for each in measurements}


def measurements_from_json(document: Mapping[str, Any]) -> tuple[Measurement, ...]:
    """What `measurements_to_json` wrote.

    Raises:
        AnalysisError: an entry has not the keys value, unit and definition, or one is of another type.
    """
    return tuple(_measurement(name, entry) for name, entry in document.items())


def _measurement(name: str, entry: Any) -> Measurement:
    match entry:
        case {"value": float() | int() | None as value, "unit": str(unit), "definition": str(definition)}:
            return Measurement(name, math.nan if value is None else float(value), unit, definition)
    raise AnalysisError(
        f"measurement '{name}' is {entry!r:.80}: expected value (number or null), unit and definition "
        f"(text); analyze the recording again"
    )
