"""Capture and counters: what the drive records is what it was asked for, and its counters count."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.acceptance import Measure
from benchtool.acceptance.suite.conditions import (
    armed,
    making_torque,
    quiet,
    rating,
    recorded,
    require_objects,
)
from benchtool.bench import Session
from benchtool.drive import TORQUE_SETPOINT, in_si

pytestmark = pytest.mark.requirement("ACC-CAPTURE")


def test_rows(bench_session: Session, measure: Measure) -> None:
    """A capture has every row, each a control period after the last, and captures are numbered."""
    require_objects(bench_session, "capture_sequence", "tick")
    before = bench_session.drive.number("capture_sequence")
    block, _ = recorded(bench_session, 0.05, ("tick", "omega_m"))
    again, _ = recorded(bench_session, 0.05, ("tick", "omega_m"))
    steps = np.diff(block.column("tick"))
    measure("rows_out_of_step", int(np.sum(steps != block.stride)), max=0)
    measure("tick_of_the_first_row", block.column("tick")[0] - block.first_tick % 2**32, min=0, max=0)
    measure("captures_counted", bench_session.drive.number("capture_sequence") - before, min=2, max=2)
    measure("captures_in_order", again.first_tick - block.first_tick, min=len(block.data))


def test_trigger(bench_session: Session, measure: Measure) -> None:
    """A capture that waits for a signal begins before it, by the rows that were asked for."""
    require_objects(bench_session, "capture_trigger_signal", "capture_pretrigger", "torque")
    drive = bench_session.drive
    limits = rating(bench_session)
    with making_torque(bench_session, 0.0, 0.3 * limits.omega_m_rad_s):
        capture = armed(
            bench_session,
            0.03,
            ("torque",),
            trigger="rising",
            trigger_signal="torque",
            trigger_level=0.3 * limits.torque_Nm,
            pretrigger_rows=50,
        )
        quiet(bench_session, 0.03)
        drive.write(in_si(drive, TORQUE_SETPOINT), 0.6 * limits.torque_Nm)
        quiet(bench_session, 0.1)
        block = capture.read()
    first = int(np.argmax(block.column("torque") >= 0.3 * limits.torque_Nm))
    measure("rows_before_the_trigger", first, min=49, max=51)


def test_counters(bench_session: Session, measure: Measure) -> None:
    """Counters of the drive count while it works."""
    require_objects(bench_session, "switching_count", "law_clipped", "torque_command")
    drive = bench_session.drive
    limits = rating(bench_session)
    T_s = limits.control_period_s
    with making_torque(bench_session, 0.5 * limits.torque_Nm, 0.5 * limits.omega_m_rad_s):
        before = drive.number("switching_count")
        block, _ = recorded(bench_session, 2000 * T_s, ("switching_count", "law_clipped"))
        after = drive.number("switching_count")
    counted = float(block.column("switching_count")[-1] - block.column("switching_count")[0])
    measure("switchings_per_control_period", counted / 2000.0, "", min=0.02, max=3.1)
    measure("switchings_read", after - before, min=counted)
