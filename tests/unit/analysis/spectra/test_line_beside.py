"""A line fitted to what moves a harmonic: its size and place, or the angle between it and the others."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.spectra.harmonic_movement import Movement, parts_of
from benchtool.analysis.spectra.interharmonics import dirichlet_kernel
from benchtool.analysis.spectra.line_beside import LineFit, kernel_along_phase

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
        assert alone.standard > 3.0 * found.standard
