"""Responses over neighbouring bins, also where two poles are within them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import signal

from benchtool.analysis.responses.estimated_response import FrequencyResponse
from benchtool.analysis.responses.frequency_response import local_response
from benchtool.analysis.responses.local_polynomial import _first_of_inverse
from tests.at_length import at_length

RATE_HZ = 10_000.0


def swept(corner_Hz: float, damping: float, noise: float, seed: int) -> tuple[FrequencyResponse, np.ndarray]:
    """Return the response of a lag to a short sweep of any phase that begins at once, and the true one."""
    random, omega = np.random.default_rng(seed), 2.0 * math.pi * corner_Hz
    lag = signal.cont2discrete(
        (np.array([omega**2]), np.array([1.0, 2.0 * damping * omega, omega**2])), 1.0 / RATE_HZ
    )
    ahead, behind = np.ravel(lag[0]), np.ravel(lag[1])
    time_s = np.arange(6_000) / RATE_HZ
    x = signal.chirp(time_s, 2.0, 0.6, 2_000.0, "logarithmic", phi=random.uniform(0.0, 360.0))
    y = signal.lfilter(ahead, behind, x)
    y = y + noise * np.std(y) * random.standard_normal(len(y))
    found = local_response(x, y, RATE_HZ)
    return found, signal.freqz(ahead, behind, found.frequency_Hz, fs=RATE_HZ)[1]


@pytest.mark.parametrize(("corner_Hz", "damping"), [(35.0, 0.2), *at_length((22.0, 0.56))])
def test_a_lag_of_second_order_within_the_bins_is_not_off_in_one_direction(
    corner_Hz: float, damping: float
) -> None:
    """The lowest six frequencies were off by two to four times their error with one pole."""
    off = []
    for seed in range(12):
        found, truth = swept(corner_Hz, damping, 5e-3, seed)
        off.append(((found.response / truth - 1.0) / found.error)[:6])
    assert float(np.max(np.abs(np.mean(off, axis=0)))) < 1.1
    assert 0.6 < float(np.sqrt(0.5 * np.mean(np.abs(off) ** 2))) < 1.4


def test_a_second_pole_makes_the_error_less() -> None:
    found, _ = swept(22.0, 0.56, 5e-3, 1)
    assert float(np.median(found.error[:4])) < 4e-4  # 1.1e-3 with one


def test_noise_alone_gives_no_poles() -> None:
    """Of a gain without any, in as much noise, the error is that of a parabola."""
    random = np.random.default_rng(2)
    x = random.standard_normal(20_000)
    found = local_response(x, x + 0.3 * random.standard_normal(len(x)), RATE_HZ)
    off = (found.response - 1.0) / found.error
    assert 0.85 < float(np.sqrt(0.5 * np.mean(np.abs(off) ** 2))) < 1.15
    assert float(np.median(found.error)) == pytest.approx(0.3 * math.sqrt(0.5 * 2.25 / 17.0), rel=0.15)


def test_the_first_row_of_an_inverse_is_that_of_the_pseudo_inverse_also_where_there_is_none() -> None:
    random = np.random.default_rng(1)
    matrices = np.triu(random.standard_normal((6, 5, 5)) + 1j * random.standard_normal((6, 5, 5)))
    matrices[2, 3, 3] = matrices[4, 0, 0] = 0.0
    found = _first_of_inverse(matrices)
    np.testing.assert_allclose(found, np.linalg.pinv(matrices)[:, 0, :], rtol=1e-9, atol=1e-9)
