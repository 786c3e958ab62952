"""What moves a harmonic by itself: with the noise that the others tell it with, and by which courses."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.spectra.harmonic_movement import Movement, movements_of

Complex = NDArray[np.complex128]
REACH, HARMONICS = 8, 6
ORDER = np.arange(1.0, REACH + 1.0)


def noise(random: np.random.Generator, *shape: int) -> Complex:
    """Return noise of mean square 1 in each bin."""
    return np.asarray((random.standard_normal(shape) + 1j * random.standard_normal(shape)) / np.sqrt(2.0))


@pytest.mark.parametrize("index", [0, 2])
def test_by_noise_alone_a_phase_moves_by_its_standard_deviation(index: int) -> None:
    """Also of a fundamental, whose phase is held against weak harmonics: the noise is theirs."""
    random, moved = np.random.default_rng(1), []
    sizes = np.array([1.0, *np.full(HARMONICS - 1, 0.05)])
    for _ in range(300):
        around = 3e-3 * noise(random, HARMONICS, 2 * REACH + 1)
        around[:, REACH] = sizes * np.exp(1j * random.uniform(0.0, 2.0 * np.pi, HARMONICS))
        movements = movements_of(around, np.full(HARMONICS, 9e-6), index, 40 * (index + 1))
        moved.append(movements[0].moved)
        assert movements[0].harmonic == around[index, REACH]
    assert np.sqrt(np.mean(np.square(moved))) == pytest.approx(1.0, abs=0.1)


def test_what_turns_all_harmonics_is_taken_off() -> None:
    """A speed moves the phase of harmonic k by k times as much."""
    common = 1e-3 * (1.0 + 0.3j) / ORDER
    around = np.zeros((HARMONICS, 2 * REACH + 1), dtype=np.complex128)
    for index in range(HARMONICS):
        moves = (index + 1) * common
        around[index] = 0.1 * np.concatenate([-np.conj(moves[::-1]), [1.0], moves])
    for index in range(HARMONICS):
        movements = movements_of(around, np.full(HARMONICS, 1e-10), index, 40 * (index + 1))
        assert min(float(np.max(np.abs(each.phase))) for each in movements) < 1e-15


@pytest.mark.parametrize(
    "course",
    [0.01 / ORDER, 0.01j / ORDER**2, (0.02 + 0j) * (ORDER == 2), np.zeros(REACH)],
    ids=["evenly", "along a parabola", "swinging", "not at all"],
)
def test_a_phase_that_moves_by_itself_is_far_more_likely_than_noise_that_moves_it(course: Complex) -> None:
    none = np.zeros(REACH, dtype=np.complex128)
    movement = Movement(1.0 + 0j, 40, none, course.astype(np.complex128), 1e-8, 1e-8)
    by_noise = -float(np.sum(movement.chi2_of_phase))
    if np.any(course):
        # what it costs that neither course nor size is known
        assert -80.0 < movement.by_itself(1.0) < -3.0
        assert movement.by_itself(1.0) > by_noise + 1000.0
    else:
        assert -4.0 < movement.by_itself(1.0) < 0.0
    moving = Movement(1.0 + 0j, 40, none + 1e-3, course.astype(np.complex128), 1e-8, 1e-8)
    assert moving.by_itself(1.0) == pytest.approx(movement.by_itself(1.0) - 8e2)
