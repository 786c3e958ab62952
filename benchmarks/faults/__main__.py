"""Faults of wires, host, drive and bench, each at random ticks of a running drive, on both wires.

python -m benchmarks.faults --json                              60 of each on a wire, lost links 299 times
python -m benchmarks.faults --repetitions 3 --fault drive_hung  a few of one
python -m benchmarks.faults --write                             keep the figures, for docs/faults.md
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from benchmarks.faults.figures import Figures, summarise
from benchmarks.faults.trial import Outcomes, applies, run_trial
from benchtool.emulator.faults import FAULTS

MEASURED = Path(__file__).parent / "measured.json"
_LINK_LOSSES = ("host_killed", "cable_pulled")
_WIRES = ("can", "serial")


def measure(
    names: list[str], repetitions: int, link_losses: int, processes: int = 1, seed: int = 0
) -> Iterator[Figures]:
    """Yield the figures of these faults, of each wire that has them."""
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        for name in names:
            wires = [wire for wire in _WIRES if applies(name, wire)]
            losses = -(-link_losses // len(wires)) if name in _LINK_LOSSES else 0
            for wire in wires:
                count = max(losses, repetitions)
                seeds = range(seed, seed + count)
                trials: list[Outcomes] = list(
                    pool.map(run_trial, [name] * count, [wire] * count, seeds, chunksize=5)
                    if processes > 1
                    else map(run_trial, [name] * count, [wire] * count, seeds)
                )
                yield summarise(name, wire, trials)


def keep(figures: Figures, file: Path = MEASURED) -> None:
    """Put figures into the file, in place of those of the same fault and wire."""
    kept = json.loads(file.read_text(encoding="utf-8"))["faults"] if file.exists() else []
    key = figures.fault, figures.wire
    rows = {(each["fault"], each["wire"]): each for each in kept} | {key: figures.to_json()}
    order = {name: number for number, name in enumerate(FAULTS)}
    ordered = sorted(rows.values(), key=lambda each: (order[each["fault"]], each["wire"]))
    file.write_text(json.dumps({"faults": ordered}, indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """Measure, print, and exit with 1 if something that must hold does not."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.faults", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--repetitions", type=int, default=60, help="of each fault on each wire")
    parser.add_argument("--link-losses", type=int, default=299, help="of a lost link, on both wires together")
    parser.add_argument("--fault", action="append", choices=sorted(FAULTS), help="only this; may be repeated")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", action="store_true", help=f"keep the figures in {MEASURED.name}")
    given = parser.parse_args()
    figures = []
    for each in measure(
        given.fault or list(FAULTS), given.repetitions, given.link_losses, given.processes, given.seed
    ):
        figures.append(each)
        sys.stderr.write(f"{each.line}\n")
        if given.write:
            keep(each)
    if given.json:
        sys.stdout.write(json.dumps({"faults": [each.to_json() for each in figures]}, indent=1) + "\n")
    return 0 if all(each.holds for each in figures) else 1


if __name__ == "__main__":
    sys.exit(main())
