"""What a plan gets wrong is refused before anything is opened: by file, line and key, with what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchtool.bench.session import dictionary_of
from benchtool.errors import PlanError
from benchtool.plan.model import load_plan
from benchtool.plan.validation import require_known
from benchtool.profile import load_profile
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
        ("[limits]\nflux_radius_pp = { max = 1.0 }\n", "flux_radius", "needs psi_alpha, psi_beta"),
        ("[limits]\ntorque_order_0 = { max = 1.0 }\n", "torque_order", "no measurement is called"),
        ("[limits]\ntorque_order_24 = { max = 1.0 }\n", "torque_order", "needs theta_m"),
        ("[limits]\novershoot = { max = 1.0 }\n", "overshoot", "analyses.step = true, which is false"),
        ("[limits]\nbandwidth_3dB = { min = 1.0 }\n", "bandwidth", "analyses.frequency_response = true"),
        ("[limits]\ntorque_reached = { min = 1.0 }\n", "torque_reached", "nothing that this operating point"),
        ("[limits]\ncapture_rows_mising = { max = 0 }\n", "capture", "did you mean 'capture_rows_missing'?"),
        ("[case_limits.cold]\ntorque_mean = { max = 1.0 }\n", "[case_limits", "names case 'cold'"),
        ("[case_limits.warm]\ntorque_man = { max = 1.0 }\n", "torque_man", "did you mean 'torque_mean'?"),
        ('[case_limits."warm.1"]\ntorque_mean = { max = 1.0 }\n', "[case_limits", "did you mean 'warm'?"),
        ("[published.cold]\ntorque_mean = 1.0\n", "[published", "published names case 'cold'"),
        ("[published.warm]\ncapture_rows_missing = 1.0\n", "capture_rows", "which limits alone may name"),
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
        ('"psi_s", "omega_m"', '"psi_s", "i_a"', "i_a comes twice"),
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
        ("[sweep.setup]\nu_s_V = [60.0, 60]\n", "u_s_V = [", "60 comes twice"),
        ("[sweep.setup]\nu_s_V = [81.65, 81.6500001]\n", "u_s_V = [", "81.65 comes twice"),
        ("[sweep.setup]\nu_s_V = [60.0, true]\n", "u_s_V = [", "valid number"),
        ('[sweep.setup]\nlaw = ["tpc", "tcp"]\n', "law", "the values are"),
        ("[sweep.operating_point]\nomega_m_rad_s = [31.42, 500.0]\n", "omega_m_rad_s = [", "157.1 rad/s"),
        ("[sweep.operating_point]\nload_torque_Nm = [1.0, 1]\n", "load_torque_Nm = [", "1 comes twice"),
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
    assert "names case 'warm.3', which the plan has not: did you mean 'warm" in message


def test_what_needs_a_transducer_is_refused_where_there_is_none(tmp_path: Path) -> None:
    text = BASE + "[limits]\ntrue_torque_ripple_pp = { max = 1.0 }\n"
    _check(tmp_path / "mine.toml", text)
    message = _refusal(tmp_path / "mine.toml", text, transducer=False)
    assert "needs a torque transducer, which the bench at this link has not" in message


@pytest.mark.parametrize("path", sorted(shipped("profiles").glob("*/*.toml")), ids=lambda path: path.stem)
def test_every_shipped_plan_is_sound(path: Path) -> None:
    if path.name != "profile.toml":
        require_known(load_plan(str(path)), path, PROFILE, DICTIONARY, transducer=True)


def test_a_number_in_quotes_is_none_in_a_profile_either(tmp_path: Path) -> None:
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    for was, now in (("psi_r_Wb = 0.1685", 'psi_r_Wb = "0.1685"'), ("R_s_ohm = 0.123", "R_s_ohm = true")):
        path = tmp_path / "mine.toml"
        path.write_text(text.replace(was, now), encoding="utf-8")
        with pytest.raises(Exception, match=r"line \d+: key 'motor\.\w+' is .*valid number"):
            load_profile(str(path))
