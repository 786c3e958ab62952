"""One fault at one moment: a bench of its own, a host, and what can be seen from outside of both."""

from __future__ import annotations

import os
import random
import re
import struct
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Final

import numpy as np

from benchmarks.faults.host import host_of
from benchtool.block import Block
from benchtool.drive import RemoteDrive
from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.faults import FAULTS, Fault, Outcome, Place, parse_fault
from benchtool.errors import BenchError, DictionaryMismatch
from benchtool.profile import Limits, Profile, altered, load_profile
from benchtool.protocol import Mode, State
from benchtool.protocol.canopen import NmtCommand
from benchtool.run.parameter_check import check_parameters
from benchtool.telemetry import LimitSupervision, Sink, StreamReport, TelemetryStream

WATCHDOG_S: Final = 0.1
OMEGA_RAD_S: Final = 50.0
FRICTION_NMS: Final = 0.04  # a load of 2 Nm at that speed, which cannot drive the shaft
OF_RATED: Final = 0.05
NAMED_WITHIN_S: Final = 1.0

_RUN_UP_S: Final = 0.4
_LATEST_S: Final = 0.1  # of the random moment
_AFTER_S: Final = 1.1
_LIMITS: Final = Limits(torque_Nm=6.0, current_sum_A=0.5, current_unbalance_percent=30.0, omega_m_rad_s=100.0)
_EXPECTED: Final = {
    "cable_pulled": "nothing was heard|did not answer",
    "bus_off": "nothing was heard|did not answer|0x8140",
    "duplicate_node": "restarted while it was enabled",
    "babbling_node": "nothing was heard|did not answer",
    "host_frozen": "0x8130",
    "host_killed": "0x8130",
    "drive_reset": "restarted while it was enabled",
    "drive_hung": "0x6010|restarted|nothing was heard",
    "other_firmware": "restarted while it was enabled",
    "encoder_loss": "0x7305",
    "encoder_offset": "limit is|0x2310",
    "encoder_slip": "limit is|0x2310",
    "phase_open": "unbalance of the phase currents",
    "phases_swapped": "limit is|0x2310|0x8400",
    "current_gain": "i_a . i_b . i_c is",
    "current_offset": "i_a . i_b . i_c is",
    "current_stuck": "i_a . i_b . i_c is|0x2310",
    "dc_link_sag": "0x3220",
    "dc_link_overvoltage": "0x3210",
    "overcurrent": "0x2310",
    "overspeed": "0x8400|0x2310",
    "overtemperature": "0x4310",
}
"""What the host is to say of a fault, as a pattern."""

_LOST_ANSWER: Final = "did not answer|out of protocol|0x8130"
"""What may end the work on a wire that loses frames: a write whose answer is lost is not repeated, and
heartbeats that are lost in a row are a lost link."""


@dataclass
class Outcomes:
    """What one trial has shown; times in s of the drive's ticks, None where there is nothing to time."""

    fault: str
    wire: str
    seed: int
    stopped_s: float | None = None
    """From the last valid command, or from the fault of a drive that was heard, to torque below 5 %."""
    latched: bool | None = None
    said: str = ""
    named_s: float | None = None
    recorded: bool = False
    next_session: bool = False
    once: bool = False
    tidy: bool = False
    remarks: list[str] = field(default_factory=list)


@cache
def profile() -> Profile:
    """Return the machine of the paper with a passive load and limits of the host."""
    return altered(load_profile("zhu2011"), {"motor.friction_Nms": FRICTION_NMS}).model_copy(
        update={"limits": _LIMITS}
    )


def run_trial(spelled: str, wire: str, seed: int) -> Outcomes:
    """Run the drive, have it fail at a moment drawn with `seed`, and judge what follows."""
    fault = parse_fault(spelled)
    threads, files = _threads(), _files()
    outcomes = Outcomes(fault.kind.name, wire, seed)
    bench = EmulatedBench(profile(), seed=seed, has_bus=wire == "can")
    try:
        _Trial(bench, wire, replace(fault, at_s=random.Random(seed).uniform(0.0, _LATEST_S)), outcomes).run()
    finally:
        bench.close()
    outcomes.tidy = _threads() == threads and _files() == files
    return outcomes


def applies(name: str, wire: str) -> bool:
    """Return whether a fault is one of this wire."""
    return wire == "can" or not FAULTS[name].can_only


class _Trial:
    def __init__(self, bench: EmulatedBench, wire: str, fault: Fault, outcomes: Outcomes) -> None:
        self._bench, self._wire, self._fault, self._outcomes = bench, wire, fault, outcomes
        self._node: Any = bench._node
        self._T_s = self._node.firmware.period_s
        self._sent: dict[int, bytes] = {}
        self._rows: list[Block] = []
        self._fed: list[int] = []
        self._enables = 0
        self._log()

    def run(self) -> None:
        bench, outcomes, clock = self._bench, self._outcomes, self._bench.clock
        drive = host_of(self._bench, self._wire)
        drive.supervisor = LimitSupervision(drive, _LIMITS)
        report = None
        failure: BenchError | None = None
        begin = end = 0
        try:
            with drive:
                drive.connect()
                drive.supervise(WATCHDOG_S)
                sinks = [Sink("kept", self._rows.append, lossless=True)]
                stream = TelemetryStream(drive, sinks)
                try:
                    with (
                        stream,
                        drive.watched(stream.check),
                        drive.enabled(Mode.VELOCITY),
                    ):
                        drive.write("omega_m_command", OMEGA_RAD_S)
                        drive.wait(_RUN_UP_S)
                        bench.transducer.start(_LATEST_S + _AFTER_S)
                        begin = self._node.tick + round(self._fault.at_s / self._T_s)
                        end = self._node.tick + round((_LATEST_S + _AFTER_S) / self._T_s)
                        bench.faults.inject(self._fault)
                        drive.wait(_LATEST_S + NAMED_WITHIN_S)
                except BenchError as reason:
                    failure, named_tick = reason, self._node.tick
                    outcomes.named_s = (named_tick - begin) * self._T_s
                finally:
                    report = stream.report()
        except BenchError as reason:
            failure = failure or reason
        outcomes.said = "" if failure is None else str(failure)
        clock.wait(max(0.0, (end + 2 - self._node.tick) * self._T_s))
        self._judge_torque(begin)
        self._judge_name(drive, failure)
        self._judge_record(report)
        drive.close_link()
        self._judge_next_session()

    # ---- what the drive does, seen from within -------------------------------------------------------------

    def _log(self) -> None:
        """Note what is sent, which commands arrive, and how often the power stage goes on."""
        node, firmware = self._node, self._node.firmware
        feed, enter, process_data = firmware.feed_link, firmware._enter, node._send_process_data

        def fed() -> None:
            self._fed.append(node.tick)
            feed()

        def entered(state: State) -> None:
            self._enables += state is State.OPERATION_ENABLED
            enter(state)

        def sent(can_id: int, data: bytes) -> None:
            self._sent[node.tick] = self._sent.get(node.tick, b"") + data
            process_data(can_id, data)

        firmware.feed_link, firmware._enter = fed, entered
        node._pdos._send = sent
        add = node.add

        def added(server: Any, *rest: Any) -> None:
            if hasattr(server, "_stream"):
                self._log_batches(server)
            add(server, *rest)

        node.add = added

    def _log_batches(self, server: Any) -> None:
        send: Callable[[Any], bool] = server._stream._send

        def sent(batch: Any) -> bool:
            size = len(batch.data) // batch.n
            for row in range(batch.n):
                tick = batch.first_tick + row * batch.stride
                self._sent[tick] = batch.data[row * size : (row + 1) * size]
            return send(batch)

        server._stream._send = sent

    # ---- judgements ----------------------------------------------------------------------------------------

    def _judge_torque(self, begin: int) -> None:
        block = self._bench.transducer.block()
        torque = np.abs(np.asarray(block.data)[:, -1])
        per_tick = self._bench.transducer._core.transducer.samples_per_tick
        first = block.first_tick // per_tick
        threshold = OF_RATED * profile().motor.T_N_Nm
        above = np.nonzero(torque > threshold)[0]
        last = first + int(above[-1]) // per_tick + 1 if len(above) else first
        running = self._node.firmware.state.power_stage_on
        outcomes = self._outcomes
        if self._fault.kind.outcome is Outcome.GOES_ON:
            return
        end = first + len(torque) // per_tick
        outcomes.latched = not running and last < end - 1
        if not outcomes.latched:
            outcomes.remarks.append(f"power stage on: {running}, torque until {last} of {end}")
            return
        since = begin
        if self._fault.kind.place in (Place.WIRE, Place.HOST) and self._fault.kind.outcome is Outcome.STOPS:
            since = max((tick for tick in self._fed if tick <= max(begin, last - 1)), default=begin)
        outcomes.stopped_s = max(0, last - since) * self._T_s

    def _judge_name(self, drive: RemoteDrive, failure: BenchError | None) -> None:
        outcomes, name = self._outcomes, self._fault.kind.name
        if name == "wrong_parameter":
            check = check_parameters(drive, profile(), {})
            lines = [f"{each}" for each in check.contradicted]
            outcomes.said = "; ".join(lines)
            return
        pattern = _EXPECTED.get(name)
        if pattern is None:  # the work goes on
            if failure is not None and not re.search(_LOST_ANSWER, str(failure)):
                outcomes.remarks.append(f"ended: {failure}")
            return
        if failure is None or not re.search(pattern, str(failure)):
            outcomes.remarks.append(f"said: '{failure}', expected: {pattern}")
            outcomes.named_s = None

    def _judge_record(self, report: StreamReport | None) -> None:
        """Every row is one that the drive sent in that tick, none is there twice, and the rest is a gap."""
        outcomes = self._outcomes
        seen: set[int] = set()
        for block in self._rows:
            for tick, row in zip(block.ticks().tolist(), block.data, strict=True):
                sent = self._sent.get(tick, b"")
                if tick in seen or not all(_holds(sent, value) for value in row.tolist()):
                    outcomes.remarks.append(f"the row of tick {tick} is not what was sent")
                    return
                seen.add(tick)
        if report is None or not seen:
            outcomes.remarks.append("nothing was recorded")
            return
        stride = self._rows[0].stride
        missing = sum(gap.missing_rows for gap in report.gaps)
        expected = (max(seen) - min(seen)) // stride + 1
        outcomes.recorded = len(seen) + missing == expected
        if not outcomes.recorded:
            outcomes.remarks.append(f"{len(seen)} rows and {missing} missing, {expected} expected")

    def _judge_next_session(self) -> None:
        """After the fault, a host finds the drive without a power cycle; commands have acted once."""
        bench, outcomes = self._bench, self._outcomes
        if self._fault.kind.name == "other_firmware":
            other = host_of(self._bench, self._wire)
            with suppress(DictionaryMismatch):
                other.check()
                outcomes.remarks.append("another dictionary was taken")
            other.close_link()
        bench.faults.end()
        bench.clock.wait(2.0 * WATCHDOG_S)
        enables = self._enables
        drive = host_of(self._bench, self._wire)
        bench.clock.wait(0.2)  # its heartbeat is heard
        try:
            with drive:
                if drive.is_stopped:  # as `benchtool reset` does it, which the host has told of
                    drive.link.nmt(NmtCommand.START)
                drive.connect()
                if drive.state() in (State.FAULT, State.FAULT_REACTION_ACTIVE):
                    drive.reset_fault()
                with drive.enabled(Mode.VELOCITY):
                    drive.write("omega_m_command", 20.0)
                    drive.wait(0.4)
                    speed = abs(drive.number("omega_m"))
            outcomes.next_session = abs(speed - 20.0) < 3.0
            if not outcomes.next_session:
                outcomes.remarks.append(f"the next session runs at {speed:.1f} rad/s")
        except BenchError as failed:
            outcomes.remarks.append(f"next session: {failed}")
        finally:
            drive.close_link()
        outcomes.once = enables == 1 and self._enables == 2
        if not outcomes.once:
            outcomes.remarks.append(f"enabled {enables} and {self._enables} times")


def _holds(sent: bytes, value: float) -> bool:
    """Return whether the bytes of a tick hold a value, of whichever type of four bytes it was."""
    if struct.pack("<f", value) in sent:
        return True
    return value >= 0.0 and value == int(value) and struct.pack("<L", int(value)) in sent


def _threads() -> int:
    return threading.active_count()


def _files() -> int:
    return len(os.listdir("/proc/self/fd"))
