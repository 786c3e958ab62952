"""THD with noise: how much the noise of another record moves it."""

import math

import numpy as np

from benchmarks.coverage.noise import pink
from benchtool.analysis.spectra.distortion_with_noise import _together

PERIODS, PER_PERIOD = 37, 50


def test_slow_noise_beside_a_dc_that_decays_is_not_lost_to_its_fit() -> None:
    # the fit takes most of what moves the sum of both squares, and 1/f noise is more there than above
    random, place = np.random.default_rng(4), np.linspace(0.0, 1.0, PERIODS * PER_PERIOD, endpoint=False)
    decay = 0.4 * np.exp(-place / 0.15)
    fit = np.column_stack([np.ones(len(place)), decay, place * decay])
    products, stated = [], []
    for _ in range(60):
        noise = 1e-2 * pink(random, len(place))
        products.append(2.0 * float(np.mean((decay - np.mean(decay)) * noise)))
        left = noise - fit @ np.linalg.lstsq(fit, noise, rcond=None)[0]
        stated.append(_together(decay, left.reshape(PERIODS, PER_PERIOD), decays=True))
    assert 0.8 < float(np.std(products)) / math.sqrt(float(np.mean(np.square(stated)))) < 1.25
    alone = [_together(decay, left.reshape(PERIODS, PER_PERIOD), decays=False)]
    assert float(np.std(products)) > 1.5 * max(alone)
