"""What moves a harmonic by itself: with the noise that the others tell it with, and by which courses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.spectra.harmonic_movement import SIZES, Movement, movements_of, parts_of

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


def modulated(sizes: list[float], amplitude: Complex, phase: list[Complex]) -> Complex:
    """Return the bins around harmonics of which the phase is moved each by its own course."""
    around = np.zeros((len(sizes), 2 * REACH + 1), dtype=np.complex128)
    for row, size, of_phase in zip(around, sizes, phase, strict=True):
        row[:] = size * np.concatenate([np.conj((amplitude - of_phase)[::-1]), [1.0], amplitude + of_phase])
    return around


def test_amplitude_and_phase_are_half_the_sum_and_the_difference_of_both_sides() -> None:
    random = np.random.default_rng(2)
    amplitude, phase = noise(random, REACH), noise(random, REACH)
    found = parts_of(modulated([2.0], amplitude, [phase])[0] * np.exp(0.7j))
    np.testing.assert_allclose(found, (amplitude, phase), atol=1e-14)


def test_a_harmonic_is_held_against_none_the_fundamental_and_all_others() -> None:
    sizes, floor2 = [1.0, 0.1, 0.2, 0.004], 1e-6
    random = np.random.default_rng(6)
    amplitude, phase = 1e-2 * noise(random, REACH), [1e-2 * noise(random, REACH) for _ in sizes]
    around = modulated(sizes, amplitude, phase)
    fundamental = movements_of(around, np.full(4, floor2), 0, 40)
    assert len(fundamental) == 2
    # of harmonics 2 and 3, each by the noise in it over its order; the last does not stand out
    mean, mean2 = _mean(phase[1] / 2.0, floor2 / 0.02 / 4.0, phase[2] / 3.0, floor2 / 0.08 / 9.0)
    for each, told in zip(fundamental, (amplitude, 0.0 * amplitude), strict=True):
        np.testing.assert_allclose(each.amplitude, told, atol=1e-12)
        np.testing.assert_allclose(each.phase, phase[0] - mean, atol=1e-12)
        assert each.of_phase2 == pytest.approx(floor2 / 2.0 + mean2)
    assert [each.of_amplitude2 for each in fundamental] == pytest.approx(
        [floor2 / 2.0, floor2 / 2.0 + 1.0 / (1.0 / (floor2 / 0.02) + 1.0 / (floor2 / 0.08))]
    )
    third = movements_of(around, np.full(4, floor2), 2, 120)
    assert [each.number for each in third] == [120] * 4  # harmonic 2 alone is no mean
    own2 = floor2 / 0.08
    assert [(each.of_amplitude2, each.of_phase2) for each in third] == [
        pytest.approx((own2 + with_amplitude2, own2 + 9.0 * with_phase2))
        for with_amplitude2 in (0.0, floor2 / 2.0)
        for with_phase2 in (0.0, floor2 / 2.0)
    ]
    np.testing.assert_allclose(third[0].phase, phase[2], atol=1e-12)
    np.testing.assert_allclose(third[1].phase, phase[2] - 3.0 * phase[0], atol=1e-12)


def _mean(first: Complex, first2: float, second: Complex, second2: float) -> tuple[Complex, float]:
    """Return the weighted mean of two courses, and its mean square error by their scatter."""
    mean = (first / first2 + second / second2) / (1.0 / first2 + 1.0 / second2)
    scatter = np.sum(np.abs(first - mean) ** 2) / first2 + np.sum(np.abs(second - mean) ** 2) / second2
    return mean, max(1.0, float(scatter) / REACH) / (1.0 / first2 + 1.0 / second2)


def test_a_phase_moves_as_far_to_one_side_as_to_the_other() -> None:
    none = np.zeros(REACH, dtype=np.complex128)
    for sign in (1.0, -1.0):
        movement = Movement(1.0 + 0j, 40, none, (sign * 3e-4 / ORDER).astype(np.complex128), 1e-8, 1e-8)
        assert movement.moved == pytest.approx(3.0 * math.sqrt(2.0 * float(np.sum(1.0 / ORDER**2))))


def test_what_a_phase_that_moves_evenly_costs_is_that_its_size_is_not_known() -> None:
    none = np.zeros(REACH, dtype=np.complex128)
    for size in (0.01, 0.1):
        movement = Movement(1.0 + 0j, 40, none, (size / ORDER).astype(np.complex128), 1e-8, 1e-8)
        squares = float(np.sum(movement.chi2_of_phase))
        evenly = 0.5 * math.log(math.pi / squares) - math.log(4.0 * SIZES)  # or not at all
        no_parabola = math.log(0.5 * (1.0 + math.sqrt(math.pi) / (2.0 * SIZES)))
        assert movement.by_itself(1.0) == pytest.approx(evenly + no_parabola + math.log(0.5), abs=0.1)


def test_an_amplitude_that_moves_by_itself_is_as_likely_as_a_phase_that_does() -> None:
    none = np.zeros(REACH, dtype=np.complex128)
    of_phase = (0.01 / ORDER).astype(np.complex128)
    of_amplitude = np.multiply(-1j, of_phase, dtype=np.complex128)
    one = Movement(1.0 + 0j, 40, none, of_phase, 1e-8, 1e-8)
    other = Movement(1.0 + 0j, 40, of_amplitude, none, 1e-8, 1e-8)
    assert other.both_by_themselves(1.0) == pytest.approx(one.both_by_themselves(1.0))
    assert other.both_by_themselves(1.0) > other.by_itself(1.0) + 1e3
