"""Dates and times of day in the cells of a table, and the seconds that they stand for."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

_NAMES = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_PATTERN = (
    r"^(?:(?:(?P<year>[0-9]{4})[-/](?P<month>[0-9]{2})[-/](?P<day>[0-9]{2})"
    r"|(?P<day_first>[0-9]{1,2})(?:\.(?P<month_next>[0-9]{1,2})\.|[- ](?P<month_named>(?i:"
    + "|".join(_NAMES)
    + r"))[- ])"
    r"(?P<year_last>[0-9]{4})"
    r"|(?P<either>[0-9]{1,2}/[0-9]{1,2}/[0-9]{4}))[Tt ,] ?)?"
    r"(?:(?P<hour>[0-9]{1,3}):(?P<minute>[0-9]{2}):(?P<second>[0-9]{2})"
    r"(?:[.,](?P<fraction>[0-9]{1,9})[0-9]*|:(?P<thousandths>[0-9]{3}))?"
    r"(?: ?(?P<half>[AaPp])\.?[Mm]\.?)?"
    r"|(?P<minute_first>[0-9]{1,2}):(?P<second_next>[0-9]{2})[.,](?P<part>[0-9]{1,9})[0-9]*)"
    r"(?P<zone> ?[Zz]|(?P<sign>[+-])(?P<hours>[0-9]{2}):?(?P<minutes>[0-9]{2})?)?$"
)
_STAMP = re.compile(_PATTERN)
_MONTHS = 12
_DAY_NS, _HOUR_NS = 86_400_000_000_000, 3_600_000_000_000


def is_stamp(cell: str) -> bool:
    """Return whether a cell is a date and time, or a time of day, in the extended format of ISO 8601-1:2019.

    Between date and time may stand a blank, as IETF RFC 3339, 5.6 allows. Dates are also read with solidi
    (2026/01/31, and 01/31/2026 where that is the same in all cells) and day first with dots (31.01.2026) or
    with the first letters of an English month (31-Jan-2026), times also of a twelve-hour clock (11:59:59.5
    PM), with thousandths behind a colon (23:59:59:500) and as minutes and seconds with decimals (59:59.5).
    """
    return _STAMP.match(cell) is not None


def seconds_of(cells: pa.ChunkedArray) -> pa.ChunkedArray:
    """Return the seconds since the first stamp among the cells of text, null where a cell is none.

    Times of day without a date go on behind midnight, minutes and seconds behind the hour; hours of 24 and
    more are elapsed ones.
    """
    cells = pc.ascii_trim_whitespace(cells).combine_chunks()
    fields = pc.extract_regex(cells, _PATTERN)
    part = {name: pc.struct_field(fields, [name]) for name in _STAMP.groupindex}
    day_s, has_date = _days(part)
    hour, minute, second = (
        _number(part["hour"]),
        _either(part, "minute", "minute_first"),
        _either(part, "second", "second_next"),
    )
    is_half, is_afternoon = (
        _is_set(part["half"]),
        _values(pc.match_substring_regex(pc.fill_null(part["half"], ""), "[Pp]")) > 0,
    )
    hour = np.where(is_half, hour % 12.0 + 12.0 * is_afternoon, hour)
    known = _values(pc.is_valid(fields)).astype(bool) & np.isfinite(day_s)
    # without a date they may count on: 25:00:00 is an hour after 24:00:00
    is_elapsed = not has_date and not is_half.any() and bool(np.any(hour[known] >= 24.0))
    known &= ((hour < 24.0) | is_elapsed) & (minute < 60.0) & (second < 61.0)
    if not known.any():
        return pa.chunked_array([pa.nulls(len(cells), pa.float64())])
    zone_s = 3600.0 * _count(part["hours"], 2) + 60.0 * _count(part["minutes"], 2)
    zone_s *= np.where(_values(pc.equal(part["sign"], "-")) > 0.0, -1.0, 1.0)
    whole_s = day_s + 3600.0 * hour + 60.0 * minute + second - zone_s
    first = int(np.argmax(known))
    # whole nanoseconds, rounded once: sums of rounded seconds are off the grid that the stamps are written on
    decimals = (_count(part[name], 9) for name in ("fraction", "thousandths", "part"))
    count_ns = np.sum(list(decimals), axis=0).astype(np.int64)
    elapsed_ns = 1_000_000_000 * np.where(known, whole_s - whole_s[first], 0.0).astype(np.int64)
    elapsed_ns += count_ns - count_ns[first]
    if not has_date and not is_elapsed:
        turn_ns = _DAY_NS if _is_set(part["hour"])[known].any() else _HOUR_NS
        elapsed_ns[known] += turn_ns * np.cumsum(2 * np.diff(elapsed_ns[known], prepend=0) < -turn_ns)
    return pa.chunked_array([pa.array(elapsed_ns / 1e9, mask=~known)])


def _days(part: dict[str, pa.Array]) -> tuple[NDArray[np.float64], bool]:
    """Return the seconds from 1970 to the day of each stamp, nan where there is no such day, and whether any
    has a date; of a date whose day and month cannot be told apart by any, as of one day, if all are the
    same."""
    written = pc.if_else(_is_there(part["day_first"]), _day_first(part), _year_first(part))
    written = pc.if_else(_is_there(part["either"]), _in_order(part["either"]), written)
    has_date = bool(pc.any(pc.not_equal(written, "")).as_py())
    dated = pc.if_else(pc.equal(written, ""), "1970-01-01", written)
    moment = pc.strptime(dated, format="%Y-%m-%d", unit="s", error_is_null=True)
    day_s = np.where(_values(pc.is_valid(moment)) > 0.0, _values(pc.cast(moment, pa.int64())), np.nan)
    either = [each for each in pc.unique(part["either"]).to_pylist() if each]
    if len(either) > 1 and not _is_month_first(either) and not _is_day_first(either):
        day_s[_is_set(part["either"])] = np.nan
    return day_s, has_date


def _is_month_first(dates: Sequence[str]) -> bool:
    return any(int(each.split("/")[1]) > _MONTHS for each in dates)


def _is_day_first(dates: Sequence[str]) -> bool:
    return any(int(each.split("/")[0]) > _MONTHS for each in dates)


def _in_order(dates: pa.Array) -> pa.Array:
    """Return dates with solidi as year, month and day, by which of them is above 12 in any; empty where none
    is."""
    known = [each for each in pc.unique(dates).to_pylist() if each]
    order = r"\2-\1" if _is_day_first(known) else r"\1-\2" if _is_month_first(known) else ""
    if not order:
        return pa.array([""] * len(dates))
    padded = pc.replace_substring_regex(dates, r"\b([0-9])/", r"0\1/")
    return pc.replace_substring_regex(padded, r"^([0-9]{2})/([0-9]{2})/([0-9]{4})$", rf"\3-{order}")


def _year_first(part: dict[str, pa.Array]) -> pa.Array:
    joined = pc.binary_join_element_wise(part["year"], part["month"], part["day"], "-")
    return pc.if_else(_is_there(part["year"]), joined, "")


def _day_first(part: dict[str, pa.Array]) -> pa.Array:
    """Return dates that begin with the day as year, month and day."""
    at = pc.index_in(pc.utf8_lower(part["month_named"]), pa.array(_NAMES))
    number = pc.cast(pc.add(pc.fill_null(at, -1), 1), pa.string())
    return pc.binary_join_element_wise(
        part["year_last"],
        pc.utf8_lpad(pc.if_else(_is_there(part["month_next"]), part["month_next"], number), 2, "0"),
        pc.utf8_lpad(part["day_first"], 2, "0"),
        "-",
    )


def _is_there(digits: pa.Array) -> pa.Array:
    return pc.not_equal(pc.fill_null(digits, ""), "")


def _is_set(digits: pa.Array) -> NDArray[np.bool_]:
    return np.asarray(_values(_is_there(digits)) > 0.0)


def _number(digits: pa.Array) -> NDArray[np.float64]:
    """Return digits as a number, 0 without any."""
    return _values(pc.cast(pc.if_else(_is_there(digits), digits, "0"), pa.int64()))


def _either(part: dict[str, pa.Array], *names: str) -> NDArray[np.float64]:
    return np.asarray(sum(_number(part[name]) for name in names))


def _count(digits: pa.Array, width: int) -> NDArray[np.float64]:
    """Return digits, filled up behind with zeros to a width, as a number; 0 without any."""
    return _values(pc.cast(pc.utf8_rpad(digits, width, "0"), pa.int64()))


def _values(numbers: pa.Array) -> NDArray[np.float64]:
    return np.asarray(pc.fill_null(pc.cast(numbers, pa.float64()), 0.0).to_numpy(zero_copy_only=False))
