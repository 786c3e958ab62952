"""Frequency responses, switching states and the torque residual of the emulated drive, over the wire."""

from __future__ import annotations

import json
import math
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchtool.analysis import Bode
from benchtool.analysis.distributions import students_deviation
from benchtool.bench.session import Session, open_session
from benchtool.errors import AnalysisError, PlanError
from benchtool.plan.cases import Case
from benchtool.plan.model import Plan, load_plan
from benchtool.plan.validation import require_known
from benchtool.profile import Motor
from benchtool.protocol.dictionary import Dictionary
from benchtool.recording import Bundle
from benchtool.report.assembly.figures import panel_of
from benchtool.report.figures.drawings import figure_names
from benchtool.results.assessment import Assessment
from benchtool.results.case_assessment import assess, assess_bundle
from benchtool.run.runner import RunInfo, run_plan

from .conftest import Wire

INFO = RunInfo("2020-01-01T00:00:00+00:00", 0, ("run",))
T_S = 1e-4
STEADY = {
    "title": "steady state",
    "profile": "zhu2011",
    "operating_point": {"omega_m_rad_s": 31.42, "load_torque_Nm": 0.65, "settle_s": 0.8},
    "record": {
        "duration_s": 0.12,
        "channels": (
            *("i_a", "i_b", "i_c", "torque", "psi_s", "psi_alpha", "psi_beta", "theta_m", "omega_m"),
            *("u_alpha", "u_beta", "u_dc", "switching_count"),
        ),
    },
}


class Silent:
    """Ignores progress."""

    def begin(self, case: str, number: int, count: int) -> None: ...
    def note(self, text: str) -> None: ...


def _opener(case: Case, seed: int) -> AbstractContextManager[Session]:
    return open_session("zhu2011", seed=seed, alter=case.emulator)


def _run(plan: Plan, folder: Path) -> dict[str, Assessment]:
    return {each.case: each for each in run_plan(_opener, plan, folder, INFO, Silent()).assessments}


def _values(result: Assessment) -> dict[str, float]:
    return {each.name: each.value for each in result.measurements}


@pytest.fixture(scope="module")
def torque_loops(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Assessment]:
    return _run(load_plan("zhu2011/bode"), tmp_path_factory.mktemp("bode") / "run")


def test_foc_answers_as_its_tuning_says(torque_loops: dict[str, Assessment]) -> None:
    bode = torque_loops["foc"].findings["frequency_response"].result
    assert isinstance(bode, Bode)
    assert "over 10 periods of 1023 samples" in bode.response.method
    share = -math.expm1(-2000.0 * T_S)  # of an error, that a period removes
    frequency_Hz = bode.response.frequency_Hz
    z = np.exp(2j * np.pi * frequency_Hz * T_S)
    expected = z**-2 * share / (1.0 - (1.0 - share) / z)
    used = bode.response.trusted & (frequency_Hz < 1000.0)
    off = np.abs(bode.response.response[used] / expected[used] - 1.0)
    assert np.count_nonzero(used) > 95
    assert np.median(off) < 0.03
    assert np.max(off) < 0.15
    found = _values(torque_loops["foc"])
    assert found["bandwidth_3dB"] == pytest.approx(319.0, rel=0.08)
    assert found["bandwidth_90deg"] == pytest.approx(545.0, rel=0.05)


def test_a_single_chirp_shows_the_same_bandwidth(tmp_path: Path) -> None:
    document = load_plan("zhu2011/bode").model_dump(mode="json", exclude_none=True)
    document["sweep"]["setup"] = {"law": ["foc"]}
    document["stimulus"] = {
        "quantity": "torque",
        "shape": "chirp_logarithmic",
        "amplitude_Nm": 0.3,
        "frequency_start_Hz": 20.0,
        "frequency_end_Hz": 1500.0,
        "duration_s": 0.5,
    }
    document["record"]["duration_s"] = 0.5
    (result,) = _run(Plan.model_validate(document), tmp_path / "run").values()
    bode = result.findings["frequency_response"].result
    assert isinstance(bode, Bode)
    assert "DFT of all" in bode.response.method
    assert "by the stimulus" in bode.response.method
    assert _values(result)["bandwidth_3dB"] == pytest.approx(319.0, rel=0.05)


@pytest.mark.parametrize("law", ["deadbeat", "tpc"])
def test_a_law_that_arrives_within_a_period_is_a_delay_of_two(
    torque_loops: dict[str, Assessment], law: str
) -> None:
    found = _values(torque_loops[law])
    assert math.isnan(found["bandwidth_3dB"])
    assert found["bandwidth_90deg"] == pytest.approx(1.0 / (4 * 2 * T_S), rel=0.03)
    assert found["response_delay"] == pytest.approx(2 * T_S, rel=0.01)
    assert found["response_gain"] == pytest.approx(1.0, abs=0.02)
    assert found["coherence_median"] > 0.98


def test_the_bundle_keeps_tables_and_has_figures(torque_loops: dict[str, Assessment]) -> None:
    result = torque_loops["tpc"]
    tables: dict[str, Any] = json.loads((result.bundle / "tables.json").read_text(encoding="utf-8"))
    assert len(tables["frequency_response"]["rows"]) == 511
    assert "bode" in figure_names(panel_of(result))
    again = assess_bundle(Bundle.open(result.bundle))
    assert {each.name: each.to_json() for each in again.tables} == tables


def test_the_speed_loop_shows_its_controller_and_inertia(tmp_path: Path) -> None:
    (result,) = _run(load_plan("zhu2011/bode_speed"), tmp_path / "run").values()
    s = 2j * np.pi * np.linspace(1.0, 60.0, 60_000)
    # The observer knows torque and inertia: it neither lags nor damps.
    loop = (0.1 + 1.0 / s) * np.exp(-2 * T_S * s) / (13.1e-4 * s)
    closed = np.abs(loop / (1.0 + loop))
    found = _values(result)
    bode = result.findings["frequency_response"].result
    assert isinstance(bode, Bode)
    assert "over 5 periods of 2550 samples" in bode.response.method
    expected_Hz = float(np.imag(s[np.argmax(closed < found["response_gain"] / math.sqrt(2.0))])) / (2 * np.pi)
    assert found["bandwidth_3dB"] == pytest.approx(expected_Hz, rel=0.02)
    expected_dB = 20 * math.log10(float(np.max(closed)) / found["response_gain"])
    assert found["resonance_peak"] == pytest.approx(expected_dB, abs=0.1)


@pytest.fixture(scope="module")
def steady(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Assessment]:
    plan = Plan.model_validate({**STEADY, "sweep": {"setup": {"law": ["tpc", "dtc"]}}})
    return _run(plan, tmp_path_factory.mktemp("steady") / "run")


def test_a_law_of_single_vectors_takes_one_for_the_whole_period(steady: dict[str, Assessment]) -> None:
    for law, vectors in (("dtc", 1.0), ("tpc", 2.0)):
        (table,) = (each for each in steady[law].tables if each.name == "switching_states")
        time, periods = (np.array([row[column] for row in table.rows]) for column in (2, 3))
        assert time.sum() == pytest.approx(100.0)
        if law == "dtc":
            np.testing.assert_allclose(time, periods, atol=1e-3)
            assert periods.sum() == pytest.approx(100.0)
        else:
            assert periods[1:].sum() == pytest.approx(200.0, rel=0.01)
        assert _values(steady[law])["active_vectors_mean"] <= vectors
        assert "switching_states" in figure_names(panel_of(steady[law]))


def test_the_flux_trajectory_is_a_circle_about_zero(steady: dict[str, Assessment]) -> None:
    found = _values(steady["tpc"])
    assert found["flux_radius_mean"] == pytest.approx(math.hypot(0.1685, 9.52e-3 * 0.643), rel=5e-3)
    assert found["flux_centre_offset"] < 1e-3
    assert found["flux_radius_pp"] == pytest.approx(found["flux_ripple_pp"], rel=0.1)


@pytest.mark.parametrize("law", ["tpc", "dtc"])
def test_the_residual_is_the_noise_of_the_currents(steady: dict[str, Assessment], law: str) -> None:
    found = _values(steady[law])
    step_A = 2 * 12.5 / 1024
    noise_A = math.hypot(step_A / math.sqrt(12.0), 1e-3)
    # of i_q in two rows: 2/3 of a phase's variance each
    expected_Nm = 1.5 * 4 * 0.1685 * noise_A * math.sqrt(2.0 / 3.0) * math.sqrt(2.0)
    assert found["torque_residual_rms"] == pytest.approx(expected_Nm, rel=0.25)
    assert abs(found["torque_residual_mean"]) < 1e-3
    assert abs(found["transducer_torque_residual_mean"]) < 2e-3
    assert found["transducer_torque_residual_rms"] < 0.03


@pytest.mark.parametrize("key", ["psi_r_Wb", "L_q_H", "L_d_H"])
def test_a_wrong_parameter_of_the_profile_shows(steady: dict[str, Assessment], key: str) -> None:
    bundle = Bundle.open(steady["dtc"].bundle)
    motor = Motor.model_validate(bundle.manifest.details["motor"])
    plan = Plan.model_validate(bundle.manifest.details["plan"])
    right = _values(steady["dtc"])
    for factor in (0.7, 1.3):
        wrong = motor.model_copy(update={key: factor * getattr(motor, key)})
        blocks = bundle.block("capture"), bundle.block("transducer")
        found = _values(assess(plan, "dtc", wrong, bundle.directory, *blocks))
        assert found["torque_residual_rms"] > 1.03 * right["torque_residual_rms"]
        if key != "L_d_H":  # whose voltage makes little torque
            assert found["torque_residual_rms"] > 5.0 * right["torque_residual_rms"]


def test_a_wrong_resistance_shows_in_the_mean(steady: dict[str, Assessment]) -> None:
    bundle = Bundle.open(steady["tpc"].bundle)
    motor = Motor.model_validate(bundle.manifest.details["motor"])
    plan = Plan.model_validate(bundle.manifest.details["plan"])
    blocks = bundle.block("capture"), bundle.block("transducer")
    wrong = motor.model_copy(update={"R_s_ohm": 10 * motor.R_s_ohm})
    before = _values(steady["tpc"])["torque_residual_mean"]
    after = _values(assess(plan, "tpc", wrong, bundle.directory, *blocks))["torque_residual_mean"]
    # 9 R_s i_q T_s / L less current in a period than there is
    expected_Nm = 1.5 * 4 * 0.1685 * 9 * 0.123 * 0.643 * T_S / 9.52e-3
    assert before - after == pytest.approx(expected_Nm, rel=0.05)


def test_orders_come_with_two_revolutions(steady: dict[str, Assessment], tmp_path: Path) -> None:
    assert not any(name.startswith("torque_order") for name in _values(steady["tpc"]))
    plan = Plan.model_validate(
        {
            **STEADY,
            "operating_point": {"omega_m_rad_s": 62.84, "load_torque_Nm": 0.65, "settle_s": 0.8},
            "record": {**STEADY["record"], "duration_s": 0.25},  # type: ignore[dict-item]
        }
    )
    (result,) = _run(plan, tmp_path / "run").values()
    assert "torque_order_largest" in _values(result)
    assert "torque_orders" in {each.name for each in result.tables}


def test_repetitions_come_to_a_mean(tmp_path: Path) -> None:
    plan = Plan.model_validate({**STEADY, "case": "tpc", "repetitions": 3})
    document = run_plan(_opener, plan, tmp_path / "run", INFO, Silent()).to_json()
    together = document["repeated"]["tpc"]["torque_ripple_rms"]
    values = [document["cases"][f"tpc.{n}"]["measurements"]["torque_ripple_rms"]["value"] for n in (1, 2, 3)]
    assert together["mean"] == pytest.approx(np.mean(values))
    of_mean = np.std(values, ddof=1) / math.sqrt(3.0)
    assert together["standard_uncertainty"] == pytest.approx(students_deviation(2.0) * of_mean)
    assert together["standard_uncertainty"] > 0.0
    assert together["n"] == 3


def test_a_response_without_excitation_is_refused(wire: Wire, tmp_path: Path) -> None:
    document = {**STEADY, "analyses": {"steady": False, "frequency_response": True}}
    document["record"] = {"duration_s": 0.1, "channels": ("torque_reference", "torque")}
    document["operating_point"] = {"mode": "torque", "torque_Nm": 0.2, "hold_speed_rad_s": 15.0}
    plan = Plan.model_validate(document)
    with pytest.raises(AnalysisError, match="'torque_reference' is constant"):
        _run(plan, tmp_path / "run")


def test_channels_of_an_analysis_are_checked_by_line(tmp_path: Path, wire: Wire) -> None:
    dictionary: Dictionary = wire.session.drive.dictionary
    path = tmp_path / "mine.toml"
    text = (
        'title = "mine"\nprofile = "zhu2011"\n[operating_point]\nomega_m_rad_s = 10.0\n[record]\n'
        'duration_s = 0.1\nchannels = ["torque", "stimulus"]\n[analyses]\nsteady = false\n'
        'frequency_response = true\nresponse_input = "stimulus"\nresponse_output = "omega_m"\n'
    )
    path.write_text(text, encoding="utf-8")
    with pytest.raises(PlanError) as refused:
        require_known(load_plan(str(path)), path, wire.session.profile, dictionary, transducer=True)
    assert "mine.toml, line 12: response_output is 'omega_m', which record.channels does not" in str(
        refused.value
    )
    named = text.replace("response_output", "[analyses.frequency_response]\ninput = 'torque'\noutput")
    named = named.replace('frequency_response = true\nresponse_input = "stimulus"\n', "")
    path.write_text(named.replace('omega_m"\n', 'torque"\nstimulus = "probe"\n'), encoding="utf-8")
    with pytest.raises(PlanError, match="stimulus is 'probe', which record"):
        require_known(load_plan(str(path)), path, wire.session.profile, dictionary, transducer=True)
    path.write_text('figure = "bode"\n' + text.replace("frequency_response = true\n", ""), encoding="utf-8")
    with pytest.raises(PlanError, match="figure = 'bode' needs"):
        load_plan(str(path))
