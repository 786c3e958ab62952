"""How long the command line takes to come up: `python -m benchmarks.startup [--json]`.

The baseline, in the same run, is an interpreter that does nothing.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time

from benchmarks.figures import print_figures

RUNS = 15
GOAL_S = 0.4


def median_s(*arguments: str) -> float:
    """Return the median wall time of a Python process with these arguments."""
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        subprocess.run((sys.executable, *arguments), stdout=subprocess.DEVNULL, check=True)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    as_json = parser.parse_args().json
    help_s, python_s = median_s("-m", "benchtool", "--help"), median_s("-c", "pass")
    figures = {
        "help_s": round(help_s, 3),
        "goal_s": GOAL_S,
        "baseline_python_s": round(python_s, 3),
        "ratio": round(help_s / python_s, 1),
        "runs": RUNS,
    }
    print_figures(figures, as_json=as_json)


if __name__ == "__main__":
    main()
