"""The example's motor: a quick stop never turns the shaft back, a halt stops and continues."""

from __future__ import annotations

import pytest

from benchtool.protocol.modes import Mode
from tests.device.c_drive import CHost

TARGET_REACHED = 1 << 10
STATE = 0x6F


def _speeds(host: CHost, ticks: int) -> list[float]:
    """Of every tick from now on, in rad/s."""
    speeds = []
    for _ in range(ticks):
        host.bench.clock.wait(1e-4)
        speeds.append(float(host.read("omega_m")))
    return speeds


OVERCURRENT = 0x2310


def test_a_sample_at_the_end_of_the_range_trips_though_it_is_not_above_the_level(raw: CHost) -> None:
    raw.write("i_trip", float(raw.read("i_full_scale")))
    raw.write("torque_limit", 1000.0)
    raw.enable(Mode.TORQUE)
    raw.write("torque_command", 100.0)
    raw.bench.clock.wait(0.01)
    assert int(raw.read("statusword")) & STATE == 0x08
    assert int(raw.read("error_1")) == OVERCURRENT
    assert raw.read("adc_saturated") > 0


def test_the_shaft_turns_where_the_inertia_is_not_stated(raw: CHost) -> None:
    raw.write("J", 0.0)
    raw.enable(Mode.VELOCITY)
    raw.write("omega_m_command", 20.0)
    raw.bench.clock.wait(0.5)
    assert 1.0 < float(raw.read("omega_m")) < 21.0


@pytest.mark.parametrize("gain", [1.0, 10.0, 40.0])
@pytest.mark.parametrize("omega_m", [20.0, -20.0])
def test_a_quick_stop_does_not_turn_back(raw: CHost, gain: float, omega_m: float) -> None:
    raw.write("K_p_speed", gain * float(raw.read("K_p_speed")))
    raw.enable(Mode.VELOCITY)
    raw.write("omega_m_command", omega_m)
    raw.bench.clock.wait(0.5)
    began = float(raw.read("omega_m"))
    assert began * omega_m > 0.0
    raw.write("controlword", 0x02)
    speeds = _speeds(raw, 3000)
    assert int(raw.read("statusword")) & STATE == 0x40
    rest = 0.01 * float(raw.read("omega_m_N"))
    assert min(speed * omega_m for speed in speeds) / abs(omega_m) > -rest
    assert abs(speeds[-1]) < rest


def test_a_halt_stands_and_the_target_comes_back(raw: CHost) -> None:
    raw.enable(Mode.VELOCITY)
    raw.write("omega_m_command", 20.0)
    raw.bench.clock.wait(1.0)
    moving = float(raw.read("omega_m"))
    raw.write("controlword", 0x10F)
    raw.bench.clock.wait(1e-4)
    assert not int(raw.read("statusword")) & TARGET_REACHED
    raw.bench.clock.wait(2.0)
    assert int(raw.read("statusword")) & (TARGET_REACHED | STATE) == TARGET_REACHED | 0x27
    assert abs(float(raw.read("omega_m"))) < 0.01 * float(raw.read("omega_m_N"))
    raw.write("controlword", 0x0F)
    raw.bench.clock.wait(1.0)
    assert float(raw.read("omega_m")) == pytest.approx(moving, rel=0.05)
