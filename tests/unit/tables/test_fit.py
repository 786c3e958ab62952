"""Lines of a table by the delimiter and the decimal sign that fit it."""

from __future__ import annotations

import pytest

from benchtool.tables.cells import BLANKS
from benchtool.tables.fit import best_fit

ROWS = {
    ",": (
        "1.5,2,-3e-4",
        " 1 , +2. , .5 ",
        "1.5,2",
        "1.5,2,x",
        "1.5,2,",
        '"1",2,3',
        "1.5,2,OVER",
        "a,b,c",
        "",
    ),
    ";": ("1,5;2;-3e-4", "1.234,5;2;3", "1,5;;3", "1,5;2;3;4"),
    "\t": ("1.5\t2\t3", "1.5 \t 2\t3", "\t1.5\t2", "1.5\t2\t3\t"),
    "|": ("1.5|2|3", "|1.5|2|3|", "1|2|--", "1|2"),
    BLANKS: ("1.5  2\t3", "  1.5 2 3", "1.5 2 3 ", '"1.5" 2 3', "1.5 2"),
}


@pytest.mark.parametrize("delimiter", ROWS)
def test_a_line_is_a_row_where_its_cells_are_one(delimiter: str) -> None:
    sample = [ROWS[delimiter][0].encode()] * 4
    fit = best_fit(sample, "", timed=True)
    assert fit is not None
    assert (fit.delimiter, fit.width) == (delimiter, 3)
    found = [fit.is_line_of_row(line) for line in ROWS[delimiter]]
    assert found == [fit.is_row(fit.cells(line)) for line in ROWS[delimiter]]
    assert found[0]
    assert not all(found)
