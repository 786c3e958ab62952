"""A line fitted to what moves a harmonic: its size and place, or the angle between it and the others."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from benchtool.analysis.spectra.harmonic_movement import Movement, parts_of
from benchtool.analysis.spectra.interharmonics import dirichlet_kernel
from benchtool.analysis.spectra.line_beside import (
    LineFit,
    _most_excess,
    _standard,
    kernel_along_phase,
    kernel_in_time,
)
from benchtool.analysis.spectra.moving_tones import Course

Complex = NDArray[np.complex128]
REACH, COUNT, NUMBER = 8, 4000, 40
KERNEL = partial(kernel_along_phase, reach=REACH, count=COUNT)
BINS = np.arange(-REACH, REACH + 1)
OF_AMPLITUDE, OF_PHASE = 1e-5, 3e-4
BY_ITSELF = 5.0


def noise(random: np.random.Generator, of: float) -> Complex:
    return np.asarray(of * (random.standard_normal(REACH) + 1j * random.standard_normal(REACH)) / 2**0.5)


def moved(random: np.random.Generator, around: Complex) -> Movement:
    amplitude, phase = parts_of(around)
    amplitude, phase = amplitude + noise(random, OF_AMPLITUDE), phase + noise(random, OF_PHASE)
    return Movement(complex(around[REACH]), NUMBER, amplitude, phase, OF_AMPLITUDE**2, OF_PHASE**2)


def with_line(bins: float, phasor: complex) -> Complex:
    around = phasor * dirichlet_kernel(np.array([bins]), BINS, COUNT)
    around[REACH] += 1.0
    return np.asarray(around)


@pytest.mark.parametrize("bins", [-0.7, 0.4, 1.1])
def test_a_line_is_told_from_an_angle_that_moves(bins: float) -> None:
    errors = []
    for seed in range(20):
        random = np.random.default_rng(seed)
        phasor = 0.02 * np.exp(1j * random.uniform(0, 2 * np.pi))
        around = with_line(bins, phasor)
        found = LineFit.of(moved(random, around), 1.0, KERNEL).line(1.0, BY_ITSELF)
        assert found.share > 0.999
        assert found.place - NUMBER == pytest.approx(bins, abs=0.1)
        made = phasor * dirichlet_kernel(np.array([bins]), np.array([0]), COUNT)[0]
        told = found.phasor * dirichlet_kernel(np.array([found.place - NUMBER]), np.array([0]), COUNT)[0]
        errors.append(((told - made) / around[REACH]).real / found.standard)
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.5


@pytest.mark.parametrize("cycles", [0.2, 2.0])
def test_an_angle_that_moves_is_told_from_a_line(cycles: float) -> None:
    for seed in range(10):
        random = np.random.default_rng(seed)
        time = (np.arange(COUNT) + 0.5) / COUNT
        turned = 0.02 * np.sin(2.0 * np.pi * cycles * time + random.uniform(0, 2 * np.pi))
        around = np.array([np.mean(np.exp(1j * turned - 2j * np.pi * k * time)) for k in BINS])
        found = LineFit.of(moved(random, around), 1.0, KERNEL).line(1.0, BY_ITSELF)
        assert found.share < 0.03
        assert found.standard < 6e-3
        # where the angle cannot move by itself a line is all that is left
        alone = LineFit.of(moved(random, around), 1.0, KERNEL).line(1.0, 0.0)
        assert alone.share == 1.0
        assert alone.standard > 1.5 * found.standard


def test_what_no_single_line_makes_is_not_taken_out_and_is_uncertain_by_its_size() -> None:
    ill, errors = 0, []
    for seed in range(12):
        random = np.random.default_rng(seed)
        first, second = 0.02 * np.exp(1j * random.uniform(0, 2 * np.pi, 2))
        around = with_line(0.3, first) + with_line(-0.6, second)
        around[REACH] -= 1.0
        fit = LineFit.of(moved(random, around), 1.0, KERNEL)
        found = fit.line(1.0, 0.0)
        assert (found.phasor == 0.0) is fit.is_ill
        ill += fit.is_ill
        if fit.is_ill:
            errors.append((abs(around[REACH]) - 1.0) / found.standard)
    assert ill > 6
    assert 0.2 < np.sqrt(np.mean(np.square(errors))) < 2.0
    noise_alone = LineFit.of(moved(np.random.default_rng(4), with_line(0.4, 0.0)), 1.0, KERNEL)
    assert not noise_alone.is_ill
    assert noise_alone.line(0.1, 0.0).standard < 1e-4


def test_a_fit_is_ill_where_noise_leaves_as_much_once_in_a_thousand_times() -> None:
    """The greatest is a quantile of Fisher's distribution: the noise was read off some forty bins."""
    for dof in (13.0, 29.0):
        assert _most_excess(dof) == pytest.approx(stats.f.isf(1e-3, dof, 40.0), rel=1e-6)
    movement = moved(np.random.default_rng(0), with_line(0.3, 0.02))
    fit = LineFit.of(movement, 1.0, KERNEL)
    assert fit.dof == 4 * REACH - 3
    # of 2 reach complex values the squares that are left, over what noise leaves of so many
    rest = np.min(-fit.likely) * fit.scale
    assert fit.excess == pytest.approx(2.0 * rest / fit.dof, rel=0.03)
    assert fit.scale == pytest.approx(max(1.0, fit.excess), rel=0.03)


def test_a_line_of_one_frequency_moves_along_a_phase_that_does() -> None:
    turned = (np.arange(4096) + 0.5) / 4096
    steady = kernel_in_time(-1.0, 1.0, NUMBER, REACH, Course(turned, turned))
    along = kernel_along_phase(-1.0, 1.0, REACH, 4096)
    # both begin within half a sample of each other
    assert np.max(np.abs(np.abs(steady.own) - np.abs(along.own))) < 1e-4
    assert np.max(np.abs(np.abs(steady.sum) - np.abs(along.sum))) < 2e-2
    passed = turned + 2e-3 * (turned**2 - turned)
    moving = kernel_in_time(-1.0, 1.0, NUMBER, REACH, Course(turned, passed))
    times = np.linspace(0.0, 1.0, 20001)[:-1] + 2.5e-5
    at = np.interp(times, turned, passed)
    line = np.exp(2j * np.pi * (NUMBER * (at - times) + moving.apart[10] * at))
    bins = np.array([np.mean(line * np.exp(-2j * np.pi * k * times)) for k in BINS])
    assert moving.own[10] == pytest.approx(bins[REACH], abs=2e-3)
    assert moving.sum[10] == pytest.approx(0.5 * (bins[REACH + 1 :] + np.conj(bins[:REACH][::-1])), abs=5e-3)


def test_a_standard_uncertainty_is_the_deviation_or_that_of_all_but_a_twentieth() -> None:
    none = np.zeros(100)
    even = np.full(100, 0.01)
    assert _standard(none, none + 2.0, even) == pytest.approx(2.0)
    assert _standard(none + 3.0, none, even) == pytest.approx(3.0 / 1.96)
    far = none.copy()
    far[:4] = 1e3  # of four in a hundred the deviation would be two hundred
    assert _standard(far, none + 1.0, even) == pytest.approx(2.0 / 1.96, rel=0.02)
    far[:8] = -1e3  # and these are more than a twentieth
    assert _standard(far, none + 1.0, even) > 200.0


def test_a_line_is_no_larger_than_twice_the_harmonic_beside_it() -> None:
    none = np.zeros(REACH, dtype=np.complex128)
    evenly = (0.3 / np.arange(1.0, REACH + 1.0)).astype(np.complex128)
    fit = LineFit.of(Movement(1.0 + 0j, NUMBER, none, evenly, 1e-4, 1e-4), 10.0, KERNEL)
    assert np.max(np.abs(fit.makes)) > 4.0
    assert fit.line(1.0, 0.0).standard < 2.0


def test_two_lines_make_no_more_than_twice_the_harmonic_beside_them() -> None:
    time = (np.arange(COUNT) + 0.5) / COUNT
    # decays as what a rotor or a loop leaves behind, which is no line, and no two
    course = np.exp(-time / 0.1 + 0.4j * time)
    around = np.array([np.mean(course * np.exp(-2j * np.pi * k * time)) for k in BINS])
    fit = LineFit.of(moved(np.random.default_rng(2), around), 10.0, KERNEL)
    assert fit.is_ill
    assert fit.line(1.0, 0.0).standard < 2.0 * abs(around[REACH])
