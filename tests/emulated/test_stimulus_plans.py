"""Plans with a stimulus: the machine held at a speed, the capture from before the stimulus on."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from benchtool.errors import DriveFault, ValueRefused
from benchtool.plan.model import Plan
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode
from benchtool.recording import Bundle
from benchtool.run.runner import RunInfo, run_plan

from .conftest import Wire

INFO = RunInfo("2020-01-01T00:00:00+00:00", 0, ("run",))
PLAN = Plan.model_validate(
    {
        "title": "torque step at a held speed",
        "profile": "zhu2011",
        "operating_point": {"mode": "torque", "torque_Nm": 0.1, "hold_speed_rad_s": 15.0, "settle_s": 0.2},
        "stimulus": {"quantity": "torque", "shape": "step", "amplitude_Nm": 0.5, "duration_s": 0.08},
        "record": {
            "duration_s": 0.12,
            "pretrigger_s": 0.02,
            "channels": ("torque_reference", "torque", "omega_m"),
        },
        "analyses": {"steady": False},
    }
)


class Silent:
    """Ignores progress."""

    def begin(self, case: str, number: int, count: int) -> None: ...
    def note(self, text: str) -> None: ...


def _run(wire: Wire, plan: Plan, folder: Path) -> None:
    run_plan(lambda *_: nullcontext(wire.session), plan, folder, INFO, Silent())


def test_a_torque_step_at_a_held_speed(wire: Wire, tmp_path: Path) -> None:
    _run(wire, PLAN, tmp_path / "run")
    block = Bundle.open(tmp_path / "run").block("capture")
    reference = block.column("torque_reference")
    assert np.array_equal(reference, np.float32(np.repeat([0.1, 0.6, 0.1], [200, 400, 600])))
    assert block.column("torque")[250:600].mean() == pytest.approx(0.6, abs=0.02)
    assert block.column("omega_m") == pytest.approx(np.full(1200, 15.0), abs=0.3)
    assert wire.session.drive.state() is State.SWITCH_ON_DISABLED


def test_the_shaft_is_let_go_also_when_the_run_fails(wire: Wire, tmp_path: Path) -> None:
    session = wire.session
    assert session.load is not None
    with pytest.raises(DriveFault, match="0x2310"):
        _run(wire, PLAN.model_copy(update={"setup": {"i_trip_A": 0.3}}), tmp_path / "run")
    held = session.drive.number("omega_m")
    assert held == pytest.approx(15.0, abs=0.3)
    drive = session.drive
    drive.reset_fault()
    with drive.enabled(Mode.TORQUE):
        drive.write("torque_command", -0.2)
        drive.wait(0.02)
        assert drive.number("omega_m") < held - 1.0, "torque moves a shaft that is not held"


def test_a_stimulus_beyond_the_rating_is_refused_before_anything_turns(wire: Wire, tmp_path: Path) -> None:
    assert PLAN.stimulus is not None
    plan = PLAN.model_copy(update={"stimulus": PLAN.stimulus.model_copy(update={"amplitude_Nm": 50.0})})
    with pytest.raises(ValueRefused, match="reaches 50 Nm, the profile's rated torque T_N is"):
        _run(wire, plan, tmp_path / "run")
    assert not (tmp_path / "run").exists()
    assert wire.session.drive.number("omega_m") == pytest.approx(0.0, abs=1e-6)
