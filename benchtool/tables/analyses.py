"""Measurements of a record: ripple of its columns, spectrum of a phase current, orders by its angle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np

from benchtool.analysis import (
    MeanBeside,
    Measurement,
    Table,
    clipping,
    count_of,
    held_rows,
    raw,
    record_basis,
    require_signal,
    ripple_of_rows,
    speed_beside_angle,
    standing,
)
from benchtool.analysis.lines import spectral_lines
from benchtool.analysis.orders import (
    Orders,
    across_gaps,
    angle_coverage,
    describe_orders,
    fitted_orders,
    order_analysis,
    orders_at_speed,
    unwrapped_angle,
)
from benchtool.analysis.spectra import (
    CURRENT_UNBALANCE,
    CurrentSpectrum,
    current_spectrum,
    current_unbalance,
)
from benchtool.errors import AnalysisError
from benchtool.tables.columns import PHASES
from benchtool.tables.periods import Periods
from benchtool.tables.record import Record
from benchtool.tables.stale_rows import often_stale

_MEASURED = ("torque", "current", "speed")
_AC_NUMBERS = (
    ("fundamental_frequency", "Hz", "frequency of the largest sinusoid"),
    ("current_fundamental", "A", "peak amplitude of the largest sinusoid"),
    ("current_thd_f", "%", "harmonics in percent of the fundamental"),
)

_Result = TypeVar("_Result", Measurement, Table)


def results(record: Record) -> Iterator[Measurement | Table]:
    """Yield all numbers of a record, column by column; impossible ones are undefined, with the reason."""
    periods = Periods(record)
    for what in _MEASURED:
        if what not in record.channels:
            continue
        if reason := record.dead(what):
            yield from _undefined(record, what, reason)
            if what == "current":
                yield from _unbalance(record, None, reason)
            continue
        if what == "current":
            yield from _current(record, periods)
        else:
            yield from _ripple(record, periods, what)
        if "angle" in record.channels or record.question.omega_m_rad_s is not None:
            yield from _orders(record, what)
        elif what != "current" and record.even is not None:
            yield from _lines(record.even, what)


def _undefined(record: Record, what: str, reason: str) -> Iterator[Measurement]:
    name, unit = record.channels[what].name, record.channels[what].unit
    numbers = [
        (f"{what}_mean", unit, "mean"),
        (f"{what}_ripple_pp", unit, "maximum minus minimum"),
        (f"{what}_ripple_rms", unit, "rms about the mean"),
    ]
    if what == "current":
        numbers = [*_AC_NUMBERS, *numbers]
    for number, of, definition in numbers:
        yield Measurement.undefined(number, of, f"{definition} of {name}", reason, record.basis)


def _ripple(record: Record, periods: Periods, what: str) -> Iterator[Measurement]:
    channel, basis, rows = record.channels[what], record.basis, ""
    if record.uniform is not None:
        basis = replace(record_basis(record.uniform), gaps=basis.gaps)
    else:
        rows = f", over {len(record.data)} rows, each counting the same whatever the time between them"
    repetition = periods.repetition()
    held = held_rows(record.column(what))
    rated = record.question.torque_rated_Nm if what == "torque" else None
    beside = _speed_beside(record) if what == "speed" else None
    for each in ripple_of_rows(
        np.ascontiguousarray(record.column(what)),
        channel.unit,
        what,
        basis,
        rated=rated,
        marks=repetition.marks,
        repeated=repetition.kind,
        per_revolution=repetition.per_revolution,
        what=channel.name,
        no_periods=periods.hidden,
        beside=beside,
    ):
        is_over_time = beside is not None and each.name == "speed_mean"
        number = each if is_over_time else replace(each, definition=f"{each.definition}{rows}")
        if record.lost.within and math.isfinite(number.value):
            number = _incomplete(number, record.lost.within)
        yield _limited(record, number, held)


def _speed_beside(record: Record) -> MeanBeside | None:
    """Return the mean speed beside the angle, or else a phase current of which the pole pairs are stated and
    the rows are even."""
    columns, question = record.channels, record.question
    names = {what: columns[what].name for what in ("angle", "current") if what in columns}
    if question.pole_pairs is None:
        names.pop("current", None)
    if record.angle_refusal:
        names.pop("angle", None)
    theta_m, i_a = (
        np.ascontiguousarray(record.column(what)) if what in names else None for what in ("angle", "current")
    )
    return speed_beside_angle(
        np.ascontiguousarray(record.column("speed")),
        np.ascontiguousarray(record.data[:, 0]) if record.uniform is None else record.base.rate_Hz,
        theta_m,
        i_a,
        question.pole_pairs or 1,
        **names,
    )


def _incomplete(number: Measurement, rows: int) -> Measurement:
    """Return the number without an uncertainty: what the rows that are left out held is not known."""
    without = f"without {count_of(rows, 'row in between that has', 'rows in between that have')} no number"
    why = f"the values of {count_of(rows, 'row')} in between are not known"
    return replace(
        number, definition=f"{number.definition}, {without}", uncertainty=None, uncertainty_reason=why
    )


def _limited(record: Record, number: Measurement, held: float) -> Measurement:
    """Return the number with a basis limited to the rows."""
    if held == 1.0 or number.basis.bandwidth_Hz is None:
        return number
    definition = f"{number.definition}, each value held for {held:.3g} rows"
    basis = replace(number.basis, bandwidth_Hz=0.5 * record.base.rate_Hz / held)
    return replace(number, definition=definition, basis=basis)


def _current(record: Record, periods: Periods) -> Iterator[Measurement | Table]:
    name = record.channels["current"].name
    try:
        if held := _held(record, "current"):
            raise AnalysisError(held)
        even = _even(record)
        spectrum = _current_spectrum(even, Periods(even) if even is not record else periods, name)
    except AnalysisError as refused:
        reason = _of_stretch(record, refused)
        for number, unit, definition in _AC_NUMBERS:
            yield Measurement.undefined(number, unit, f"{definition} of {name}", reason, record.basis)
        yield from _ripple(record, periods, "current")
        yield from _unbalance(record, None, reason)
        return
    yield from _told(even, spectrum.measurements)
    yield from _told(even, _unbalance(even, spectrum, ""))
    yield from _told(even, spectrum.tables)


def _even(record: Record) -> Record:
    """Return the rows with even steps of which a spectrum is made, and none is stale; raises AnalysisError
    where there are none."""
    if record.even is None:
        raise AnalysisError(record.uneven)
    return record.even.restored


def _of_stretch(record: Record, refused: AnalysisError) -> str:
    """Return why there is no number, and that it would have been of a stretch of the rows if it is so."""
    if record.even is None or record.even is record:
        return str(refused)
    return f"{record.uneven}; the longest stretch without a gap, {len(record.even.data)} rows: {refused}"


def _current_spectrum(record: Record, periods: Periods, name: str) -> CurrentSpectrum:
    """Return the spectrum; raises AnalysisError with the reason if there is none."""
    base = record.base
    if record.uniform is None:
        raise AnalysisError(record.uneven)
    require_signal(record.column("current"), name, record.channels["current"].unit)
    track = periods.of_phase_current()
    found = current_spectrum(record.uniform, name, track, rate_relative=record.rate_relative)
    if base.gaps_known:
        return found
    return replace(
        found,
        measurements=tuple(_without_gaps(each) for each in found.measurements),
        tables=tuple(_without_gaps(each) for each in found.tables),
    )


def _unbalance(record: Record, of_a: CurrentSpectrum | None, refusal: str) -> Iterator[Measurement]:
    """Yield the symmetrical components of three phase currents along the track of the first, or why there are
    none; nothing of fewer currents."""
    if not record.channels.keys() >= set(PHASES):
        return
    names = [record.channels[each].name for each in PHASES]
    reasons = (record.dead(each) or _held(record, each) or _invalid(record, each) for each in PHASES)
    refusal = refusal or next(filter(None, reasons), "")
    try:
        if of_a is None or record.uniform is None or refusal:
            raise AnalysisError(refusal)
        yield from current_unbalance(record.uniform, of_a.track, names, known={names[0]: of_a})
    except AnalysisError as refused:
        of = f"of {', '.join(names)}"
        for each in CURRENT_UNBALANCE.quantities:
            for name in each.names:
                text = f"{each.text}, {of}"
                yield Measurement.undefined(name, str(each.unit), text, str(refused), record.basis)


def _held(record: Record, what: str) -> str:
    """Return that a signal was sampled less often than it is listed, which makes its lines smaller and adds
    others; empty if it was not."""
    if (held := held_rows(record.column(what))) == 1.0:
        return often_stale(record.column(what), record.stale)
    rate_Hz = record.base.rate_Hz
    return (
        f"each value is held for {held:.3g} rows, the {'current' if what in PHASES else what} was sampled at "
        f"about {raw(rate_Hz / held, 4)} Hz and not at {raw(rate_Hz, 4)} Hz: export each once"
    )


def _invalid(record: Record, what: str) -> str:
    """Return that a column is clipped or stood still, with its name; empty if it did neither."""
    column, channel = record.column(what), record.channels[what]
    reason = clipping(column, channel.unit) or standing(column, channel.unit)
    return f"'{channel.name}': {reason}" if reason else ""


def _lines(record: Record, what: str) -> Iterator[Measurement | Table]:
    channel = record.channels[what]
    if record.uniform is None or record.dead(what):  # of a stretch alone: the record is not
        return
    try:
        if held := _held(record, what):
            raise AnalysisError(held)
        restored = record.restored
    except AnalysisError as refused:
        for name, unit in ((f"{what}_line_frequency", "Hz"), (f"{what}_line_amplitude", channel.unit)):
            definition = f"largest line of {channel.name}"
            yield Measurement.undefined(name, unit, definition, str(refused), record.basis)
        return
    assert restored.uniform is not None  # as that of the record
    lines = spectral_lines(restored.uniform, channel.name, what, rate_relative=record.rate_relative or 0.0)
    yield from _told(restored, lines.measurements)
    yield from _told(restored, lines.tables)


def _orders(record: Record, what: str) -> Iterator[Measurement | Table]:
    try:
        orders = _found_orders(record, what)
    except AnalysisError as refused:
        channel, angle = record.channels[what], record.channels.get("angle")
        by = "at the stated speed" if angle is None else f"on {angle.name}"
        definition = f"order with the largest peak amplitude of {channel.name} {by}"
        reason = str(refused) if record.question.omega_m_rad_s is None else _of_stretch(record, refused)
        yield Measurement.undefined(f"{what}_order_largest", "", definition, reason, record.basis)
        return
    yield from orders.measurements
    yield from orders.tables


def _found_orders(record: Record, what: str) -> Orders:
    if held := _held(record, what):
        raise AnalysisError(held)
    channel, unit = record.channels[what].name, record.channels[what].unit
    pole_pairs, slots = record.question.pole_pairs, record.question.slots
    omega_m_rad_s = record.question.omega_m_rad_s
    if omega_m_rad_s is not None:
        even = _even(record)
        if even.uniform is None:
            raise AnalysisError(record.uneven)
        stated = describe_orders(
            orders_at_speed(even.uniform, channel, omega_m_rad_s), what, pole_pairs, slots
        )
        return replace(
            stated,
            measurements=tuple(_told(even, stated.measurements)),
            tables=tuple(_told(even, stated.tables)),
        )
    angle = record.channels["angle"].name
    block = record.read  # values and angles of stale rows are late by the same, and their times are not
    if block is not None:
        return order_analysis(block, channel, what, angle=angle, pole_pairs=pole_pairs, slots=slots)
    rows = ~record.lost_angle
    angle_rad = unwrapped_angle(record.column("angle")[rows], angle)
    if not np.all(rows):
        angle_rad = across_gaps(angle_rad, record.data[rows, 0])
    coverage = angle_coverage(angle_rad, angle)
    # stamps that are uneven do not tell a wobble from their own jitter
    spectrum = fitted_orders(coverage, record.column(what)[rows], channel, unit, angle, record.basis)
    return describe_orders(spectrum, what, pole_pairs, slots)


def _told(record: Record, numbers: Iterable[_Result]) -> Iterator[_Result]:
    """Yield numbers of the rows, whose definitions say that some were stale."""
    for each in numbers:
        if record.restored_rows:
            rows = count_of(record.restored_rows, "row that repeats", "rows that repeat")
            text = f"{each.definition}; {rows} the one before left out, and continued from the others"
            yield replace(each, definition=text)
        else:
            yield each


def _without_gaps(number: _Result) -> _Result:
    """Return the number with an unknown number of gaps in its basis."""
    return replace(number, basis=replace(number.basis, gaps=None))
