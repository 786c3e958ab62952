"""Units and factors in names of columns, and what a name or another column says of a unit that is missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.errors import AnalysisError
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.remarks import RemarkKind
from benchtool.tables.text import TextTable
from benchtool.tables.unit_in_name import perhaps_in_name, unit_in_name

TIME_S = np.arange(400) / 1000.0


def table(folder: Path, name: str) -> TextTable:
    path = folder / "table.csv"
    rows = "".join(f"{t:.3f};{np.sin(300 * t):.4f};{np.cos(200 * t):.4f}\n" for t in TIME_S)
    path.write_text(f"t [s];{name};other\n{rows}", encoding="utf-8")
    return TextTable.open(path)


@pytest.mark.parametrize(
    ("name", "si_unit", "unit"),
    [
        *(("Current_mA_filtered", "A", "mA"), ("Ia |mA|", "A", "mA"), ("Ia mA DC", "A", "mA")),
        *(("CurrentMilliAmps", "A", "milliamps"), ("Moment, mN m", "Nm", "mNm"), ("rpm", "rad/s", "rpm")),
        *(
            ("MotorRPM", "rad/s", "rpm"),
            ("timems", "s", "ms"),
            ("status", "s", ""),
            ("time_min_max", "s", ""),
        ),
        *(("i_m_A", "A", ""), ("Iq_MA", "A", ""), ("torque_pin", "Nm", ""), ("torque_inp", "Nm", "")),
        *(
            ("w_rad_s_filtered", "rad/s", "rad/s"),
            ("theta_deg_raw", "rad", "deg"),
            ("omega_dps", "rad/s", "dps"),
        ),
    ],
)
def test_a_unit_may_stand_anywhere_in_a_name(name: str, si_unit: str, unit: str) -> None:
    assert unit_in_name(name, si_unit) == unit


@pytest.mark.parametrize("name", ["Ia（mA）", "Ia〔mA〕", "Strom (in mA)", "mA (phase a)"])
def test_brackets_of_other_scripts_and_prepositions(tmp_path: Path, name: str) -> None:
    chosen = table(tmp_path, name).select("2", "A")
    assert (chosen.unit, chosen.unit_from, chosen.factor) == ("mA", "head", 1e-3)


def test_what_may_be_a_unit_or_indices_is_asked_for(tmp_path: Path) -> None:
    assert perhaps_in_name("IuA", "A") == "uA"  # phase u of motor A
    with pytest.raises(AnalysisError, match="ends in 'mA', which may be its unit: state it"):
        table(tmp_path, "ImA").select("2", "A")
    assert table(tmp_path, "ImA").select("2:mA", "A").factor == 1e-3


@pytest.mark.parametrize("name", ["I*1000 [A]", "I[A]*1000", "Ia x10 [A]", "Ia 1e3 [A]", "CH1 10x (A)"])
def test_a_factor_in_the_name_is_asked_for(tmp_path: Path, name: str) -> None:
    with pytest.raises(AnalysisError, match=r"in the name of column '2' of .* may be a factor of its values"):
        table(tmp_path, name).select("2", "A")
    assert table(tmp_path, name).select("2:A*0.1", "A").gain == 0.1


def test_digits_in_a_name_are_no_factor(tmp_path: Path) -> None:
    for name in ("ax10_i [A]", "I100 [A]", "group/10/i [A]", "I_1 [A]"):
        assert table(tmp_path, name).select("2", "A").unit == "A"


def remarks(folder: Path, speed: str, angle: str, gain: float = 1.0) -> dict[RemarkKind, str]:
    """Measure a shaft at 80 rad/s, its speed in a column whose cells are `gain` times that."""
    path = folder / "speed.csv"
    ripple = 1.0 + 0.01 * np.cos(480.0 * TIME_S)
    cells = np.column_stack((TIME_S, gain * 80.0 * ripple, np.mod(80.0 * TIME_S, 2.0 * np.pi), ripple))
    np.savetxt(path, cells, "%.6f", ";", header=f"t [s];{speed};{angle};T [Nm]", comments="")
    columns = {"torque": "4", "angle": "3", "speed": "2"}
    return {each.kind: each.text for each in analyze_table(TableQuestion(path, "t", columns)).remarks}


def test_a_speed_without_a_unit_says_that_one_was_assumed(tmp_path: Path) -> None:
    found = remarks(tmp_path, "Drehzahl", "theta [rad]")
    assert "the unit of the speed 'Drehzahl' is not stated, rad/s was taken" in found[RemarkKind.UNIT_ASSUMED]
    assert not remarks(tmp_path, "n [rad/s]", "theta [rad]")


@pytest.mark.parametrize("gain", [60.0 / (2.0 * np.pi), 4.0, 1.0 / (2.0 * np.pi)])
def test_an_angle_that_advances_at_another_speed_is_told(tmp_path: Path, gain: float) -> None:
    found = remarks(tmp_path, "n [rad/s]", "theta [rad]", gain)
    assert found[RemarkKind.OTHER_SPEED].endswith(
        "and 'theta [rad]' advances by 80 rad in a second: check the units of time, angle and speed, and "
        "that both are mechanical"
    )


@pytest.mark.parametrize(
    "name", ["omega_e [rad/s]", "n_el [rpm]", "erpm", "electrical speed [rpm]", "w_e [rad/s]"]
)
def test_what_is_electrical_by_its_name_is_told(tmp_path: Path, name: str) -> None:
    assert "is by its name electrical" in remarks(tmp_path, name, "theta [rad]")[RemarkKind.ELECTRICAL]


@pytest.mark.parametrize(
    "name", ["wheel [rad/s]", "speed_rel [rpm]", "elapsed [rpm]", "w [rad/s]", "n_e1 [rpm]"]
)
def test_other_names_are_not(tmp_path: Path, name: str) -> None:
    assert RemarkKind.ELECTRICAL not in remarks(tmp_path, name, "theta [rad]")
