"""Play a stimulus on the drive: checked against the rating, timed by the drive, and captured."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

from benchtool.block import Block, Channel
from benchtool.drive.capabilities import Capability
from benchtool.drive.capture import Capture, CaptureRequest
from benchtool.drive.remote import RemoteDrive
from benchtool.drive.stimulus import Stimulus
from benchtool.errors import BenchError, StimulusError, ValueRefused
from benchtool.profile import Motor
from benchtool.protocol.dictionary import Role

_POLL_S = 0.01
_SLACK_S = 1.0


def play(
    drive: RemoteDrive, stimulus: Stimulus, request: CaptureRequest | None = None, *, motor: Motor
) -> Block | None:
    """Play a stimulus on a drive that is enabled in one of its modes; return when it has ended.

    Args:
        drive: connected, operation enabled.
        stimulus: what to play.
        request: what to capture meanwhile; unless it names another trigger, row `pretrigger_rows` is that of
            the tick in which the stimulus begins.
        motor: whose rating it must stay within.

    Returns:
        The captured rows, channel `stimulus` in the unit of its quantity; None without a request.

    Raises:
        CapabilityMissing: the drive has no stimulus.
        ValueRefused: beyond the rating, or the drive is in another mode; nothing was written.
        SdoAbort: the drive refuses it.
        StimulusError: it was stopped before its end.
        DriveFault, CaptureError: as `Capture.wait` and `Capture.read`.
    """
    drive.capabilities.require(Capability.STIMULUS, purpose="playing a stimulus")
    stimulus.require_rated(motor)
    _require_within_limits(drive, stimulus, motor)
    _require_mode(drive, stimulus)
    period_s = drive.number("control_period")
    for name, value in stimulus.table(period_s).items():
        drive.write(name, value)
    capture = None
    if request is not None:
        capture = Capture(
            drive, replace(request, trigger="stimulus") if request.trigger == "immediate" else request
        )
        drive.wait(request.pretrigger_rows * request.stride * period_s)
    end_s = drive.clock.now_s() + stimulus.ticks(period_s) * stimulus.repetitions * period_s
    drive.write("stimulus_control", "start")
    try:
        if capture is not None:
            capture.wait()
        drive.wait(end_s - drive.clock.now_s())
        _wait_for_the_end(drive)
    except BaseException:
        with suppress(BenchError):  # the failure that is under way is the one to report
            drive.write("stimulus_control", "stop")
        raise
    return None if capture is None else _with_unit(capture.read(), stimulus.unit)


def _require_within_limits(drive: RemoteDrive, stimulus: Stimulus, motor: Motor) -> None:
    """Check against what the drive has in force, which takes reads."""
    match stimulus.quantity:
        case "torque":
            stimulus.require_within(drive.number("torque_limit"), "the drive's torque_limit")
        case "speed":
            setpoint = abs(drive.number("omega_m_command"))
            stimulus.require_within(motor.omega_m_N_rad_s - setpoint, "the rated speed less the setpoint")
        case "d_current" | "current":
            stimulus.require_within(drive.number("i_trip"), "the drive's i_trip")
        case "voltage":
            drive.wait(_POLL_S)  # for a measurement with the power stage on
            stimulus.require_within(drive.number("u_dc") / math.sqrt(3.0), "the drive's u_dc / sqrt(3)")


def _require_mode(drive: RemoteDrive, stimulus: Stimulus) -> None:
    mode = int(drive.number(Role.MODE_OF_OPERATION_DISPLAY))
    if mode not in stimulus.modes:
        names = " or ".join(each.name.lower() for each in stimulus.modes)
        raise ValueRefused(
            f"the drive is in mode {mode}, a {stimulus.quantity} stimulus plays in {names} mode: "
            f"enable that mode; nothing was written"
        )


def _wait_for_the_end(drive: RemoteDrive) -> None:
    waited_s = 0.0
    while (state := drive.read("stimulus_state")) != "done":
        if state != "running" or waited_s > _SLACK_S:
            raise StimulusError(
                f"the stimulus is {state!r}, 'done' was expected: another master, a change of mode or the "
                f"power stage going off stopped it; enable the drive and play it again"
            )
        drive.wait(_POLL_S)
        waited_s += _POLL_S


def _with_unit(block: Block, unit: str) -> Block:
    channels = (Channel(each.name, unit) if each.name == "stimulus" else each for each in block.channels)
    return replace(block, channels=tuple(channels))
