"""A number with its unit, its definition and what it rests on; tables of such numbers; their form in JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from pydantic import TypeAdapter, ValidationError

from benchtool.errors import AnalysisError

MeasurementJson = dict[str, Any]


@dataclass(frozen=True)
class Basis:
    """The samples and the processing behind a number; what does not apply is None or empty.

    `samples` were used, taken at `sample_rate_Hz` over `duration_s`, with `gaps` places where rows are
    missing; components up to `bandwidth_Hz` could contribute. `window` names the window and what it spans,
    `harmonics` is the highest harmonic counted, `reference` what a ratio is a ratio to.
    """

    samples: float | None = None
    sample_rate_Hz: float | None = None
    duration_s: float | None = None
    bandwidth_Hz: float | None = None
    window: str = ""
    harmonics: int | None = None
    reference: str = ""
    gaps: int | None = None

    def to_json(self) -> dict[str, float | int | str]:
        """The fields that apply."""
        return {key: value for key, value in asdict(self).items() if value is not None and value != ""}


@dataclass(frozen=True)
class Uncertainty:
    """Standard uncertainty (one standard deviation; JCGM 100:2008, 2.3.1) in the measurement's unit.

    `source` says what it was estimated from, and with that what it leaves out.
    """

    standard: float
    source: str


@dataclass(frozen=True)
class Measurement:
    """One result: `definition` is a line that lets another person compute the same number.

    `value` is nan where the quantity is undefined; the definition then ends with the reason. `uncertainty` is
    None where the data give none.
    """

    name: str
    value: float
    unit: str
    definition: str
    basis: Basis = Basis()
    uncertainty: Uncertainty | None = None

    @classmethod
    def undefined(
        cls, name: str, unit: str, definition: str, reason: str, basis: Basis | None = None
    ) -> Measurement:
        """A quantity that these samples do not define."""
        return cls(name, math.nan, unit, f"{definition}; undefined here: {reason}", basis or Basis())

    def to_json(self) -> MeasurementJson:
        """`value`, `unit`, `definition`, and where there are any `basis` and `uncertainty`.

        JSON has no nan and no infinity, so these become null.
        """
        document: MeasurementJson = {
            "value": _finite(self.value),
            "unit": self.unit,
            "definition": self.definition,
        }
        if basis := self.basis.to_json():
            document["basis"] = basis
        if self.uncertainty is not None:
            document["uncertainty"] = {
                "standard": _finite(self.uncertainty.standard),
                "source": self.uncertainty.source,
            }
        return document


@dataclass(frozen=True)
class Table:
    """Many numbers of one kind, such as harmonics: `columns` are (name, unit), `rows` as wide as they are."""

    name: str
    definition: str
    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[float, ...], ...]
    basis: Basis = Basis()

    def to_json(self) -> dict[str, Any]:
        """`definition`, `basis`, `columns` and `rows`; what is not finite is null."""
        return {
            "definition": self.definition,
            "basis": self.basis.to_json(),
            "columns": [{"name": name, "unit": unit} for name, unit in self.columns],
            "rows": [[_finite(value) for value in row] for row in self.rows],
        }


def measurements_to_json(measurements: Iterable[Measurement]) -> dict[str, MeasurementJson]:
    """Measurements by name, in their order."""
    return {each.name: each.to_json() for each in measurements}


def tables_to_json(tables: Iterable[Table]) -> dict[str, dict[str, Any]]:
    """Tables by name, in their order."""
    return {each.name: each.to_json() for each in tables}


def measurements_from_json(document: Mapping[str, Any]) -> tuple[Measurement, ...]:
    """What `measurements_to_json` wrote.

    Raises:
        AnalysisError: an entry has not the keys value, unit and definition, or one is of another type.
    """
    return tuple(_measurement(name, entry) for name, entry in document.items())


_BASIS = TypeAdapter(Basis)
_UNCERTAINTY = TypeAdapter(Uncertainty | None)


def _measurement(name: str, entry: Any) -> Measurement:
    match entry:
        case {"value": float() | int() | None as value, "unit": str(unit), "definition": str(definition)}:
            number = math.nan if value is None else float(value)
            try:
                basis = _BASIS.validate_python(entry.get("basis", {}))
                uncertainty = _UNCERTAINTY.validate_python(entry.get("uncertainty"))
            except ValidationError:
                pass
            else:
                return Measurement(name, number, unit, definition, basis, uncertainty)
    raise AnalysisError(
        f"measurement '{name}' is {entry!r:.80}: expected value (number or null), unit and definition "
        f"(text); analyze the recording again"
    )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
