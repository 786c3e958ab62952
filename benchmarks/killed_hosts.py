"""Hosts that end without a word: `python -m benchmarks.killed_hosts [--trials 20] [--json]`.

An emulated drive runs in a process of its own, in real time. A host in another process has it turn the shaft,
over either wire, and ends at a random moment:

    killed    kill -9 of a Python process with an open bench, such as the kernel of a notebook
    terminal  the terminal of `benchtool jog` is closed, so that the system sends SIGHUP
    shell     the terminal of `benchtool shell` is closed
    logout    SIGTERM and SIGHUP to all processes of a session, as a logout sends them, to a script

A third process's view, on the other wire, is what counts: how long after the end the power stage is off
without current, and that the next session works without a power cycle. Exit code 1 if one did not.
"""

from __future__ import annotations

import argparse
import os
import pty
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from benchmarks.figures import print_figures
from benchmarks.killed_commissioning import SLACK_S, TIMEOUT_S, served, time_to_zero_s
from benchtool.bench import Session, open_session
from benchtool.drive import RemoteDrive
from benchtool.errors import BenchError
from benchtool.profile import profile_path
from benchtool.protocol import State

_SPEED: Final = 20.0
_PATIENCE_S: Final = 60.0
_OPEN: Final = (
    "import time, benchtool\n"
    "bench = benchtool.open_bench('zhu2011', {link!r})\n"
    "running = bench.drive.enable('velocity')\n"
    "running.omega_m_command = {speed}\n"
)
_SCRIPT: Final = (
    "import time, benchtool\n"
    "with benchtool.open_bench('zhu2011', {link!r}) as bench, bench.drive.enabled('velocity') as running:\n"
    "    running.omega_m_command = {speed}\n"
    "    bench.wait(600.0)\n"
)
_LOG_IN: Final = "import os, sys; os.login_tty(0); os.execv(sys.argv[1], sys.argv[1:])"


@dataclass
class Host:
    """A process that has a drive enabled, and how it is ended."""

    process: subprocess.Popen[bytes]
    end: Callable[[], None]


def _python(link: str, text: str) -> subprocess.Popen[bytes]:
    code = text.format(link=link, speed=_SPEED)
    return subprocess.Popen(
        (sys.executable, "-c", code),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _killed(link: str) -> Host:
    process = _python(link, _OPEN + "time.sleep(600.0)\n")
    return Host(process, process.kill)


def _logout(link: str) -> Host:
    process = _python(link, _SCRIPT)

    def end() -> None:
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGCONT):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, number)

    return Host(process, end)


def _at_a_terminal(*command: str, typed: str = "") -> Host:
    """Run a command whose controlling terminal is a pseudo-terminal, which ends by being closed."""
    master, slave = pty.openpty()
    process = subprocess.Popen(
        (sys.executable, "-c", _LOG_IN, sys.executable, "-m", "benchtool", *command),
        stdin=slave,
        stdout=slave,
        stderr=slave,
    )
    os.close(slave)
    if typed:
        os.write(master, typed.encode())
    return Host(process, lambda: os.close(master))


def _terminal(link: str) -> Host:
    return _at_a_terminal("jog", "--speed", f"{_SPEED}", "--duration", "600", "--link", link)


def _shell(link: str) -> Host:
    typed = f"running = drive.enable('velocity')\nrunning.omega_m_command = {_SPEED}\n"
    return _at_a_terminal("shell", "--link", link, typed=typed)


WAYS: Final[dict[str, Callable[[str], Host]]] = {
    "killed": _killed,
    "terminal": _terminal,
    "shell": _shell,
    "logout": _logout,
}


def trial(way: str, link: str, watching: Session, rng: random.Random) -> tuple[float, bool]:
    """Return the drive's time from the end of a host until no current flows, and whether it stays disabled
    and can be used again."""
    drive = watching.drive
    with suppress(BenchError):
        drive.reset_fault()
    drive.emergencies()
    host = WAYS[way](link)
    try:
        _wait_until_it_turns(drive, host.process)
        drive.clock.wait(rng.uniform(0.0, 0.5))
        host.end()
        zero_s = time_to_zero_s(drive)
        host.process.wait(_PATIENCE_S)
    finally:
        host.process.kill()
        host.process.wait()
    drive.clock.wait(0.3)
    off = not drive.state().power_stage_on
    with suppress(BenchError):
        drive.reset_fault()
    return zero_s, off and drive.state() is not State.FAULT


def _wait_until_it_turns(drive: RemoteDrive, process: subprocess.Popen[bytes]) -> None:
    begin_s = drive.clock.now_s()
    while not (drive.state().power_stage_on and drive.number("omega_m") > 0.8 * _SPEED):
        if process.poll() is not None or drive.clock.now_s() - begin_s > _PATIENCE_S:
            raise SystemExit(f"the host did not turn the shaft, exit code {process.poll()}: try it by hand")
        drive.clock.wait(0.05)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20, help="of each way, on both wires together")
    parser.add_argument("--way", action="append", choices=list(WAYS), help="only this; may be repeated")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    rng = random.Random(asked.seed)
    figures: dict[str, object] = {}
    good = True
    with served(profile_path("zhu2011")) as links:
        for way in asked.way or list(WAYS):
            found: list[tuple[float, bool]] = []
            for number in range(asked.trials):
                own, other = ("serial", "slcan") if number % 2 else ("slcan", "serial")
                with open_session("zhu2011", links[other]) as watching:
                    found.append(trial(way, links[own], watching, rng))
                print(f"{way} over {own}: off in {found[-1][0]:.3f} s", file=sys.stderr, flush=True)
            in_time = sum(zero_s <= TIMEOUT_S + SLACK_S and well for zero_s, well in found)
            figures[way] = {
                "trials": len(found),
                "disabled_in_time": in_time,
                "longest_to_zero_s": round(max(zero_s for zero_s, _ in found), 3),
            }
            good = good and in_time == len(found)
    print_figures(figures, as_json=asked.json)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
