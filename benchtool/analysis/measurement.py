"""A number with its unit, definition, basis and uncertainty; tables of such numbers; their JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, TypeAdapter, ValidationError

from benchtool.analysis.numbers import number, with_expanded, with_unit
from benchtool.analysis.sensitivity import MEASURED_AGAIN, Sensitivities
from benchtool.analysis.uncertainty import (
    Contribution,
    InstrumentError,
    Uncertainty,
    combined,
    coverage_factor,
)
from benchtool.block import Channel
from benchtool.document import unit_suffix
from benchtool.errors import AnalysisError
from benchtool.notebook import table_html

MeasurementJson = dict[str, Any]


def _sentences(stated: object) -> object:
    """Return the one text that a document has as a tuple of it."""
    return (stated,) if isinstance(stated, str) else stated


@dataclass(frozen=True)
class Basis:
    """The samples and the processing behind a number; fields that do not apply are None or empty.

    `samples` were used, taken at `sample_rate_Hz` over `duration_s`, with `gaps` places where rows are
    missing; components up to `bandwidth_Hz` could contribute. `window` names the window and what it spans,
    `harmonics` is the highest harmonic counted, `reference` what a ratio is a ratio to. `sensors` states what
    is unknown about the sensors, or which components they attenuate, a sentence each. `alignment_s` is the
    standard uncertainty with which samples of another clock stand at the drive's ticks. `line_Hz` is where
    the one line of a spectrum is that was chosen as the largest. `frequency_Hz` is that of the line that a
    number is, chosen or not; of a table of orders that of the first. `order` is how often in a revolution a
    component repeats itself that comes with the angle of the shaft, such as the one that was chosen as the
    largest. `bin_Hz` is the width of the bins that noise is stated of, and `band` half the width of the band,
    in the signal's unit, within which a signal counts as settled. `span_s` is how long after a step its
    samples count. `angle_Hz` is the electrical frequency by a rotor angle, where the phase of the signal gave
    another, and `flat_crest` the share of a period for which a current is level at its crest, if it is.
    """

    samples: float | None = None
    sample_rate_Hz: float | None = None
    duration_s: float | None = None
    bandwidth_Hz: float | None = None
    window: str = ""
    harmonics: int | None = None
    reference: str = ""
    gaps: int | None = None
    sensors: Annotated[tuple[str, ...], BeforeValidator(_sentences)] = ()
    alignment_s: float | None = None
    line_Hz: float | None = None
    frequency_Hz: float | None = None
    order: int | None = None
    bin_Hz: float | None = None
    band: float | None = None
    span_s: float | None = None
    angle_Hz: float | None = None
    flat_crest: float | None = None

    def to_json(self) -> dict[str, float | int | str]:
        """Return the fields that apply; samples as the whole number nearest to that in whole periods, the
        sentences on sensors as one text."""
        fields = asdict(self) | {"sensors": "; ".join(self.sensors)}
        document = {key: value for key, value in fields.items() if value is not None and value != ""}
        return document if self.samples is None else document | {"samples": round(self.samples)}


@dataclass(frozen=True)
class Correction:
    """What was `added` to a value as it was read, in its unit, for a known effect `of` a sensor (JCGM
    100:2008, 3.2.3)."""

    added: float
    of: str


@dataclass(frozen=True)
class Unresolved:
    """What is known of an uncertainty beside the resolution of `channels` that read the same in every sample:
    `beside`."""

    channels: tuple[Channel, ...]
    beside: Uncertainty

    @property
    def reason(self) -> str:
        """Why that is not the whole, and what would make it so."""
        names = " and ".join(each.name for each in self.channels)
        keys = (
            f"resolution_{unit_suffix(each.unit)} in [bench.channels.{each.name}]" for each in self.channels
        )
        verb = "read" if len(self.channels) > 1 else "reads"
        return (
            f"{names} {verb} the same in every sample, which does not show the step of its converter: state "
            f"{' and '.join(keys)} of the profile"
        )


@dataclass(frozen=True)
class Measurement:
    """One result: `definition` is a line from which the same number can be computed.

    `value` is nan where the quantity is undefined, and `reason` says why. `uncertainty` is None where the
    data give none. `repeatability` is by how much the value of another record of the same state differs
    besides (JCGM 200:2012, 2.21): of a mean over this record alone the uncertainty does not hold it.
    `uncertainty_reason` says why a value has no uncertainty. `correction` is in the value. `below` is what an
    amplitude without a value is less than, as it does not stand out of the noise.
    `in_common_band` is what a number by the drive's estimate is in the band of a slower torque transducer,
    which ends at its `basis.bandwidth_Hz`. `sensitivities` are to the errors of sensors, and `of_sensors`
    what these come to where the data give no uncertainty; `unresolved` is what stated resolutions make whole.
    None of these is part of the document.
    """

    name: str
    value: float
    unit: str
    definition: str
    basis: Basis = Basis()
    uncertainty: Uncertainty | None = None
    reason: str = ""
    repeatability: Contribution | None = None
    in_common_band: Measurement | None = None
    uncertainty_reason: str = ""
    correction: Correction | None = None
    below: float | None = None
    sensitivities: Sensitivities = field(default=MEASURED_AGAIN, compare=False, repr=False)
    of_sensors: tuple[Contribution, ...] = field(default=(), compare=False, repr=False)
    unresolved: Unresolved | None = field(default=None, compare=False, repr=False)

    @property
    def known_uncertainty(self) -> Uncertainty | None:
        """The uncertainty, or what is known of it where a resolution does not show."""
        return self.uncertainty if self.unresolved is None else self.unresolved.beside

    def without_uncertainty(self, reason: str) -> Measurement:
        """Return it without an uncertainty for a reason; what had none keeps its own."""
        if self.uncertainty is None:
            return self
        return replace(self, uncertainty=None, uncertainty_reason=reason)

    def without_resolution_of(self, *channels: Channel) -> Measurement:
        """Return it without an uncertainty where channels that it rests on read the same in every sample."""
        if not channels or self.uncertainty is None:
            return self
        unresolved = Unresolved(channels, self.uncertainty)
        return replace(self, uncertainty=None, uncertainty_reason=unresolved.reason, unresolved=unresolved)

    def with_stated_resolutions(self) -> Measurement:
        """Return it with the uncertainty that is known beside resolutions, which are stated and enter as
        those of sensors do."""
        if self.unresolved is None:
            return self
        return replace(self, uncertainty=self.unresolved.beside, uncertainty_reason="", unresolved=None)

    @property
    def as_read(self) -> float:
        """The value without its correction."""
        return self.value if self.correction is None else self.value - self.correction.added

    @property
    def uncertainty_of_state(self) -> Uncertainty | None:
        """That of the value as one of any record of the same state: with the repeatability."""
        own, further = self.uncertainty, self.repeatability
        if own is None or further is None:
            return own
        width = own.half_width
        if width is not None:
            width = math.hypot(width, coverage_factor(further.dof) * further.standard)
        return combined((*own.budget, further), own.source, half_width=width)

    @classmethod
    def undefined(
        cls, name: str, unit: str, definition: str, reason: str, basis: Basis | None = None
    ) -> Measurement:
        """Return a quantity that these samples do not define."""
        return cls(name, math.nan, unit, definition, basis or Basis(), reason=reason)

    @property
    def upper_bound(self) -> float | None:
        """What it is less than where it has no value; None where it has one, or no bound is known."""
        return None if math.isfinite(self.value) else self.below

    @property
    def is_told(self) -> bool:
        """Whether it has a value or a bound, so that it says something in a table."""
        return math.isfinite(self.value) or self.upper_bound is not None

    @property
    def text(self) -> str:
        """The value with its expanded uncertainty for 95 %, `0.0501 ± 0.0016`, or what it is less than."""
        if self.upper_bound is not None:
            return f"< {number(self.upper_bound, 2)}"
        return with_expanded(self.value, self.uncertainty)

    @property
    def in_unit(self) -> str:
        """The same with its unit, `0.0501 ± 0.0016 Nm`."""
        return with_unit(self.text, self.unit)

    def __str__(self) -> str:
        """Return the same, and why it has no value or no uncertainty."""
        if self.reason:
            return f"{self.in_unit} ({self.reason})"
        reason = self.uncertainty_reason
        return f"{self.in_unit} (no uncertainty: {reason})" if reason else self.in_unit

    def _repr_html_(self) -> str:
        rows = [(self.name, str(self)), ("definition", self.definition)]
        if self.uncertainty is not None:
            rows.append(("uncertainty from", self.uncertainty.source))
        if self.correction is not None:
            rows.append(
                ("corrected by", f"{number(self.correction.added)} {self.unit}: {self.correction.of}")
            )
        rows += [(key, str(value)) for key, value in self.basis.to_json().items()]
        return table_html(("measurement", "value ± U (95 %)"), rows)

    def to_json(self) -> MeasurementJson:
        """`value`, `unit`, `definition`, and where there are any `reason`, `basis` and `uncertainty`, or
        `uncertainty_reason`.

        JSON has no nan and no infinity, so these become null.
        """
        document: MeasurementJson = {
            "value": _finite(self.value),
            "unit": self.unit,
            "definition": self.definition,
        }
        if self.reason:
            document["reason"] = self.reason
        if self.uncertainty_reason:
            document["uncertainty_reason"] = self.uncertainty_reason
        if basis := self.basis.to_json():
            document["basis"] = basis
        if self.uncertainty is not None:
            document["uncertainty"] = self.uncertainty.to_json()
        if self.repeatability is not None:
            document["repeatability"] = self.repeatability.to_json()
        if self.correction is not None:
            document["correction"] = {"added": _finite(self.correction.added), "of": self.correction.of}
        if self.below is not None:
            document["below"] = _finite(self.below)
        return document


@dataclass(frozen=True)
class LineColumn:
    """A column of a table whose numbers are measurements of lines, one in each row.

    `uncertainty` is the column of their standard uncertainties, `channel` what they were computed from,
    `frequency` the column of the lines' frequencies where there are no orders; `is_amplitude` tells sizes of
    lines from where they are.
    """

    value: str
    uncertainty: str
    channel: str
    frequency: str = ""
    is_amplitude: bool = True


@dataclass(frozen=True)
class Table:
    """Many numbers of one kind, such as harmonics: `columns` are (name, unit), `rows` as wide as they are.

    `lines` are the columns that hold measurements; `uncertainty_reason` says why rows have no uncertainty.
    """

    name: str
    definition: str
    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[float, ...], ...]
    basis: Basis = Basis()
    uncertainty_reason: str = ""
    lines: tuple[LineColumn, ...] = ()

    def without_uncertainty(self, reason: str) -> Table:
        """Return it without the uncertainties of its measurements, for a reason."""
        names = {each.uncertainty for each in self.lines}
        unknown = [name in names for name, _ in self.columns]
        rows = tuple(
            tuple(math.nan if none else value for value, none in zip(row, unknown, strict=True))
            for row in self.rows
        )
        return replace(self, rows=rows, uncertainty_reason=reason)

    def _repr_html_(self) -> str:
        columns = [f">{name} in {unit}" if unit else f">{name}" for name, unit in self.columns]
        rows = [[number(value) for value in row] for row in self.rows]
        return table_html(columns, rows, self.name, self.definition)

    def to_json(self) -> dict[str, Any]:
        """`definition`, `basis`, `columns` and `rows`; what is not finite is null."""
        reason = {"uncertainty_reason": self.uncertainty_reason} if self.uncertainty_reason else {}
        return {
            "definition": self.definition,
            **reason,
            "basis": self.basis.to_json(),
            "columns": [{"name": name, "unit": unit} for name, unit in self.columns],
            "rows": [[_finite(value) for value in row] for row in self.rows],
        }


def undefined(measurements: Iterable[Measurement]) -> dict[str, tuple[str, ...]]:
    """Return the names of the measurements that have neither a value nor a bound, by the reason."""
    return _names_by_reason((each.reason, each.name) for each in measurements if each.upper_bound is None)


def without_uncertainty(measurements: Iterable[Measurement]) -> dict[str, tuple[str, ...]]:
    """Return the names of the measurements with a value and without an uncertainty, by the reason."""
    return _names_by_reason(
        (each.uncertainty_reason, each.name)
        for each in measurements
        if not each.reason and each.uncertainty is None
    )


def _names_by_reason(told: Iterable[tuple[str, str]]) -> dict[str, tuple[str, ...]]:
    """Return names by their reason, those of an empty one left out."""
    found: dict[str, tuple[str, ...]] = {}
    for reason, name in told:
        if reason:
            found[reason] = (*found.get(reason, ()), name)
    return found


def measurements_to_json(measurements: Iterable[Measurement]) -> dict[str, MeasurementJson]:
    """Return the measurements by name, in their order."""
    return {each.name: each.to_json() for each in measurements}


def tables_to_json(tables: Iterable[Table]) -> dict[str, dict[str, Any]]:
    """Return the tables by name, in their order."""
    return {each.name: each.to_json() for each in tables}


def measurements_from_json(document: Mapping[str, Any]) -> tuple[Measurement, ...]:
    """Return what `measurements_to_json` wrote.

    Raises:
        AnalysisError: an entry lacks one of the keys value, unit and definition, or one is of another type.
    """
    return tuple(_measurement(name, entry) for name, entry in document.items())


def tables_from_json(document: Mapping[str, Any]) -> tuple[Table, ...]:
    """Return what `tables_to_json` wrote.

    Raises:
        AnalysisError: an entry is not a table.
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
_CORRECTION = TypeAdapter(Correction | None)
_BELOW = TypeAdapter(float | None)
_OF_A_BUNDLE = "; undefined here: "  # what older bundles have between definition and reason


class _Column(BaseModel):
    name: str
    unit: str


class _Table(BaseModel):
    definition: str
    basis: Basis = Basis()
    uncertainty_reason: str = ""
    columns: tuple[_Column, ...]
    rows: tuple[tuple[float | None, ...], ...]

    def read(self, name: str) -> Table:
        rows = tuple(tuple(_or(value, math.nan) for value in row) for row in self.rows)
        columns = tuple((each.name, each.unit) for each in self.columns)
        return Table(name, self.definition, columns, rows, self.basis, self.uncertainty_reason)


class _Contribution(BaseModel):
    name: str
    evaluation: Literal["A", "B"]
    standard: float | None
    dof: float | None = None
    instrument: InstrumentError | None = None
    sign: Literal[-1, 1] = 1
    of_student: bool = False
    adds_power: bool = False

    def read(self) -> Contribution:
        standard, dof = _or(self.standard, math.nan), _or(self.dof, math.inf)
        told = {"of_student": self.of_student, "adds_power": self.adds_power}
        return Contribution(self.name, self.evaluation, standard, dof, self.instrument, self.sign, **told)


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
            reason, of_none = entry.get("reason", older), entry.get("uncertainty_reason", "")
            try:
                basis = _BASIS.validate_python(entry.get("basis", {}))
                found = entry.get("uncertainty")
                uncertainty = None if found is None else _Uncertainty.model_validate(found).read()
                further = entry.get("repeatability")
                repeatability = None if further is None else _Contribution.model_validate(further).read()
                correction = _CORRECTION.validate_python(entry.get("correction"))
                below = _BELOW.validate_python(entry.get("below"))
            except ValidationError:
                pass
            else:
                if isinstance(reason, str) and isinstance(of_none, str):
                    return Measurement(
                        name,
                        number,
                        unit,
                        text,
                        basis,
                        uncertainty,
                        reason,
                        repeatability,
                        uncertainty_reason=of_none,
                        correction=correction,
                        below=below,
                    )
    raise AnalysisError(
        f"measurement '{name}' is {entry!r:.80}: expected value (number or null), unit and definition "
        f"(text); analyze the recording again"
    )


def _or(value: float | None, missing: float) -> float:
    return missing if value is None else value


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
