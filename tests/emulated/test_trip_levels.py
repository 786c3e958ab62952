"""Trip levels beyond the sensor range are refused by the host: on a drive, in a profile, in a plan."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.bench.session import dictionary_of
from benchtool.cli import app
from benchtool.drive.parameters.transaction import temporary, write_all
from benchtool.emulator.bench import EmulatedBench
from benchtool.errors import PlanError, ProfileError, SdoAbort, ValueRefused
from benchtool.plan.model import Plan, load_plan, plan_path
from benchtool.plan.sensor_ranges import require_protected
from benchtool.profile import altered, load_profile
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.dictionary.variable import Value

from .conftest import Wire, over_both_wires


@over_both_wires
def test_the_drive_tells_of_its_ranges_and_refuses_a_level_beyond_them(wire: Wire) -> None:
    drive = wire.session.drive
    assert (drive.read("i_full_scale"), drive.read("u_dc_full_scale")) == (12.5, 500.0)
    with pytest.raises(SdoAbort) as refused:
        drive.write("i_trip", 229.0)
    assert refused.value.code == Abort.VALUE_HIGH
    assert drive.read("i_trip") == 12.0


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        (
            {"i_trip": 229.0},
            "i_trip = 229 A is above i_full_scale = 12.5 A: give at most 12.5 A; nothing was sent",
        ),
        ({"R_s": 0.2, "i_trip": 12.51}, "above i_full_scale"),
        ({"u_dc_max": 501.0}, "above u_dc_full_scale = 500 V"),
        ({"u_dc_min": 401.0}, "u_dc_min = 401 V is above u_dc_max = 400 V"),
        ({"u_dc_max": 49.0}, "u_dc_min = 50 V is above u_dc_max = 49 V"),
        ({"omega_m_trip": 1572.0}, "above 10 times omega_m_N = 157.1 rad/s: give at most 1571 rad/s"),
        ({"omega_m_N": 20.0}, "omega_m_trip = 220 rad/s is above 10 times omega_m_N"),
        ({"omega_m_trip": 0.0}, "its limits are"),
    ],
)
def test_the_host_says_what_is_beyond_what_and_sends_nothing(
    wire: Wire, values: dict[str, Value], complaint: str
) -> None:
    drive = wire.session.drive
    for write in (write_all, lambda drive, values: temporary(drive, _keyed(values)).__enter__()):
        with pytest.raises(ValueRefused) as refused:
            write(drive, values)
        assert complaint in str(refused.value)
    assert (drive.read("R_s"), drive.read("i_trip")) == (0.123, 12.0)


def _keyed(values: dict[str, Value]) -> dict[str, Value]:
    units = {"i": "A", "u": "V", "omega": "rad_s", "R": "ohm"}
    return {f"{name}_{units[name.split('_')[0]]}": value for name, value in values.items()}


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("pair", [(450.0, 480.0), (10.0, 40.0), (50.0, 50.0), (400.0, 400.0)])
def test_a_pair_is_written_and_restored_in_whichever_order_it_comes(
    wire: Wire, pair: tuple[float, float], turned: bool
) -> None:
    drive = wire.session.drive
    values = dict(zip(("u_dc_min", "u_dc_max"), pair, strict=True))
    before = {"u_dc_min": 50.0, "u_dc_max": 400.0}
    assert write_all(drive, dict(reversed(values.items())) if turned else values) == before
    assert {name: drive.read(name) for name in values} == values
    write_all(drive, before)
    with temporary(drive, _keyed({**values})):
        assert {name: drive.read(name) for name in values} == values
    assert {name: drive.read(name) for name in values} == before


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"sensors.i_full_scale_A": 10.0}, "i_trip = 12 A is above i_full_scale = 10 A"),
        ({"sensors.u_full_scale_V": 300.0}, "u_dc_max = 400 V is above u_dc_full_scale = 300 V"),
    ],
)
def test_a_bench_is_not_powered_with_levels_beyond_its_sensors(
    change: dict[str, float], complaint: str
) -> None:
    with pytest.raises(ProfileError, match=complaint):
        EmulatedBench(altered(load_profile("zhu2011"), change))


def _changed(**changes: object) -> Plan:
    content = load_plan("zhu2011/ripple").model_dump(exclude_none=True)
    return Plan.model_validate(content | changes)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"setup": {"i_trip_A": 14.5}}, "case tpc: i_trip = 14.5 A is above i_full_scale = 12.5 A"),
        ({"emulator": {"sensors.i_full_scale_A": 10.0}, "setup": {}}, "above i_full_scale = 10 A"),
        ({"sweep": {"setup": {"i_trip_A": [12.0, 14.5]}}}, "case i_trip_A=14.5: i_trip"),
        ({"setup": {"u_dc_min_V": 401.0}}, "above u_dc_max"),
        ({"emulator": {"sensors.i_full_scale_A": 16.0}, "setup": {"i_trip_A": 15.5}}, ""),
        (
            {"emulator": {"sensors.i_full_scale_A": 10.0}, "setup": {"i_trip_A": 9.5}},
            "i_trip = 12 A is above",
        ),
        ({"setup": {"u_dc_min_V": 410.0, "u_dc_max_V": 450.0}}, ""),
    ],
)
def test_a_plan_is_refused_before_any_of_its_cases_runs(changes: dict[str, object], complaint: str) -> None:
    plan = _changed(**changes)
    profile, dictionary = load_profile("zhu2011"), dictionary_of("zhu2011")
    if not complaint:
        require_protected(plan, None, profile, dictionary)
        return
    with pytest.raises(PlanError, match=complaint):
        require_protected(plan, None, profile, dictionary)


@pytest.mark.parametrize("link", ["emulated", "emulated?wire=serial"])
def test_the_same_plans_are_refused_over_either_wire_of_the_emulated_drive(link: str, tmp_path: Path) -> None:
    text = plan_path("zhu2011/ripple").read_text(encoding="utf-8")
    plan = tmp_path / "mine.toml"
    plan.write_text(text.replace("[setup]", "[setup]\ni_trip_A = 14.5"), encoding="utf-8")
    result = CliRunner().invoke(app, ["run", str(plan), "--link", link, "--out", str(tmp_path / "run")])
    assert result.exit_code == 2
    assert "i_trip = 14.5 A is above i_full_scale = 12.5 A" in result.stderr
    assert not (tmp_path / "run").exists()


def test_defaults_beyond_a_smaller_converter_are_in_force_as_cut_by_the_drive() -> None:
    profile = load_profile("zhu2011")
    small = {"i_trip_A": 4.0, "u_dc_max_V": 150.0}
    drive_ = profile.drive.model_copy(update={"parameters": {**profile.drive.parameters, **small}})
    bench = altered(
        profile.model_copy(update={"drive": drive_}),
        {"sensors.i_full_scale_A": 5.0, "sensors.u_full_scale_V": 160.0},
    )
    emulated = EmulatedBench(bench)
    firmware = emulated._node.firmware
    firmware._restore()
    firmware.reset()
    assert (firmware.objects["i_trip"], firmware.objects["u_dc_max"]) == (5.0, 160.0)
    emulated.close()
