"""A response between frequencies that no parabola follows, by its reciprocals, and how far off it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize

from benchtool.analysis.measurement import Basis
from benchtool.analysis.responses.local_reciprocal import LocalReciprocal
from benchtool.analysis.responses.margins import margins
from benchtool.analysis.responses.response_curve import ResponseCurve

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]


def _two_poles(frequency_Hz: Floats, corner_Hz: float, damping: float, dead_s: float = 0.0) -> Complex:
    s = 1j * frequency_Hz / corner_Hz
    return np.asarray(np.exp(-2j * np.pi * dead_s * frequency_Hz) / (1.0 + 2.0 * damping * s + s**2))


def _noise(random: np.random.Generator, count: int) -> Complex:
    return np.asarray(random.standard_normal(count) + 1j * random.standard_normal(count))


@pytest.mark.parametrize("damping", [0.02, 0.3, 1.0])
def test_two_poles_are_known_between_few_frequencies(damping: float) -> None:
    frequency_Hz = np.geomspace(10.0, 1000.0, 9)
    reciprocal = LocalReciprocal(
        frequency_Hz, 1.0 / _two_poles(frequency_Hz, 123.0, damping), np.full(9, 1e-12)
    )
    for at in range(1, 9):
        fine_Hz = np.linspace(frequency_Hz[at - 1], frequency_Hz[at], 7)
        found, error = reciprocal.between(at, fine_Hz)
        np.testing.assert_allclose(found * _two_poles(fine_Hz, 123.0, damping), 1.0, rtol=1e-9)
        # at either end one quartic at least tells the same
        assert float(np.max(error)) < 1e-9 or at in (1, 8)


@pytest.mark.parametrize("damping", [0.05, 0.35, 0.8])
@pytest.mark.parametrize("noise", [1e-6, 1e-4, 1e-2])
def test_the_error_between_frequencies_is_known_to_its_size(damping: float, noise: float) -> None:
    """-90 degrees of two poles behind a dead time, wherever they are between the frequencies."""
    random = np.random.default_rng(5)
    missed = []
    for _ in range(32):
        corner_Hz, frequency_Hz = random.uniform(200.0, 240.0), np.geomspace(20.0, 900.0, 30)
        response = _two_poles(frequency_Hz, corner_Hz, damping, 0.04 / corner_Hz)
        response *= np.exp(noise * _noise(random, 30))
        curve = ResponseCurve.of_phase(frequency_Hz, response, np.full(30, noise), math.pi / 2)
        found = curve.falls_to(-0.5 * math.pi)
        truth_Hz = optimize.brentq(
            lambda f, w=corner_Hz: float(np.real(_two_poles(np.array([f]), w, damping, 0.04 / w)[0])),
            0.7 * corner_Hz,
            corner_Hz,
        )
        assert found is not None
        missed.append((found.frequency_Hz - truth_Hz) / found.standard_Hz)
    assert 0.6 < math.sqrt(float(np.mean(np.square(missed)))) < 1.4
    assert float(np.mean(np.abs(missed) < 2.0)) > 0.9


def test_what_errors_make_polynomials_differ_by_counts_once() -> None:
    random = np.random.default_rng(3)
    frequency_Hz, middle_Hz = np.arange(10.0, 300.0, 10.0), np.array([105.0])
    relative = []
    for _ in range(200):
        response = _two_poles(frequency_Hz, 100.0, 0.5) * np.exp(0.01 * _noise(random, 29))
        found, error = LocalReciprocal(frequency_Hz, 1.0 / response, np.full(29, 0.01)).between(10, middle_Hz)
        missed = np.log(found * _two_poles(middle_Hz, 100.0, 0.5))
        relative += [float(missed.real[0] / error[0]), float(missed.imag[0] / error[0])]
    assert 0.8 < math.sqrt(float(np.mean(np.square(relative)))) < 1.1


def test_a_response_that_reciprocals_do_not_follow_is_uncertain() -> None:
    """An antiresonance between two frequencies is a pole of the reciprocal."""
    frequency_Hz = np.geomspace(10.0, 1000.0, 14)
    reciprocal = _two_poles(frequency_Hz, 130.0, 0.05)
    found, error = LocalReciprocal(frequency_Hz, reciprocal, np.full(14, 1e-9)).between(
        int(np.searchsorted(frequency_Hz, 130.0)), np.array([130.0])
    )
    truth = _two_poles(np.array([130.0]), 130.0, 0.05)
    assert abs(found[0] / truth[0] - 1.0) < 4.0 * error[0]
    assert error[0] > 0.2


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_few_frequencies_are_followed_as_far_as_they_go(count: int) -> None:
    frequency_Hz = np.arange(1.0, count + 1.0)
    values = np.asarray(1.0 + 2j * frequency_Hz, dtype=np.complex128)
    reciprocal = LocalReciprocal(frequency_Hz, values, np.full(count, 1e-3))
    for at in range(1, count):
        found, error = reciprocal.between(at, np.array([at + 0.5]))
        assert found[0] == pytest.approx(1.0 + 2j * (at + 0.5), rel=1e-9)
        assert 1e-4 < error[0] < 2e-3


@pytest.mark.parametrize("crossover_Hz", [80.0, 97.0, 111.0])
def test_margins_of_an_integrator_with_a_dead_time_are_read_between_lines(crossover_Hz: float) -> None:
    """Phase margin pi / 2 - w_c tau, gain margin pi / (2 w_c tau); the peak by a fine search."""
    turn = 0.8  # w_c tau

    def closed(frequency_Hz: Floats) -> Complex:
        late = np.exp(-1j * turn * frequency_Hz / crossover_Hz)
        opened = late * crossover_Hz / (1j * frequency_Hz)
        return np.asarray(opened / (1.0 + opened))

    frequency_Hz, fine_Hz = np.geomspace(8.0, 900.0, 20), np.linspace(20.0, 400.0, 100_001)
    basis = Basis(1000, 1e4, 0.1, bandwidth_Hz=900.0, window="none", reference="", gaps=0)
    found = {
        each.name: each for each in margins(frequency_Hz, closed(frequency_Hz), np.full(20, 1e-6), basis)
    }
    truths = {
        "crossover": crossover_Hz,
        "phase_margin": 90.0 - math.degrees(turn),
        "gain_margin": 20.0 * math.log10(0.5 * math.pi / turn),
        "sensitivity_peak": float(np.max(np.abs(1.0 - closed(fine_Hz)))),
    }
    for name, truth in truths.items():
        uncertain = found[name].uncertainty
        assert uncertain is not None
        assert found[name].value == pytest.approx(truth, rel=3e-3)
        assert abs(found[name].value - truth) < 2.5 * uncertain.standard
        assert uncertain.standard < 3e-3 * truth


def test_errors_that_neighbours_have_in_common_are_no_less_between_them() -> None:
    """Running means over four places: what lies between is as uncertain as they are."""
    random, missed = np.random.default_rng(11), []
    frequency_Hz, shared = np.arange(20.0, 60.0), np.full(40, 4.0)
    truth = _two_poles(frequency_Hz, 123.0, 0.3)
    for _ in range(200):
        white = _noise(random, 43)
        noise = 1e-3 * np.convolve(white, np.full(4, 0.5), "valid")
        reciprocal = LocalReciprocal(frequency_Hz, (1.0 + noise) / truth, np.full(40, 2e-3), shared)
        found, error = reciprocal.between(20, np.array([39.5]))
        off = found * _two_poles(np.array([39.5]), 123.0, 0.3) - 1.0
        missed.append(float(off[0].real / error[0]))
    assert 0.8 < float(np.sqrt(np.mean(np.square(missed)))) < 1.25
