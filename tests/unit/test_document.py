"""What is wrong with a document: all of it at once, each with its line and its key."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.errors import PlanError, ProfileError
from benchtool.plan.model import load_plan
from benchtool.plan.validation import require_known
from benchtool.profile import load_profile
from benchtool.protocol.dictionary import Dictionary
from benchtool.shipped import shipped

PLAN = """\
titel = "x"
profile = 3
[operating_point]
omega_m = 15
sttle_s = 1
[record]
duration_s = "long"
chanels = ["i_a"]
[limits]
torque_ripple_pp = { max = true, maxi = 3 }
[[variants]]
name = "a"
emulater = { a = 1.0 }
"""
KNOWN_TO_NONE = """\
title = "x"
profile = "zhu2011"
[setup]
R_z_ohm = 1.0
law = "fco"
[operating_point]
omega_m_rad_s = 1500.0
load_torque_Nm = 100.0
[record]
duration_s = 0.5
channels = ["i_a", "torqe"]
[limits]
torque_ripple_p = { max = 1.0 }
"""


def lines(error: BaseException) -> list[str]:
    return [str(error), *getattr(error, "__notes__", ())]


def test_every_wrong_key_of_a_plan_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(PLAN, encoding="utf-8")
    with pytest.raises(PlanError) as failed:
        load_plan(str(path))
    told = lines(failed.value)
    for line, what in (
        (1, "unknown key 'titel': did you mean 'title'?"),
        (2, "key 'profile' is 3: "),
        (4, "unknown key 'operating_point.omega_m': did you mean 'omega_m_rad_s'?"),
        (5, "unknown key 'operating_point.sttle_s': did you mean 'settle_s'?"),
        (7, "key 'record.duration_s' is 'long': "),
        (8, "unknown key 'record.chanels': did you mean 'channels'?"),
        (10, "unknown key 'limits.torque_ripple_pp.maxi': did you mean 'max'?"),
        (13, "unknown key 'variants.0.emulater': did you mean 'emulator'?"),
    ):
        assert [each for each in told if each.startswith(f"{path}, line {line}: {what}")], what
    # what is missing because its key is misspelt is not told again
    assert not [each for each in told if "is missing" in each]


def test_a_flood_of_wrong_keys_is_cut_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "flood.toml"
    path.write_text("\n".join(f"key_{n} = {n}" for n in range(1000)), encoding="utf-8")
    with pytest.raises(PlanError) as failed:
        load_plan(str(path))
    told = lines(failed.value)
    assert len(told) == 41
    assert told[-1] == "and 964 more: fix these first"  # four keys of a plan are missing besides


def test_every_missing_key_of_a_profile(tmp_path: Path) -> None:
    path = tmp_path / "bare.toml"
    path.write_text('title = "x"\n[motor]\npole_pairs = 4\n[drive]\n[emulator.inverter]\n', encoding="utf-8")
    with pytest.raises(ProfileError) as failed:
        load_profile(str(path))
    told = lines(failed.value)
    missing = {each.split("'")[1] for each in told if "is missing: add it" in each}
    motor = {"R_s_ohm", "L_d_H", "L_q_H", "psi_r_Wb", "J_kgm2", "T_N_Nm", "omega_m_N_rad_s", "I_N_A_rms"}
    assert [each for each in told if each.endswith("a table with i_full_scale_A, u_full_scale_V")]
    assert missing == {f"motor.{key}" for key in motor} | {"emulator.inverter.u_dc_V", "emulator.sensors"}
    assert len(told) == len(missing)


def test_every_name_and_value_that_nothing_knows(tmp_path: Path) -> None:
    path = tmp_path / "unknown.toml"
    path.write_text(KNOWN_TO_NONE, encoding="utf-8")
    dictionary = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
    with pytest.raises(PlanError) as failed:
        require_known(load_plan(str(path)), path, load_profile("zhu2011"), dictionary, transducer=True)
    told = "\n".join(lines(failed.value))
    for line, what in (
        (4, "no parameter 'R_z_ohm' in drive.eds: did you mean 'R_s_ohm'?"),
        (5, "law is 'fco', the values are tpc, "),
        (7, "omega_m_rad_s is 1500, the profile rates the motor at 157.1 rad/s"),
        (8, "load_torque_Nm is 100, "),
        (11, "no signal 'torqe' to capture: did you mean 'torque'"),
        (13, "no measurement is called 'torque_ripple_p': did you mean 'torque_ripple_pp'"),
    ):
        assert f"{path}, line {line}: {what}" in told, what


WRONG_IN_EVERY_WAY = """\
title = "x"
profile = "zhu2011"
repetitons = 3
judge = "mean"
[operating_point]
omega_m_rad_s = "fast"
load_torq_Nm = 100.0
[record]
duration_s = -0.22
channels = ["i_a", "torqe", "torque", "theta_m"]
[limits]
torque_ripple_p = { max = 0.045 }
torque_ripple_pp = { min = 2.0, max = 1.0 }
"""


def test_keys_values_and_names_are_told_at_once(tmp_path: Path) -> None:
    """Values were told once the keys were right, and names once the values were."""
    path = tmp_path / "bad.toml"
    path.write_text(WRONG_IN_EVERY_WAY, encoding="utf-8")
    result = CliRunner().invoke(app, ["run", str(path)])
    assert result.exit_code == 2
    told = result.stderr.splitlines()
    for line, what in (
        (3, "unknown key 'repetitons': did you mean 'repetitions'?"),
        (7, "unknown key 'operating_point.load_torq_Nm': did you mean 'load_torque_Nm'?"),
        (6, "key 'operating_point.omega_m_rad_s' is 'fast': "),
        (9, "key 'record.duration_s' is -0.22: "),
        (13, "[limits.torque_ripple_pp]: min 2.0 is above max 1.0"),
        (5, "load_torque_Nm is 100, "),  # the table, which does not have that key
        (10, "no signal 'torqe' to capture: did you mean 'torque'"),
        (12, "no measurement is called 'torque_ripple_p': did you mean 'torque_ripple_pp'"),
    ):
        assert [each for each in told if f"{path}, line {line}: {what}" in each], what
    assert len(told) == 8  # nothing that follows from what is left out


def test_a_table_is_looked_at_as_a_whole_without_what_is_wrong_in_it(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    text = PLAN_OF_TWO.replace("repetitions = 2", 'repetitions = 1\njudge = "mean"\ntitel = "y"')
    path.write_text(text, encoding="utf-8")
    with pytest.raises(PlanError) as failed:
        load_plan(str(path))
    told = "\n".join(lines(failed.value))
    assert "unknown key 'titel'" in told
    assert "judge = 'mean' is over repetitions, of which there is one" in told


PLAN_OF_TWO = """\
title = "x"
profile = "zhu2011"
repetitions = 2
[operating_point]
omega_m_rad_s = 15.71
[record]
duration_s = 0.5
channels = ["torque", "theta_m"]
"""


def _lines_told(path: Path, text: str) -> list[str]:
    path.write_text(text, encoding="utf-8")
    result = CliRunner().invoke(app, ["run", str(path)])
    assert result.exit_code == 2
    return [each.partition(f"{path}")[2] for each in result.stderr.splitlines()]


@pytest.mark.parametrize("text", [WRONG_IN_EVERY_WAY, KNOWN_TO_NONE])
def test_what_is_wrong_is_told_in_the_order_of_the_lines(tmp_path: Path, text: str) -> None:
    """It came by what had found it: keys, then settings, channels, and names last."""
    told = _lines_told(tmp_path / "bad.toml", text)
    numbers = [
        int(each.removeprefix(", line ").partition(":")[0]) for each in told if each.startswith(", line")
    ]
    assert len(numbers) > 4
    assert numbers == sorted(numbers)


def test_names_are_told_where_no_channels_are_stated(tmp_path: Path) -> None:
    """A misspelt limit and an unknown value were told in a second round, once record.channels was there."""
    text = """
title = "x"
profile = "zhu2011"
setup = { law = "tcp" }
operating_point = { omega_m_rad_s = 15.71 }
record = { duration_s = 0.52 }
[limits]
torque_riple_pp = { max = 0.06 }
current_fundamental = { max = 0.06, unit = "V" }
flux_ripple_pp = { max = 0.06 }
"""
    begin = (
        ", line 4: law is 'tcp', the values are tpc",
        ", line 6: key 'record.channels' is missing: add it",
        ", line 8: no measurement is called 'torque_riple_pp': did you mean 'torque_ripple_pp'?",
        ", line 9: the limit of 'current_fundamental' is in V, that is in A",
    )
    told = _lines_told(tmp_path / "bad.toml", text)
    assert all(each.startswith(what) for each, what in zip(told, begin, strict=True)), told
