"""An operating point that is not reached fails; a drive that contradicts its profile is not enabled."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest

from benchtool.bench.operator import confirmed_beforehand
from benchtool.bench.session import Session
from benchtool.errors import ParameterMismatch, ValueRefused
from benchtool.plan.model import Plan
from benchtool.protocol.cia402 import State
from benchtool.recording import Bundle
from benchtool.results.assessment import Assessment
from benchtool.results.case_assessment import assess_bundle
from benchtool.run.runner import RunInfo, run_plan

from .conftest import Opener, Wire, over_both_wires

INFO = RunInfo("2020-01-01T00:00:00+00:00", 0, ("run",))
ALL = ("i_a", "torque", "psi_s", "theta_m", "omega_m", "u_dc", "switching_count")


class Silent:
    """Keeps the notes."""

    def __init__(self) -> None:
        self.notes: list[str] = []

    def begin(self, case: str, number: int, count: int) -> None: ...

    def note(self, text: str) -> None:
        self.notes.append(text)


def _plan(channels: tuple[str, ...] = ALL, **point: object) -> Plan:
    return Plan.model_validate(
        {
            "title": "test",
            "profile": "zhu2011",
            "case": "only",
            "operating_point": {
                "settle_s": 0.8,  # poles of the speed loop at 15 rad/s
                **(point or {"omega_m_rad_s": 31.42, "load_torque_Nm": 0.65}),
            },
            "record": {"duration_s": 0.12, "channels": channels},
        }
    )


def _run(session: Session, plan: Plan, folder: Path, info: RunInfo = INFO) -> Assessment:
    (found,) = run_plan(lambda *_: nullcontext(session), plan, folder, info, Silent()).assessments
    again = assess_bundle(Bundle.open(folder))
    assert again.to_json() == found.to_json(), "the bundle tells the same"
    return found


def test_what_was_reached_is_measured_and_limited(wire: Wire, tmp_path: Path) -> None:
    found = _run(wire.session, _plan(), tmp_path / "run")
    value = {name: each.value for name, each in found.found.items()}
    assert value["omega_m_reached"] == pytest.approx(31.42, rel=0.02)
    assert value["load_torque_reached"] == pytest.approx(0.65, rel=0.02)
    assert value["u_dc_reached"] == pytest.approx(122.5, rel=0.01)
    assert found.missed == ()
    assert found.verdict == "pass"


@over_both_wires
def test_what_the_capture_has_not_is_read_from_the_drive(wire: Wire, tmp_path: Path) -> None:
    found = _run(replace(wire.session, transducer=None), _plan(("i_a",)), tmp_path / "run")
    for name, expected in {"omega_m": 31.42, "load_torque": 0.65, "u_dc": 122.5}.items():
        each = found.found[f"{name}_reached"]
        assert each.value == pytest.approx(expected, rel=0.03)
        assert "read just before the capture" in each.definition
    assert found.verdict == "pass"


def test_a_load_that_was_never_there_fails_and_says_by_how_much(wire: Wire, tmp_path: Path) -> None:
    for transducer in (wire.session.transducer, None):
        session = replace(wire.session, load=None, transducer=transducer)
        folder = tmp_path / ("with" if transducer else "without")
        found = _run(session, _plan(), folder, replace(INFO, prompt=confirmed_beforehand))
        assert found.verdict == "fail"
        (missed,) = found.missed
        assert missed.name == "load_torque_reached"
        assert "at least 0.459 Nm is asked for: 0.4" in str(missed)
        assert "too little" in str(missed)


def test_a_speed_out_of_reach_fails(wire: Wire, tmp_path: Path) -> None:
    wire.session.drive.write("torque_limit", 0.2)  # as a drive that cannot: less than the load
    plan = _plan(("torque", "u_dc"), omega_m_rad_s=20.0, load_torque_Nm=0.4)
    plan = plan.model_copy(update={"setup": {"torque_limit_Nm": 0.2}})
    found = _run(wire.session, plan, tmp_path / "run")
    assert found.verdict == "fail"
    assert "omega_m_reached" in {each.name for each in found.missed}


def test_another_dc_link_than_the_plan_takes_fails(wire: Wire, tmp_path: Path) -> None:
    found = _run(wire.session, _plan(ALL, omega_m_rad_s=31.42, u_dc_V=311.0), tmp_path / "run")
    (missed,) = found.missed
    assert missed.name == "u_dc_reached"
    assert "is 122.56 ± 0.28 V, at least 279.9 V is asked for" in str(missed)


@pytest.mark.parametrize(("held", "verdict"), [(31.42, "pass"), (25.0, "fail")])
def test_a_held_speed_and_a_torque_are_reached_too(
    wire: Wire, tmp_path: Path, held: float, verdict: str
) -> None:
    session = wire.session
    load = session.load
    assert load is not None
    apply, hold = load.apply, load.hold

    class Stubborn:
        """A load machine that holds its own speed."""

        def apply(self, torque_Nm: float) -> None:
            apply(torque_Nm)

        def hold(self, omega_m_rad_s: float) -> None:
            hold(held)

    plan = _plan(ALL, mode="torque", torque_Nm=1.0, hold_speed_rad_s=31.42)
    found = _run(replace(session, load=Stubborn()), plan, tmp_path / "run")
    assert found.found["torque_reached"].value == pytest.approx(1.0, abs=0.02)
    assert found.verdicts["torque_reached"] == "pass"
    assert found.verdicts["omega_m_reached"] == verdict
    assert bool(found.refusal) == (verdict == "fail"), "fewer than two periods at that speed"


def test_a_plans_own_limit_stands_in_place_of_the_default(wire: Wire, tmp_path: Path) -> None:
    plan = _plan()
    strict = Plan.model_validate(plan.model_dump() | {"limits": {"omega_m_reached": {"max": 30.0}}})
    found = _run(wire.session, strict, tmp_path / "run")
    assert found.verdicts["omega_m_reached"] == "fail"
    assert "at most 30 rad/s is allowed: 1.4" in str(found.missed[0])
    assert "too much" in str(found.missed[0])


def test_a_stimulus_begins_where_the_plan_says(wire: Wire, tmp_path: Path) -> None:
    document = _plan(ALL, mode="torque", torque_Nm=0.5, hold_speed_rad_s=31.42).model_dump()
    stimulus = {"quantity": "torque", "shape": "constant", "amplitude_Nm": 0.5, "duration_s": 0.1}
    document |= {"stimulus": stimulus, "analyses": {"steady": False}}
    for pretrigger_s in (0.01, 0.0):
        document["record"]["pretrigger_s"] = pretrigger_s
        found = _run(wire.session, Plan.model_validate(document), tmp_path / f"{pretrigger_s}")
        assert found.found["torque_reached"].value == pytest.approx(0.5, abs=0.02)
        assert found.verdict == "pass"


# ---- the drive's parameters against the profile's ----------------------------------------------------------


@over_both_wires
def test_a_drive_that_contradicts_the_profile_is_not_enabled(wire: Wire, tmp_path: Path) -> None:
    wire.session.drive.write("psi_r", 0.2)
    wire.session.drive.write("R_s", 0.2)
    with pytest.raises(ParameterMismatch) as refused:
        _run(wire.session, _plan(), tmp_path / "run")
    message = str(refused.value)
    assert "R_s_ohm = 0.2 (the profile states 0.123), psi_r_Wb = 0.2 (the profile states 0.1685)" in message
    assert "--allow-different" in message
    assert wire.session.drive.state() is State.SWITCH_ON_DISABLED
    assert not (tmp_path / "run").exists()


def test_a_difference_that_is_allowed_is_recorded(wire: Wire, tmp_path: Path) -> None:
    wire.session.drive.write("L_q", 0.012)
    found = _run(wire.session, _plan(), tmp_path / "run", replace(INFO, allow_different=True))
    held = {"L_q_H": {"profile": 0.00952, "drive": 0.012}}
    assert found.to_json()["different_parameters"] == held
    assert Bundle.open(tmp_path / "run").manifest.details["parameter_check"]["contradicted"] == held


def test_what_the_plan_sets_and_what_the_profile_leaves_open_may_differ(wire: Wire, tmp_path: Path) -> None:
    wire.session.drive.write("u_s", 60.0)
    wire.session.drive.write("delay_compensation", "off")
    plan = Plan.model_validate(_plan().model_dump() | {"setup": {"u_s_V": 81.65}})
    found = _run(wire.session, plan, tmp_path / "run")
    assert found.to_json()["different_parameters"] == {}
    assert list(found.parameter_check["unstated"]) == ["delay_compensation"]


def test_a_parameter_that_a_float32_rounds_is_no_difference(open_wire: Opener, tmp_path: Path) -> None:
    wire = open_wire()
    profile = wire.session.profile
    motor = profile.motor.model_copy(update={"psi_r_Wb": 0.16850000001})
    session = replace(wire.session, profile=profile.model_copy(update={"motor": motor}))
    assert _run(session, _plan(), tmp_path / "run").to_json()["different_parameters"] == {}


# ---- nothing beyond the rating -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "point",
    [
        {"omega_m_rad_s": 500.0},
        {"omega_m_rad_s": -1e9},
        {"omega_m_rad_s": 10.0, "load_torque_Nm": 10.0},
        {"mode": "torque", "torque_Nm": -10.0},
        {"mode": "torque", "torque_Nm": 1.0, "hold_speed_rad_s": 158.0},
    ],
)
def test_a_setpoint_beyond_the_rating_is_never_sent(
    wire: Wire, tmp_path: Path, point: dict[str, object]
) -> None:
    with pytest.raises(ValueRefused, match="the profile rates the motor at"):
        _run(wire.session, _plan(ALL, **point), tmp_path / "run")
    assert wire.session.drive.state() is State.SWITCH_ON_DISABLED
    assert wire.session.drive.number("omega_m_command") == 0.0
