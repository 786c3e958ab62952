"""A commissioning killed at random moments: `python -m benchmarks.killed_commissioning [--json]`.

An emulated drive runs in a process of its own, in real time, beside what commissions it: a process that is
ended by SIGKILL. Of four kills two are at a moment that is uniform over the whole commissioning, one is while
the host puts in force what the profile states, one while it writes, stores and reads back what was found. A
third process's view, on another wire, is what counts: how long after the kill the power stage is off without
current, and whether the drive holds all of its old parameters or all of the new ones, in force then and after
a reset.

A commissioning is long beside what it takes to kill it. A drive is commissioned once as a whole; each of the
others is resumed (`--resume`) at the step in which its moment falls. Several drives, each with a host of its
own, are under way at once (`--drives`): nearly all of that time is waiting.

With --virtual nothing is killed: the host sends no frame from a random moment of virtual time on, or from a
random write on. That is as quick as the emulated drive, and does not depend on what else the machine does.
"""

from __future__ import annotations

import argparse
import json
import queue
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
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

SILENT_STEPS: Final = ("offsets", "resistance", "inductance")
BEGINS: Final = "in force what the profile states"
BEGINS_S: Final = 1.0
SAVES_S: Final = 1.5
STOPPED_RAD_S: Final = 0.5
LONGEST_STOP_S: Final = 30.0
_ANOTHER: Final = 100_000  # beyond the numbers of the kills, and a multiple of the strata
_ATTEMPTS: Final = 3  # at a whole commissioning, on a machine too busy for a heartbeat in time
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


def host(profile: Path, link: str, steps: Sequence[str], *where: str) -> subprocess.Popen[str]:
    """Start a commissioning; `where` names its folder, with --out or with --resume."""
    command = (sys.executable, *COMMISSION, *steps, "--profile", str(profile), "--link", link, *where)
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def until(process: subprocess.Popen[str], note: str) -> bool:
    """Return when a commissioning says this; False when it has ended without."""
    assert process.stderr is not None
    return any(note in line for line in process.stderr)


@dataclass(frozen=True)
class Moment:
    """When a commissioning is killed: so long after the first time that it says `note`, with the steps `done`
    already there."""

    stratum: str
    done: tuple[str, ...]
    note: str
    after_s: float


@dataclass(frozen=True)
class Course:
    """What a whole commissioning said, and when: of its beginning, of each step, of saving."""

    notes: tuple[tuple[str, float], ...]

    @classmethod
    def of(cls, process: subprocess.Popen[str], place: Path) -> Course | None:
        """Return that of a process that begins now, once it has ended; None if it has stored nothing."""
        assert process.stderr is not None
        told: dict[str, float] = {}
        line = ""
        for line in process.stderr:
            step = line.split(": ")[0]
            told.setdefault(next((each for each in (BEGINS, SAVING) if each in line), step), time.monotonic())
        if process.wait() != 0 or SAVING not in told:
            kept = place / "commissioning.json"
            why = json.loads(kept.read_text())["not_saved"] if kept.is_file() else line.strip()
            print(f"a whole commissioning stored nothing: {why}", file=sys.stderr, flush=True)
            return None
        names = [each.name for each in steps_for(())]
        return cls(tuple((key, at_s) for key, at_s in told.items() if key in (BEGINS, *names, SAVING)))

    @property
    def lasts_s(self) -> float:
        """Length, up to where all is stored; what is written to the disk after that is not the drive's."""
        return self.notes[-1][1] + SAVES_S - self.notes[0][1]

    def moment(self, stratum: str, rng: random.Random) -> Moment:
        """Return a random moment: of the whole, of what begins it, or of saving."""
        began_s = self.notes[0][1]
        if stratum == "stating":
            return Moment(stratum, (), BEGINS, rng.uniform(0.0, BEGINS_S))
        if stratum == "saving":
            at_s = self.notes[-1][1] + rng.uniform(0.0, SAVES_S)
        else:
            at_s = rng.uniform(began_s, began_s + self.lasts_s)
        key, since_s = [each for each in self.notes if each[1] <= at_s][-1]
        steps = [name for name, _ in self.notes[1:-1]]
        if key == SAVING:
            return Moment(stratum, tuple(steps[:-1]), SAVING, at_s - since_s)
        if key == BEGINS:
            return Moment(stratum, (), BEGINS, at_s - since_s)
        return Moment(stratum, tuple(steps[: steps.index(key)]), f"{key}: ", at_s - since_s)


@dataclass(frozen=True)
class Kill:
    """One kill: when, whether the power stage was on, the drive's time until no current flowed, and the
    parameters in force then and after a reset."""

    moment: Moment
    powered: bool
    zero_s: float
    in_force: str
    kept: str


def killed(process: subprocess.Popen[str], moment: Moment) -> bool:
    """End a commissioning at a moment. Returns whether it was still under way."""
    try:
        if until(process, moment.note):
            with suppress(subprocess.TimeoutExpired):
                process.wait(moment.after_s)
        return process.poll() is None
    finally:
        process.kill()
        process.wait()
        if process.stderr is not None:
            process.stderr.close()


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


def figures(kills: Sequence[Kill], run_s: float) -> dict[str, object]:
    """Return how many stopped in time and what parameters they left, over all and by stratum."""
    found: dict[str, object] = {"run_s": round(run_s, 1)}
    found |= counted([each.zero_s for each in kills], [(each.in_force, each.kept) for each in kills])
    powered = sorted(each.zero_s for each in kills if each.powered)
    found["powered_when_killed"] = len(powered)
    if len(powered) > 1:
        found["to_zero_powered_s"] = [round(each, 3) for each in statistics.quantiles(powered, n=4)]
    for stratum in STRATA:
        of = [each for each in kills if each.moment.stratum == stratum]
        told = {kind: sum(each.in_force == kind for each in of) for kind in ("old", "new")}
        found[stratum] = f"{len(of)} kills, {told['old']} old, {told['new']} new"
    return found


STRATA: Final = ("whole", "stating", "saving")
_IN_TURN: Final = ("whole", "saving", "whole", "stating")


def killing(
    profile: Path, folder: Path, steps: Sequence[str], asked: queue.SimpleQueue[int], seed: int
) -> Iterator[tuple[float, Kill]]:
    """Commission one emulated drive as a whole, then kill a commissioning of it for each number asked for.

    Yields:
        The length of the whole commissioning, and a kill.
    """
    with served(profile) as links, open_session(str(profile), links["slcan"]) as watching:
        drive, link = watching.drive, links["serial"]
        before = snapshot(drive)
        for attempt in range(_ATTEMPTS):
            restored(drive, before)
            whole = folder / f"whole-{attempt}"
            course = Course.of(host(profile, link, steps, "--out", str(whole)), whole)
            if course is not None:
                break
        else:
            raise SystemExit("a whole commissioning does not pass: run it by hand, or with fewer --drives")
        after = snapshot(drive)
        while True:
            try:
                number = asked.get_nowait()
            except queue.Empty:
                return
            rng = random.Random(seed * 10_000 + number)
            place = folder / str(number)
            try:
                restored(drive, before)
                moment = course.moment(_IN_TURN[number % len(_IN_TURN)], rng)
                for step in moment.done:
                    shutil.copytree(whole / step, place / step)
                process = host(profile, link, steps, "--resume" if moment.done else "--out", str(place))
                if not killed(process, moment):
                    print(f"{moment.note} it had ended before its moment, another follows", file=sys.stderr)
                    asked.put(number + _ANOTHER)
                    continue
                yield course.lasts_s, judged(drive, moment, before, after)
            except BenchError:
                asked.put(number)  # for another drive, or this one started again
                raise
            finally:
                shutil.rmtree(place, ignore_errors=True)


def judged(drive: RemoteDrive, moment: Moment, before: Mapping[str, Any], after: Mapping[str, Any]) -> Kill:
    """Return what a kill just now has left, in the time of the drive, which a busy machine delays."""
    began, T_s = drive.number("tick"), drive.number("control_period")
    powered = drive.state().power_stage_on
    zero_s = time_to_zero_s(drive)
    while (drive.number("tick") - began) * T_s < TIMEOUT_S + SLACK_S:
        drive.clock.wait(POLL_S)
    in_force = held_kind(held := snapshot(drive), before, after)
    if in_force == "mixture":
        mixed = [key for key, value in held.items() if value not in (before[key], after[key])]
        print(f"neither old nor new: {', '.join(mixed)}", file=sys.stderr, flush=True)
    at_rest(drive)
    restart(drive)
    return Kill(moment, powered, zero_s, in_force, held_kind(snapshot(drive), before, after))


def held_kind(held: Mapping[str, Any], before: Mapping[str, Any], after: Mapping[str, Any]) -> str:
    """Return whether parameters are exactly the old ones, exactly those that the whole commissioning has
    stored, or a mixture."""
    return "old" if held == before else "new" if held == after else "mixture"


def in_real_time(kills: int, drives: int, steps: Sequence[str], seed: int) -> dict[str, object]:
    """Return the figures of hosts that are killed, with so many drives at once."""
    asked: queue.SimpleQueue[int] = queue.SimpleQueue()
    for number in range(kills):
        asked.put(number)
    found: list[Kill] = []
    lengths_s: list[float] = []
    failures: list[BenchError | OSError | SystemExit] = []

    def lane(profile: Path, folder: Path) -> None:
        for attempt in range(_ATTEMPTS):
            try:
                for lasts_s, kill in killing(profile, folder / f"{attempt}", steps, asked, seed):
                    lengths_s.append(lasts_s)
                    found.append(kill)
                    print(told(len(found), kill), file=sys.stderr, flush=True)
            except (BenchError, OSError, SystemExit) as failure:
                failures.append(failure)
                print(f"a drive is started again: {failure}", file=sys.stderr, flush=True)
            else:
                return

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        profile = boxed(folder)
        print(f"commissioning {drives} emulated drives as a whole first", file=sys.stderr, flush=True)
        threads = [threading.Thread(target=lane, args=(profile, folder / f"{n}")) for n in range(drives)]
        for each in threads:
            each.start()
        for each in threads:
            each.join()
    if failures and not found:
        raise failures[0]
    return {**figures(found, statistics.median(lengths_s)), "drives_started_again": len(failures)}


def told(number: int, kill: Kill) -> str:
    """Return a line of progress."""
    stage = "on" if kill.powered else "off"
    kinds = kill.in_force if kill.in_force == kill.kept else f"{kill.in_force} then {kill.kept}"
    return (
        f"{number}: {kill.moment.note} + {kill.moment.after_s:.2f} s, power stage {stage}, zero after "
        f"{kill.zero_s:.3f} s, {kinds}"
    )


def main() -> int:
    """Measure and print; exit code 1 if one left a mixture, or torque for longer than the timeout."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--steps", default="", help="names, separated by commas; all without")
    parser.add_argument("--drives", type=int, default=4, help="how many are under way at once")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--virtual", action="store_true")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    steps = asked.steps.split(",") if asked.steps else []
    if asked.virtual:
        found = virtual(asked.kills, steps or list(SILENT_STEPS), asked.seed)
    else:
        found = in_real_time(asked.kills, asked.drives, steps, asked.seed)
    print_figures(found, as_json=asked.json)
    well = found["mixture"] == 0 and found["torque_zero_within_timeout"] == found["kills"]
    return 0 if well and found["kills"] == asked.kills else 1


def at_rest(drive: RemoteDrive) -> None:
    """Wait until the shaft has run down."""
    waited_s = 0.0
    while abs(drive.number("omega_m")) > STOPPED_RAD_S and waited_s < LONGEST_STOP_S:
        drive.clock.wait(0.1)
        waited_s += 0.1


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
    sys.exit(main())
