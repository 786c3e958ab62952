"""The mutator makes mutants: each compiles, differs, and is named by what it changes and not by where."""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path

from tests.mutation.__main__ import draw, equivalents, share_noticed
from tests.mutation.caches import clear_caches
from tests.mutation.operators import Mutant, functions_of, mutants_of
from tests.mutation.reach import Reach
from tests.mutation.trial import Outcome, Result

ROOT = Path(__file__).parents[2]
SOURCE = '''"""A module."""

LIMIT = 3


class Motor:
    def held(self, i_a: float, i_b: float) -> bool:
        """Words are left alone."""
        self.count += 1
        if abs(i_a) > LIMIT or not i_b:
            raise ValueError(f"{i_a} is beyond {LIMIT + 1}")
        return min(i_a, 2.0 * i_b) <= 0.0


def swapped(first: int, last: int) -> int:
    return divmod(first, last)[0] - -last + gcd(first, last)
'''


@cache
def kept() -> object:
    return object()


def changes(operator: str) -> set[str]:
    return {mutant.change for mutant in mutants_of("a.py", SOURCE) if mutant.operator == operator}


def test_every_kind_of_change_is_made() -> None:
    assert "abs(i_a) > LIMIT -> (abs(i_a) >= LIMIT)" in changes("comparison")
    assert "abs(i_a) -> i_a" in changes("dropped call")
    assert changes("other call") == {"min(i_a, 2.0 * i_b) -> max(i_a, 2.0 * i_b)"}
    assert "i_a -> i_b" in changes("neighbouring name")
    assert changes("swapped arguments") == {"divmod(first, last) -> divmod(last, first)"}
    assert changes("sign") == {"-last -> last"}
    assert "self.count += 1 -> pass" in changes("removed assignment")
    assert {"3 -> 4", "3 -> 2", "0.0 -> 1.0", "2.0 -> 4.0"} <= changes("constant")
    assert any(change.startswith("raise ValueError") for change in changes("removed raise"))
    assert "not i_b -> i_b" in changes("negated condition")
    assert any(change.endswith("-> return False") for change in changes("fixed return"))


def test_mutants_compile_differ_and_leave_words_alone() -> None:
    mutants = mutants_of("a.py", SOURCE)
    for mutant in mutants:
        compile(mutant.mutated, "a.py", "exec")
        assert mutant.mutated != SOURCE
        assert '"""Words are left alone."""' in mutant.mutated
        assert '"""A module."""' in mutant.mutated
    assert max(Counter(mutant.identity for mutant in mutants).values()) == 1


def test_what_stands_before_a_function_does_not_change_the_names_of_its_mutants() -> None:
    moved = mutants_of("a.py", SOURCE.replace("LIMIT = 3\n", "LIMIT = 3\n\n# more\n"))
    assert [mutant.identity for mutant in moved] == [mutant.identity for mutant in mutants_of("a.py", SOURCE)]
    assert functions_of(SOURCE)[0][0] == "Motor.held"


def test_a_draw_takes_a_line_once_and_the_same_ones_for_the_same_seed() -> None:
    mutants = mutants_of("a.py", SOURCE)
    drawn = draw(mutants, 5, seed=1)
    assert drawn == draw(mutants, 5, seed=1)
    assert len({mutant.line for mutant in drawn}) == 5
    assert len(draw(mutants, 1000, seed=1)) == len({mutant.line for mutant in mutants})


def test_tests_are_those_of_the_line_wherever_its_function_has_moved_to() -> None:
    reach = Reach({"slow": 2.0, "quick": 1.0}, {"a.py": {"f": {1: ["slow", "quick"], 3: ["slow"]}}})

    def reaching(function: str, line: int) -> list[str]:
        return reach.tests_of(Mutant("a.py", function, line, 1, "", "", ""), first_line=10)

    assert reaching("f", 11) == ["quick", "slow"]
    assert reaching("f", 13) == ["slow"]
    assert reaching("f", 19) == ["quick", "slow"]  # edited since: all that run the function
    assert reaching("", 1) == ["quick", "slow"]


def test_equivalent_mutants_do_not_count_and_each_has_a_reason() -> None:
    mutant = mutants_of("a.py", SOURCE)[0]
    outcomes = (Outcome.NOTICED, Outcome.SURVIVED, Outcome.TIMED_OUT, Outcome.UNREACHED, Outcome.EQUIVALENT)
    assert share_noticed([Result(mutant, outcome, "", 0, 0.0) for outcome in outcomes]) == 0.5
    for identity, reason in equivalents().items():
        assert (ROOT / identity.partition("::")[0]).is_file()
        assert len(reason) > 20


def test_no_test_finds_what_another_had_computed() -> None:
    first = kept()
    assert kept() is first
    clear_caches()
    assert kept() is not first
