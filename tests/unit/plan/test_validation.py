"""Faults of a plan are refused before anything is opened: by file, line and key, with a remedy."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.bench.session import dictionary_of
from benchtool.cli import app
from benchtool.errors import PlanError
from benchtool.plan.analyses import Analyses
from benchtool.plan.cases import cases
from benchtool.plan.model import load_plan
from benchtool.plan.not_made import not_made
from benchtool.plan.rated import for_motor
from benchtool.plan.validation import require_known
from benchtool.profile import load_profile
from benchtool.results.judged_repetitions import limits_alone
from benchtool.shipped import shipped

PROFILE, DICTIONARY = load_profile("zhu2011"), dictionary_of("zhu2011")
BASE = """title = "mine"
profile = "zhu2011"
case = "warm"
figure = "none"
repetitions = 1
[setup]
u_s_V = 81.65
[operating_point]
omega_m_rad_s = 31.42
load_torque_Nm = 0.65
[record]
duration_s = 0.2
channels = ["i_a", "torque", "psi_s", "omega_m"]
"""


def _check(path: Path, text: str, *, transducer: bool = True) -> None:
    path.write_text(text, encoding="utf-8")
    require_known(load_plan(str(path)), path, PROFILE, DICTIONARY, transducer=transducer)


def _refusal(path: Path, text: str, *, transducer: bool = True) -> str:
    with pytest.raises(PlanError) as refused:
        _check(path, text, transducer=transducer)
    message = str(refused.value)
    assert "\n" not in message
    return message


def _line(text: str, part: str) -> str:
    return f"line {1 + text[: text.index(part)].count(chr(10))}:"


SWEPT = '[sweep.setup]\nlaw = ["tpc", "foc"]\n'


@pytest.mark.parametrize(
    ("more", "at", "complaint"),
    [
        ("[limits]\ntorque_riple_pp = { max = 1.0 }\n", "torque_riple", "did you mean 'torque_ripple_pp'?"),
        ("[limits]\ntorque_ripple_pp_Nm = 0.1\n", "[limits]", "a table is expected, of min, max, margin"),
        ("[limits]\nflux_radius_pp = { max = 1.0 }\n", "flux_radius", "needs psi_alpha, psi_beta"),
        ("[limits]\ntorque_order_0 = { max = 1.0 }\n", "torque_order", "no measurement is called"),
        ("[limits]\ntorque_order_24 = { max = 1.0 }\n", "torque_order", "needs theta_m"),
        ("[limits]\novershoot = { max = 1.0 }\n", "overshoot", "analyses.step = true, which is false"),
        ("[limits]\nbandwidth_3dB = { min = 1.0 }\n", "bandwidth", "analyses.frequency_response = true"),
        ("[limits]\ntorque_reached = { min = 1.0 }\n", "torque_reached", "no target of this operating point"),
        ("[limits]\ncapture_rows_mising = { max = 0 }\n", "capture", "did you mean 'capture_rows_missing'?"),
        ("[case_limits.cold]\ntorque_mean = { max = 1.0 }\n", "[case_limits", "names case 'cold'"),
        ("[case_limits.warm]\ntorque_man = { max = 1.0 }\n", "torque_man", "did you mean 'torque_mean'?"),
        ('[case_limits."warm.1"]\ntorque_mean = { max = 1.0 }\n', "[case_limits", "did you mean 'warm'?"),
        ("[published.cold]\ntorque_mean = 1.0\n", "[published", "published names case 'cold'"),
        ("[published.warm]\ncapture_rows_missing = 1.0\n", "capture_rows", "which only limits may name"),
    ],
)
def test_names_that_match_nothing(tmp_path: Path, more: str, at: str, complaint: str) -> None:
    text = BASE + more
    message = _refusal(tmp_path / "mine.toml", text)
    assert complaint in message
    assert _line(text, at) in message


@pytest.mark.parametrize(
    ("was", "now", "complaint"),
    [
        ('figure = "none"', 'tabulate = ["torque_ripple_pp", "torque_rms"]', "no measurement is called"),
        ('figure = "none"', 'figure_of = "torque_mean"', "figure_of is drawn by figure = 'sweep'"),
        ('figure = "none"', 'figure = "sweep"', "needs a [sweep.operating_point]"),
        ("[setup]", "figure_of = 1\n[setup]", "should be a valid string"),
        ("duration_s = 0.2", "duration_s = 3000", "30000000 rows"),
        ("duration_s = 0.2", "duration_s = 30", "the drive records 200000 at most"),
        (
            'duration_s = 0.2\nchannels = ["i_a"',
            'duration_s = 20\nchannels = ["i_b", "i_c", "i_a"',
            "the drive has room for 1000000",
        ),
        ("duration_s = 0.2", "duration_s = 0.09", "electrical periods at 31.42 rad/s"),
        ("duration_s = 0.2", "duration_s = 1e-5", "at least 2 are needed"),
        ("omega_m_rad_s = 31.42", "omega_m_rad_s = 0", "the shaft stands"),
        ("omega_m_rad_s = 31.42", "omega_m_rad_s = 500", "the profile rates the motor at 157.1 rad/s"),
        ("omega_m_rad_s = 31.42", "omega_m_rad_s = -1e9", "the profile rates the motor at 157.1 rad/s"),
        ("load_torque_Nm = 0.65", "load_torque_Nm = 10", "the profile rates the motor at 9.55 Nm"),
        ("omega_m_rad_s = 31.42", "omega_m_rad_s = true", "should be a valid number"),
        ("omega_m_rad_s = 31.42", 'omega_m_rad_s = "15.71"', "should be a valid number"),
        ("omega_m_rad_s = 31.42", "omega_m_rad_s = nan", "finite number"),
        ("omega_m_rad_s = 31.42", "omega_m_rad_s = inf", "finite number"),
        ("repetitions = 1", "repetitions = true", "valid integer"),
        ("repetitions = 1", "repetitions = 2.0", "valid integer"),
        ("u_s_V = 81.65", "u_s_V = true", "valid number"),
        ("u_s_V = 81.65", 'u_s_V = "81.65"', "write it without quotes"),
        ("u_s_V = 81.65", 'law = "0"', "the values are"),
        ("u_s_V = 81.65", 'law = "tcp"', "the values are"),
        ('"psi_s", "omega_m"', '"psi_s", "i_a"', "i_a appears twice"),
        ('"psi_s", "omega_m"', '"psi_s", "omega"', "did you mean 'omega_m'?"),
    ],
)
def test_values_that_cannot_be(tmp_path: Path, was: str, now: str, complaint: str) -> None:
    text = BASE.replace(was, now)
    assert text != BASE
    message = _refusal(tmp_path / "mine.toml", text)
    assert complaint in message
    assert ", line " in message


@pytest.mark.parametrize(
    ("more", "at", "complaint"),
    [
        ("[sweep.setup]\nu_s_V = [60.0, 60]\n", "u_s_V = [", "60 appears twice"),
        ("[sweep.setup]\nu_s_V = [81.65, 81.6500001]\n", "u_s_V = [", "81.65 appears twice"),
        ("[sweep.setup]\nu_s_V = [60.0, true]\n", "u_s_V = [", "valid number"),
        ('[sweep.setup]\nlaw = ["tpc", "tcp"]\n', "law", "the values are"),
        ("[sweep.operating_point]\nomega_m_rad_s = [31.42, 500.0]\n", "omega_m_rad_s = [", "157.1 rad/s"),
        ("[sweep.operating_point]\nload_torque_Nm = [1.0, 1]\n", "load_torque_Nm = [", "1 appears twice"),
        ("[sweep.operating_point]\nomega_m_rad_s = [31.42, 5.0]\n", "duration_s", "electrical periods"),
        ('[sweep.emulator]\n"inverter.u_dc_V" = [122.5, -1.0]\n', '"inverter.u_dc_V"', "is -1.0"),
        ('[emulator]\n"inverter.u_dc" = 122.5\n', '"inverter.u_dc"', "did you mean 'u_dc_V'?"),
        ('[[variants]]\nname = "a b"\n[[variants]]\nname = "a_b"\n', 'name = "a_b"', "share its folder"),
        ('[[variants]]\nname = "a"\n[[variants]]\nname = "A"\n', 'name = "A"', "share its folder"),
        ('[[variants]]\nname = "a"\n[[variants]]\nname = ".."\n', 'name = ".."', "give it another name"),
        ('[[variants]]\nname = "a"\n[[variants]]\nname = "plots"\n', 'name = "plots"', "another name"),
        (
            '[[variants]]\nname = "a"\nsetup = {}\n[[variants]]\nname = "b"\nsetup = { u_s_V = 1e9 }\n',
            "setup = { u_s_V",
            "limits",
        ),
    ],
)
def test_cases_that_cannot_be(tmp_path: Path, more: str, at: str, complaint: str) -> None:
    text = BASE + more
    message = _refusal(tmp_path / "mine.toml", text)
    assert complaint in message
    assert _line(text, at) in message


TORQUE = """[stimulus]
quantity = "torque"
shape = "{shape}"
amplitude_Nm = {amplitude}
duration_s = {duration}
{more}
[analyses]
steady = false
"""


@pytest.mark.parametrize(
    ("setpoint", "shape", "amplitude", "duration", "fits"),
    [
        (-3.0, "constant", 6.0, 0.1, True),
        (-9.0, "constant", 9.0, 0.1, True),
        (9.0, "constant", 1.0, 0.1, False),
        (0.0, "constant", 10.0, 0.1, False),
        (-9.0, "sine", 1.0, 0.1, False),
        (0.0, "constant", 1.0, 1e-5, False),
    ],
)
def test_setpoint_and_stimulus_stay_within_the_rating_together(
    tmp_path: Path, setpoint: float, shape: str, amplitude: float, duration: float, fits: bool
) -> None:
    text = BASE.replace(
        "omega_m_rad_s = 31.42\nload_torque_Nm = 0.65",
        f'mode = "torque"\nhold_speed_rad_s = 31.42\ntorque_Nm = {setpoint}',
    )
    more = "frequency_Hz = 50.0" if shape == "sine" else ""
    text += TORQUE.format(shape=shape, amplitude=amplitude, duration=duration, more=more)
    if fits:
        _check(tmp_path / "mine.toml", text)
    else:
        assert ", line " in _refusal(tmp_path / "mine.toml", text)


def test_repetitions_take_the_limits_of_their_case_and_each_its_own(tmp_path: Path) -> None:
    text = BASE.replace("repetitions = 1", "repetitions = 2")
    text += "[case_limits.warm]\ntorque_mean = { max = 1.0 }\n"
    text += '[case_limits."warm.2"]\ntorque_ripple_pp = { max = 1.0 }\n'
    _check(tmp_path / "mine.toml", text)
    message = _refusal(tmp_path / "mine.toml", text.replace('"warm.2"', '"warm.3"'))
    assert "names case 'warm.3', which the plan lacks: did you mean 'warm" in message


COMBINED = """variants = [{ name = "cold", setup = { i_trip_A = 9.0 } }, { name = "hot" }]
[sweep.setup]
law = ["tpc", "foc"]
[sweep.operating_point]
load_torque_Nm = [0.65, 1.5]
"""


@pytest.mark.parametrize("repetitions", [1, 2])
@pytest.mark.parametrize("swept", [False, True])
@pytest.mark.parametrize("variants", [False, True])
def test_a_case_is_named_alone_or_with_its_repetitions_whatever_the_plan_varies(
    tmp_path: Path, repetitions: int, swept: bool, variants: bool
) -> None:
    """Every name that holds is accepted and applied, the same misspelt is refused with its line."""
    varied, header, sweep = COMBINED.partition("[sweep")
    text = BASE.replace("repetitions = 1", f"repetitions = {repetitions}")
    text = (varied + text if variants else text) + (header + sweep if swept else "")
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    todo = cases(load_plan(str(path)))
    assert len(todo) == (4 if swept else 1) * (2 if variants else 1) * repetitions
    for name in sorted({name for case in todo for name in (case.name, case.group)}):
        limited = f'{text}[case_limits."{name}"]\ntorque_mean = {{ max = 1.0 }}\n'
        _check(path, limited)
        plan = load_plan(str(path))
        holds = [each.name for each in cases(plan) if "torque_mean" in limits_alone(plan, each)]
        assert holds == [each.name for each in todo if name in (each.name, each.group)]
        wrong = limited.replace(f'."{name}"]', f'."{name}x"]')
        message = _refusal(path, wrong)
        assert f"case_limits names case '{name}x', which the plan lacks: did you mean '" in message
        assert _line(wrong, "[case_limits") in message


@pytest.mark.parametrize("repetitions", [1, 2])
def test_the_misspelt_case_of_a_sweep_is_refused(tmp_path: Path, repetitions: int) -> None:
    text = BASE.replace("repetitions = 1", f"repetitions = {repetitions}") + SWEPT
    text += "[case_limits.tcp]\ntorque_mean = { max = 1.0 }\n"
    message = _refusal(tmp_path / "mine.toml", text)
    assert "case_limits names case 'tcp', which the plan lacks: did you mean 'tpc" in message
    assert _line(text, "[case_limits") in message


@pytest.mark.parametrize(
    "written",
    [
        "[case_limits.warm.torque_man]\nmax = 1.0\n",
        "[case_limits]\nwarm.torque_man.max = 1.0\n",
        "[case_limits]\nwarm = { torque_man = { max = 1.0 } }\n",
    ],
)
def test_a_name_is_found_however_the_table_is_written(tmp_path: Path, written: str) -> None:
    text = BASE + written
    message = _refusal(tmp_path / "mine.toml", text)
    assert "did you mean 'torque_mean'?" in message
    assert f"line {1 + text[: text.rindex('warm')].count(chr(10))}:" in message


@pytest.mark.parametrize(
    ("limit", "complaint"),
    [
        ('torque_mean = { max = 1.0, unit = "Nm" }', ""),
        ("torque_mean = { max_Nm = 1.0, margin_Nm = 0.1 }", ""),
        ("torque_mean_Nm = { max = 1.0 }", ""),
        ('omega_m_reached = { max = 40.0, unit = "rad/s" }', ""),
        ("omega_m_reached = { max_rad_s = 40.0 }", ""),
        ("torque_ripple_percent_of_mean = { max_percent = 40.0 }", ""),
        ('capture_rows_missing = { max = 0, unit = "1" }', ""),
        ('torque_mean = { max = 1000, unit = "mNm" }', 'convert it, and write unit = "Nm"'),
        ("torque_mean = { max_mNm = 1000 }", "the limit of 'torque_mean' is in mNm, that is in Nm"),
        ("torque_mean_mNm = { max = 1000 }", "'torque_mean' is in Nm: convert it, and write torque_mean or"),
        ("torque_mean_Nm = { max_mNm = 1 }", "units Nm and mNm in one limit"),
        ("torque_mean = { min_Nm = 0, max_mNm = 1 }", "units Nm and mNm in one limit"),
        ('omega_m_reached = { max = 40.0, unit = "rpm" }', "the limit of 'omega_m_reached' is in rpm"),
        ('capture_rows_missing = { max = 0, unit = "s" }', "a pure number: leave the unit out"),
        ("torque_mean = { max = 1, max_Nm = 2 }", "max and max_Nm in one limit, each states the same"),
        ('torque_mean = { max = 1.0, margin = "U" }', ""),
        ('capture_rows_missing = { max = 0, margin = "U" }', "never has an uncertainty: leave the margin"),
        ('current_thd_f_plus_noise = { max = 2, margin = "U" }', ""),
        ("torque_mean = { max = 1 }\ntorque_mean_Nm = { max = 1 }", "appears twice"),
    ],
)
@pytest.mark.parametrize("table", ["[limits]", "[case_limits.warm]"])
def test_a_limit_has_the_unit_of_its_measurement(
    tmp_path: Path, table: str, limit: str, complaint: str
) -> None:
    text = f"{BASE}{table}\n{limit}\n"
    if not complaint:
        _check(tmp_path / "mine.toml", text)
        return
    message = _refusal(tmp_path / "mine.toml", text)
    assert complaint in message
    assert _line(text, table if "appears twice" in complaint else limit) in message


@pytest.mark.parametrize(("unit", "fits"), [("rad/s", True), ("Nm", False)])
@pytest.mark.parametrize(
    "spelling", ['overshoot = {{ max = 1, unit = "{unit}" }}', "overshoot_{key}.max = 1"]
)
def test_a_unit_of_the_signal_is_that_of_the_channel(
    tmp_path: Path, unit: str, fits: bool, spelling: str
) -> None:
    text = BASE.replace('"omega_m"]', '"omega_m", "stimulus"]')
    text += '[analyses.step]\nsignal = "omega_m"\nreference = "stimulus"\n'
    text += f"[limits]\n{spelling.format(unit=unit, key=unit.replace('/', '_'))}\n"
    if fits:
        _check(tmp_path / "mine.toml", text)
    else:
        message = _refusal(tmp_path / "mine.toml", text)
        assert "is in Nm, that is in rad/s" in message
        assert _line(text, "overshoot") in message


_SPEED_STEP = """[stimulus]
quantity = "speed"
shape = "step"
amplitude_rad_s = 5.0
duration_s = 0.6

[analyses]
steady = false

[analyses.step]
signal = "omega_m"
"""


@pytest.mark.parametrize("reference", ["", 'reference = "stimulus"\n'])
def test_a_reference_in_another_unit_is_refused_before_the_run(tmp_path: Path, reference: str) -> None:
    """The channel of the stimulus is in the unit of the quantity that plays."""
    text = BASE.replace('"omega_m"]', '"omega_m", "torque_reference", "stimulus"]') + _SPEED_STEP + reference
    text = text.replace("omega_m_rad_s = 31.42", "omega_m_rad_s = 0.0")
    if reference:
        _check(tmp_path / "mine.toml", text)
        return
    message = _refusal(tmp_path / "mine.toml", text)
    assert "step.reference is 'torque_reference', in Nm, and signal is 'omega_m', in rad/s" in message
    assert "one unit is needed, choose stimulus" in message


@pytest.mark.parametrize(
    ("analyses", "at", "complaint"),
    [
        ("[analyses]\nstpe = true\n", "stpe", "analyses.stpe' is True: unknown key: did you mean 'step'?"),
        ("[analyses.step]\nsignl = 1\n", "signl", "unknown key: did you mean 'signal'?"),
        ("[analyses]\nstep = 3\n", "step", "true, false or a table of settings is expected"),
        ("[analyses]\nstep = true\n", "step", "analyses.step.reference is 'torque_reference', which record"),
        ('[analyses]\nstep = true\nstep_reference = "x"\n', "step_r", "step_reference is 'x', which record"),
        ('[analyses.step]\nreference = "x"\n', "reference", "analyses.step.reference is 'x', which record"),
        ("[analyses]\ntorque_orders = true\n", "torque_o", "analyses.torque_orders needs theta_m, which"),
        ("[analyses]\nsteady = false\ntorque_ripple = true\n", "[analyses", "set steady = true"),
    ],
)
def test_what_is_asked_of_an_analysis_is_checked(
    tmp_path: Path, analyses: str, at: str, complaint: str
) -> None:
    text = BASE + analyses
    message = _refusal(tmp_path / "mine.toml", text)
    assert complaint in message
    assert f"line {1 + text[: text.rindex(at)].count(chr(10))}:" in message


@pytest.mark.parametrize(
    ("figure", "complaint"),
    [
        ("torqe", "there is no such figure: did you mean 'torque'?"),
        ("bode", "figure = 'bode' needs analyses.frequency_response = true"),
        ("spectra", "figure = 'spectra' draws i_a, which record.channels does not have"),
    ],
)
def test_a_figure_is_one_of_the_catalogue_and_can_be_drawn(
    tmp_path: Path, figure: str, complaint: str
) -> None:
    text = BASE.replace('figure = "none"', f'figure = "{figure}"').replace('"i_a", ', "")
    message = _refusal(tmp_path / "mine.toml", text)
    assert complaint in message
    assert _line(text, "figure") in message


def test_the_older_form_of_the_analyses_reads_as_the_new_one() -> None:
    older = {"steady_from_s": 0.1, "step": True, "step_signal": "omega_m", "frequency_response": False}
    newer = {"steady_from_s": 0.1, "step": {"signal": "omega_m"}}
    analyses = Analyses.model_validate(older | {"response_input": "torque_reference"})
    assert analyses == Analyses.model_validate(newer)
    assert Analyses.model_validate(analyses.model_dump(mode="json")) == analyses
    assert Analyses.model_validate({"torque_orders": False}).model_dump()["torque_orders"] is False


def test_what_needs_a_transducer_is_refused_where_there_is_none(tmp_path: Path) -> None:
    text = BASE + "[limits]\ntransducer_torque_ripple_pp = { max = 1.0 }\n"
    _check(tmp_path / "mine.toml", text)
    message = _refusal(tmp_path / "mine.toml", text, transducer=False)
    assert "needs a torque transducer, which the bench at this link does not have" in message


@pytest.mark.parametrize("path", sorted(shipped("profiles").glob("*/*.toml")), ids=lambda path: path.stem)
def test_every_shipped_plan_is_sound(path: Path) -> None:
    if path.name != "profile.toml":
        plan = for_motor(load_plan(str(path)), PROFILE.motor)
        require_known(plan, path, PROFILE, DICTIONARY, transducer=True)


def test_a_number_in_quotes_is_none_in_a_profile_either(tmp_path: Path) -> None:
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    for was, now in (("psi_r_Wb = 0.1685", 'psi_r_Wb = "0.1685"'), ("R_s_ohm = 0.123", "R_s_ohm = true")):
        path = tmp_path / "mine.toml"
        path.write_text(text.replace(was, now), encoding="utf-8")
        with pytest.raises(Exception, match=r"line \d+: key 'motor\.\w+' is .*valid number"):
            load_profile(str(path))


SLOW = BASE.replace('"omega_m"]', '"omega_m", "theta_m"]').replace("31.42", "31.4159")


@pytest.mark.parametrize(
    ("duration_s", "complaint"),
    [
        (0.39, "lasts 0.39 s, 1.95 at 31.4159 rad/s: record 0.4 s at least"),
        (0.401, ""),
    ],
)
def test_a_limit_on_an_order_needs_two_revolutions(tmp_path: Path, duration_s: float, complaint: str) -> None:
    text = SLOW.replace("duration_s = 0.2", f"duration_s = {duration_s}")
    limited = f"{text}[limits]\ntorque_order_6p = {{ max = 1.0 }}\n"
    if not complaint:
        _check(tmp_path / "plan.toml", limited)
        return
    assert f"'torque_order_6p' needs 2 mechanical revolutions, the steady state {complaint}" in _refusal(
        tmp_path / "plan.toml", limited
    )


def test_the_limit_of_a_case_needs_the_revolutions_of_that_case(tmp_path: Path) -> None:
    swept = SLOW.replace("duration_s = 0.2", "duration_s = 0.21").replace('case = "warm"\n', "")
    swept += "[sweep.operating_point]\nomega_m_rad_s = [31.4159, 62.8318]\n"
    (tmp_path / "plan.toml").write_text(swept, encoding="utf-8")
    slow, fast = (each.name for each in cases(load_plan(str(tmp_path / "plan.toml"))))
    limited = '{}[case_limits."{}"]\ntorque_order_6p = {{ max = 1.0 }}\n'
    told = _refusal(tmp_path / "plan.toml", limited.format(swept, slow))
    assert f"1.05 at 31.4159 rad/s (case '{slow}')" in told
    _check(tmp_path / "plan.toml", limited.format(swept, fast))


def test_what_is_not_measured_is_known_before_the_run(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(SLOW, encoding="utf-8")
    found = not_made(load_plan(str(tmp_path / "plan.toml")), transducer=False)
    assert found["torque orders"].startswith("needs 2 mechanical revolutions, the steady state lasts 0.2 s")
    assert found["current unbalance"] == "needs i_b, i_c"
    assert "torque residual on the shaft" not in found


def test_profile_that_is_not_beside_the_plan(tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(BASE.replace('"zhu2011"', '"gimbal.toml"'), encoding="utf-8")
    result = CliRunner().invoke(app, ["run", str(plan), "--dry-run"])
    assert result.exit_code == 2
    complaint = (
        f"{plan}: there is no profile file {tmp_path / 'gimbal.toml'}: a plan names it relative to itself"
    )
    assert complaint in result.stderr
