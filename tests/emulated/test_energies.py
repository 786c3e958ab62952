"""The energy accounts of an emulated bench as a stream of a run."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from benchtool.bench.session import open_session
from benchtool.emulator.core import core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.plan.model import Plan
from benchtool.recording import Bundle
from benchtool.run.runner import RunInfo, run_plan

INFO = RunInfo("2020-01-01T00:00:00+00:00", 0, ("run",))
LOSSES = ("copper", "iron", "inverter", "friction", "shaft", "magnetic", "kinetic")


class Silent:
    def begin(self, case: str, number: int, count: int) -> None: ...

    def note(self, text: str) -> None: ...


def test_a_plan_records_where_the_energy_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A row for every control period beside the capture; the bench is computed by the plain functions, whose
    compilation would take longer."""
    monkeypatch.setattr(core, "kernel_of", lambda _: run_ticks)
    plan = Plan.model_validate(
        {
            "title": "energies",
            "profile": "zhu2011",
            "emulator": {"energy_accounts": 1},
            "operating_point": {
                "settle_s": 0.004,
                "torque_Nm": 2.0,
                "mode": "torque",
                "hold_speed_rad_s": 20.0,
            },
            "record": {"duration_s": 0.003, "channels": ["torque", "omega_m"]},
        }
    )
    with open_session("zhu2011", alter=plan.emulator) as session:
        run_plan(lambda *_: nullcontext(session), plan, tmp_path / "run", INFO, Silent())
    bundle = Bundle.open(tmp_path / "run")
    energies = bundle.block("energies")
    assert len(energies.data) == 31
    assert energies.tick_s == bundle.block("capture").tick_s
    used = {name: np.diff(energies.column(f"energy_{name}")) for name in ("supply", "dc", *LOSSES)}
    assert used["dc"] == pytest.approx(sum(used[name] for name in LOSSES), abs=1e-12)
    assert used["supply"] == pytest.approx(used["dc"], rel=1e-12)
    # 2 Nm at 20 rad/s.
    assert float(np.mean(used["shaft"])) / 1e-4 == pytest.approx(40.0, rel=0.1)
