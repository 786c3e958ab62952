"""How much faster two processes run a plan than one: `python -m benchmarks.workers [--json] [--cases 64]`.

The demo's plan with repetitions, each a case on an emulated bench of its own, with its recording and
analysis. Measured is wall time of one process and of two, in turns, the median of some; both ways the
processes are started for each run and load the kernel, which is compiled before. Processor time is beside it:
what two take more of it than one is the start of the second process, and what sharing costs. Few cases
measure the start, which does not become shorter by a second process. Where the load of the machine is not
near nothing before it begins, only processor time tells anything.
"""

from __future__ import annotations

import argparse
import gc
import os
import resource
import statistics
import tempfile
import time
from pathlib import Path

from benchmarks.figures import print_figures
from benchtool.cli.exit_codes import OBJECTS
from benchtool.plan import Plan, load_plan
from benchtool.profile import profile_path
from benchtool.run.parallel import run_in_processes
from benchtool.run.runner import RunInfo

PLAN, PROFILE = "zhu2011/ripple", "zhu2011"
TURNS = 3
GOAL = 1.9


class _Silent:
    def begin(self, case: str, number: int, count: int) -> None:
        """Does nothing."""

    def note(self, text: str) -> None:
        """Does nothing."""


def run_s(plan: Plan, folder: Path, jobs: int) -> tuple[float, float]:
    """Return the wall time of a run, and the processor time of all its processes."""
    toml = profile_path(PROFILE).read_text(encoding="utf-8")
    info = RunInfo("2000-01-01T00:00:00+00:00", 0, ("benchmark",), profile_toml=toml)
    begin_s, before_s = time.monotonic(), _processor_s()
    run_in_processes(plan, PROFILE, folder, info, _Silent(), jobs=jobs)
    return time.monotonic() - begin_s, _processor_s() - before_s


def _processor_s() -> float:
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in used)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--cases", type=int, default=64)
    given = parser.parse_args()
    plan = load_plan(PLAN).model_copy(update={"repetitions": given.cases})
    gc.set_threshold(OBJECTS)  # as the command line does
    load = os.getloadavg()[0]
    wall_s: dict[int, list[float]] = {1: [], 2: []}
    processor_s: dict[int, list[float]] = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as folder:
        run_s(load_plan(PLAN).model_copy(update={"repetitions": 2}), Path(folder) / "first", 1)
        for turn in range(TURNS):
            for jobs in wall_s:
                wall, processor = run_s(plan, Path(folder) / f"{turn}-{jobs}", jobs)
                wall_s[jobs].append(wall)
                processor_s[jobs].append(processor)
    one_s, two_s = (statistics.median(wall_s[jobs]) for jobs in (1, 2))
    one_cpu_s, two_cpu_s = (statistics.median(processor_s[jobs]) for jobs in (1, 2))
    figures = {
        "one_process_s": round(one_s, 2),
        "two_processes_s": round(two_s, 2),
        "speed_of_two_over_one": round(one_s / two_s, 2),
        "goal_speed_of_two_over_one": GOAL,
        "one_process_cpu_s": round(one_cpu_s, 2),
        "two_processes_cpu_s": round(two_cpu_s, 2),
        "start_of_a_process_cpu_s": round(two_cpu_s - one_cpu_s, 2),
        "cases": given.cases,
        "turns": TURNS,
        "processors": os.cpu_count(),
        "load_before": round(load, 2),
    }
    print_figures(figures, as_json=given.json)


if __name__ == "__main__":
    main()
