"""Whether stated uncertainties hold: `python -m benchmarks.coverage [--json] [--repetitions N] [NAME ...]`,
of all families `python -m benchmarks.coverage --all`, or of such that are drawn at random `--drawn N`.

Of every family of signals random records are made, whose truth is known by construction, and analysed.
Printed is for each measurement how often +-u, +-2u and +-U hold the truth and the rms of error / u; `null`
stands for a number that was refused with a reason, `uncounted` for one whose truth the family does not tell,
and `bound` for errors that are smaller than u because the
family's sensors are always of one kind among those that the profile allows. Last come the quantiles of that
rms over all answers. A pass over the families that stand for all takes seven minutes on two cores, one over
all more than an hour; a doubtful number is counted again by its family's name with more repetitions and
another seed. Drawn families are others with each seed, and what they are is printed where a number does not
hold. Exit code 1 if any uncertainty is too small.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import partial

import numpy as np

from benchmarks.coverage.drawn import drawn_family
from benchmarks.coverage.families import Score, scores
from benchmarks.coverage.registry import FAMILIES
from benchmarks.coverage.representative import REPRESENTATIVE

REPETITIONS = 40
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


def score_family(which: str | int, repetitions: int, seed: int = 0) -> list[Score]:
    """Return the scores of one family by its name, or of a drawn one by its number."""
    family = drawn_family(which, seed) if isinstance(which, int) else FAMILIES[which]
    return list(scores(family, repetitions, seed))


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", help="parts of their names; without, those that stand for all")
    parser.add_argument("--all", action="store_true", help="count every family")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--repetitions", type=int, default=REPETITIONS, help="random records of each family")
    parser.add_argument("--seed", type=int, default=0, help="of the random records")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--drawn", type=int, default=0, help="count so many families drawn at random")
    parser.add_argument("--narrow", action="store_true", help="print only what does not hold")
    options = parser.parse_args()
    if options.names:
        names = [name for name in FAMILIES if any(part in name for part in options.names)]
    else:
        names = list(FAMILIES if options.all else REPRESENTATIVE)
    counted: Sequence[str | int] = range(options.drawn) if options.drawn else names
    if not options.json:
        heads = ("family", "measurement", "n", "u", "2u", "U", "rms", "mean")
        print("{:30} {:32} {:>4} {:>5} {:>5} {:>5} {:>7} {:>7}".format(*heads))
    begin = time.perf_counter()
    with ProcessPoolExecutor(max_workers=options.workers) as pool:
        found: list[Score] = []
        score = partial(score_family, repetitions=options.repetitions, seed=options.seed)
        for which, part in zip(counted, pool.map(score, counted), strict=True):
            found.extend(part)
            if not options.json:
                shown = [each for each in part if not options.narrow or each.verdict in ("narrow", "wide")]
                _print(shown)
                if isinstance(which, int) and any(each.verdict == "narrow" for each in part):
                    print(drawn_family(which, options.seed).what, flush=True)
    counts = {
        verdict: sum(each.verdict == verdict for each in found)
        for verdict in ("holds", "wide", "bound", "narrow", "null", "uncounted")
    }
    rms = [each.rms for each in found if each.verdict not in ("null", "uncounted") and each.rms > 0.0]
    quantiles = {
        f"{100.0 * share:g} %": round(float(np.quantile(rms, share)), 3) for share in _QUANTILES if rms
    }
    if options.json:
        document = {
            "families": len(counted),
            "repetitions": options.repetitions,
            "seed": options.seed,
            "seconds": round(time.perf_counter() - begin, 1),
            **counts,
            "rms": quantiles,
            "scores": [
                {key: _number(value) for key, value in asdict(each).items()} | {"verdict": each.verdict}
                for each in found
            ],
        }
        print(json.dumps(document, indent=2, allow_nan=False))
    else:
        print(f"{len(counted)} families, {counts}, {time.perf_counter() - begin:.0f} s")
        print(f"rms of error / u, quantiles over {len(rms)} answers: {quantiles}")
    return 1 if counts["narrow"] else 0


def _print(found: list[Score]) -> None:
    for each in found:
        print(
            f"{each.family:30} {each.measurement:32} {each.answered:4} {each.within_u:5.2f} "
            f"{each.within_2u:5.2f} {each.within_U:5.2f} {each.rms:7.3g} {each.mean:7.2g} {each.verdict}",
            flush=True,
        )


def _number(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


if __name__ == "__main__":
    raise SystemExit(main())
