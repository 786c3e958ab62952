"""What analyses find that are asked of a table by name, such as a step response."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from benchtool.analysis import Analysis, Findings, Perturbed, Window, measure
from benchtool.block import Block
from benchtool.document import Section
from benchtool.errors import AnalysisError
from benchtool.tables.asked_columns import Asked, known_analysis, settings_of
from benchtool.tables.record import Record


def asked_findings(record: Record) -> Iterator[Findings]:
    """Yield what the analyses that were asked for find in a record, without values where it does not allow
    them."""
    for name, named in record.analyses.items():
        analysis = known_analysis(name)
        settings = settings_of(analysis, named)
        try:
            if record.uniform is None:
                raise AnalysisError(record.uneven)
            yield _measured(analysis, record, record.uniform, settings)
        except AnalysisError as refused:
            step_s = record.base.step_s if record.base.step_s > 0.0 else 1.0
            rows = Block(tuple(record.channels.values()), 0, 1, step_s, record.data[:, 1:])
            yield analysis.undefined(rows, settings, str(refused))


def asked_again(record: Record, altered: Perturbed) -> Iterator[Findings]:
    """Yield what they find with another error of a sensor; nothing where it is not found again."""
    block = record.uniform
    for name, named in record.analyses.items() if block is not None else ():
        assert block is not None
        analysis = known_analysis(name)
        try:
            yield _measured(analysis, record, altered.of(block), settings_of(analysis, named))
        except AnalysisError:  # a measurement that is not found again has an unknown uncertainty
            continue


def _measured(analysis: Analysis[Any], record: Record, block: Block, settings: Section) -> Findings:
    question = record.question
    rated_Nm = math.nan if question.torque_rated_Nm is None else question.torque_rated_Nm
    window = Window(block, question.pole_pairs or 1, rated_Nm, at_drive_ticks=False)
    return measure(analysis, window, settings)


def with_analyses(record: Record, analyses: Asked) -> Record:
    """Return the record with the analyses that are asked of it, with the names of its channels in place of
    the kinds of columns."""
    named = {
        name: {
            key: record.channels[value].name
            if value and key in known_analysis(name).channel_settings
            else value
            for key, value in settings.items()
        }
        for name, settings in analyses.items()
    }
    return replace(record, analyses=named)
