"""Lines about a fundamental: sidebands of its swing, or no part of it."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.spectra.swing_lines import may_be_swing, off_by_lines

PERIODS = 60.0
HARMONICS = np.array([1.0, 0.0, 0.0, 0.0, 0.04, 0.0, 0.02])


def lines(*found: tuple[float, float]) -> tuple[bool, float]:
    """Return what lines, each an order and a size, tell."""
    orders, sizes = np.array(found).reshape(-1, 2).T
    return off_by_lines(orders, sizes, HARMONICS, PERIODS)


@pytest.mark.parametrize("below", [0.15, 1e-4])
def test_lines_that_a_harmonic_repeats_on_both_sides_are_of_a_swing(below: float) -> None:
    """However large the lower sideband of the fundamental is beside the upper."""
    about = (1.0 - 1 / 3, below), (1.0 + 1 / 3, 0.17)
    assert lines(*about, (5.0 - 1 / 3, 0.01), (5.0 + 1 / 3, 0.012)) == (True, 0.0)


def test_lines_that_no_harmonic_repeats_are_beside_it() -> None:
    assert lines((0.93, 0.012), (1.07, 0.028)) == (False, 0.028)


def test_one_side_of_a_harmonic_is_no_swing() -> None:
    assert lines((0.93, 0.02), (1.07, 0.02), (5.07, 0.01)) == (False, 0.02)


def test_sidebands_of_a_harmonic_that_is_smaller_are_none_of_it() -> None:
    """An order of a half and one and a half are as far from an order of two that is not there."""
    assert lines((0.5, 0.01), (1.5, 0.005), (2.5, 0.004)) == (False, 0.01)


def test_a_phase_that_swings_far_has_sidebands_at_twice_the_distance() -> None:
    swing = (0.7, 0.1), (1.3, 0.1), (4.7, 0.01), (5.3, 0.01)
    assert lines(*swing, (0.4, 0.005), (1.6, 0.005)) == (True, 0.0)
    assert lines(*swing, (0.25, 0.005), (1.6, 0.005)) == (True, 0.005)


def test_what_a_track_makes_of_a_swing_is_on_both_sides() -> None:
    """Of a swing of two thirds of a cycle, phases of periods have one of a third."""
    swing = (1 / 3, 0.1), (5 / 3, 0.1), (4 + 1 / 3, 0.01), (5 + 2 / 3, 0.01)
    assert lines(*swing, (2 / 3, 0.007), (4 / 3, 0.005)) == (True, 0.0)
    assert lines(*swing, (2 / 3, 0.007), (4 / 3, 0.003)) == (True, 0.007)


def test_nothing_beside_a_fundamental_is_no_swing() -> None:
    assert lines() == (False, 0.0)


def test_fast_lines_on_both_sides_may_be_a_swing() -> None:
    def paired(*orders: float) -> bool:
        return may_be_swing(np.array(orders), np.full(len(orders), 0.1), PERIODS)

    assert paired(1.0 / 3.0, 5.0 / 3.0)
    assert not paired(1.0 / 3.0, 1.7)
    assert not paired(0.5, 1.5)  # which is halfway between harmonics
    assert not paired(0.93, 1.07)
    assert not paired()
