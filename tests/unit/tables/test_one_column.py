"""Tables of one column, whose rows a stated rate times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.errors import RecordingError
from benchtool.tables.text import TextTable

CURRENT = np.round(np.sin(np.arange(60) * 0.7), 4)


def write(folder: Path, content: str) -> Path:
    path = folder / "current.txt"
    path.write_bytes(content.encode())
    return path


@pytest.mark.parametrize(
    ("form", "head", "decimal"),
    [
        ("{:.4f}\n", "", ""),
        ("  {:.4e} \r\n", "", ""),
        ("{:.4f}\n", "Scope, model 5\nCH1 [A]\n", ""),
        ("{:.4f};\n", "i_a;\n", ""),
        ("{:.4f}\n", "Strom (A)\n", ","),
    ],
)
def test_one_column_is_enough_where_none_is_the_time(
    tmp_path: Path, form: str, head: str, decimal: str
) -> None:
    body = "".join(form.format(each) for each in CURRENT)
    path = write(tmp_path, head + (body.replace(".", ",") if decimal else body))

    table = TextTable.open(path, decimal, timed=False)

    np.testing.assert_allclose(table.rows([table.select("1", "A")]).data[:, 0], CURRENT, atol=1e-4)


@pytest.mark.parametrize("head", ["", "Strom (A)\n"])
def test_zeros_behind_a_comma_tell_decimal_commas(tmp_path: Path, head: str) -> None:
    body = "".join(f"{each:.4f}\n" for each in CURRENT).replace(".", ",")

    table = TextTable.open(write(tmp_path, head + body), timed=False)

    np.testing.assert_allclose(table.rows([table.select("1", "A")]).data[:, 0], CURRENT, atol=1e-4)


def test_other_decimal_commas_that_are_not_stated_are_refused(tmp_path: Path) -> None:
    body = "".join(f"{each + 2.5:.1f}\n" for each in CURRENT).replace(".", ",")

    with pytest.raises(RecordingError, match=r"decimal commas .* or state --decimal , for one column"):
        TextTable.open(write(tmp_path, f"Strom (A)\n{body}"), timed=False)


def test_a_blank_line_is_an_empty_cell(tmp_path: Path) -> None:
    lines = [f"{each:.4f}" for each in CURRENT]
    lines[20] = lines[21] = ""
    table = TextTable.open(write(tmp_path, "i [A]\n" + "\n".join(lines) + "\n\n"), timed=False)

    rows = table.rows([table.select("1", "A")])

    assert rows.dropped == {"a cell is no number": 2}
    np.testing.assert_array_equal(rows.place, np.delete(np.arange(len(CURRENT)), [20, 21]))


def test_blank_lines_between_all_rows_are_none(tmp_path: Path) -> None:
    body = "".join(f"{each:.4f}\n\n" for each in CURRENT)
    table = TextTable.open(write(tmp_path, f"i [A]\n{body}"), timed=False)

    assert not table.rows([table.select("1", "A")]).dropped


def test_pairs_in_the_head_are_no_columns_of_a_table_of_one(tmp_path: Path) -> None:
    head = "Revision: 0\nPoints: 60\nCount: 1\nXInc: 1.0E-04\nXOrg: 0.0\nDate: 28 NOV 2026\nData:\n"
    body = "".join(f"{each:.4e}\n" for each in CURRENT)

    table = TextTable.open(write(tmp_path, head + body), timed=False)

    np.testing.assert_allclose(table.rows([table.select("1", "A")]).data[:, 0], CURRENT, atol=1e-4)


@pytest.mark.parametrize("timed", [True, False])
def test_words_are_no_table(tmp_path: Path, *, timed: bool) -> None:
    with pytest.raises(RecordingError, match="no table of numbers"):
        TextTable.open(write(tmp_path, "hello\nworld\n"), timed=timed)
