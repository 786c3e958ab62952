"""Stimuli and plans with them, as far as they can be judged without a drive."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from benchtool.drive import Stimulus
from benchtool.errors import PlanError, ValueRefused
from benchtool.plan.model import Plan, load_plan

T_S = 1e-4
PRBS: dict[str, Any] = {
    "quantity": "torque",
    "shape": "prbs",
    "amplitude_Nm": 0.5,
    "prbs_clock_s": 5e-4,
    "prbs_length": 7,
    "seed": 3,
}
STEP: dict[str, Any] = {"quantity": "torque", "shape": "step", "amplitude_Nm": 0.5, "duration_s": 0.1}
PLAN: dict[str, Any] = {
    "title": "test",
    "profile": "zhu2011",
    "operating_point": {"mode": "torque", "torque_Nm": 0.1, "hold_speed_rad_s": 15.0, "settle_s": 0.2},
    "stimulus": STEP,
    "record": {"duration_s": 0.12, "pretrigger_s": 0.02, "channels": ("torque_reference", "omega_m")},
    "analyses": {"steady": False},
}


def test_the_table_holds_what_the_shape_uses_and_no_more() -> None:
    table = Stimulus.model_validate({**PRBS, "offset_Nm": -0.1}).table(T_S)
    assert table == {
        "stimulus_quantity": "torque",
        "stimulus_shape": "prbs",
        "stimulus_amplitude": 0.5,
        "stimulus_offset": -0.1,
        "stimulus_ticks": 5 * 127,
        "stimulus_repetitions": 1,
        "stimulus_prbs_clock": 5,
        "stimulus_prbs_length": 7,
        "stimulus_seed": 3,
        "stimulus_frame": "stator",
        "stimulus_angle": 0.0,
    }


def test_a_sine_has_one_frequency_and_durations_become_the_nearest_tick() -> None:
    sine = Stimulus(quantity="speed", shape="sine", amplitude_rad_s=1.0, frequency_Hz=7.0, duration_s=0.12344)
    table = sine.table(T_S)
    assert (table["stimulus_frequency_start"], table["stimulus_ticks"]) == (7.0, 1234)
    assert "stimulus_frequency_end" not in table
    assert (sine.unit, sine.peak) == ("rad/s", 1.0)


def test_less_than_a_tick_is_refused() -> None:
    with pytest.raises(ValueRefused, match=r"duration_s = 1e-05 s is shorter than the control period"):
        Stimulus.model_validate({**STEP, "duration_s": 1e-5}).ticks(T_S)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"amplitude_Nm": None}, "a torque needs its amplitude_Nm"),
        ({"amplitude_A": 1.0}, "a torque has amplitude_Nm, not amplitude_A"),
        ({"offset_V": 1.0}, "a torque has offset_Nm, not offset_V"),
        ({"duration_s": None}, "shape 'step' needs duration_s"),
        ({"steps": 3}, "shape 'step' has no steps"),
        ({"shape": "sine"}, "shape 'sine' needs frequency_Hz"),
        ({"shape": "chirp_linear", "frequency_start_Hz": 1.0}, "needs frequency_end_Hz"),
        (
            {"shape": "chirp_logarithmic", "frequency_start_Hz": 0.0, "frequency_end_Hz": 9.0},
            "frequencies above 0",
        ),
        ({**PRBS, "duration_s": None, "prbs_length": 2, "seed": 4}, "no bit set within a register of 2"),
        ({"shape": "stepp"}, "'constant', 'step'"),
        ({"amplitude_Nm": float("nan")}, "finite"),
    ],
)
def test_what_makes_no_stimulus(change: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        Stimulus.model_validate({**STEP, **change})


def test_a_plan_keeps_its_stimulus_in_its_bundle() -> None:
    plan = Plan.model_validate(PLAN)
    assert Plan.model_validate(plan.model_dump(mode="json")) == plan


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"operating_point": {"omega_m_rad_s": 1.0}}, "torque stimulus does not play in velocity mode"),
        ({"operating_point": {"mode": "torque", "omega_m_rad_s": 1.0}}, "torque mode has no omega_m_rad_s"),
        ({"operating_point": {"omega_m_rad_s": 1.0, "torque_Nm": 1.0}}, "velocity mode has no torque_Nm"),
        ({"operating_point": {"load_torque_Nm": 1.0}}, "velocity mode needs omega_m_rad_s"),
        (
            {"operating_point": {"mode": "torque", "hold_speed_rad_s": 1.0, "load_torque_Nm": 1.0}},
            "give one of the two",
        ),
        ({"sweep": {"operating_point": {"omega_m_rad_s": [1.0]}}}, "no omega_m_rad_s to sweep"),
        ({"analyses": {}}, r"set analyses\.steady = false"),
        ({"record": {"duration_s": 0.01, "channels": ["torque"]}}, "leaves nothing"),
    ],
)
def test_what_makes_no_plan(change: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        Plan.model_validate({**PLAN, **change})


def test_a_mistake_in_a_plan_file_is_named_by_its_section(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        'title = "t"\nprofile = "zhu2011"\n[operating_point]\nmode = "torque"\n'
        '[stimulus]\nquantity = "torque"\nshape = "step"\namplitude_A = 1.0\nduration_s = 0.1\n'
        '[record]\nduration_s = 0.1\nchannels = ["torque"]\n',
        encoding="utf-8",
    )
    with pytest.raises(
        PlanError, match=r"mine\.toml, line 5: \[stimulus\]: a torque needs its amplitude_Nm$"
    ):
        load_plan(str(path))
