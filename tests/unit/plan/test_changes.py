"""`--set`: values of a plan changed for one run, in any unit of their quantity."""

from __future__ import annotations

import math
import tomllib
from typing import Any

import pytest
from hypothesis import given, settings, strategies as st

from benchtool.errors import PlanError
from benchtool.plan.changes import Changes, places_of
from benchtool.plan.model import Plan, load_plan
from benchtool.protocol.dictionary import Dictionary
from benchtool.shipped import shipped

DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
CONTENT = tomllib.loads((shipped("profiles") / "zhu2011" / "ripple.toml").read_text(encoding="utf-8"))
PLACES = list(places_of(DICTIONARY))


def changed(*given: str) -> Plan:
    return load_plan("zhu2011/ripple", Changes(given, DICTIONARY).applied)


@pytest.mark.parametrize(
    "key", ["operating_point.omega_m_rad_s", "operating_point.omega_m", "omega_m_rad_s", "omega_m"]
)
@pytest.mark.parametrize(
    "value", ["150rpm", "150 rpm", "15.707963267948966", "15.707963267948966rad/s", "2.5rev/s"]
)
def test_a_key_with_or_without_table_and_unit(key: str, value: str) -> None:
    assert changed(f"{key}={value}").operating_point.omega_m_rad_s == pytest.approx(5.0 * math.pi)


@pytest.mark.parametrize(
    ("text", "path", "value"),
    [
        ("load_torque=500mNm", ("operating_point", "load_torque_Nm"), 0.5),
        ("settle=20ms", ("operating_point", "settle_s"), 0.02),
        ("repetitions=3", ("repetitions",), 3),
        ("law=foc", ("setup", "law"), "foc"),
        ('setup.law="foc"', ("setup", "law"), "foc"),
        ("R_s=123mohm", ("setup", "R_s_ohm"), 0.123),
        ("emulator.inverter.dead_time=2us", ("emulator", "inverter.dead_time_s"), 2e-6),
        ("channels=i_a, torque", ("record", "channels"), ["i_a", "torque"]),
        ("sweep.setup.law=tpc,foc", ("sweep", "setup", "law"), ["tpc", "foc"]),
        ("sweep.operating_point.omega_m=100rpm,200rpm", ("sweep", "operating_point", "omega_m_rad_s"), None),
        ("limits.torque_ripple_pp.max=0.1", ("limits", "torque_ripple_pp", "max"), 0.1),
        ("limits.torque_mean.min=0.1", ("limits", "torque_mean", "min"), 0.1),
        ("analyses.steady_from=100ms", ("analyses", "steady_from_s"), 0.1),
        ("stride=2", ("record", "stride"), 2),
        ("profile=mine.toml", ("profile",), "mine.toml"),
    ],
)
def test_what_may_be_changed(text: str, path: tuple[str, ...], value: Any) -> None:
    content: Any = Changes((text,), DICTIONARY).applied(CONTENT)
    Plan.model_validate(content)
    for key in path:
        content = content[key]
    expected = [math.pi / 30 * 100, math.pi / 30 * 200] if value is None else value
    assert content == (pytest.approx(expected) if not isinstance(value, str | list) else expected)


def test_the_files_content_stays_and_only_that_key_is_another() -> None:
    before = tomllib.loads((shipped("profiles") / "zhu2011" / "ripple.toml").read_text(encoding="utf-8"))
    after = Changes(("load_torque_Nm=1", "emulator.inverter.u_dc=100V"), DICTIONARY).applied(CONTENT)
    assert before == CONTENT
    assert after.pop("emulator") == {"inverter.u_dc_V": 100.0}
    after["operating_point"]["load_torque_Nm"] = 0.65
    assert after == before


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("omga_m=300rpm", "no key 'omga_m': did you mean 'omega_m'"),
        ("operating_point.omega=3", "did you mean 'operating_point.omega_m'"),
        ("load_torque=3rpm", r"load_torque = '3rpm': a value in Nm \(or mNm"),
        ("setup.R_s=3V", "a value in ohm"),
        ("load_torque", "KEY=VALUE is expected"),
        ("=3", "KEY=VALUE is expected"),
        ("load_torque=", "KEY=VALUE is expected"),
        ("qqqq=3", "a key of the plan is expected"),
        ("title.x=3", "no key 'title.x'"),
    ],
)
def test_what_may_not(text: str, complaint: str) -> None:
    with pytest.raises(PlanError, match=rf"--set {text}: .*{complaint}"):
        changed(text)


def test_a_key_of_two_tables_is_that_of_the_table_which_the_plan_has() -> None:
    assert changed("duration=1").record.duration_s == 1.0
    both = load_plan("zhu2011/laws").model_dump(mode="json", exclude_none=True)
    with pytest.raises(PlanError, match=r"'duration' may be record\.duration_s or stimulus\.duration_s"):
        Changes(("duration=1",), DICTIONARY).applied(both)


def test_all_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(PlanError) as failed:
        changed("omga_m=1", "load_torque_Nm=1", "R_s=1V")
    assert len([str(failed.value), *failed.value.__notes__]) == 2


@settings(max_examples=50)
@given(st.sampled_from([each for each in PLACES if each.unit and not each.array]), st.floats(1e-3, 1e3))
def test_every_place_takes_the_key_that_it_proposes(place: Any, value: float) -> None:
    for spelling in (place.key, place.spellings[1]):
        content: Any = Changes((f"{spelling}={value!r} {place.unit}",), DICTIONARY).applied(CONTENT)
        for key in place.path:
            content = content[key]
        assert content == pytest.approx(value)
