"""How long the command line and the demo take to come up: `python -m benchmarks.startup [--json]`.

Figures are the processor time of whole processes, the least of several turns in which all take part, so that
a neighbour on the machine does not count. The baselines are of the same turns: an interpreter that does
nothing, and the bare imports of what the demo cannot do without. The kernel is compiled before.

The goal of the demo counts in a plain install (`pip install benchtool`): with the development requirements
python-can loads asammdf and pandas beside, which the command line forgoes and the baseline does not.
"""

from __future__ import annotations

import argparse
import importlib.util
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.figures import print_figures

TURNS = 9
GOAL_HELP, GOAL_DEMO = 12.0, 2.0  # over the baselines
IMPORTS = "import numpy, numba, pyarrow, matplotlib, canopen, pydantic"


def cpu_s(*arguments: str) -> float:
    """Return the processor time of a Python process with these arguments, user and system."""
    process = subprocess.Popen(
        (sys.executable, *arguments), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(arguments)} ended with {process.returncode}: run it by hand")
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    as_json = parser.parse_args().json
    least = dict.fromkeys(("python", "help", "imports", "demo"), math.inf)
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(TURNS + 1):
            commands = {
                "python": ("-c", "pass"),
                "help": ("-m", "benchtool", "--help"),
                "imports": ("-c", IMPORTS),
                "demo": ("-m", "benchtool", "demo", "--json", "--out", str(Path(folder) / str(turn))),
            }
            for name, command in commands.items():
                used = cpu_s(*command)
                if turn > 0:  # the first may compile, and fills the caches of the disk
                    least[name] = min(least[name], used)
    is_plain = importlib.util.find_spec("asammdf") is None
    figures = {
        "environment": "plain install" if is_plain else "with asammdf: the goal of the demo does not count",
        **{f"{name}_cpu_s": round(used, 3) for name, used in least.items()},
        "help_over_python": round(least["help"] / least["python"], 1),
        "goal_help_over_python": GOAL_HELP,
        "demo_over_imports": round(least["demo"] / least["imports"], 2),
        "goal_demo_over_imports": GOAL_DEMO,
        "turns": TURNS,
    }
    print_figures(figures, as_json=as_json)


if __name__ == "__main__":
    main()
