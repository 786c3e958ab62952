"""Whether runs of one plan differ as stated: `python -m benchmarks.repeated_runs [--runs N] [PLAN ...]`.

Each plan is run several times on the emulated bench, with another seed of its noise, and recorded at
another moment, so that the record begins at another angle of the rotor. For each measurement of all cases
printed is the standard deviation of its values over the rms of its u, the median over the cases, and how many
differences of the first run and the second, the third and the fourth, and so on, exceed their expanded
uncertainty: 5 % would by chance. What the bench itself does not repeat, such as its speed, differs by more
than the uncertainty of one record; `compare` knows of it.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import benchtool
from benchmarks.figures import print_figures
from benchtool.api.plans import PlanResult
from benchtool.plan import load_plan

PLANS = ("zhu2011/ripple", "zhu2011/fig5", "zhu2011/fig8")
RUNS = 10
_LATER_S = 0.5
_SHARES = (0.05, 0.25, 0.5, 0.75, 0.95)
_FEWEST = 4  # values that a standard deviation is of


def repeated(plan: str, runs: int, folder: Path) -> list[PlanResult]:
    """Return what a plan gives in so many runs."""
    found = []
    random = np.random.default_rng(0)
    stated = load_plan(plan)
    for seed in range(1, runs + 1):
        point = stated.operating_point
        later = point.model_copy(update={"settle_s": point.settle_s + random.uniform(0.0, _LATER_S)})
        drawn = stated.model_copy(update={"operating_point": later})
        found.append(benchtool.run_plan(drawn, folder / f"{seed}", seed=seed))
    return found


def scatter(results: list[PlanResult]) -> Iterator[tuple[str, float]]:
    """Yield measurements with the scatter of their values over the rms of u, case by case."""
    for case in results[0]:
        values: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
        for result in results:
            for name in result[case]:
                each = result[case][name]
                if each.uncertainty is not None and math.isfinite(each.value):
                    values[name].append((each.value, each.uncertainty.standard))
        for name, pairs in values.items():
            value, u = np.array(pairs).T
            if len(pairs) >= _FEWEST and np.any(u > 0.0):
                yield name, float(np.std(value, ddof=1) / np.sqrt(np.mean(u**2)))


def exceeding(results: list[PlanResult]) -> Iterator[tuple[str, bool]]:
    """Yield measurements with whether two runs differ by more than U."""
    for one, two in zip(results[::2], results[1::2], strict=False):
        for case in one:
            compared = benchtool.compare(one[case], two[case])
            for name in compared:
                exceeds = compared[name].exceeds
                if exceeds is not None:
                    yield name, exceeds


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("plans", nargs="*", default=PLANS)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    ratios: defaultdict[str, list[float]] = defaultdict(list)
    decided: defaultdict[str, list[bool]] = defaultdict(list)
    for plan in options.plans:
        with tempfile.TemporaryDirectory() as folder:
            results = repeated(plan, options.runs, Path(folder))
            for name, ratio in scatter(results):
                ratios[name].append(ratio)
            for name, exceeds in exceeding(results):
                decided[name].append(exceeds)
    every = [ratio for each in ratios.values() for ratio in each]
    marks = [mark for each in decided.values() for mark in each]
    figures: dict[str, object] = {
        name: {
            "scatter_over_u": round(float(np.median(ratios[name])), 2),
            "differences": len(decided[name]),
            "exceeding": sum(decided[name]),
        }
        for name in sorted(ratios)
    }
    quantiles = {f"{100 * share:g} %": round(float(np.quantile(every, share)), 2) for share in _SHARES}
    print_figures(
        {
            **figures,
            "scatter_over_u": quantiles,
            "differences": len(marks),
            "exceeding_percent": round(100.0 * float(np.mean(marks)), 2),
        },
        as_json=options.json,
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
