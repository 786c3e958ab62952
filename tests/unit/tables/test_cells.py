"""Cells of a table: numbers of other languages, thousands separators, and words in place of numbers."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from benchtool.errors import AnalysisError, RecordingError
from benchtool.tables.cells import Cell, ascii_numbers, kind_of_word
from benchtool.tables.grouping import Use, use_of
from benchtool.tables.text import Rows, TextTable

COUNT = 300
TORQUE_MNM = np.round(1000.0 + 60.0 * np.sin(np.arange(COUNT) * 0.1))


def write(folder: Path, text: str) -> Path:
    path = folder / "table.csv"
    path.write_text(text, encoding="utf-8")
    return path


def read(path: Path, decimal: str = "") -> Rows:
    table = TextTable.open(path, decimal)
    return table.rows([table.select("1", "s"), table.select("2", "Nm")])


def grouped(value: float, sign: str) -> str:
    return f"{value:,.0f}".replace(",", sign)


@pytest.mark.parametrize(
    ("written", "plain"),
    [
        *(("\u22121.5", "-1.5"), ("2,\u20130.5", "2,-0.5"), ("1.5E\u221203", "1.5E-03"), ("\u2212∞", "-inf")),
        *(("1\u00a0234,5", "1234,5"), ("1'234'567", "1234567"), ("12\u202f345", "12345")),
        *(("1.5D+03", "1.5E+03"), ("1.5d-03", "1.5E-03"), ("phase \u2013 a", "phase \u2013 a")),
        *(("12\u00a034", "12\u00a034"), ("0.001\u00a0123", "0.001\u00a0123")),
    ],
)
def test_numbers_of_other_languages(written: str, plain: str) -> None:
    assert ascii_numbers(written.encode()).decode() == plain


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        (
            ("OVER", "-OL", "∞".replace("∞", "inf"), "1.#INF", "Overflow", "Überlauf", "O.L", ">>>"),
            Cell.OVERLOAD,
        ),
        (("", "nan", "--", "***", "#N/A", "No Data", "?", "1.#QNAN", "null"), Cell.MISSING),
        (("Time", "RUN", "Iq [A]"), None),
    ],
)
def test_words_in_place_of_a_number(words: tuple[str, ...], kind: Cell | None) -> None:
    assert {kind_of_word(word) for word in words} == {kind}


@pytest.mark.parametrize("word", ["OVER", "--", "∞", "#N/A", "***", "1.#INF", "No Data", "?", "Sensor 3 off"])
@pytest.mark.parametrize("head", ["Time,Torque\n(ms),(mNm)\n\n", "t [ms],T [mNm]\n"])
def test_a_word_in_the_first_row_takes_no_unit_away(tmp_path: Path, word: str, head: str) -> None:
    cells = [word, word, *map(str, TORQUE_MNM[2:])]
    body = "".join(f"{row}.5,{cell}\n" for row, cell in enumerate(cells))
    found = read(write(tmp_path, head + body))
    np.testing.assert_allclose(found.data[:, 0], (np.arange(2, COUNT) + 0.5) * 1e-3)
    np.testing.assert_allclose(found.data[:, 1], TORQUE_MNM[2:] * 1e-3)
    assert found.dropped == {"a cell is no number": 2}


@pytest.mark.parametrize(
    ("delimiter", "sign", "quote"),
    [(";", ".", ""), (";", ",", ""), ("\t", ",", ""), (",", ",", '"'), (";", "'", ""), ("\t", " ", "")],
)
def test_thousands_separators_are_no_decimals(tmp_path: Path, delimiter: str, sign: str, quote: str) -> None:
    rows = (f"{row}{delimiter}{quote}{grouped(value, sign)}{quote}\n" for row, value in enumerate(TORQUE_MNM))
    found = read(write(tmp_path, f"t{delimiter}T [mNm]\n" + "".join(rows)))
    np.testing.assert_allclose(found.data[:, 1], TORQUE_MNM * 1e-3)


@pytest.mark.parametrize("sign", [".", ","])
def test_what_may_be_either_is_refused_until_it_is_stated(tmp_path: Path, sign: str) -> None:
    values = TORQUE_MNM + 1000.0
    path = write(tmp_path, "t;T\n" + "".join(f"{row};{grouped(v, sign)}\n" for row, v in enumerate(values)))
    with pytest.raises(AnalysisError, match=r"state --decimal \. or --decimal ,"):
        read(path)
    np.testing.assert_allclose(read(path, sign).data[:, 1], values * 1e-3)
    np.testing.assert_allclose(read(path, "," if sign == "." else ".").data[:, 1], values)


def test_decimals_of_another_sign_than_the_table_has_are_open(tmp_path: Path) -> None:
    rows = (f"0,{row:04d};{1 + row / 1000:.3f}\n" for row in range(COUNT))
    path = write(tmp_path, "t;T\n" + "".join(rows))
    with pytest.raises(
        AnalysisError, match=r"'\.' in column '2' .* may be the decimal sign or stand between"
    ):
        read(path)
    np.testing.assert_allclose(read(path, ",").data[:, 1], 1000.0 + np.arange(COUNT))


@pytest.mark.parametrize(
    ("cells", "use"),
    [
        (["1,5", "2"], Use.DECIMALS),
        (["0,125", "1,125"], Use.DECIMALS),
        (["1500", "1,125"], Use.DECIMALS),
        (["998", "3"], Use.NOTHING),
        (["1,125", "2,250"], Use.EITHER),
        (["1,125", "998"], Use.EITHER),
        (["1,125,000"], Use.THOUSANDS),
        (["1,095"] * 64 + ["998", "997"], Use.THOUSANDS),
        (["1,095"] * 64 + ["0", "0"], Use.EITHER),
    ],
)
def test_use_of_a_sign(cells: list[str], use: Use) -> None:
    assert use_of(",", cells) == use


@pytest.mark.parametrize("head", ["t,T\n", ""])
def test_decimal_commas_between_commas_are_refused(tmp_path: Path, head: str) -> None:
    rows = (f"0,{row:04d},{value / 1000:.4f}\n".replace(".", ",") for row, value in enumerate(TORQUE_MNM))
    with pytest.raises(
        RecordingError, match="decimal commas and commas between columns cannot be told apart"
    ):
        TextTable.open(write(tmp_path, head + "".join(rows)))


def test_a_row_that_was_left_out_says_what_its_cells_are(tmp_path: Path) -> None:
    text = "0.5,1\n1.5,OL\n2.5,\n3.5,9.9e37\n4.5,9.91e37\n5.5,2\n6.5,3,4\n7.5,4\n8.5\n"
    rows = read(write(tmp_path, text))
    kinds = [Cell.OVERLOAD, Cell.MISSING, Cell.OVERLOAD, Cell.MISSING]
    assert rows.left_out.cells[:, 1].tolist() == kinds
    assert rows.left_out.place.tolist() == [1, 2, 3, 4]
    assert rows.left_out.broken == 1  # the last line is cut short, the other is not


@pytest.mark.parametrize(
    "cell", ["1" * 200_000 + ".5.5", "-" * 200_000 + "x", "(" * 200_000, "1 " * 100_000 + "x"]
)
@pytest.mark.parametrize("place", ["head", "row"])
def test_long_cells_take_no_time_by_the_square_of_their_length(tmp_path: Path, cell: str, place: str) -> None:
    head, row = (cell, "0.5") if place == "head" else ("T", cell)
    body = "".join(f"{number}.5,0.{number}\n" for number in range(9))
    begin_s = time.monotonic()
    TextTable.open(write(tmp_path, f"t,{head}\n0.25,{row}\n{body}"))
    assert time.monotonic() - begin_s < 5.0
