"""Families drawn at random: of a seed the same ones, of another others, and none that cannot be analysed."""

from __future__ import annotations

import math

import pytest

from benchmarks.coverage.drawn import drawn_family
from benchmarks.coverage.families import scores
from tests.at_length import at_length


def test_a_family_is_that_of_its_number_and_seed() -> None:
    kinds = [type(drawn_family(number, 1).what).__name__ for number in range(6)]
    assert kinds == ["Disturbance", "Stepped", "Disturbance", "Stepped", "Disturbance", "Excited"]
    assert drawn_family(3, 1).what == drawn_family(3, 1).what
    assert len({repr(drawn_family(number, seed).what) for number in range(6) for seed in range(3)}) == 18


@pytest.mark.parametrize("number", [*range(3), *at_length(*range(3, 60))])
def test_each_gives_numbers_or_reasons(number: int) -> None:
    for each in scores(drawn_family(number, 7), 2):
        assert each.answered == 0 or math.isfinite(each.rms)
