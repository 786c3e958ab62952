"""A plan on a bench with a fan and a transducer at the flange, from the profile's keys to the bundle."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import pytest

from benchtool.bench.session import open_session
from benchtool.plan.model import Plan
from benchtool.recording import Bundle
from benchtool.results.case_assessment import assess_bundle
from benchtool.run.runner import RunInfo, run_plan

from .test_operating_point import Silent

# The same parts as of tests/physics/test_flange: one kernel for both.
BENCH = {
    "motor.cogging_Nm": 0.01,
    "motor.cogging_order": 24.0,
    "motor.coulomb_Nm": 0.15,
    "shaft.J_load_kgm2": 1e-4,
    "load.quadratic_Nms2": 4e-4,
    "flange.offset_Nm": 0.001,
    "inverter.dc_link_R_ohm": 0.01,
    "inverter.dc_link_C_F": 0.1,
}


def test_a_plan_expects_what_the_driven_machine_takes(tmp_path: Path) -> None:
    """The flange has the load and the fan; the air gap has the friction as well."""
    plan = Plan.model_validate(
        {
            "title": "test",
            "profile": "zhu2011",
            "case": "only",
            "emulator": BENCH,
            "operating_point": {"settle_s": 0.8, "omega_m_rad_s": 31.42, "load_torque_Nm": 0.65},
            "record": {"duration_s": 0.12, "channels": ("torque", "omega_m", "u_dc")},
        }
    )
    info = RunInfo("2020-01-01T00:00:00+00:00", 0, ("run",))
    with open_session("zhu2011", "emulated", alter=BENCH) as session:
        (found,) = run_plan(
            lambda *_: nullcontext(session), plan, tmp_path / "run", info, Silent()
        ).assessments
    assert found.verdict == "pass"
    reached = found.found["load_torque_reached"]
    assert reached.value == pytest.approx(0.65 + 4e-4 * 31.42**2, rel=0.02)
    assert "asked for: 1.04" in reached.definition
    bundle = Bundle.open(tmp_path / "run")
    assert assess_bundle(bundle).to_json() == found.to_json()
    recorded = bundle.block("transducer")
    assert recorded.names == ("torque_transducer", "torque_airgap")
    flange, airgap = (recorded.column(name).mean() for name in recorded.names)
    assert airgap - flange == pytest.approx(0.15 - 0.001, abs=0.01)
