"""Vectors before and behind the converters of their two axes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.quantisation.vector_steps import vectors_as_read

_ROWS, _STEP, _SIZE, _LEVEL = 6_000, 2.0, 21.3, 0.3
Floats = NDArray[np.float64]


def _read(values: Floats, noise: float, seed: int, step: float = _STEP) -> Floats:
    """Return values behind noise and a converter, one of whose levels is `_LEVEL`."""
    noisy = values + noise * np.random.default_rng(seed).standard_normal(len(values))
    return np.asarray(np.round((noisy - _LEVEL) / step) * step + _LEVEL)


def _turning() -> tuple[Floats, Floats]:
    angle = 2.0 * np.pi * 37.3 * np.arange(_ROWS) / _ROWS
    return 5.0 + _SIZE * np.cos(angle), _SIZE * np.sin(angle) - 3.0


@pytest.mark.parametrize(("noise", "least", "most"), [(0.0, 0.0, 0.01), (0.5, 0.35, 0.65)])
def test_vectors_like_those_that_were_read_are_read_in_the_same_levels(
    noise: float, least: float, most: float
) -> None:
    alpha, beta = _turning()
    found = list(vectors_as_read(_read(alpha, noise, 1), _read(beta, noise, 2), 3.0))
    sizes = [float(np.std(each.vectors)) for each in found]
    # the middle one is as large as what was read, the others by a fifth of a step to either side at most
    assert np.mean(sizes) == pytest.approx(_SIZE, abs=0.15 * _STEP)
    assert 0.2 * _STEP < np.ptp(sizes) < 0.4 * _STEP
    assert np.all(np.diff(sizes) > 0.0)
    for each in found:
        assert np.mean(each.vectors) == pytest.approx(5.0 - 3.0j, abs=0.15 * _STEP)
        levels = (np.concatenate([each.once.real, each.once.imag]) - _LEVEL) / _STEP
        assert np.allclose(levels, np.round(levels))
        error = np.abs(each.once - each.vectors) / _STEP
        assert float(np.max(error)) < 0.75 + 4.0 * noise
        # read once, noise scatters about what is read on average
        scatter = np.sqrt(np.mean(np.abs(each.once - each.on_average) ** 2)) / _STEP
        assert least <= scatter < most
        assert abs(np.mean(each.once - each.on_average)) < 0.03 * _STEP


def test_what_is_read_on_average_is_the_mean_of_many_readings() -> None:
    alpha, beta = _turning()
    found = next(vectors_as_read(_read(alpha, 0.3, 1), _read(beta, 0.3, 2), 3.0))
    many = np.mean([_read(found.vectors.real, 0.3, seed) for seed in range(400)], axis=0)
    assert np.corrcoef(found.on_average.real - found.vectors.real, many - found.vectors.real)[0, 1] > 0.95
    assert np.std(found.on_average.real - many) < 0.1 * _STEP


def test_an_axis_without_steps_is_read_as_it_is() -> None:
    alpha, beta = _turning()
    beta = beta + 0.3 * np.random.default_rng(3).standard_normal(_ROWS)
    found, *others = vectors_as_read(_read(alpha, 0.3, 1), beta, 3.0)
    assert np.allclose(np.mean([each.vectors.imag for each in (found, *others)], axis=0), beta)
    assert np.array_equal(found.once.imag, found.vectors.imag)
    assert np.array_equal(found.on_average.imag, found.vectors.imag)
    assert not np.array_equal(found.once.real, found.vectors.real)
    # its noise is not told from it: the middle of all is the record
    assert np.corrcoef(found.vectors.imag, beta)[0, 1] > 0.9999


def test_the_size_of_steps_that_are_whole_powers_of_two_changes_nothing_else() -> None:
    """Numbers that differ in their exponents alone."""
    axes, scale = [_read(each, 0.3, seed) for seed, each in enumerate(_turning())], 2.0**-9
    large = vectors_as_read(axes[0], axes[1], 3.0)
    small = vectors_as_read(scale * axes[0], scale * axes[1], scale * 3.0)
    for one, other in zip(large, small, strict=True):
        for of_one, of_other in zip(one, other, strict=True):
            assert np.array_equal(scale * of_one, of_other)


def test_an_axis_whose_steps_noise_hides_is_read_as_it_is() -> None:
    """Vectors are as much larger as smaller than those of the record: on average these."""
    alpha, beta = _turning()
    hidden = _read(alpha, 5.0, 1)
    found = list(vectors_as_read(hidden, _read(beta, 0.3, 2), 3.0))
    assert np.allclose(np.mean([each.vectors.real for each in found], axis=0), hidden)
    assert all(np.array_equal(each.once.real, each.vectors.real) for each in found)
    assert not np.array_equal(found[0].once.imag, found[0].vectors.imag)


@pytest.mark.parametrize("turns", [4.0, 4.4])
def test_the_noise_that_is_drawn_is_that_of_the_record(turns: float) -> None:
    """Where turns are not whole, leaks of a line of many steps are more than the noise between lines."""
    angle, errors = 2.0 * np.pi * turns * np.arange(400) / 400, []
    for seed in range(6):
        alpha = _read(400.0 * np.cos(angle), 0.6, 2 * seed)
        found = next(vectors_as_read(alpha, _read(400.0 * np.sin(angle), 0.6, 2 * seed + 1), 3.0))
        errors.append(np.mean(np.abs(found.once - found.vectors) ** 2))
    # of two axes, noise and what it does not hide of the steps
    assert np.mean(errors) == pytest.approx(2.0 * (0.6**2 + _STEP**2 / 12.0), rel=0.4)


@pytest.mark.parametrize(("noise", "step", "largest"), [(5.0, 2.0, 3.0), (0.0, 2.0, 1.9), (0.3, 0.0, 3.0)])
def test_steps_that_noise_hides_that_no_converter_has_and_none_are_not_drawn(
    noise: float, step: float, largest: float
) -> None:
    random = np.random.default_rng(4)
    axes = [
        _read(each, noise, seed) if step else each + noise * random.standard_normal(_ROWS)
        for seed, each in enumerate(_turning())
    ]
    assert list(vectors_as_read(axes[0], axes[1], largest)) == []


def test_a_long_record_is_drawn_at_fewer_rows() -> None:
    angle = 2.0 * np.pi * 37.3 * np.arange(40_000) / 40_000
    found = next(
        vectors_as_read(_read(_SIZE * np.cos(angle), 0.3, 1), _read(_SIZE * np.sin(angle), 0.3, 2), 3.0)
    )
    assert len(found.once) == 40_000 // 3 + 1
