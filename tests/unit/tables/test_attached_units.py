"""Numbers with their unit behind them in the cell, as spreadsheets, loggers and simulators write them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.attached_units import without_units

ROWS, RATE_HZ = 2_000, 10e3
TIME_S = np.arange(ROWS) / RATE_HZ
CURRENT_A = 5.0 * np.cos(2 * np.pi * 50.0 * TIME_S) + 1e-3 * np.random.default_rng(1).standard_normal(ROWS)


def with_prefix(value: float) -> str:
    for prefix, size in (("", 1.0), ("m", 1e-3), ("u", 1e-6)):
        if abs(value) >= size:
            return f"{value / size:.6g}{prefix}"
    return "0"


def fundamental(path: Path, text: str, columns: tuple[str, str] = ("t", "i")) -> float:
    path.write_text(text, encoding="utf-8")
    found = analyze_table(TableQuestion(path, columns[0], {"current": columns[1]})).measurements
    numbers = {each.name: each.value for each in found}
    assert numbers["fundamental_frequency"] == pytest.approx(50.0, rel=1e-4)
    return numbers["current_fundamental"]


ROWS_OF = list(zip(TIME_S.tolist(), CURRENT_A.tolist(), strict=True))
TABLES = {
    "one unit": "t,i\n" + "\n".join(f"{1e3 * t:.1f} ms,{i:.5f} A" for t, i in ROWS_OF),
    "without a blank": "t;i\n" + "\n".join(f"{1e6 * t:.0f}µs;{1e3 * i:.3f}mA" for t, i in ROWS_OF),
    "decimal comma": "t;i\n" + "\n".join(f"{1e3 * t:.1f} ms;{i:.5f} A".replace(".", ",") for t, i in ROWS_OF),
    "prefixes": "t,i\n" + "\n".join(f"{with_prefix(t)},{with_prefix(i)}" for t, i in ROWS_OF),
    "prefixes and unit": "t\ti\n" + "\n".join(f"{with_prefix(t)}s\t{with_prefix(i)}A" for t, i in ROWS_OF),
    "one column": "t,i,state\n" + "\n".join(f"{t:.4f},{1e3 * i:.2f} mA,run" for t, i in ROWS_OF),
    "as in the head": "t [ms],i [mA]\n" + "\n".join(f"{1e3 * t:.1f} ms,{1e3 * i:.2f} mA" for t, i in ROWS_OF),
    "exponents": "t,i\n" + "\n".join(f"{1e3 * t:.5e}ms,{1e3 * i:.5e}mA" for t, i in ROWS_OF),
}


@pytest.mark.parametrize("kind", TABLES)
def test_units_behind_numbers_are_theirs(tmp_path: Path, kind: str) -> None:
    assert fundamental(tmp_path / "t.csv", TABLES[kind]) == pytest.approx(5.0, rel=1e-3)


def test_a_number_with_another_unit_is_no_number(tmp_path: Path) -> None:
    lines = TABLES["one unit"].split("\n")
    lines[1_500] = lines[1_500].replace("A", "V")
    path = tmp_path / "t.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    found = analyze_table(TableQuestion(path, "t", {"current": "i"}))
    assert found.to_json()["source"]["rows_dropped"] == {"a cell is no number": 1}


@pytest.mark.parametrize(
    "text",
    [
        "t,i\n0.1,1.5\n0.2,1.6\n0.3,1.7\n",
        "range,10 A\nt,i\n0.1,1.5\n0.2,1.6\n0.3,1.7\n",
        "t,phase,i\n0.1,1A,1.5\n0.1,2A,1.6\n0.2,1A,1.5\n0.2,2A,1.6\n",
        "t;i\n2026-01-31T23:59:59.1Z;1.5\n2026-01-31T23:59:59.2Z;1.6\n2026-01-31T23:59:59.3Z;1.4\n",
        "t,i,code\n0.1,1.5,1F\n0.2,1.6,2C\n0.3,1.7,3D\n",
    ],
)
def test_other_tables_are_left_as_they_are(text: str) -> None:
    assert without_units(text.encode()) == (text.encode(), ())


def test_powers_of_ten_are_exact(tmp_path: Path) -> None:
    text = "a,b\n" + "".join(f"{number}.3m,{number}.7uA\n" for number in range(1, 20))
    plain, units = without_units(text.encode())
    assert units == ("", "uA")
    last = plain.decode().split("\n")[-2].split(",")
    assert [float(each) for each in last] == [19.3e-3, 19.7]
    assert math.isfinite(float(last[0]))
