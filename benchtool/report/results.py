"""Results in a report: limits, measurements and tables."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Final

from benchtool.analysis import (
    NOTHING,
    Basis,
    Measurement,
    Table,
    Uncertainty,
    count_of,
    degrees,
    number,
    placed,
    probability,
    raw,
)
from benchtool.plan import JudgedLimit, Limit, Verdict
from benchtool.report.content import Cell, Grid, Item, Mark, Section, Text

_SHOWN_ROWS = 10
_MOST_PERCENT = 1000.0  # of a bound: more tells less than the distance itself
_ALIKE = 0.005  # relative: standard uncertainties that are the same to two digits
_BY_STUDENT: Final = (
    "U = t s: s is the experimental standard uncertainty and t Student's factor of the effective degrees of "
    "freedom (JCGM 100:2008, G.4.1)."
)
_DERIVED: Final = "Without t, U is half of the interval of a derived distribution."
_OF_FEW: Final = (
    "u is the standard deviation, and s where many observations tell it. Where few do, it is larger: "
    "s sqrt(dof / (dof − 2)) of type A (JCGM 101:2008, 6.4.9.4), so that ±2u holds about 95 % too; k = U/u."
)
_OF_MANY: Final = "u = s, the standard uncertainty; k = U/u."
_MARKS: Final[Mapping[Verdict, Mark]] = {
    Verdict.NONE: "none",
    Verdict.PASS: "pass",
    Verdict.MARGINAL: "marginal",
    Verdict.UNDECIDED: "undecided",
    Verdict.FAIL: "fail",
}


def mark(verdict: Verdict) -> Mark:
    """Return a verdict as the report marks it."""
    return _MARKS[verdict]


def bounds_of(limit: Limit) -> str:
    """Return the bounds of a limit, none of which a line break separates from its sign."""
    return re.sub("([≥≤=]) ", "\\1\N{NO-BREAK SPACE}", limit.bounds).replace("-", "−")


def limits_section(judged: Collection[JudgedLimit]) -> Section:
    """Return every limit with its value, rule, headroom, probability of conformance and verdict."""
    if not judged:
        return Section("Limits and verdicts", (Text("The plan sets no limits.", "note"),))
    headings = (
        "measurement",
        ">value ± U (95 %)",
        "unit",
        "limit",
        "decision rule",
        ">margin left",
        ">P",
        "verdict",
    )
    grid = Grid.of(headings, [_limit_row(each) for each in judged])
    return Section("Limits and verdicts", (grid, *conformance_notes(judged)))


def conformance_notes(judged: Collection[JudgedLimit]) -> Iterator[Text]:
    """Yield what P is the probability of, why some limits have none, and which of them no value can pass."""
    for meaning in dict.fromkeys(each.probability_of for each in judged):
        yield Text(f"P is the {meaning}, by the measurement alone.", "note")
    for each in judged:
        if each.conformance_reason:
            yield Text(f"No P of {each.name}: {each.conformance_reason.rstrip('.')}.", "note")
        if each.remark:
            yield Text(f"{each.name}: {each.remark}.", "warning")


def _limit_row(judged: JudgedLimit) -> tuple[str | Cell, ...]:
    limit, measured, left = judged.limit, judged.measured, judged.headroom_text
    if measured is not None and math.isfinite(measured.value):
        stated = (bound for bound in (limit.min, limit.max) if bound is not None)
        nearer = min(stated, key=lambda bound: abs(measured.value - bound))
        percent = 100.0 * judged.headroom / abs(nearer) if nearer else math.inf
        left += f" ({raw(percent, 2)} %)" if abs(percent) < _MOST_PERCENT else ""
    return (
        judged.name,
        judged_value(measured),
        measured.unit if measured else "",
        *(bounds_of(limit), limit.rule, left, conformance_of(judged), verdict_cell(judged)),
    )


def verdict_cell(judged: JudgedLimit) -> Cell:
    """Return the verdict on a limit, marked."""
    return Cell(str(judged.verdict), mark(judged.verdict))


def conformance_of(judged: JudgedLimit) -> str:
    """Return the probability of conformance; a dash where it is not known."""
    return NOTHING if judged.conformance is None else probability(judged.conformance)


def judged_value(measured: Measurement | None) -> str:
    """Return a value that a limit is held against, with its expanded uncertainty."""
    return "not measured" if measured is None else _value(measured)


def measurements_section(
    title: str,
    measurements: Sequence[Measurement],
    limits: Mapping[str, JudgedLimit],
    published: Mapping[str, float],
) -> Section:
    """Return every measurement with its uncertainty; definition, basis and source of the uncertainty
    unfold."""
    shown_published = any(each.name in published for each in measurements)
    limited = any(each.name in limits for each in measurements)
    uncertain = any(each.uncertainty is not None for each in measurements)
    headings = ["measurement", ">value ± U (95 %)" if uncertain else ">value", "unit"]
    headings += [">published"] * shown_published + ["limit", "verdict"] * limited
    rows = []
    for each in measurements:
        row: list[str | Cell] = [
            Cell(each.name, notes=tuple(measurement_notes(each))),
            _value(each),
            each.unit,
        ]
        if shown_published:
            row.append(raw(published[each.name]) if each.name in published else "")
        if limited:
            judged = limits.get(each.name)
            row += [bounds_of(judged.limit), verdict_cell(judged)] if judged else ["", ""]
        rows.append(tuple(row))
    return Section(title, (Grid.of(headings, rows),) if rows else (Text("None.", "note"),))


def budgets_section(measurements: Sequence[Measurement]) -> Section | None:
    """Return the budget of every uncertainty: its contributions of type A and B, degrees of freedom, and how
    they come to U."""
    rows: list[tuple[str | Cell, ...]] = []
    for each in measurements:
        known = each.uncertainty
        if known is not None and math.isfinite(each.value):
            rows.append((each.name, "combined", known.source, *_whole(known, each.unit)))
            rows += [
                (
                    *("", f"type {line.evaluation}", line.name),
                    *(number(line.experimental, 2), number(line.standard, 2), each.unit, degrees(line.dof)),
                    *("", ""),
                )
                for line in known.budget
            ]
    headings = (
        *("measurement", "", "contribution", ">s", ">u", "unit"),
        *(">degrees of freedom", ">t", ">k"),
    )
    if not rows:
        return None
    notes = [Text(each, "note") for each in _budget_notes(measurements)]
    return Section("Uncertainty budgets", (Grid.of(headings, rows, shown=_SHOWN_ROWS), *notes))


def _budget_notes(measurements: Sequence[Measurement]) -> Iterator[str]:
    """Yield how U and u come about, as far as it is so of one of the numbers."""
    known = [each.uncertainty for each in measurements if each.uncertainty and math.isfinite(each.value)]
    by_student = [each.student_factor is not None for each in known]
    yield " ".join(
        text for text, told in ((_BY_STUDENT, any(by_student)), (_DERIVED, not all(by_student))) if told
    )
    alike = all(math.isclose(each.experimental, each.standard, rel_tol=_ALIKE) for each in known)
    yield _OF_MANY if alike else _OF_FEW


def _whole(known: Uncertainty, unit: str) -> tuple[str, ...]:
    """Return s, u, unit, degrees of freedom, t and k of an uncertainty."""
    t = known.student_factor
    return (
        *(number(known.experimental, 2), number(known.standard, 2), unit, degrees(known.dof)),
        NOTHING if t is None else number(t, 3),
        number(known.k, 3) if known.expanded > 0.0 else NOTHING,
    )


def tables_section(tables: Sequence[Table]) -> Section | None:
    """Return every table of numbers with its definition and basis; fields that do not apply are left out."""
    if not tables:
        return None
    parts = (Section(each.name, tuple(_table(each)), paper=bool(each.rows)) for each in tables)
    return Section("Tables", tuple(parts))


def _table(table: Table) -> Iterator[Item]:
    reason = table.uncertainty_reason.rstrip(".")
    notes = basis_text(table.basis), f"Without uncertainty: {reason}." if reason else ""
    yield Text(" ".join((_sentence(table.definition), *filter(None, notes))), "note")
    headings = [f">{name} ({unit})" if unit else f">{name}" for name, unit in table.columns]
    if table.rows:
        rows = [tuple(number(value) for value in row) for row in table.rows]
        yield Grid.of(headings, rows, shown=_SHOWN_ROWS)
    else:
        yield Text("No rows.", "note")


def _value(measured: Measurement) -> str:
    return measured.text


def measurement_notes(measured: Measurement) -> Iterator[str]:
    """Definition, basis and source of the uncertainty, a sentence each, as far as they exist."""
    yield _sentence(measured.definition)
    if basis := basis_text(measured.basis):
        yield basis
    if measured.reason:
        yield f"Undefined here: {measured.reason.rstrip('.')}."
    if measured.uncertainty_reason:
        yield f"No uncertainty: {measured.uncertainty_reason.rstrip('.')}."
    if measured.uncertainty is not None:
        yield from _uncertainty_notes(measured.uncertainty, f" {measured.unit}" if measured.unit else "")
    if (correction := measured.correction) is not None:
        read = f"{placed(measured.as_read, abs(correction.added))} {measured.unit}".rstrip()
        added = f"{number(correction.added, 2)} {measured.unit}".rstrip()
        yield f"Corrected by {added} from {read} as read: {correction.of}."
    if (further := measured.repeatability) is not None:
        yield (
            f"Of another record of this state, besides, u = {number(further.standard, 2)} {measured.unit}: "
            f"{further.name.rstrip('.')}."
        )


def _uncertainty_notes(uncertainty: Uncertainty, unit: str) -> Iterator[str]:
    """Yield the expanded uncertainty, what it is a multiple of, and its source; the appendix has the
    budget."""
    U, u, t = number(uncertainty.expanded, 2), number(uncertainty.standard, 2), uncertainty.student_factor
    source, k = uncertainty.source.rstrip("."), number(uncertainty.k, 3)
    dof = f", {degrees(uncertainty.dof)} degrees of freedom" if math.isfinite(uncertainty.dof) else ""
    if uncertainty.expanded <= 0.0:
        yield f"Without uncertainty: {source}."
        return
    if t is None:
        how = f"half of the interval of a derived distribution; u = {u}{unit}, k = U/u = {k}"
    elif math.isclose(uncertainty.experimental, uncertainty.standard, rel_tol=_ALIKE):
        how = f"k = {k}, u = {u}{unit}{dof}"
    else:
        s = number(uncertainty.experimental, 2)
        how = (
            f"{number(t, 3)} times the experimental standard uncertainty {s}{unit}{dof}; "
            f"with what few observations add, u = {u}{unit} and k = U/u = {k}"
        )
    yield f"U = {U}{unit} covers 95 %, {how}: {source}."


def basis_text(basis: Basis) -> str:
    """Return the basis of a number in words; empty if it is unknown."""
    parts = []
    if basis.samples is not None:
        rate = f" at {raw(basis.sample_rate_Hz)} Hz" if basis.sample_rate_Hz is not None else ""
        over = f" over {raw(basis.duration_s)} s" if basis.duration_s is not None else ""
        parts.append(f"{count_of(round(basis.samples), 'sample')}{rate}{over}")
    else:
        parts += [f"sampled at {raw(basis.sample_rate_Hz)} Hz"] if basis.sample_rate_Hz is not None else []
        parts += [f"{raw(basis.duration_s)} s"] if basis.duration_s is not None else []
    if basis.bandwidth_Hz is not None:
        parts.append(f"components up to {raw(basis.bandwidth_Hz)} Hz")
    if basis.window:
        parts.append(f"window: {basis.window}")
    if basis.harmonics is not None:
        parts.append(f"harmonics up to {basis.harmonics}")
    if basis.reference:
        parts.append(f"relative to {basis.reference}")
    if basis.gaps is not None:
        parts.append(count_of(basis.gaps, "gap") if basis.gaps else "no gaps")
    parts += basis.sensors
    return f"Basis: {'; '.join(parts)}." if parts else ""


def _sentence(text: str) -> str:
    """Return a definition as a sentence: a capital where a word begins it, and a full stop."""
    if not text:
        return ""
    first = text.split(maxsplit=1)[0].rstrip(",;:") if text.strip() else ""
    begun = text[0].upper() + text[1:] if first.isalpha() and first.islower() else text
    return begun if begun.endswith((".", "!", "?")) else f"{begun}."
