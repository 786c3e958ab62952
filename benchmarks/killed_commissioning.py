"""A commissioning killed at random moments: `python -m benchmarks.killed_commissioning [--json]`.

An emulated drive runs in a process of its own, in real time, beside what commissions it: a process that is
ended by SIGKILL, two thirds of the times at a moment that is uniform from its first write on, else within
the second in which it writes, stores and reads back. A third process's view, on another wire, is what counts:
how long after the kill the power stage is off without current, and whether the drive holds all of its old
parameters or all of the new ones, in force then and after a reset.

With --virtual nothing is killed: the host sends no frame from a random moment of virtual time on, or from a
random write on. That is as quick as the emulated drive, and does not depend on what else the machine does.
"""

from __future__ import annotations

import argparse
import itertools
import json
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from benchmarks.figures import print_figures
from benchtool.bench import open_session
from benchtool.commission import commission, steps_for
from benchtool.drive import RemoteDrive
from benchtool.drive.parameters import reset, snapshot, store, write_all
from benchtool.errors import BenchError, NoAnswer
from benchtool.protocol.dictionary import variable_of
from benchtool.shipped import shipped

TIMEOUT_S: Final = 0.5
"""What a host arms the drive's supervision with."""

POLL_S: Final = 0.01
SLACK_S: Final = 0.1  # of heartbeats, polling and a busy machine
NO_CURRENT: Final = 0.05  # A, of the vector: two steps of the converter
WHOLE_S: Final = 16.0
"""About what the steps resistance and those that it needs take of drive time."""

BEGINS: Final = "in force what the profile states"
SAVES_S: Final = 1.0
SAVING: Final = "storing the parameters"
COMMISSION: Final = ("-m", "benchtool", "commission", "--yes", "--save", "--json")


def boxed(folder: Path) -> Path:
    """Return a profile whose drive knows nothing of its motor, and whose nameplate is off."""
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    truth = "[emulator]\ncommissioned = false\n\n[emulator.motor]\n"
    for key, true, stated in (
        ("R_s_ohm", "0.123", "0.14"),
        ("L_d_H", "9.52e-3", "8e-3"),
        ("L_q_H", "9.52e-3", "8e-3"),
    ):
        text = text.replace(f"{key} = {true}", f"{key} = {stated}")
        truth += f"{key} = {true}\n"
    text = text.replace("omega_m_N_rad_s = 157.1", "omega_m_N_rad_s = 100.0")  # that its dc link allows
    path = folder / "boxed.toml"
    path.write_text(text.split("[[choices]]")[0].replace("[emulator.motor]\n", truth), encoding="utf-8")
    return path


@contextmanager
def served(profile: Path) -> Iterator[dict[str, str]]:
    """Run the emulated drive; yield the links of its two wires."""
    command = (sys.executable, "-m", "benchtool", "emulate", "--json", "--profile", str(profile))
    process = subprocess.Popen(
        (*command, "--tcp", "0", "--slcan-tcp", "0"), stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        wires = json.loads(process.stdout.readline())["wires"]
        yield {each["wire"]: each["link"] for each in wires if "socket:" in each["place"]}
    finally:
        process.terminate()
        process.wait()


def host(profile: Path, link: str, steps: list[str], out: Path) -> subprocess.Popen[str]:
    """Start a commissioning."""
    command = (
        sys.executable,
        *COMMISSION,
        *steps,
        "--profile",
        str(profile),
        "--link",
        link,
        "--out",
        str(out),
    )
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def until(process: subprocess.Popen[str], note: str) -> None:
    """Return when a commissioning says this."""
    assert process.stderr is not None
    for line in process.stderr:
        if note in line:
            return


def kill(
    process: subprocess.Popen[str], rng: random.Random, lasts_s: float, saves_s: float, *, saving: bool
) -> bool:
    """End a commissioning at a random moment. Returns whether it was still under way."""
    with suppress(subprocess.TimeoutExpired):
        until(process, SAVING if saving else BEGINS)
        process.wait(rng.uniform(0.0, saves_s if saving else lasts_s))
    alive = process.poll() is None
    process.kill()
    process.wait()
    if process.stderr is not None:
        process.stderr.close()
    return alive


def time_to_zero_s(drive: RemoteDrive) -> float:
    """Return the drive's time from now until the power stage is off and no current flows; infinity beyond
    5 s."""
    T_s, began = drive.number("control_period"), drive.number("tick")
    while (past_s := (drive.number("tick") - began) * T_s) < 5.0:
        off = not drive.state().power_stage_on
        if off and max(abs(drive.number(f"i_{phase}")) for phase in "abc") < NO_CURRENT:
            return past_s
        drive.clock.wait(POLL_S)
    return float("inf")


def of_one_kind(held: Mapping[str, Any], old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """Return whether parameters are the old ones, the new ones, or a mixture.

    New are those that a whole commissioning has stored, whatever the numbers that this one found.
    """
    if held == old:
        return "old"
    changed = [key for key in old if old[key] != new[key]]
    kept = [key for key in old if old[key] == new[key]]
    if all(held[key] != old[key] for key in changed) and all(held[key] == old[key] for key in kept):
        return "new"
    return "mixture"


class Dead(BaseException):
    """What ends a host that is killed: nothing of it runs any more."""


def silenced(
    profile: Path, steps: list[str], rng: random.Random, after: Mapping[str, Any]
) -> tuple[float, str, str]:
    """Run a commissioning in virtual time whose host falls silent at a random moment.

    Returns:
        The drive's time until no current flows, the kind of parameters in force, and after a reset.
    """
    with open_session(str(profile), "emulated", seed=rng.randrange(1000)) as session:
        drive, link = session.drive, session.drive.link
        drive.connect()
        before = snapshot(drive)
        ends_s = drive.clock.now_s() + rng.uniform(0.0, WHOLE_S)
        writes = rng.randrange(1, 400) if rng.random() < 0.5 else 10**9
        download, upload = link.download, link.upload

        def live() -> None:
            nonlocal writes
            if drive.clock.now_s() >= ends_s or writes <= 0:
                writes = 0
                drive.stop_heartbeat()
                raise Dead

        def downloading(index: int, sub: int, data: bytes, *, block: bool = False) -> None:
            nonlocal writes
            writes -= 1
            live()
            download(index, sub, data, block=block)

        def uploading(*arguments: Any, **options: Any) -> bytes:
            live()
            return upload(*arguments, **options)

        # a host that dies has no hook of its own: its link fails from a write on
        link.download, link.upload = downloading, uploading  # type: ignore[method-assign]
        try:
            with drive.watched(live):
                commission(drive, session.profile, steps_for(steps), keep=True)
        except Dead:
            pass
        finally:
            link.download, link.upload = download, upload  # type: ignore[method-assign]
        zero_s = time_to_zero_s(drive)
        drive.clock.wait(TIMEOUT_S + SLACK_S)
        held = snapshot(drive)
        reset(drive)
        return zero_s, of_one_kind(held, before, after), of_one_kind(snapshot(drive), before, after)


def commissioned(profile: Path, steps: list[str]) -> dict[str, Any]:
    """Return the parameters of a drive that a whole commissioning has left."""
    with open_session(str(profile), "emulated") as session:
        session.drive.connect()
        if not commission(session.drive, session.profile, steps_for(steps), keep=True).saved:
            raise SystemExit("the commissioning does not pass: run it by hand")
        return snapshot(session.drive)


def virtual(kills: int, steps: list[str], seed: int) -> dict[str, object]:
    """Return the figures of hosts that fall silent in virtual time."""
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        profile = boxed(Path(name))
        after = commissioned(profile, steps)
        found = [silenced(profile, steps, rng, after) for _ in range(kills)]
    kinds = [(in_force, kept) for _, in_force, kept in found]
    return counted([zero_s for zero_s, _, _ in found], kinds)


def counted(times_s: list[float], kinds: list[tuple[str, str]]) -> dict[str, object]:
    """Return how many stopped in time, and what parameters they left."""
    whole = [one for one, other in kinds if one == other != "mixture"]
    return {
        "kills": len(kinds),
        "torque_zero_within_timeout": sum(each <= TIMEOUT_S + SLACK_S for each in times_s),
        "longest_to_zero_s": round(max(times_s), 3),
        "old": whole.count("old"),
        "new": whole.count("new"),
        "mixture": len(kinds) - len(whole),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--steps", default="offsets,resistance,inductance")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--virtual", action="store_true")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    rng = random.Random(asked.seed)
    steps = asked.steps.split(",")
    if asked.virtual:
        print_figures(virtual(asked.kills, steps, asked.seed), as_json=asked.json)
        return
    times_s: list[float] = []
    kinds: list[tuple[str, str]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        profile = boxed(folder)
        with served(profile) as links, open_session(str(profile), links["slcan"]) as watching:
            drive = watching.drive
            before = snapshot(drive)
            whole = host(profile, links["serial"], steps, folder / "whole")
            until(whole, BEGINS)
            began_s = time.monotonic()
            until(whole, SAVING)
            saves_s = time.monotonic() - began_s
            whole.communicate()
            lasts_s = saves_s + SAVES_S  # what it writes to the disk after that is not the drive's
            after = snapshot(drive)
            for number in itertools.count():
                restored(drive, before)
                process = host(profile, links["serial"], steps, folder / str(number))
                saving = number % 3 == 2
                if not kill(process, rng, lasts_s, lasts_s - saves_s, saving=saving):
                    continue  # it had ended before
                times_s.append(time_to_zero_s(drive))
                drive.clock.wait(TIMEOUT_S + SLACK_S)
                in_force = of_one_kind(snapshot(drive), before, after)
                restart(drive)
                kinds.append((in_force, of_one_kind(snapshot(drive), before, after)))
                shown = " then ".join(kinds[-1])
                print(f"{len(kinds)}: off in {times_s[-1]:.3f} s, {shown}", file=sys.stderr, flush=True)
                if len(kinds) == asked.kills:
                    break
    print_figures({"run_s": round(lasts_s, 2), **counted(times_s, kinds)}, as_json=asked.json)


def restart(drive: RemoteDrive) -> None:
    """Reset the drive; on a busy machine its boot-up may come later than a host waits for it."""
    with suppress(NoAnswer):
        reset(drive)
    drive.clock.wait(1.0)


def restored(drive: RemoteDrive, values: Mapping[str, Any]) -> None:
    """Have the drive store what it had at first."""
    with suppress(BenchError):
        drive.reset_fault()
    by_name = {variable_of(drive.dictionary, key).name: value for key, value in values.items()}
    held = {name: value for name, value in by_name.items() if drive.dictionary[name].writable}
    write_all(drive, {name: value for name, value in held.items() if drive.read(name) != value})
    store(drive)


if __name__ == "__main__":
    main()
