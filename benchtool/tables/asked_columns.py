"""Analyses that are asked of a table by name, such as a step response, and the columns that they name."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from pydantic import ValidationError

from benchtool.analysis import Analysis, catalogue
from benchtool.document import Section, closest
from benchtool.errors import AnalysisError
from benchtool.misfits import explain
from benchtool.tables.selection import Selection
from benchtool.tables.text import TextTable
from benchtool.tables.units import KNOWN

Asked = Mapping[str, Mapping[str, Any]]
"""Settings by the name of the analysis."""


def with_their_columns(
    table: TextTable, asked: Asked, chosen: Mapping[str, Selection]
) -> tuple[dict[str, Selection], dict[str, dict[str, Any]]]:
    """Return the columns that were chosen and those that analyses name, and the settings with the kind of a
    column in place of what was asked for.

    A column that no unit is stated of is as it was chosen for something else, or in the unit of the others
    of its analysis.

    Raises:
        AnalysisError: no such analysis of columns alone, no such setting, no such column, no unit, two units
            for one column, or the time.
    """
    found, resolved = dict(chosen), {}
    for name, settings in asked.items():
        analysis = known_analysis(name)
        checked = settings_of(analysis, settings)
        named = {key: str(getattr(checked, key)) for key in analysis.channel_settings}
        wanted = {key: spec for key, spec in named.items() if spec}
        stated = {
            key: _in_stated_unit(table, spec) or _as_chosen(table, spec, chosen)
            for key, spec in wanted.items()
        }
        units = {each.si_unit for each in stated.values() if each is not None}
        kinds = {}
        for key, spec in wanted.items():
            selection = stated[key]
            if selection is None and len(units) != 1:
                raise AnalysisError(f"no unit of '{spec}' is stated: name it in the option, as '{spec}:Nm'")
            selection = selection or table.select(spec, next(iter(units)))
            same = (what for what, each in found.items() if each.number == selection.number)
            kinds[key] = next(same, f"{name} {key}")
            if kinds[key] == "time":
                raise AnalysisError(
                    f"column {selection.number} '{selection.name}' is the time, and asked for as {name} "
                    f"{key}: another column is expected"
                )
            _require_one_unit(selection, f"{name} {key}", found.get(kinds[key], selection), kinds[key])
            found.setdefault(kinds[key], selection)
        resolved[name] = {**settings, **kinds}
    return found, resolved


def _require_one_unit(asked: Selection, what: str, chosen: Selection, other: str) -> None:
    """Refuse a column that an analysis asks for in another unit, or with another gain, than it was chosen in.

    Raises:
        AnalysisError: the option of the analysis states the other unit.
    """
    if asked.unit_from == "option" and asked.scale != chosen.scale:
        raise AnalysisError(
            f"column {asked.number} '{asked.name}' is asked for in {chosen.scale_text} as {other}, and in "
            f"{asked.scale_text} as {what}: one unit is expected, state the same or only the first"
        )


def known_analysis(name: str) -> Analysis[Any]:
    """Return the analysis of that name, if it needs no more than columns that its settings name.

    Raises:
        AnalysisError: there is none.
    """
    known = {
        each.name: each
        for each in catalogue().analyses
        if not each.of_steady_state and each.channel_settings and not each.channels
    }
    if name not in known:
        raise AnalysisError(f"--analysis '{name}' is none of a table: {closest(name, list(known))}")
    return known[name]


def settings_of(analysis: Analysis[Any], named: Mapping[str, Any]) -> Section:
    """Return the settings of an analysis.

    Raises:
        AnalysisError: a key or a value is wrong.
    """
    texts = {key: str(value) if key in analysis.channel_settings else value for key, value in named.items()}
    try:
        settings: Section = analysis.settings.model_validate(texts)
    except ValidationError as failed:
        raise AnalysisError(f"--analysis {analysis.name}: {explain(analysis.settings, failed)}") from None
    return settings


def _in_stated_unit(table: TextTable, spec: str) -> Selection | None:
    """Return a column in the unit that the option or the head states; None where neither does.

    Raises:
        AnalysisError: there is no such column.
    """
    refusals = []
    for unit in KNOWN:
        try:
            selection = table.select(spec, unit)
        except AnalysisError as refused:
            refusals.append(refused)
            continue
        if selection.unit_from != "assumed":
            return selection
    if len(refusals) == len(KNOWN):
        raise refusals[0]
    return None


def _as_chosen(table: TextTable, spec: str, chosen: Mapping[str, Selection]) -> Selection | None:
    """Return the column as it was chosen for something else; None where it was not."""
    for each in chosen.values():
        with suppress(AnalysisError):
            if table.select(spec, each.si_unit).number == each.number:
                return each
    return None
