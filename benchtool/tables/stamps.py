"""Dates and times of day in the cells of a table, and the seconds that they stand for."""

from __future__ import annotations

import re

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

_PATTERN = (
    r"^(?:(?P<date>[0-9]{4}-[0-9]{2}-[0-9]{2})[Tt ] ?)?"
    r"(?P<time>[0-9]{2}:[0-9]{2}:[0-9]{2})(?:[.,](?P<fraction>[0-9]{1,9})[0-9]*)?"
    r"(?P<zone> ?[Zz]|(?P<sign>[+-])(?P<hours>[0-9]{2}):?(?P<minutes>[0-9]{2})?)?$"
)
_STAMP = re.compile(_PATTERN)
_DAY_S = 86400.0


def is_stamp(cell: str) -> bool:
    """Return whether a cell is a date and time, or a time of day, in the extended format of ISO 8601-1:2019.

    Between date and time may stand a blank, as IETF RFC 3339, 5.6 allows.
    """
    return _STAMP.match(cell) is not None


def seconds_of(cells: pa.ChunkedArray) -> pa.ChunkedArray:
    """Return the seconds since the first stamp among the cells of text, null where a cell is none.

    Times of day without a date go on behind midnight.
    """
    cells = pc.ascii_trim_whitespace(cells).combine_chunks()
    parts = pc.extract_regex(cells, _PATTERN)
    date, time, fraction, sign, hours, minutes = (
        pc.struct_field(parts, [name]) for name in ("date", "time", "fraction", "sign", "hours", "minutes")
    )
    dated = pc.if_else(pc.equal(date, ""), "1970-01-01", date)
    moment = pc.strptime(
        pc.binary_join_element_wise(dated, time, " "),
        format="%Y-%m-%d %H:%M:%S",
        unit="s",
        error_is_null=True,
    )
    known = _values(pc.is_valid(moment)).astype(bool)
    if not known.any():
        return pa.chunked_array([pa.nulls(len(cells), pa.float64())])
    zone_s = 3600.0 * _count(hours, 2) + 60.0 * _count(minutes, 2)
    zone_s *= np.where(_values(pc.equal(sign, "-")) > 0.0, -1.0, 1.0)
    whole_s = _values(pc.cast(moment, pa.int64())) - zone_s
    first = int(np.argmax(known))
    # the whole seconds first: a second of the year 2026 leaves no room for nanoseconds
    count_ns = _count(fraction, 9)
    elapsed_s = (whole_s - whole_s[first]) + 1e-9 * (count_ns - count_ns[first])
    if pc.all(pc.equal(date, "")).as_py():
        elapsed_s[known] += _DAY_S * np.cumsum(np.diff(elapsed_s[known], prepend=0.0) < -0.5 * _DAY_S)
    return pa.chunked_array([pa.array(elapsed_s, mask=~known)])


def _count(digits: pa.Array, width: int) -> NDArray[np.float64]:
    """Return digits, filled up behind with zeros to a width, as a number; 0 without any."""
    return _values(pc.cast(pc.utf8_rpad(digits, width, "0"), pa.int64()))


def _values(numbers: pa.Array) -> NDArray[np.float64]:
    return np.asarray(pc.fill_null(pc.cast(numbers, pa.float64()), 0.0).to_numpy(zero_copy_only=False))
