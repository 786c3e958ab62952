"""Trip levels that could never trip: refused when written, from the store, and as defaults; by the drive."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given, strategies as st

from benchtool.emulator.core import Core
from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.firmware.objects import Refused
from benchtool.emulator.machine.sensor_truth import SensorTruth
from benchtool.emulator.machine.truth import InverterTruth, MotorTruth
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.canopen.emcy import Emergency
from benchtool.protocol.cia402 import State
from tests.physics.paper_machine import MOTOR, object_table

TABLE = object_table()


def drive(
    stored: dict[str, float] | None = None, i_full_scale: float = 12.5, u_full_scale: float = 500.0
) -> tuple[Firmware, list[Emergency]]:
    """A drive with a range of its converter, and the emergencies it has sent."""
    sensors = SensorTruth(i_full_scale_A=i_full_scale, u_full_scale_V=u_full_scale)
    core = Core(TABLE, MotorTruth(**MOTOR), InverterTruth(u_dc_V=122.5), sensors)
    sent: list[Emergency] = []
    return Firmware(TABLE, core, 1, stored or {}, sent.append), sent


def write(firmware: Firmware, name: str, value: float) -> Abort | None:
    entry = TABLE.by_name[name]
    try:
        firmware.objects.write(entry.index, entry.sub, struct.pack("<f", value))
    except Refused as refused:
        return refused.code
    return None


@pytest.mark.parametrize(
    ("name", "value", "code"),
    [
        ("i_trip", 12.5, None),
        ("i_trip", 12.51, Abort.VALUE_HIGH),
        ("i_trip", 229.0, Abort.VALUE_HIGH),
        ("i_trip", 1e4, Abort.VALUE_HIGH),
        ("i_trip", math.inf, Abort.VALUE),
        ("i_trip", math.nan, Abort.VALUE),
        ("i_trip", -1.0, Abort.VALUE_LOW),
        ("omega_m_trip", 1000.0, None),
        ("omega_m_trip", 1000.1, Abort.VALUE_HIGH),
        ("omega_m_trip", 1e5, Abort.VALUE_HIGH),
        ("omega_m_trip", 0.0, Abort.VALUE_LOW),
        ("omega_m_trip", math.nan, Abort.VALUE),
        ("omega_m_N", 20.0, None),
        ("omega_m_N", 19.0, Abort.PARAMETER_INCOMPATIBLE),
        ("u_dc_max", 500.0, None),
        ("u_dc_max", 500.1, Abort.VALUE_HIGH),
        ("u_dc_max", 9.0, Abort.VALUE_LOW),
        ("u_dc_max", math.nan, Abort.VALUE),
        ("u_dc_min", 500.1, Abort.VALUE_HIGH),
        ("u_dc_min", math.inf, Abort.VALUE),
        ("u_dc_min", 0.0, Abort.VALUE_LOW),
        ("u_dc_min", 7.8, Abort.VALUE_LOW),
        ("u_dc_min", 7.8125, None),
        ("i2t_current", 12.6, Abort.VALUE_HIGH),
        ("i2t_current", -1.0, Abort.VALUE_LOW),
        ("i2t_tau", 0.0, Abort.VALUE_LOW),
        ("i2t_tau", 1e9, Abort.VALUE_HIGH),
        ("i2t_tau", math.nan, Abort.VALUE),
        ("temperature_trip", 1000.0, Abort.VALUE_HIGH),
        ("temperature_trip", math.nan, Abort.VALUE),
    ],
)
def test_a_level_that_cannot_trip_is_refused_and_memory_is_as_it_was(
    name: str, value: float, code: Abort | None
) -> None:
    firmware, _ = drive()
    before = firmware.objects[name]
    assert write(firmware, name, value) is code
    assert firmware.objects[name] == pytest.approx(before if code else value)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["i_trip", "omega_m_trip", "omega_m_N", "u_dc_min", "u_dc_max", "i2t_current"]),
            st.floats(0.0, 2000.0, width=32) | st.floats(width=32),
        ),
        max_size=12,
    )
)
def test_no_sequence_of_writes_leaves_a_level_that_cannot_trip(writes: list[tuple[str, float]]) -> None:
    firmware, _ = drive()
    for name, value in writes:
        write(firmware, name, value)
    held = firmware.objects
    assert 0.0 <= held["i_trip"] <= 12.5
    assert 0.0 < held["omega_m_trip"] <= 10.0 * held["omega_m_N"] * (1 + 1e-6)
    assert 500.0 / 64.0 <= held["u_dc_min"] <= held["u_dc_max"] <= 500.0
    assert 0.0 <= held["i2t_current"] <= 12.5


def test_defaults_are_cut_to_the_range_of_the_converter() -> None:
    firmware, sent = drive(i_full_scale=5.0, u_full_scale=60.0)
    assert (firmware.objects["i_trip"], firmware.objects["u_dc_max"]) == (5.0, 60.0)
    assert firmware.objects["i2t_current"] == 5.0
    assert not sent
    tiny, _ = drive(u_full_scale=5.0)
    assert (tiny.objects["u_dc_min"], tiny.objects["u_dc_max"]) == (5.0, 5.0)
    huge, _ = drive(u_full_scale=1280.0)
    assert huge.objects["u_dc_min"] == 20.0, "a default is raised, too"
    wide, _ = drive(i_full_scale=50.0, u_full_scale=1000.0)
    assert (wide.objects["i_trip"], wide.objects["u_dc_max"]) == (10.0, 400.0)


@pytest.mark.parametrize(
    "stored",
    [
        {"i_trip": 14.5},
        {"i_trip": math.inf},
        {"i_trip": math.nan},
        {"omega_m_trip": 0.0},
        {"omega_m_N": 157.1, "omega_m_trip": 1600.0},
        {"u_dc_max": 600.0},
        {"u_dc_min": 300.0, "u_dc_max": 200.0},
    ],
)
def test_a_store_with_such_a_level_is_a_parameter_fault_and_its_default_is_in_force(
    stored: dict[str, float],
) -> None:
    firmware, sent = drive({**stored, "R_s": 0.25})
    assert firmware.state is State.FAULT
    assert [each.code for each in sent] == [0x6320]
    assert firmware.objects["R_s"] == pytest.approx(0.25)
    held = firmware.objects
    assert held["i_trip"] <= 12.5
    assert 0.0 < held["omega_m_trip"] <= 10 * held["omega_m_N"]
    assert held["u_dc_min"] <= held["u_dc_max"] <= 500.0


def test_a_good_store_is_in_force_after_a_reset() -> None:
    stored = {"i_trip": 12.0, "omega_m_N": 157.1, "omega_m_trip": 220.0, "u_dc_min": 50.0, "u_dc_max": 400.0}
    firmware, sent = drive(stored)
    firmware.reset()
    assert firmware.state is State.SWITCH_ON_DISABLED
    assert not sent
    assert {name: pytest.approx(firmware.objects[name]) for name in stored} == stored
