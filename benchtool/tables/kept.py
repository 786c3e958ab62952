"""What a bundle keeps of a measured table beside its rows, so that these can be measured again."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from benchtool.analysis import Instruments, Measurement, Perturbed, Table
from benchtool.block import Block, Channel
from benchtool.document import Section, defaults
from benchtool.errors import AnalysisError
from benchtool.misfits import explain
from benchtool.profile import Bench
from benchtool.tables.analyses import results
from benchtool.tables.asked_analyses import asked_again, asked_findings
from benchtool.tables.columns import TableQuestion
from benchtool.tables.lost import Lost
from benchtool.tables.record import Record, time_base_of


class KeptTable(Section):
    """What the numbers of a table rest on beside its rows: `columns` are the kinds of those behind the time,
    with their names in the file, `joined` says why the rows are no one record, `bench` has the sensors by
    these names."""

    columns: dict[str, str]
    pole_pairs: int | None = None
    slots: int | None = None
    torque_rated_Nm: float | None = None
    rate_Hz: float | None = None
    omega_m_rad_s: float | None = None
    is_of_phase: bool = False
    analyses: dict[str, dict[str, Any]] = Field(default_factory=dict)
    joined: str = ""
    lost: Lost = Lost()
    bench: Bench = defaults(Bench)

    @classmethod
    def of(cls, record: Record, joined: str, bench: Bench) -> KeptTable:
        """Return what is kept of a record."""
        question = record.question
        return cls(
            columns={what: channel.name for what, channel in record.channels.items()},
            pole_pairs=question.pole_pairs,
            slots=question.slots,
            torque_rated_Nm=question.torque_rated_Nm,
            rate_Hz=question.rate_Hz,
            omega_m_rad_s=question.omega_m_rad_s,
            is_of_phase=question.is_of_phase,
            analyses={name: dict(settings) for name, settings in record.analyses.items()},
            joined=joined,
            lost=record.lost,
            bench=bench,
        )

    @classmethod
    def of_document(cls, document: Any) -> KeptTable:
        """Return it as `to_json` has written it.

        Raises:
            AnalysisError: this version does not understand it.
        """
        try:
            return cls.model_validate_json(json.dumps(document))
        except ValidationError as failed:
            raise AnalysisError(
                f"what the bundle keeps of its table cannot be read: {explain(cls, failed)}; use the "
                f"benchtool that wrote it"
            ) from None

    def to_json(self) -> dict[str, Any]:
        """Return what is stated, as the manifest of the bundle has it."""
        return self.model_dump(mode="json", exclude_defaults=True)

    def record(self, rows: Block) -> Record:
        """Return the record of rows whose first channel is their time.

        Raises:
            AnalysisError: the rows have other columns.
        """
        channels = rows.channels[1:]
        if len(channels) != len(self.columns):
            raise AnalysisError(
                f"the rows have {len(channels)} columns behind the time, {len(self.columns)} are expected"
            )
        question = TableQuestion(
            Path(),
            None,
            {},
            pole_pairs=self.pole_pairs,
            slots=self.slots,
            torque_rated_Nm=self.torque_rated_Nm,
            rate_Hz=self.rate_Hz,
            omega_m_rad_s=self.omega_m_rad_s,
            is_of_phase=self.is_of_phase,
            bench=self.bench,
        )
        named = {
            what: Channel(name, channel.unit)
            for (what, name), channel in zip(self.columns.items(), channels, strict=True)
        }
        base = time_base_of(rows.data, self.joined)
        return Record(rows.data, base, named, question, self.lost, analyses=self.analyses)

    def measured_again(self, rows: Block) -> tuple[tuple[Measurement, ...], tuple[Table, ...]]:
        """Return measurements and tables of the rows.

        Raises:
            AnalysisError: as `record`.
        """
        record = self.record(rows)
        return measured(record, sensors_of(record, self.bench))


def sensors_of(record: Record, bench: Bench) -> Instruments:
    """Return the sensors of a record's columns, which `bench` states by their names."""
    return Instruments(bench, () if record.block is None else (record.block,), clock_of="the record")


def measured(record: Record, sensors: Instruments) -> tuple[tuple[Measurement, ...], tuple[Table, ...]]:
    """Return every number and table of a record, with the errors of its sensors."""
    found, asked = list(results(record)), list(asked_findings(record))
    numbers = [each for each in found if isinstance(each, Measurement)]
    tables = [each for each in found if isinstance(each, Table)]
    for findings in asked:
        numbers += findings.measurements
        tables += findings.tables

    def again(altered: Perturbed) -> Iterator[Measurement]:
        for findings in asked_again(record, altered):
            yield from findings.measurements

    return sensors.applied(numbers, again), sensors.applied_to(tables)
