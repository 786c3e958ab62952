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
from benchtool.tables.units import unit_factor
from tests.at_length import at_length

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
            ("time_s", "s", "s"),
            ("Zeit s", "s", "s"),
            ("i_s", "s", ""),
        ),
        *(("torqueNm", "Nm", "Nm"), ("speedRadS", "rad/s", "rad/s"), ("thetaRad", "rad", "rad")),
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


@pytest.mark.parametrize(
    ("name", "si_unit", "unit", "perhaps"),
    [
        *(("omega_rad_s", "rad/s", "rad/s", ""), ("omega_rad_s", "rad", "", "rad/s")),
        *(("speed_rad_s_filtered", "rad", "", "rad/s"), ("rad_s", "rad", "", "rad/s")),
        *(("omega_deg_ms", "s", "", "deg/ms"), ("n_rev_min", "rad", "", "rev/min")),
        *(("n_rev_min", "rad/s", "rev/min", ""), ("theta_deg_min", "rad", "deg", "")),
        *(("torque_Nm_per_s", "Nm", "", "Nm/s"), ("probe_mV_per_A", "A", "", "mV/A")),
        *(("psi_V_s", "Wb", "Vs", ""), ("psi_V_s", "V", "", "Vs"), ("v_m_s", "rad/s", "", "m/s")),
        # indices: of a phase u or a magnetizing current in the stator's frame, and of a motor
        *(("i_u_s", "A", "", ""), ("i_m_s", "A", "", ""), ("T_m_Nm", "Nm", "Nm", "")),
    ],
)
def test_a_part_of_a_quotient_or_product_is_no_unit(name: str, si_unit: str, unit: str, perhaps: str) -> None:
    assert unit_in_name(name, si_unit) == unit
    assert unit or perhaps_in_name(name, si_unit) == perhaps


@pytest.mark.parametrize("name", ["Ia（mA）", "Ia〔mA〕", "Strom (in mA)", "mA (phase a)"])
def test_brackets_of_other_scripts_and_prepositions(tmp_path: Path, name: str) -> None:
    chosen = table(tmp_path, name).select("2", "A")
    assert (chosen.unit, chosen.unit_from, chosen.factor) == ("mA", "head", 1e-3)


def test_what_may_be_a_unit_or_indices_is_asked_for(tmp_path: Path) -> None:
    assert perhaps_in_name("IuA", "A") == "uA"  # phase u of motor A
    with pytest.raises(AnalysisError, match=r"has 'mA' in it, .* state it in the option, as '2:mA'"):
        table(tmp_path, "ImA").select("2", "A")
    assert table(tmp_path, "ImA").select("2:mA", "A").factor == 1e-3


@pytest.mark.parametrize(
    ("name", "si_unit", "found"),
    [
        *(("torque_pu", "Nm", "pu"), ("M %", "Nm", "%"), ("iq_counts", "A", "counts")),
        *(("ticks_1", "s", "ticks"), ("time_rel", "s", ""), ("torque_raw", "Nm", "raw"), ("i_ma", "A", "ma")),
        *(("T_MS", "s", "MS"), ("I 10mA", "A", "10mA"), ("Phase 1 A", "A", ""), ("CH1_mV", "A", "mV")),
        *(("Ток, xx", "A", "xx"), ("i, avg", "A", ""), ("电流 毫安", "A", "毫安"), ("i_max", "A", "")),
        *(("phase_a", "A", ""), ("i alpha β", "A", ""), ("T_min", "Nm", ""), ("T_q15", "Nm", "q15")),
        *(("I_U", "A", ""), ("Phase V", "A", ""), ("CH1, V", "A", "V"), ("Phase, A", "A", "")),
    ],
)
def test_what_may_be_another_unit_or_scale(name: str, si_unit: str, found: str) -> None:
    assert perhaps_in_name(name, si_unit) == found


@pytest.mark.parametrize(
    ("text", "si_unit", "factor"),
    [
        *(("мА", "A", 1e-3), ("мкс", "s", 1e-6), ("мН·м", "Nm", 1e-3), ("рад/с", "rad/s", 1.0)),
        *(("Mikrosekunden", "s", 1e-6), ("micros", "s", 1e-6), ("msek", "s", 1e-3), ("mins", "s", 60.0)),
        *(("MA", "A", None), ("Ms", "s", None), ("MNm", "Nm", 1e6)),
    ],
)
def test_further_spellings(text: str, si_unit: str, factor: float | None) -> None:
    assert unit_factor(text, si_unit) == (None if factor is None else pytest.approx(factor))


@pytest.mark.parametrize(
    "line",
    [
        *(
            "# current_unit=mA",
            "# Y-Unit: mA",
            "XUnit=s YUnit=mA",
            "All currents are in mA.",
            "# units: s mA Nm",
        ),
        *('# {"unit": {"i": "mA"}}', "unit = mA", "Einheiten: s, mA"),
    ],
)
def test_a_unit_in_a_line_of_the_head_keeps_si_from_being_assumed(tmp_path: Path, line: str) -> None:
    path = tmp_path / "table.csv"
    rows = "".join(f"{t:.3f};{np.sin(300 * t):.4f}\n" for t in TIME_S)
    for text in (f"{line}\nt;i\n{rows}", f"t;i\n{rows}{line}\n"):
        if text.endswith(f"{line}\n") and not line.startswith("#"):
            continue  # below the rows comments alone are looked at as lines
        path.write_text(text, encoding="utf-8")
        with pytest.raises(AnalysisError, match="has the unit 'mA', but not of which column"):
            TextTable.open(path).select("i", "A")


def test_units_of_settings_are_none_of_columns(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    rows = "".join(f"{t:.3f};{np.sin(300 * t):.4f}\n" for t in TIME_S)
    path.write_text(f"Range: 500 mA\nTime base: 10 ms per unit\nt;i\n{rows}", encoding="utf-8")
    found = TextTable.open(path)
    assert [found.select(*each).unit_from for each in (("t", "s"), ("i", "A"))] == ["assumed"] * 2


@pytest.mark.parametrize("head", ["t;T\n", "Name;t;i;T\n", *at_length("t;i;T;n\n")])
def test_a_head_of_another_width_is_told(tmp_path: Path, head: str) -> None:
    path = tmp_path / "table.csv"
    path.write_text(head + "".join(f"{t:.3f};{np.sin(300 * t):.4f};1.5\n" for t in TIME_S), encoding="utf-8")
    found = analyze_table(TableQuestion(path, "1", {"current": "2"}))
    text = next(each.text for each in found.remarks if each.kind == RemarkKind.OTHER_HEAD)
    assert f"has {head.count(';') + 1} cells and the rows have 3" in text


@pytest.mark.parametrize(
    "name", ["I*1000 [A]", "I[A]*1000", "Ia x10 [A]", "Ia 1e3 [A]", "CH1 10x (A)", "I x0.01 A"]
)
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


@pytest.mark.parametrize(
    ("name", "si_unit", "scale"),
    [
        *(("T/Tn", "Nm", "T/Tn"), ("i/i_N", "A", "i/i_N"), ("Iq/Imax", "A", "Iq/Imax")),
        *(("torque / torque_rated", "Nm", "torque / torque_rated"), ("n/n0", "rad/s", "n/n0")),
        *(("Ia_dA", "A", "dA"), ("t_cs", "s", "cs"), ("i_dq", "A", ""), ("i_ds", "A", "")),
        *(("Ia mA/div", "A", "mA/div"), ("Ia_mA_div", "A", "mA_div"), ("CH1 V/div", "A", "V/div")),
        *(("6077h", "Nm", "6077h"), ("torque_0x6077", "Nm", "0x6077"), ("Iq p.u.", "A", "p.u.")),
        # paths, and a serial number
        *(
            ("motor/i_q", "A", ""),
            ("motor/main", "A", ""),
            ("/drive/torque", "Nm", ""),
            ("M_60770", "Nm", ""),
        ),
    ],
)
def test_a_scale_that_a_name_may_state_is_asked_for(name: str, si_unit: str, scale: str) -> None:
    assert unit_in_name(name, si_unit) == ""
    assert perhaps_in_name(name, si_unit) == scale


@pytest.mark.parametrize(
    ("head", "called"),
    [
        *(("Strom A", "Strom"), ("Iq_mA", "Iq"), ("r69[0] Strom U [A]", "r69[0] Strom U")),
        *(("i_s", "i_s"), ("CH1 (V) [A]", "CH1 (V)")),
    ],
)
def test_a_column_is_called_by_its_name_without_the_unit(tmp_path: Path, head: str, called: str) -> None:
    assert table(tmp_path, head).select(called, "A").number == 2


@pytest.mark.parametrize("head", ["omega_rad_s", "omega_deg_per_s"])
def test_a_speed_is_called_by_its_name_without_the_quotient(tmp_path: Path, head: str) -> None:
    assert table(tmp_path, head).select("omega", "rad/s").number == 2


def test_a_letter_behind_an_underscore_is_an_index(tmp_path: Path) -> None:
    with pytest.raises(AnalysisError, match="no column 'i'"):
        table(tmp_path, "i_s").select("i", "A")
