"""Remarks on oddities of the columns of a table that do not prevent measurements."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from enum import StrEnum

import numpy as np

from benchtool.analysis import (
    Measurement,
    angle_remarks,
    clipping,
    count_of,
    flat_crest_remark,
    standing,
)
from benchtool.analysis.orders import across_gaps, unwrapped_angle
from benchtool.errors import AnalysisError
from benchtool.profile import Bench, Instrument
from benchtool.tables.cells import BLANKS
from benchtool.tables.clocks import Clock
from benchtool.tables.columns import QUANTITIES
from benchtool.tables.head import has_number, split
from benchtool.tables.layout import Layout
from benchtool.tables.phase_wiring import miswired
from benchtool.tables.record import Record
from benchtool.tables.regimes import regimes
from benchtool.tables.selection import Selection
from benchtool.tables.stale_rows import too_stale

_LARGEST_SLIP = 0.1  # an induction machine's at its rated load is less
_LARGEST_DEVIATION = 0.01  # of a stated speed, from lines of its orders, or of a stated distance of rows


class RemarkKind(StrEnum):
    """Kind of a remark."""

    CLIPPED = "clipped"
    FLAT_CRESTS = "flat_crests"
    STOOD_STILL = "stood_still"
    MISWIRED = "miswired"
    REPEATED_ROWS = "repeated_rows"
    TWO_REGIMES = "two_regimes"
    SEVERAL_REGIMES = "several_regimes"
    ROWS_LEFT_OUT = "rows_left_out"
    NAMED_BY_A_NUMBER = "named_by_a_number"
    OTHER_FREQUENCY = "other_frequency"
    CALIBRATION_OVERDUE = "calibration_overdue"
    CALIBRATED_LATER = "calibrated_later"
    OTHER_SPEED = "other_speed"
    ANGLE_DEPARTS = "angle_departs"
    ELECTRICAL = "electrical"
    UNIT_ASSUMED = "unit_assumed"
    UNIT_CONTRADICTED = "unit_contradicted"
    OTHER_UNITS = "other_units"
    NUMBERS_IN_HEAD = "numbers_in_head"
    OTHER_HEAD = "other_head"
    OTHER_INTERVAL = "other_interval"
    TIME_GOES_BACK = "time_goes_back"
    SEVERAL_TABLES = "several_tables"
    TIME_SINCE_1970 = "time_since_1970"
    TIME_ROLLS_OVER = "time_rolls_over"


@dataclass(frozen=True)
class Remark:
    """One oddity: `column` is the kind of the column ("current"), or empty for all rows."""

    kind: RemarkKind
    column: str
    text: str

    def to_json(self) -> dict[str, str]:
        return {"kind": str(self.kind), "column": self.column, "text": self.text}


def overdue(bench: Bench, on: date) -> Iterator[Remark]:
    """Yield the instruments of a bench, by their columns, and its clock, whose calibration was due before a
    day, or was made after it."""
    instruments: dict[str, Instrument] = {**bench.channels}
    if bench.clock is not None:
        instruments["the clock"] = bench.clock
    for column, each in instruments.items():
        if each.overdue(on):
            label = f" ({each.label})" if each.label else ""
            text = f"calibration of {column}{label} was due on {each.due}, before this record of {on}"
            yield Remark(RemarkKind.CALIBRATION_OVERDUE, column, text)
        if each.calibrated is not None and each.calibrated > on:
            label = f" ({each.label})" if each.label else ""
            text = (
                f"{column}{label} was calibrated on {each.calibrated}, after this record of {on}: what is "
                f"stated of it need not hold for that day, give the certificate of then or the day, --date"
            )
            yield Remark(RemarkKind.CALIBRATED_LATER, column, text)


def other_frequency(record: Record, measurements: Sequence[Measurement]) -> Iterator[Remark]:
    """Yield that the current's fundamental is not at the frequency of the speed, of a column or stated, by
    the pole pairs.

    A column may be the speed of an induction machine. A stated speed may too, but every order rests on it.
    """
    pole_pairs, stated = record.question.pole_pairs, record.question.omega_m_rad_s
    found = [each.value for each in measurements if each.name == "fundamental_frequency"]
    if pole_pairs is None or "angle" in record.channels or not found:
        return
    if stated is not None:
        omega_m_rad_s, what, most = stated, "the stated speed", _LARGEST_DEVIATION
    elif "speed" in record.channels:
        omega_m_rad_s, most = float(np.mean(record.column("speed"))), _LARGEST_SLIP
        what = f"the mean of '{record.channels['speed'].name}'"
    else:
        return
    expected_Hz = pole_pairs * abs(omega_m_rad_s) / (2.0 * math.pi)
    if abs(found[0] - expected_Hz) > most * expected_Hz:
        slips = ", or the machine slips" if stated is not None and found[0] > expected_Hz else ""
        yield Remark(
            RemarkKind.OTHER_FREQUENCY,
            "current",
            f"the current's fundamental is at {found[0]:.4g} Hz, {what} with {pole_pairs} pole pairs says "
            f"{expected_Hz:.4g} Hz: check the units of time and speed, and the pole pairs{slips}",
        )


def of_signals(measurements: Sequence[Measurement]) -> Iterator[Remark]:
    """Yield that current and angle do not turn together, and that the current has flat crests."""
    for text in angle_remarks(measurements):
        yield Remark(RemarkKind.ANGLE_DEPARTS, "angle", text)
    if text := flat_crest_remark(measurements):
        yield Remark(RemarkKind.FLAT_CRESTS, "current", text)


def numbers_in_head(layout: Layout) -> Iterator[Remark]:
    """Yield that a line of numbers right above the rows was taken for one of the head, and that one of the
    head states factors or offsets."""
    if layout.head_numbers:
        text = (
            f"'{layout.head_numbers}' was taken for a line of the head: it does not continue the rows below, "
            f"or is written in another way than all of them; if it is a row, write it as they are, "
            f"if it holds factors, state the gains"
        )
        yield Remark(RemarkKind.NUMBERS_IN_HEAD, "", text)
    if layout.head_factors:
        lines = " and ".join(f"'{line:.60}'" for line in layout.head_factors)
        text = (
            f"the head states {lines}, and the cells were taken as they are: if that is to be applied, state "
            f"the gain and the offset, as --current '2:A*0.01-0.2'"
        )
        yield Remark(RemarkKind.NUMBERS_IN_HEAD, "", text)


def other_head(layout: Layout) -> Iterator[Remark]:
    """Yield that a line above rows without names has names for more or fewer columns than they have cells."""
    cells = [] if layout.delimiter == BLANKS else split(layout.head, layout.delimiter)
    width = len(layout.columns)
    if 1 < len(cells) != width and not any(map(has_number, cells)):
        text = (
            f"the head '{layout.head:.40}' has {len(cells)} cells and the rows have {width}: columns were "
            f"counted in the rows, where names may stand above other ones"
        )
        yield Remark(RemarkKind.OTHER_HEAD, "", text)


def other_interval(layout: Layout, record: Record) -> Iterator[Remark]:
    """Yield that the rows have another distance than the head states."""
    stated, step_s = layout.row_distance, record.base.step_s
    if stated is None or not step_s > 0.0 or abs(step_s / stated.seconds - 1.0) <= _LARGEST_DEVIATION:
        return
    by = "by --rate" if record.question.rate_Hz is not None else "by the time"
    text = (
        f"'{stated.line}' in the head puts rows {stated.seconds:g} s apart, and {by} they are {step_s:g} s, "
        f"on which every frequency rests: state the unit of the time, or the rate, unless rows were left out"
    )
    yield Remark(RemarkKind.OTHER_INTERVAL, "time", text)


def other_speed(record: Record) -> Iterator[Remark]:
    """Yield that the angle advances at another speed than that of the column of the speed."""
    if not record.channels.keys() >= {"angle", "speed"}:
        return
    name, time_s = record.channels["angle"].name, record.data[:, 0]
    if record.angle_refusal:
        return
    try:
        angle_rad = across_gaps(unwrapped_angle(record.column("angle"), name), time_s)
    except AnalysisError:
        return
    elapsed_s = float(time_s[-1] - time_s[0])
    if elapsed_s <= 0.0 or record.base.refusal:
        return
    of_angle = float(angle_rad[-1] - angle_rad[0]) / elapsed_s
    of_speed = float(np.trapezoid(record.column("speed"), time_s)) / elapsed_s
    if abs(abs(of_angle) - abs(of_speed)) > _LARGEST_SLIP * max(abs(of_angle), abs(of_speed)):
        yield Remark(
            RemarkKind.OTHER_SPEED,
            "speed",
            f"the mean of '{record.channels['speed'].name}' is {of_speed:.4g} rad/s, and '{name}' advances "
            f"by {of_angle:.4g} rad in a second: check the units of time, angle and speed, and that both are "
            f"mechanical",
        )


def of_clock(clock: Clock, time: Selection | None) -> Iterator[Remark]:
    """Yield that the unit of a time was told by its size, and that it rolled over."""
    if time is None:
        return
    name = time.in_option
    if clock.day is not None:
        text = (
            f"the unit of the time '{name}' is not stated: counted in {time.unit} since 1970 it is of "
            f"{clock.day}, and that was taken; if it is another, state it, as --time '{name}:ms'"
        )
        yield Remark(RemarkKind.TIME_SINCE_1970, "time", text)
    if clock.modulus:
        text = (
            f"the time '{name}' starts again after {clock.modulus} counts, as a counter of "
            f"{clock.modulus.bit_length() - 1} bits does, {clock.rollovers} times: it was continued"
        )
        yield Remark(RemarkKind.TIME_ROLLS_OVER, "time", text)


def remarks(record: Record) -> Iterator[Remark]:
    """Yield the clipping, rows that repeat the one before, a channel that stood still, a phase that reads
    backwards or is another, and two regimes that one number would average."""
    if text := _left_out(record):
        yield Remark(RemarkKind.ROWS_LEFT_OUT, "", text)
    if text := _shortened(record):
        yield Remark(RemarkKind.ROWS_LEFT_OUT, "", text)
    steps = np.diff(record.data[:, 0])
    if np.any(steps < 0.0) and np.any(steps > 0.0):
        text = f"{record.base.refusal}; the numbers are of all rows together: measure each record by itself"
        yield Remark(RemarkKind.TIME_GOES_BACK, "", text)
    if text := _repeated(record):
        yield Remark(RemarkKind.REPEATED_ROWS, "", text)
    if text := record.angle_refusal:
        text = f"{text}; orders leave them out, and it tells no periods: choose a span without them"
        yield Remark(RemarkKind.STOOD_STILL, "angle", text)
    what, text = miswired(record)
    if text:
        yield Remark(RemarkKind.MISWIRED, what, text)
    settings = [each for table in record.analyses.values() for each in table.values()]
    responding = [each for each in settings if isinstance(each, str)]  # they do not stay at one level
    for what, channel in record.channels.items():
        samples = record.column(what)
        if what == "angle" or what not in QUANTITIES:
            continue
        if clipped := clipping(samples, channel.unit):
            yield Remark(RemarkKind.CLIPPED, what, f"'{channel.name}': {clipped}")
        if channel.name in responding:
            continue
        if not clipped and (held := standing(samples, channel.unit)):
            yield Remark(RemarkKind.STOOD_STILL, what, f"'{channel.name}': {held}")
        elif found := regimes(samples, channel.unit):
            kind = RemarkKind.TWO_REGIMES if found.levels == 2 else RemarkKind.SEVERAL_REGIMES
            yield Remark(kind, what, f"'{channel.name}': {found.text}")


def _left_out(record: Record) -> str:
    lost = record.lost
    if not lost.left_out:
        return ""
    reasons = ", ".join(f"{count} ({why})" for why, count in lost.left_out.items())
    first = f", the first {lost.first}" if lost.first else ""
    within = (
        f"; {lost.within} are between rows that were used, and mean and ripple have no uncertainty"
        if lost.within
        else ""
    )
    return f"rows were left out: {reasons}{first}{within}"


def of_tables(joined: str) -> Iterator[Remark]:
    """Yield why rows may be those of several tables."""
    if joined:
        text = f"{joined}; the numbers are of all rows together: measure each table by itself"
        yield Remark(RemarkKind.SEVERAL_TABLES, "", text)


def of_stretch(record: Record, measurements: Sequence[Measurement]) -> Iterator[Remark]:
    """Yield that spectrum, lines or orders at a stated speed are of a stretch of the rows, if any of them
    is."""
    if record.even is None or record.even is record:
        return
    if any(math.isfinite(each.value) and each.basis.gaps == 0 for each in measurements):
        text = _shortened(record.even, "spectra are of", "; other numbers are of all")
        yield Remark(RemarkKind.ROWS_LEFT_OUT, "", text)


def _shortened(record: Record, measured: str = "measured is", others: str = "") -> str:
    if record.cut is None:
        return ""
    begin_s, end_s = float(record.data[0, 0]), float(record.data[-1, 0])
    missing, places = record.cut.missing_rows, len(record.cut.gaps)
    where = (
        f"{missing} rows are missing in {count_of(places, 'place')}" if missing > 1 else "one row is missing"
    )
    return (
        f"{where}: {measured} the longest stretch without a gap, {begin_s:.6g} s to {end_s:.6g} s, "
        f"{len(record.data)} of {record.cut.rows} rows{others}"
    )


def _repeated(record: Record) -> str:
    count, row = int(np.count_nonzero(record.repeating)), int(np.argmax(record.repeating)) + 1
    if not count:
        return ""
    share = 100 * count / len(record.repeating)
    text = (
        f"{share:.2g} % of the rows ({count}) repeat all values of the row before, the first is row {row} of "
        f"those used: values were held or written twice; mean and ripple count them as often"
    )
    if not np.any(record.stale):
        return text
    if too_stale(record.stale):
        return f"{text}, spectra and lines are undefined"
    return f"{text}, orders leave them out, and spectra and lines continue the others there"
