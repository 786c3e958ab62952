"""Link supervision: a host that falls silent, and commands that take the torque away."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.acceptance import Attach, Measure
from benchtool.acceptance.suite.conditions import (
    SETTLE_S,
    armed,
    making_torque,
    number,
    quiet,
    rating,
    recorded,
    require_objects,
    starts,
    times_s,
    torque_ends_s,
)
from benchtool.bench import Session
from benchtool.block import Block
from benchtool.drive import TORQUE_SETPOINT, in_si
from benchtool.protocol import Mode, State
from benchtool.protocol.canopen import ErrorCode, NmtCommand
from benchtool.protocol.dictionary import Role
from benchtool.report import draw_traces

_CHANNELS = ("torque", "omega_m", "switching_count")
_OF_RATED = 0.05
_AFTER_S = 0.1
_HOST = 127  # node id of a host
_QUICK_STOP = 3  # of the abort connection option (CiA 402-2, 0x6007)


@pytest.mark.requirement("ACC-WATCHDOG", "ACC-LINK-LOSS")
def test_silent_host(bench_session: Session, measure: Measure, attach: Attach) -> None:
    """Without the host's heartbeat the torque is gone within the time that the drive was given, whatever is
    read meanwhile; the loss is reported once, counted and latched."""
    require_objects(bench_session, "link_state", "link_losses", *_CHANNELS)
    drive, clock = bench_session.drive, bench_session.clock
    limits = rating(bench_session)
    drive.connect()
    timeout_s = (int(drive.number(Role.CONSUMER_HEARTBEAT)) & 0xFFFF) / 1000.0
    losses = drive.number("link_losses")
    with making_torque(bench_session, 0.4 * limits.torque_Nm, 0.3 * limits.omega_m_rad_s):
        capture = armed(bench_session, timeout_s + 3.0 * _AFTER_S, _CHANNELS)
        quiet(bench_session, 2.0 * _AFTER_S / 3.0)
        drive.link.send_heartbeat()
        last_s = clock.now_s()
        drive.stop_heartbeat()
        while clock.now_s() < last_s + timeout_s + 1.5 * _AFTER_S:
            quiet(bench_session, 0.02)
            drive.number("omega_m")  # a read is no sign of life
        emergencies = [each.code for each in drive.emergencies() if each.code]
        state, link = drive.state(), drive.read("link_state")
        code = int(drive.number(Role.ERROR_CODE))
        quiet(bench_session, _AFTER_S)
        drive.link.send_heartbeat()
        quiet(bench_session, 0.05)
        latched = drive.state() is state and drive.read("link_state") == link
        block = capture.read()
        again = starts(bench_session)
        drive.reset_fault()
    last_tick = drive.tick_at(last_s)
    assert last_tick is not None
    off_s = torque_ends_s(block, _OF_RATED * limits.T_N_Nm, last_tick)
    attach.picture(
        "link_loss",
        lambda: draw_traces(
            block,
            (("torque",), ("omega_m",)),
            "The host falls silent",
            {"last heartbeat": (last_tick - block.first_tick) * block.tick_s},
        ),
    )
    measure("time_to_no_torque", off_s, "s", min=0.5 * timeout_s, max=1.02 * timeout_s + 0.005)
    measure("link_loss_seen", link == "lost" and state.value.startswith("fault"), min=1)
    measure("emergencies", len(emergencies), min=1, max=1)
    measure("emergency_code", emergencies[0] if emergencies else None, min=0x8130, max=0x8130)
    measure("error_code", code, min=int(ErrorCode.HEARTBEAT), max=int(ErrorCode.HEARTBEAT))
    measure("link_losses", drive.number("link_losses") - losses, min=1, max=1)
    measure("latched", latched, min=1)
    measure("enabled_without_a_reset", again, max=0)
    measure("switched_after_the_loss", _switched_after(block, last_tick, 1.05 * timeout_s + 0.01), max=0)


@pytest.mark.requirement("ACC-LINK-LOSS")
def test_restart_after_a_loss(bench_session: Session, measure: Measure) -> None:
    """After a loss and a reset the drive works again, and waits for a fresh command."""
    require_objects(bench_session, "link_state")
    drive = bench_session.drive
    limits = rating(bench_session)
    with making_torque(bench_session, 0.4 * limits.torque_Nm, 0.3 * limits.omega_m_rad_s):
        drive.stop_heartbeat()
        quiet(bench_session, 1.0)
        drive.emergencies()
        left_Nm = drive.number(in_si(drive, TORQUE_SETPOINT))
        drive.reset_fault()
        drive.supervise()
        with drive.enabled(Mode.TORQUE):
            drive.wait(0.05)
            block, _ = recorded(bench_session, 0.02, ("torque",))
            before = float(np.mean(block.column("torque"))) / limits.T_N_Nm
            measure("torque_before_a_command", before, "T_N", min=-0.08, max=0.08)
            drive.write(in_si(drive, TORQUE_SETPOINT), 0.4 * limits.torque_Nm)
            drive.wait(SETTLE_S)
            block, _ = recorded(bench_session, 0.02, ("torque",))
            made = float(np.mean(block.column("torque"))) / (0.4 * limits.torque_Nm)
    measure("target_left_by_the_loss", left_Nm, "Nm", min=0.0, max=0.0)
    measure("torque_made_again", made, "", min=0.8, max=1.2)


@pytest.mark.requirement("ACC-LINK-LOSS", "ACC-STOP")
def test_quick_stop_on_loss(bench_session: Session, measure: Measure, attach: Attach) -> None:
    """A drive that is set to quick stop on a lost link brakes to standstill from the loss on, and is off."""
    require_objects(bench_session, "link_state", "omega_m_command", *_CHANNELS)
    drive, clock = bench_session.drive, bench_session.clock
    option = drive.dictionary.get(Role.ABORT_CONNECTION_OPTION)
    if option is None:
        pytest.skip("the drive's dictionary has no abort connection option (0x6007): its reaction is fixed")
    limits = rating(bench_session)
    speed = 0.5 * limits.omega_m_rad_s
    longest_s = 0.2 + 40.0 / number(bench_session, "omega_observer", 100.0)
    before = int(drive.number(option))
    try:
        drive.write(option, _QUICK_STOP)
        drive.connect()
        timeout_s = (int(drive.number(Role.CONSUMER_HEARTBEAT)) & 0xFFFF) / 1000.0
        with drive.enabled(Mode.VELOCITY):
            drive.write("omega_m_command", speed)
            drive.wait(1.0)
            reached = drive.number("omega_m")
            capture = armed(bench_session, timeout_s + 2.0 * longest_s, _CHANNELS)
            drive.link.send_heartbeat()
            last_s = clock.now_s()
            drive.stop_heartbeat()
            quiet(bench_session, timeout_s + 2.0 * longest_s)
            emergencies = [each.code for each in drive.emergencies() if each.code]
            state, link = drive.state(), drive.read("link_state")
            block = capture.read()
    finally:
        drive.release()
        drive.write(option, before)
        drive.reset_fault()
        drive.emergencies()
    last_tick = drive.tick_at(last_s)
    assert last_tick is not None
    attach.picture(
        "quick_stop_on_loss",
        lambda: draw_traces(
            block,
            (("omega_m",), ("torque",)),
            "Quick stop on a lost link",
            {"last heartbeat": (last_tick - block.first_tick) * block.tick_s},
        ),
    )
    time_s, omega = times_s(block, last_tick), block.column("omega_m")
    fast = time_s[np.abs(omega) > 0.03 * speed]
    braking = block.column("torque")[(time_s > 0.5 * timeout_s) & (time_s < timeout_s + 0.1 * longest_s)]
    measure("speed_before", reached / speed, "", min=0.97, max=1.03)
    latest_s = 1.02 * timeout_s + 0.005 + longest_s
    measure("time_to_standstill", float(fast[-1]) if len(fast) else None, "s", min=0.0, max=latest_s)
    measure("braking_torque", -float(braking.min()) / limits.T_N_Nm, "T_N", min=0.005, max=1.3)
    measure("turned_back", -float(omega.min()) / speed, "", max=0.05)
    measure("link_loss_seen", link == "lost", min=1)
    measure("emergencies", len(emergencies), min=1, max=1)
    measure("emergency_code", emergencies[0] if emergencies else None, min=0x8130, max=0x8130)
    measure("off_at_standstill", state is State.SWITCH_ON_DISABLED, min=1)
    measure("switched_after_standstill", _switched_after(block, last_tick, latest_s), max=0)


@pytest.mark.requirement("ACC-WATCHDOG")
def test_no_start_without_a_host(bench_session: Session, measure: Measure) -> None:
    """A drive that is to watch a host does not start before it has heard one."""
    drive = bench_session.drive
    if Role.CONSUMER_HEARTBEAT not in drive.dictionary:
        pytest.skip("the drive's dictionary has no supervision of the host")
    drive.write(Role.CONSUMER_HEARTBEAT, _HOST << 16 | 500)
    started = starts(bench_session)
    drive.write(Role.CONSUMER_HEARTBEAT, 0)
    drive.emergencies()
    measure("started_without_a_host", started, max=0)


@pytest.mark.requirement("ACC-STOP")
@pytest.mark.parametrize("how", ["disable", "nmt_stop"])
def test_torque_off(bench_session: Session, measure: Measure, how: str) -> None:
    """Disabling, and NMT stop, take the torque away at once."""
    require_objects(bench_session, *_CHANNELS)
    drive = bench_session.drive
    limits = rating(bench_session)
    with making_torque(bench_session, 0.4 * limits.torque_Nm, 0.3 * limits.omega_m_rad_s):
        capture = armed(bench_session, 0.2, _CHANNELS)
        quiet(bench_session, 0.05)
        told = drive.tick_now()
        if how == "disable":
            drive.disable()
        else:
            drive.link.nmt(NmtCommand.STOP)
            quiet(bench_session, 0.02)
            drive.link.nmt(NmtCommand.START)
        quiet(bench_session, 0.2)
        block = capture.read()
        state = drive.state()
    assert told is not None
    off_s = torque_ends_s(block, _OF_RATED * limits.T_N_Nm, told)
    measure("time_to_no_torque", off_s, "s", min=-0.002, max=0.02)
    measure("power_stage_on", state.power_stage_on, max=0)
    measure("switched_afterwards", _switched_after(block, told, 0.03), max=0)


@pytest.mark.requirement("ACC-STOP")
@pytest.mark.parametrize("direction", [1.0, -1.0], ids=["forward", "backward"])
def test_quick_stop(bench_session: Session, measure: Measure, attach: Attach, direction: float) -> None:
    """Quick stop brakes to standstill within the torque limit, and does not turn back."""
    require_objects(bench_session, "omega_m_command", *_CHANNELS)
    drive = bench_session.drive
    limits = rating(bench_session)
    speed = direction * 0.6 * limits.omega_m_rad_s
    word = drive.dictionary[Role.CONTROLWORD]
    longest_s = 0.2 + 40.0 / number(bench_session, "omega_observer", 100.0)
    with drive.enabled(Mode.VELOCITY):
        drive.write("omega_m_command", speed)
        drive.wait(1.0)
        reached = drive.number("omega_m")
        capture = armed(bench_session, 2.0 * longest_s, _CHANNELS)
        quiet(bench_session, 0.02)
        told = drive.tick_now()
        drive.link.download(word.index, word.sub, word.encode(0x0002))
        during = drive.state()
        quiet(bench_session, 2.0 * longest_s)
        after, block = drive.state(), capture.read()
    assert told is not None
    time_s, omega = times_s(block, told), direction * block.column("omega_m")
    fast = time_s[np.abs(omega) > 0.03 * abs(speed)]
    attach.picture(
        "quick_stop",
        lambda: draw_traces(
            block,
            (("omega_m",), ("torque",)),
            "Quick stop",
            {"told": (told - block.first_tick) * block.tick_s},
        ),
    )
    measure("speed_before", reached / speed, "", min=0.97, max=1.03)
    measure("time_to_standstill", float(fast[-1]) if len(fast) else None, "s", min=0.0, max=longest_s)
    measure("turned_back", -float(omega.min()) / abs(speed), "", max=0.05)
    braking = direction * block.column("torque")[(time_s > 0.0) & (time_s < 0.1 * longest_s)]
    measure("braking_torque", -float(braking.min()) / limits.T_N_Nm, "T_N", min=0.005, max=1.3)
    known = during in (State.QUICK_STOP_ACTIVE, State.SWITCH_ON_DISABLED)
    measure("state_known", known and after in (State.QUICK_STOP_ACTIVE, State.SWITCH_ON_DISABLED), min=1)
    holds = number(bench_session, "quick_stop_option", 2.0) in (5.0, 6.0)
    if not holds:
        measure("off_at_standstill", after is State.SWITCH_ON_DISABLED, min=1)


@pytest.mark.requirement("ACC-STOP")
def test_halt(bench_session: Session, measure: Measure) -> None:
    """Halt brings the shaft to rest and holds it, and ends with its bit."""
    require_objects(bench_session, "omega_m_command", "omega_m")
    drive = bench_session.drive
    limits = rating(bench_session)
    speed = 0.4 * limits.omega_m_rad_s
    word = drive.dictionary[Role.CONTROLWORD]
    with drive.enabled(Mode.VELOCITY):
        drive.write("omega_m_command", speed)
        drive.wait(1.0)
        drive.link.download(word.index, word.sub, word.encode(0x010F))
        drive.wait(1.0)
        halted, state = drive.number("omega_m") / speed, drive.state()
        drive.link.download(word.index, word.sub, word.encode(0x000F))
        drive.wait(1.0)
        again = drive.number("omega_m") / speed
    measure("speed_in_halt", halted, "", min=-0.03, max=0.03)
    measure("enabled_in_halt", state is State.OPERATION_ENABLED, min=1)
    measure("speed_after_halt", again, "", min=0.97, max=1.03)


def _switched_after(block: Block, tick: int, after_s: float) -> float:
    """Return how often the power stage switched later than some time after a tick."""
    count = block.column("switching_count")[times_s(block, tick) > after_s]
    return float(count[-1] - count[0]) if len(count) else float("nan")
