"""Which tests reach which lines, measured once and kept in a cache outside of the project.

Lines are kept by function and by their distance from its first line, so that an edit elsewhere in a module
leaves the map as good as it was. What is compiled is not traced; `plain` is a second map of the quick tests
of the control laws, measured with the compiler switched off.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from coverage import CoverageData

from tests.mutation.operators import Mutant, functions_of

TESTS = ("tests/unit", "tests/wire", "tests/physics", "tests/emulated")
TESTS_IN_PLAIN_PYTHON = (
    "tests/unit/control",
    *(f"tests/physics/test_{name}.py" for name in ("control", "laws", "cycle")),
)
_ENTRY = ("benchtool/emulator/core/core.py", "Core.run")  # what runs the compiled core


@dataclass(frozen=True)
class Reach:
    """`seconds` by test; `lines[path][function][distance]` are the tests that run that line."""

    seconds: Mapping[str, float]
    lines: Mapping[str, Mapping[str, Mapping[int, Sequence[str]]]]

    def tests_of(self, mutant: Mutant, first_line: int) -> list[str]:
        """Tests that reach any line of a mutant whose function begins at `first_line`, the quickest first.

        For code outside of functions, and for a function that was edited, those that reach the module or the
        function at all.
        """
        functions = self.lines.get(mutant.path, {})
        if mutant.function not in functions:
            found = {test for lines in functions.values() for tests in lines.values() for test in tests}
            return self._quickest(found)
        lines = functions[mutant.function]
        begin = mutant.line - first_line
        exact = {test for at in range(begin, begin + mutant.lines) for test in lines.get(at, ())}
        return self._quickest(exact or {test for tests in lines.values() for test in tests})

    @cached_property
    def closed_loop(self) -> list[str]:
        """Tests that run the compiled core: those of physics first, the quickest first."""
        path, function = _ENTRY
        lines = self.lines.get(path, {}).get(function, {})
        found = self._quickest({test for tests in lines.values() for test in tests})
        return sorted(found, key=lambda test: not test.startswith("tests/physics"))

    def _quickest(self, tests: set[str]) -> list[str]:
        return sorted(tests, key=lambda test: (self.seconds[test], test))


def reach_of(tree: Path, cache: Path, tests: Sequence[str], *, plain: bool, renew: bool) -> Reach:
    """The map of `tests`, folders or files of `tree`, a copy of the project.

    Only test files that changed since the last time are run again, or all of them by `renew`.
    """
    folder = cache / ("plain" if plain else "compiled")
    folder.mkdir(parents=True, exist_ok=True)
    places = [tree / place for place in tests]
    files = [path for place in places for path in ([place] if place.is_file() else _test_files(place))]
    kept = {path: folder / f"{_digest(tree, path)}.json" for path in files}
    stale = [path for path, place in kept.items() if renew or not place.exists()]
    if stale:
        sys.stderr.write(
            f"measuring what {len(stale)} test files reach{' in plain Python' if plain else ''}\n"
        )
        for path, text in _measured(tree, stale, plain):
            kept[path].write_text(text, encoding="utf-8")
    return _read(place for place in kept.values() if place.exists())


def _test_files(folder: Path) -> list[Path]:
    return sorted(folder.rglob("test_*.py"))


def _digest(tree: Path, path: Path) -> str:
    name = str(path.relative_to(tree))
    return hashlib.sha256(name.encode() + path.read_bytes()).hexdigest()[:24]


def _measured(tree: Path, files: Sequence[Path], plain: bool) -> Iterator[tuple[Path, str]]:
    """Run test files under coverage, and split what came by test file."""
    traced, timed = tree.parent / "coverage", tree.parent / "timings"
    environment = os.environ | {
        "PYTHONPATH": str(tree),
        "TRACED": str(traced),
        "TIMED": str(timed),
        "NUMBA_DISABLE_JIT": "1" if plain else "0",
    }
    command = [sys.executable, "-m", "pytest", *(str(path.relative_to(tree)) for path in files)]
    command += ["-p", "tests.mutation.tracing", "-p", "no:cacheprovider", "--tb=no"]
    subprocess.run(command, cwd=tree, env=environment, stdout=sys.stderr, check=False)
    seconds: dict[str, float] = json.loads(timed.read_text(encoding="utf-8"))
    data = CoverageData(str(traced))
    data.read()
    reached: dict[str, dict[str, dict[str, dict[str, list[str]]]]] = {}
    for measured in data.measured_files():
        path = Path(measured)
        if path.suffix != ".py":
            continue  # a template, whose compiled form goes by its name
        functions = functions_of(path.read_text(encoding="utf-8"))
        for line, contexts in data.contexts_by_lineno(measured).items():
            # the innermost function that holds the line
            name, first, _ = max(
                (each for each in functions if each[1] <= line <= each[2]),
                key=lambda each: each[1],
                default=("", 0, 0),
            )
            for test in set(contexts) & seconds.keys():
                by_path = reached.setdefault(test.partition("::")[0], {}).setdefault(
                    str(path.relative_to(tree)), {}
                )
                by_path.setdefault(name, {}).setdefault(str(line - first), []).append(test)
    traced.unlink()
    timed.unlink()
    for file in files:
        name = str(file.relative_to(tree))
        of_file = {test: took for test, took in seconds.items() if test.partition("::")[0] == name}
        yield file, json.dumps({"seconds": of_file, "lines": reached.get(name, {})})


def _read(places: Iterator[Path]) -> Reach:
    seconds: dict[str, float] = {}
    lines: dict[str, dict[str, dict[int, list[str]]]] = {}
    for place in places:
        document = json.loads(place.read_text(encoding="utf-8"))
        seconds |= document["seconds"]
        for path, functions in document["lines"].items():
            for function, by_distance in functions.items():
                into = lines.setdefault(path, {}).setdefault(function, {})
                for distance, tests in by_distance.items():
                    into.setdefault(int(distance), []).extend(tests)
    return Reach(seconds, lines)
