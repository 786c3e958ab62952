"""Mutation testing: change the code in small ways, one at a time, and report changes that no test notices.

python -m tests.mutation --module benchtool/drive --count 40 --seed 1 [--only TEXT] [--json] [--renew]

Mutants are drawn at random, one to a line; the same seed draws the same ones from the same source. Each is
put into a copy of the project in a temporary directory and met by the tests that reach the changed line, as
a run under coverage has found. That map is kept in a cache; test files that changed since are measured
again, `--renew` measures all of them. `equivalent.toml` beside this file lists the mutants that no test can
notice, with the reason. The exit code is 1 if less than 90 % of the others are noticed.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import sys
import tempfile
import tomllib
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.mutation.operators import Mutant, mutants_of
from tests.mutation.reach import TESTS, TESTS_IN_PLAIN_PYTHON, reach_of
from tests.mutation.trial import Outcome, Result, Trials, copied
from tests.mutation.warm import PROJECT

MODULES = (
    *("benchtool/link", "benchtool/telemetry", "benchtool/drive", "benchtool/recording"),
    *("benchtool/emulator/firmware", "benchtool/emulator/control", "benchtool/plan/limits.py"),
    "benchtool/analysis",
)
LEAST = 0.9


def draw(mutants: Sequence[Mutant], count: int, seed: int) -> list[Mutant]:
    """Up to `count` mutants in random order, each of another line, kinds of change being equally likely."""
    source = random.Random(seed)
    by_line: dict[tuple[str, int], list[Mutant]] = {}
    for mutant in mutants:
        by_line.setdefault((mutant.path, mutant.line), []).append(mutant)
    drawn = []
    for line in source.sample(sorted(by_line), min(count, len(by_line))):
        kind = source.choice(sorted({mutant.operator for mutant in by_line[line]}))
        drawn.append(source.choice([mutant for mutant in by_line[line] if mutant.operator == kind]))
    return drawn


def equivalents() -> dict[str, str]:
    """The reviewed mutants that behave as the original does: reason by identity."""
    text = (Path(__file__).parent / "equivalent.toml").read_text(encoding="utf-8")
    return {each["mutant"]: each["reason"] for each in tomllib.loads(text).get("equivalent", [])}


def run(
    mutants: Sequence[Mutant],
    tests: Sequence[str],
    cache: Path,
    *,
    renew: bool,
    tell: Callable[[Result], None],
) -> list[Result]:
    """Meet each mutant with the tests that reach it; `tell` is called with each result."""
    known = equivalents()
    results = []
    with tempfile.TemporaryDirectory(prefix="benchtool-mutation-") as folder:
        tree = copied(PROJECT, Path(folder))
        compiled = reach_of(tree, cache, tests, plain=False, renew=renew)
        laws = any(mutant.path.startswith("benchtool/emulator/control") for mutant in mutants)
        plain = reach_of(tree, cache, TESTS_IN_PLAIN_PYTHON, plain=True, renew=renew) if laws else None
        trials = Trials(tree, compiled, plain)
        for mutant in mutants:
            if mutant.identity in known:
                result = Result(mutant, Outcome.EQUIVALENT, "", 0, 0.0)
            else:
                result = trials.meet(mutant)
            results.append(result)
            tell(result)
    return results


def share_noticed(results: Sequence[Result]) -> float:
    """Noticed or timed out, of all that are not equivalent; 1 if there are none."""
    counted = [result for result in results if result.outcome is not Outcome.EQUIVALENT]
    noticed = [result for result in counted if result.outcome in (Outcome.NOTICED, Outcome.TIMED_OUT)]
    return len(noticed) / len(counted) if counted else 1.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and report; the process's exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutation",
        description="Change the code in small ways and see what tests notice.",
    )
    parser.add_argument("--module", action="append", help="folder or file; may be repeated", metavar="PATH")
    parser.add_argument("--count", type=int, default=40, help="mutants of each module")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tests", action="append", help="folder or file; may be repeated", metavar="PATH")
    parser.add_argument(
        "--only",
        action="append",
        help="of those drawn, the ones whose name holds this text; may be repeated",
        metavar="TEXT",
    )
    parser.add_argument("--renew", action="store_true", help="measure again which tests reach which lines")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args(arguments)

    mutants = [
        mutant
        for module in options.module or MODULES
        for mutant in draw(_mutants_within(module), options.count, options.seed)
        if any(text in mutant.identity for text in options.only or ("",))
    ]
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "benchtool-mutation"
    out = sys.stderr if options.json else sys.stdout

    def tell(result: Result) -> None:
        place = f"{result.mutant.path}:{result.mutant.line}"
        by = f"  [{result.by}]" if result.by else ""
        out.write(f"{result.outcome:10s} {result.seconds:5.1f} s  {place}  {result.mutant.identity}{by}\n")
        out.flush()

    results = run(mutants, options.tests or TESTS, cache, renew=options.renew, tell=tell)
    counts = Counter(str(result.outcome) for result in results)
    share = share_noticed(results)
    if options.json:
        sys.stdout.write(json.dumps(_document(options.seed, results, counts, share), indent=2) + "\n")
    else:
        told = ", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items()))
        sys.stdout.write(f"{len(results)} mutants: {told}; {share:.1%} noticed\n")
    return 0 if share >= LEAST else 1


def _mutants_within(module: str) -> list[Mutant]:
    place = PROJECT / module
    paths = [place] if place.is_file() else sorted(place.rglob("*.py"))
    if not paths:
        raise SystemExit(f"there is no Python file in {module}: give a path within the project")
    return [
        mutant
        for path in paths
        for mutant in mutants_of(path.relative_to(PROJECT).as_posix(), path.read_text(encoding="utf-8"))
    ]


def _document(seed: int, results: Sequence[Result], counts: Counter[str], share: float) -> dict[str, object]:
    return {
        "seed": seed,
        "share_noticed": share,
        "counts": dict(sorted(counts.items())),
        "mutants": [
            {
                "mutant": result.mutant.identity,
                "line": result.mutant.line,
                "outcome": result.outcome,
                "by": result.by,
                "tests": result.tests,
                "seconds": round(result.seconds, 1),
            }
            for result in results
        ],
    }


if __name__ == "__main__":
    sys.exit(main())
