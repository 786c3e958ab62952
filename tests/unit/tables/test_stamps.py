"""Times of day in a table stand for the seconds since the first of them."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings, strategies as st

from benchtool.errors import AnalysisError
from benchtool.tables.stamps import is_stamp, seconds_of
from benchtool.tables.text import TextTable

STAMPS = st.datetimes(datetime(1971, 1, 1), datetime(2199, 1, 1))
ZONES = st.integers(-14 * 60, 14 * 60).map(lambda minutes: timezone(timedelta(minutes=minutes)))


def seconds(*cells: str) -> list[float | None]:
    values: list[float | None] = seconds_of(pa.chunked_array([cells])).to_pylist()
    return values


@given(stamps=st.lists(STAMPS, min_size=1, max_size=6), zone=st.none() | ZONES, between=st.sampled_from("T "))
@settings(deadline=None)
def test_seconds_are_those_of_the_standard_library(
    stamps: list[datetime], zone: timezone | None, between: str
) -> None:
    zoned = [stamp.replace(tzinfo=zone) for stamp in stamps]
    cells = [stamp.isoformat(sep=between) for stamp in zoned]
    expected = [(stamp - zoned[0]) / timedelta(seconds=1) for stamp in zoned]

    assert all(is_stamp(cell) for cell in cells)
    np.testing.assert_allclose(np.array(seconds(*cells), float), expected, rtol=1e-15, atol=1e-9)


def test_zones_are_taken_into_account() -> None:
    assert seconds("2026-10-25T02:59:59+02:00", "2026-10-25T02:00:00.25+01:00") == [0.0, 1.25]
    assert seconds("2026-10-25 12:00:00Z", "2026-10-25 13:30:00+0130") == [0.0, 0.0]


def test_times_of_day_go_on_behind_midnight_and_those_with_a_date_do_not() -> None:
    assert seconds("23:59:59.5", "00:00:00,25", "00:00:01") == [0.0, 0.75, 1.5]
    assert seconds("2026-01-01 23:59:59", "2026-01-01 00:00:00") == [0.0, -86399.0]


def test_stamps_lie_on_the_grid_that_they_are_written_on() -> None:
    cells = [f"23:59:59.{place:03d}" for place in range(800, 1000)]
    cells += [f"00:00:00.{place:03d}" for place in range(200)]
    assert seconds(*cells) == [place / 1000 for place in range(400)]


@given(stamps=st.lists(STAMPS, min_size=1, max_size=6), between=st.sampled_from("- "), is_loud=st.booleans())
@settings(deadline=None)
def test_months_may_have_their_english_names_and_thousandths_a_colon(
    stamps: list[datetime], between: str, is_loud: bool
) -> None:
    stamps = [each.replace(microsecond=each.microsecond // 1000 * 1000) for each in stamps]
    months = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
    cells = []
    for each in stamps:
        month = months[each.month - 1]
        date = between.join((f"{each.day:02}", month.upper() if is_loud else month, f"{each.year}"))
        cells.append(f"{date} {each:%H:%M:%S}:{each.microsecond // 1000:03}")
    expected = [(each - stamps[0]) / timedelta(seconds=1) for each in stamps]
    np.testing.assert_allclose(np.array(seconds(*cells), float), expected, rtol=1e-15, atol=1e-9)
    assert not any(map(is_stamp, ("31-Foo-2026 10:00:00", "10:00:00:12", "31 12 2026 10:00:00")))


def test_what_is_no_time_is_null_and_the_first_time_counts() -> None:
    assert seconds("x", "10:00:00", "", "2026-13-01 10:00:00", "10:00:02", "25:00:00") == [
        *(None, 0.0, None, None, 2.0, None)
    ]
    assert seconds("x", "") == [None, None]
    assert not any(map(is_stamp, ("", "1.5", "2026-11-23", "1:30", "23.11.26 10:00:00", "10:00 PM")))


@pytest.mark.parametrize(
    ("delimiter", "sign"),
    [(",", "."), (";", ","), ("\t", "."), ("  ", ".")],
    ids=["comma", "semicolon", "tab", "blanks"],
)
def test_a_table_timed_by_stamps(tmp_path: Path, delimiter: str, sign: str) -> None:
    begin, between = datetime(2026, 11, 23, 23, 59, 59, 990_000), "T" if delimiter == "  " else " "
    time_s = np.arange(40) * 1e-3
    stamps = [begin + timedelta(seconds=t) for t in time_s]
    rows = (
        f"{stamp.isoformat(sep=between, timespec='milliseconds')}{delimiter}{row}.5".replace(".", sign)
        for row, stamp in enumerate(stamps)
    )
    path = tmp_path / "logger.csv"
    path.write_text(f"Timestamp [UTC]{delimiter}Iq\n" + "\n".join(rows) + "\nno time;;,\t1\n")
    table = TextTable.open(path)
    chosen = [table.select("1", "s"), table.select("2", "A")]
    found = table.rows(chosen)

    np.testing.assert_allclose(found.data, np.stack([time_s, np.arange(40) + 0.5], axis=1), atol=1e-9)
    assert (chosen[0].unit, found.read, sum(found.dropped.values())) == ("s", 41, 1)
    with pytest.raises(AnalysisError, match="holds times of day, numbers in A are expected"):
        table.select("1", "A")
    with pytest.raises(AnalysisError, match="holds times of day, numbers in ms are expected"):
        table.select("1:ms", "s")


def test_dates_and_clocks_of_other_tools() -> None:
    assert seconds("31.12.2026 23:59:59,5", "1.1.2027 0:00:00") == [0.0, 0.5]
    assert seconds("2026/03/01 9:59:59", "2026/03/01 10:00:00.25") == [0.0, 1.25]
    assert seconds("11:59:59 AM", "12:00:00 PM", "1:00:00 p.m.") == [0.0, 1.0, 3601.0]
    assert seconds("12:00:00 AM", "12:30:00 AM") == [0.0, 1800.0]
    assert seconds("59:59.75", "00:00.25", "00:01.0") == pytest.approx([0.0, 0.5, 1.25])


def test_a_day_and_a_month_that_cannot_be_told_apart_are_none() -> None:
    assert seconds("03/01/2026 11:59:58 PM", "03/01/2026 11:59:59 PM") == [0.0, 1.0]
    assert seconds("03/01/2026 11:59:59 PM", "03/02/2026 12:00:00 AM") == [None, None]


def test_hours_of_a_day_and_more_are_elapsed() -> None:
    assert seconds("23:59:59.5", "24:00:00", "100:00:00") == [0.0, 0.5, 273600.5]


@pytest.mark.parametrize(
    "cells", [("11/28/2026 23:59:59", "11/29/2026 00:00:00"), ("28/11/2026 23:59:59", "29/11/2026 0:00:00")]
)
def test_a_day_above_twelve_tells_days_from_months(cells: tuple[str, str]) -> None:
    assert seconds(*cells) == [0.0, 1.0]
    assert seconds("1/2/2026 00:00:00", "1/3/2026 00:00:00", cells[0])[1] == (
        86400.0 if cells[0].startswith("11") else 28 * 86400.0
    )
    assert seconds("1/2/2026 00:00:00", "1/3/2026 00:00:00") == [None, None]
