"""Steps of a speed that an encoder counts: levels of counts are no levels of a converter."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.steps.step import analyze_step
from benchtool.block import Block

RATE_HZ, COUNTS = 1_000.0, 4_096
COUNT_RAD_S = 2.0 * np.pi / COUNTS * RATE_HZ  # of a reading
BEFORE, AFTER = 200, 800
OMEGA, DAMPING, HEIGHT, BASE = 40.0, 0.5, 100.0, 10.0
FINE = 20


def answer(time_s: np.ndarray) -> np.ndarray:
    """Return what a loop of second order answers to a step at zero."""
    since, ring = np.maximum(time_s, 0.0), OMEGA * np.sqrt(1.0 - DAMPING**2)
    wave = np.cos(ring * since) + DAMPING * OMEGA / ring * np.sin(ring * since)
    return np.asarray(1.0 - np.exp(-DAMPING * OMEGA * since) * wave)


def numbers(random: np.random.Generator, base: float = BASE) -> dict[str, Measurement]:
    """Return those of a step that begins anywhere in a row, of an encoder that begins anywhere in a count."""
    fine = 1.0 / (RATE_HZ * FINE)
    time_s = np.arange(-(BEFORE + 1) * FINE, AFTER * FINE) * fine + random.uniform() / RATE_HZ
    angle = np.cumsum(base + HEIGHT * answer(time_s)) * fine
    counts = np.floor(angle[::FINE] * COUNTS / (2.0 * np.pi) + random.uniform())
    since = time_s[::FINE][1:]
    reference = base + HEIGHT * (since >= 0.0)
    units = {"speed": "rad/s", "reference": "rad/s"}
    block = Block.from_arrays(RATE_HZ, units, speed=COUNT_RAD_S * np.diff(counts), reference=reference)
    return {each.name: each for each in analyze_step(block, "speed", "reference").measurements}


@pytest.mark.parametrize("base", [BASE, 0.0])
def test_excursions_of_a_counted_speed_are_known_to_less_than_a_count(base: float) -> None:
    over = HEIGHT * np.exp(-np.pi * DAMPING / np.sqrt(1.0 - DAMPING**2))
    truths = {"overshoot": over, "undershoot": over**2 / HEIGHT}
    random = np.random.default_rng(6)
    found = [numbers(random, base) for _ in range(3)]
    for name, truth in truths.items():
        errors = []
        for each in found:
            uncertainty = each[name].uncertainty
            assert uncertainty is not None
            assert uncertainty.standard < 0.2 * COUNT_RAD_S
            errors.append((each[name].value - truth) / uncertainty.standard)
        assert np.sqrt(np.mean(np.square(errors))) < 1.4


def test_a_counted_speed_settles_within_the_band_and_not_within_a_count() -> None:
    fine_s = np.arange(0.0, AFTER / RATE_HZ, 1e-5)
    outside = fine_s[np.abs(answer(fine_s) - 1.0) > 0.02]
    truth_s = outside[-1] + 0.5 / RATE_HZ  # a reading is the mean since the row before
    for each in (numbers(random) for random in map(np.random.default_rng, range(3))):
        settling = each["settling_time"]
        assert settling.uncertainty is not None
        assert settling.uncertainty.standard < 0.005
        assert settling.basis.band == pytest.approx(0.02 * HEIGHT)
        assert abs(settling.value - truth_s) < 3.0 * settling.uncertainty.standard
