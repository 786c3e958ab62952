"""A number with its unit, its definition and what it rests on; tables of such numbers; their form in JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from pydantic import BaseModel, TypeAdapter, ValidationError

from benchtool.analysis.uncertainty import Contribution, InstrumentError, Uncertainty
from benchtool.errors import AnalysisError

MeasurementJson = dict[str, Any]


@dataclass(frozen=True)
class Basis:
    """The samples and the processing behind a number; what does not apply is None or empty.

    `samples` were used, taken at `sample_rate_Hz` over `duration_s`, with `gaps` places where rows are
    missing; components up to `bandwidth_Hz` could contribute. `window` names the window and what it spans,
    `harmonics` is the highest harmonic counted, `reference` what a ratio is a ratio to. `sensors` says
    what is not known of the sensors, or what they do not let through. `alignment_s` is the standard
    uncertainty with which samples of another clock stand at the drive's ticks.
    """

    samples: float | None = None
    sample_rate_Hz: float | None = None
    duration_s: float | None = None
    bandwidth_Hz: float | None = None
    window: str = ""
    harmonics: int | None = None
    reference: str = ""
    gaps: int | None = None
    sensors: str = ""
    alignment_s: float | None = None

    def to_json(self) -> dict[str, float | int | str]:
        """The fields that apply."""
        return {key: value for key, value in asdict(self).items() if value is not None and value != ""}


@dataclass(frozen=True)
class Measurement:
    """One result: `definition` is a line that lets another person compute the same number.

    `value` is nan where the quantity is undefined, and `reason` says why. `uncertainty` is None where the
    data give none.
    """

    name: str
    value: float
    unit: str
    definition: str
    basis: Basis = Basis()
    uncertainty: Uncertainty | None = None
    reason: str = ""

    @classmethod
    def undefined(
        cls, name: str, unit: str, definition: str, reason: str, basis: Basis | None = None
    ) -> Measurement:
        """A quantity that these samples do not define."""
        return cls(name, math.nan, unit, definition, basis or Basis(), reason=reason)

    def to_json(self) -> MeasurementJson:
        """`value`, `unit`, `definition`, and where there are any `reason`, `basis` and `uncertainty`.

        JSON has no nan and no infinity, so these become null.
        """
        document: MeasurementJson = {
            "value": _finite(self.value),
            "unit": self.unit,
            "definition": self.definition,
        }
        if self.reason:
            document["reason"] = self.reason
        if basis := self.basis.to_json():
            document["basis"] = basis
        if self.uncertainty is not None:
            document["uncertainty"] = self.uncertainty.to_json()
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


def tables_from_json(document: Mapping[str, Any]) -> tuple[Table, ...]:
    """What `tables_to_json` wrote.

    Raises:
        AnalysisError: an entry is none of a table.
    """
    try:
        return tuple(_Table.model_validate(entry).read(name) for name, entry in document.items())
    except ValidationError as failed:
        first = failed.errors()[0]
        raise AnalysisError(
            f"tables have {'.'.join(str(part) for part in first['loc'])}: {first['msg'].lower()}, what "
            f"benchtool wrote is expected: analyze the recording again"
        ) from None


_BASIS = TypeAdapter(Basis)
_OF_A_BUNDLE = "; undefined here: "  # what older bundles have between definition and reason


class _Column(BaseModel):
    name: str
    unit: str


class _Table(BaseModel):
    definition: str
    basis: Basis = Basis()
    columns: tuple[_Column, ...]
    rows: tuple[tuple[float | None, ...], ...]

    def read(self, name: str) -> Table:
        rows = tuple(tuple(_or(value, math.nan) for value in row) for row in self.rows)
        columns = tuple((each.name, each.unit) for each in self.columns)
        return Table(name, self.definition, columns, rows, self.basis)


class _Contribution(BaseModel):
    name: str
    evaluation: Literal["A", "B"]
    standard: float | None
    dof: float | None = None
    instrument: InstrumentError | None = None
    sign: Literal[-1, 1] = 1

    def read(self) -> Contribution:
        standard, dof = _or(self.standard, math.nan), _or(self.dof, math.inf)
        return Contribution(self.name, self.evaluation, standard, dof, self.instrument, self.sign)


class _Uncertainty(BaseModel):
    """What `Uncertainty.to_json` wrote, or an older version with `standard` and `source` alone."""

    standard: float | None
    source: str
    dof: float | None = None
    budget: tuple[_Contribution, ...] = ()
    half_width: float | None = None

    def read(self) -> Uncertainty:
        budget = tuple(each.read() for each in self.budget)
        standard, dof = _or(self.standard, math.nan), _or(self.dof, math.inf)
        return Uncertainty(standard, self.source, dof, budget, self.half_width)


def _measurement(name: str, entry: Any) -> Measurement:
    match entry:
        case {"value": float() | int() | None as value, "unit": str(unit), "definition": str(definition)}:
            number = math.nan if value is None else float(value)
            text, _, older = definition.partition(_OF_A_BUNDLE)
            reason = entry.get("reason", older)
            try:
                basis = _BASIS.validate_python(entry.get("basis", {}))
                found = entry.get("uncertainty")
                uncertainty = None if found is None else _Uncertainty.model_validate(found).read()
            except ValidationError:
                pass
            else:
                if isinstance(reason, str):
                    return Measurement(name, number, unit, text, basis, uncertainty, reason)
    raise AnalysisError(
        f"measurement '{name}' is {entry!r:.80}: expected value (number or null), unit and definition "
        f"(text); analyze the recording again"
    )


def _or(value: float | None, missing: float) -> float:
    return missing if value is None else value


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
