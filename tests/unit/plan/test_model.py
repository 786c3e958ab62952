"""Limits, verdicts and plans."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, strategies as st
from pydantic import ValidationError

from benchtool.errors import PlanError
from benchtool.plan.limits import Limit, Verdict, worst
from benchtool.plan.model import load_plan
from benchtool.plan.validation import require_known
from benchtool.profile import load_profile
from benchtool.protocol.dictionary import Dictionary
from benchtool.shipped import shipped

PROFILE = load_profile("zhu2011")
DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
PLAN = (shipped("profiles") / "zhu2011" / "ripple.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        (0.9, Verdict.FAIL),
        (1.0, Verdict.MARGINAL),
        (1.05, Verdict.MARGINAL),
        (1.5, Verdict.PASS),
        (1.95, Verdict.MARGINAL),
        (2.1, Verdict.FAIL),
        (None, Verdict.FAIL),
        (math.nan, Verdict.FAIL),
        (math.inf, Verdict.FAIL),
    ],
)
def test_judgement(value: float | None, verdict: Verdict) -> None:
    assert Limit(min=1.0, max=2.0, margin=0.1).judge(value) is verdict


@given(st.floats(-1e6, 1e6), st.floats(0.0, 1e3))
def test_a_margin_never_turns_a_failure_into_something_better(value: float, margin: float) -> None:
    assert (Limit(max=0.0, margin=margin).judge(value) is Verdict.FAIL) == (value > 0.0)


def test_a_limit_needs_a_bound() -> None:
    with pytest.raises(ValidationError, match="needs min, max or both"):
        Limit(margin=1.0)
    with pytest.raises(ValidationError, match=r"min 2\.0 is above max 1\.0"):
        Limit(min=2.0, max=1.0)


def test_a_margin_leaves_room_between_the_bounds() -> None:
    assert Limit(min=0.1, max=0.3, margin=0.1).judge(0.2).met
    with pytest.raises(ValidationError, match=r"margin 0\.11 lets no value .* half of max − min .* 0\.1"):
        Limit(min=0.1, max=0.3, margin=0.11)
    assert Limit(min=0.1, margin=7.0).margin == 7.0


def test_the_worst_verdict_counts() -> None:
    assert worst([]) is Verdict.NONE
    assert worst([Verdict.PASS, Verdict.MARGINAL]) is Verdict.MARGINAL
    assert worst([Verdict.FAIL, Verdict.PASS]) is Verdict.FAIL


def test_the_shipped_plan_states_the_papers_operating_point() -> None:
    plan = load_plan("zhu2011/ripple")
    assert plan.operating_point.omega_m_rad_s == pytest.approx(0.1 * 157.1)
    assert plan.operating_point.load_torque_Nm == 0.65
    assert plan.limits["torque_ripple_pp"].max == 0.06


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (("settle_s", "setle_s"), "unknown key 'operating_point.setle_s': did you mean 'settle_s'?"),
        (("duration_s = 0.5", "duration_s = -1"), "key 'record.duration_s' is -1"),
        (("max = 0.06, ", ""), "a limit needs min, max or both"),
        (("duration_s = 0.52", "length_s = 0.52"), "unknown key 'record.length_s'"),
    ],
)
def test_mistakes_in_a_plan(tmp_path: Path, change: tuple[str, str], complaint: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(PLAN.replace(*change), encoding="utf-8")
    with pytest.raises(PlanError) as refused:
        load_plan(str(path))
    told = [str(refused.value), *getattr(refused.value, "__notes__", ())]
    assert any(complaint in each for each in told)
    assert not any("\n" in each for each in told)


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize("where", ["sweep", "variants"])
def test_every_value_that_a_plan_would_set_is_checked(tmp_path: Path, where: str, place: int) -> None:
    values = [0.1, 0.12, 0.14]
    values[place] = -1.0
    if where == "sweep":
        added = f"\n[sweep.setup]\nR_s_ohm = {values}\n"
    else:
        added = "".join(
            f"\n[[variants]]\nname = '{number}'\nsetup = {{ R_s_ohm = {value} }}\n"
            for number, value in enumerate(values)
        )
    path = tmp_path / "mine.toml"
    path.write_text(PLAN + added, encoding="utf-8")
    with pytest.raises(PlanError, match=r"mine\.toml.*R_s"):
        require_known(load_plan(str(path)), path, PROFILE, DICTIONARY, transducer=True)
    path.write_text((PLAN + added).replace("-1.0", "0.16"), encoding="utf-8")
    require_known(load_plan(str(path)), path, PROFILE, DICTIONARY, transducer=True)


def test_unknown_plan_lists_the_known() -> None:
    with pytest.raises(
        PlanError,
        match=r"no plan 'zhu2011/fig99': did you mean 'zhu2011/fig\d'\? the names are .*zhu2011/ripple",
    ):
        load_plan("zhu2011/fig99")
