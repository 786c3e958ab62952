"""A long run of commands, streams, captures, faults and reconnections on one emulated drive a wire.

python -m benchmarks.soak --minutes 30 --json      of the wall clock; drive time passes several times as fast

Each round is a session on the drive that the rounds before have left: random setpoints with a stream, then a
capture, or a fault at a random moment. What must hold: every record is there or reported missing, nothing is
there twice, the drive is disabled after every round and works in the next one, and memory, threads and files
stay as they are after the first rounds. Exit code 1 if something does not.
"""

from __future__ import annotations

import argparse
import gc
import os
import random
import sys
import threading
import time
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field

from benchmarks.faults.host import host_of
from benchmarks.figures import print_figures
from benchtool.block import Block
from benchtool.drive import Capture, CaptureRequest, RemoteDrive
from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.faults import FAULTS
from benchtool.errors import BenchError
from benchtool.profile import altered, load_profile
from benchtool.protocol import Mode, State
from benchtool.protocol.canopen import NmtCommand
from benchtool.telemetry import Sink, TelemetryStream

_WIRES = ("can", "serial")
_NEVER = ("phase_open", "phases_swapped", "wrong_parameter", "encoder_offset", "encoder_slip", "overspeed")
_WARM_ROUNDS = 20
_MORE_MB = 30.0


@dataclass
class Account:
    """What has happened so far, and what did not hold."""

    rounds: int = 0
    drive_s: float = 0.0
    records: int = 0
    missing: int = 0
    captures: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    ended: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)


class Soak:
    """The rounds on one wire; its drive is never switched off."""

    def __init__(self, wire: str, seed: int, account: Account) -> None:
        profile = altered(load_profile("zhu2011"), {"motor.friction_Nms": 0.04})
        self._wire, self._draw, self._account = wire, random.Random(f"{seed} {wire}"), account
        self._bench = EmulatedBench(profile, seed=seed, has_bus=wire == "can")
        can = wire == "can"
        self._faults = [
            name for name, kind in FAULTS.items() if name not in _NEVER and (can or not kind.can_only)
        ]

    def close(self) -> None:
        """Switch the drive off."""
        self._bench.close()

    def round(self) -> None:
        """Run one session, with a fault in every second one."""
        account, begin_s = self._account, self._bench.clock.now_s()
        fault = self._draw.choice(self._faults) if self._draw.random() < 0.5 else ""
        rows: list[Block] = []
        drive, stream = host_of(self._bench, self._wire), None
        self._bench.clock.wait(0.15)  # a heartbeat is heard
        try:
            with drive:
                if drive.is_stopped:
                    drive.link.nmt(NmtCommand.START)
                drive.connect()
                if drive.state() is State.FAULT:
                    drive.reset_fault()
                stream = TelemetryStream(drive, [Sink("kept", rows.append, lossless=True)])
                with stream, drive.watched(stream.check), drive.enabled(Mode.VELOCITY):
                    self._command(drive, fault)
                if not fault:
                    self._capture(drive)
        except BenchError as reason:
            account.ended[type(reason).__name__] += 1
            if not fault:
                account.wrong.append(f"{self._wire}, no fault: {reason}")
        finally:
            drive.close_link()
        self._bench.faults.end()
        self._bench.clock.wait(0.7)  # a lost host is noticed
        if self._bench.enabled:
            account.wrong.append(f"{self._wire}, {fault}: the drive is enabled after the session")
        self._count(rows, stream, fault)
        account.rounds += 1
        account.drive_s += self._bench.clock.now_s() - begin_s

    def _command(self, drive: RemoteDrive, fault: str) -> None:
        if fault:
            self._account.faults[fault] += 1
            self._bench.faults.inject(f"{fault}@{self._draw.uniform(0.0, 0.5):.4f}")
        for _ in range(self._draw.randint(1, 5)):
            drive.write("omega_m_command", self._draw.uniform(-40.0, 40.0))
            drive.wait(self._draw.uniform(0.02, 0.4))

    def _capture(self, drive: RemoteDrive) -> None:
        armed = Capture(drive, CaptureRequest(("i_a", "torque"), rows=1000, stride=1))
        armed.wait()
        block = armed.read()
        self._account.captures += 1
        if len(block.data) != 1000 or block.gaps:
            self._account.wrong.append(f"{self._wire}: a capture of {len(block.data)} rows")

    def _count(self, rows: list[Block], stream: TelemetryStream | None, fault: str) -> None:
        if not rows or stream is None:
            return
        account, report = self._account, stream.report()
        ticks = [tick for block in rows for tick in block.ticks().tolist()]
        missing = sum(gap.missing_rows for gap in report.gaps)
        expected = (ticks[-1] - ticks[0]) // rows[0].stride + 1
        if len(ticks) + missing != expected or len(set(ticks)) != len(ticks) or ticks != sorted(ticks):
            account.wrong.append(
                f"{self._wire}, {fault}: {len(ticks)} records, {missing} missing of {expected}"
            )
        account.records += len(ticks)
        account.missing += missing


def memory_MB() -> float:
    """Return the resident memory of this process."""
    with open("/proc/self/statm", encoding="ascii") as statm:
        return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def soak(duration_s: float, seed: int = 0, *, most_rounds: int | None = None) -> dict[str, object]:
    """Run for so long of the wall clock, or so many rounds; return the account."""
    account, end_s = Account(), time.monotonic() + duration_s
    drives = [Soak(wire, seed, account) for wire in _WIRES]
    warm: tuple[int, int, float] | None = None
    now = (0, 0, 0.0)
    try:
        while time.monotonic() < end_s and (most_rounds is None or account.rounds < most_rounds):
            for each in drives:
                each.round()
            gc.collect()
            now = threading.active_count(), len(os.listdir("/proc/self/fd")), memory_MB()
            if account.rounds == _WARM_ROUNDS:
                warm = now
    finally:
        for each in drives:
            with suppress(BenchError):
                each.close()
    before = warm or now
    if now[:2] != before[:2]:
        account.wrong.append(f"threads and files {now[:2]}, {before[:2]} after the first rounds")
    if now[2] - before[2] > _MORE_MB:
        account.wrong.append(f"memory {now[2]:.0f} MB, {before[2]:.0f} MB after the first rounds")
    return {
        "rounds": account.rounds,
        "drive_s": round(account.drive_s, 1),
        "records": account.records,
        "records_missing": account.missing,
        "captures": account.captures,
        "faults": dict(sorted(account.faults.items())),
        "ended_by": dict(sorted(account.ended.items())),
        "threads": now[0],
        "files": now[1],
        "memory_MB": round(now[2], 1),
        "memory_after_first_rounds_MB": round(before[2], 1),
        "wrong": account.wrong[:20],
    }


def main() -> int:
    """Run, print, and exit with 1 if something did not hold."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0, help="of the wall clock")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    given = parser.parse_args()
    figures = soak(given.minutes * 60.0, given.seed)
    print_figures(figures, as_json=given.json)
    return 1 if figures["wrong"] else 0


if __name__ == "__main__":
    sys.exit(main())
