"""The capture unit: ring, pretrigger, triggers and order of rows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchtool.emulator.core import Core
from benchtool.emulator.core.capture_memory import CaptureState, Trigger
from benchtool.errors import ValueRefused
from tests.physics.paper_machine import make_core


def ticks_of(core: Core) -> list[int]:
    return [int(tick) for tick in core.capture.rows()[:, 0]]


def test_immediate_trigger_takes_the_next_rows() -> None:
    core = make_core()
    core.run(7)
    core.capture.arm(names=["tick", "u_dc"], rows=5, stride=3)
    assert core.capture.state.name == "ARMED"
    core.run(1)
    assert core.capture.state.name == "TRIGGERED"
    assert core.capture.rows_done == 1
    core.run(100)
    assert core.capture.state is CaptureState.COMPLETE
    assert ticks_of(core) == [8, 11, 14, 17, 20]
    assert (core.capture.trigger_tick, core.capture.first_tick, core.capture.rows_done) == (8, 8, 5)
    assert core.capture.rows()[:, 1].view(np.float32) == pytest.approx(122.5, abs=0.3)


@pytest.mark.parametrize("command", ["torque_command", "omega_m_command"])
def test_setpoint_trigger_keeps_the_rows_before_it(command: str) -> None:
    core = make_core()
    core.capture.arm(names=["tick"], rows=10, pretrigger=4, trigger=Trigger.SETPOINT)
    core.run(33)
    assert core.capture.rows_done == 4
    core.memory[command] = 0.5
    core.run(50)
    assert core.capture.trigger_tick == 34
    assert ticks_of(core) == list(range(30, 40))
    assert core.capture.first_tick == 30


def test_early_trigger_is_taken_and_more_rows_follow_it() -> None:
    core = make_core()
    core.capture.arm(names=["tick"], rows=10, pretrigger=8, trigger=Trigger.SETPOINT)
    core.run(3)
    core.memory["torque_command"] = 1.0
    core.run(50)
    assert core.capture.trigger_tick == 4
    assert ticks_of(core) == list(range(1, 11))


def test_trigger_between_two_rows_keeps_the_grid_of_rows() -> None:
    core = make_core()
    core.capture.arm(names=["tick"], rows=6, stride=10, pretrigger=2, trigger=Trigger.SETPOINT)
    core.run(44)
    core.memory["torque_command"] = 1.0
    core.run(100)
    assert core.capture.trigger_tick == 45
    assert ticks_of(core) == [31, 41, 51, 61, 71, 81]
    assert core.capture.first_tick == 31


@pytest.mark.parametrize(
    ("trigger", "sign"), [(Trigger.RISING, 1.0), (Trigger.FALLING, -1.0)], ids=["rising", "falling"]
)
def test_level_trigger_fires_at_the_crossing(trigger: Trigger, sign: float) -> None:
    core = make_core()
    core.capture.arm(
        names=["tick", "omega_m"],
        rows=30,
        pretrigger=10,
        trigger=trigger,
        trigger_name="omega_m",
        trigger_level=10.0 * sign,
    )
    core.load.held = 1
    for omega_m in np.linspace(0.0, 20.0, 200):
        core.load.omega_m_rad_s = sign * omega_m
        core.run(10)
    rows = core.capture.rows()
    at = ticks_of(core).index(core.capture.trigger_tick)
    assert at == 10
    speeds = sign * rows[:, 1].view(np.float32)
    assert speeds[at - 1] < 10.0 <= speeds[at]


def test_level_trigger_on_a_counter() -> None:
    core = make_core()
    core.capture.arm(names=["tick"], rows=3, trigger=Trigger.RISING, trigger_name="tick", trigger_level=40.0)
    core.run(60)
    assert ticks_of(core) == [40, 41, 42]


def test_fault_trigger() -> None:
    core = make_core()
    core.capture.arm(names=["tick"], rows=8, pretrigger=3, trigger=Trigger.FAULT)
    core.run(20)
    core.memory["u_dc_max"] = 100.0
    assert core.run(20) == 1
    core.run(20)
    assert core.capture.trigger_tick == 21
    assert ticks_of(core) == list(range(18, 26))


def test_aborted_capture_takes_nothing_and_reads_nothing() -> None:
    core = make_core()
    core.capture.arm(names=["tick"], rows=5)
    core.run(2)
    core.capture.abort()
    core.run(20)
    assert core.capture.state is CaptureState.ABORTED
    with pytest.raises(ValueRefused, match="aborted"):
        core.capture.rows()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"names": []}, "0 channels"),
        ({"names": ["tick"] * 17}, "17 channels"),
        ({"names": ["law"]}, "'law'"),
        ({"names": ["nothing"]}, "'nothing'"),
        ({"rows": 0}, "0 rows"),
        ({"rows": 200_001}, "200001 rows"),
        ({"names": ["tick"] * 16, "rows": 62_501}, "62501 rows"),
        ({"pretrigger": 10}, "pretrigger"),
        ({"stride": 0}, "stride"),
        ({"trigger": 99}, "trigger 99"),
    ],
)
def test_refuses_what_cannot_be_captured(change: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueRefused, match=named):
        make_core().capture.arm(**{"names": ["tick"], "rows": 10, **change})
