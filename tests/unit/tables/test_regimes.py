"""Regimes of a record: stretches at levels of their own, and what is none."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.tables.regimes import regimes

Array = NDArray[np.float64]
SHARE = np.arange(5_000) / 5_000


def noisy(values: Array, seed: int, rms: float = 0.01) -> Array:
    return np.asarray(values + rms * np.random.default_rng(seed).standard_normal(len(values)))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    ("begins", "levels"),
    [
        ((0.5,), (1, 2)),
        ((0.97,), (1, 2)),
        ((0.03,), (2, 1)),
        ((0.36, 0.7), (1, 3, 2)),
        ((0.4, 0.44), (1, 2, 1)),
    ],
)
def test_levels_are_counted(begins: tuple[float, ...], levels: tuple[float, ...], seed: int) -> None:
    values = np.asarray(levels, dtype=np.float64)[np.searchsorted(begins, SHARE, side="right")]
    found = regimes(noisy(values + 0.1 * np.cos(2 * np.pi * 1_000 * SHARE), seed), "Nm")
    assert found is not None
    assert found.levels == len(set(levels))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("rms", [0.0, 0.01, 0.1, 0.3])
@pytest.mark.parametrize(
    "values",
    [
        *(1.0 + SHARE, 1.0 + SHARE**2, 1.0 + np.exp(-5.0 * SHARE), 0.0 * SHARE + 1.0),
        *(np.sin(2 * np.pi * count * SHARE) for count in (1.0, 1.5, 3.5, 17.3, 40.0)),
    ],
)
def test_drifts_and_swings_have_none(values: Array, rms: float, seed: int) -> None:
    assert regimes(noisy(values.astype(np.float64), seed, rms), "Nm") is None


@pytest.mark.parametrize("periods", [16.0, 24.0, 40.0, 48.0, 80.0, 95.97])
@pytest.mark.parametrize("mean", [0.0, 8.0])
def test_whole_periods_do_not_beat_with_the_parts(periods: float, mean: float) -> None:
    share = np.arange(round(periods) * 100) / (round(periods) * 100)
    for seed, phase in enumerate(np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)):
        values = mean + 10.0 * np.sin(2.0 * np.pi * periods * share + phase)
        assert regimes(noisy(values, seed, 0.02), "A") is None


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("periods", [17.3, 40.0, 80.0, 400.0])
def test_amplitudes_and_means_of_an_alternating_current_have_their_levels(periods: float, seed: int) -> None:
    levels = np.where(SHARE < 0.4, 1.0, 2.0)
    sine = np.sin(2.0 * np.pi * periods * SHARE + seed)
    for values, of in ((levels * sine, "rms deviation"), (levels + 0.5 * sine, "average")):
        found = regimes(noisy(values, seed), "A")
        assert found is not None
        assert found.levels == 2
        assert of in found.text


@pytest.mark.parametrize("seed", range(5))
def test_spikes_are_no_regime(seed: int) -> None:
    spikes = 5.0 * (np.random.default_rng(seed + 50).random(5_000) < 5e-4)
    assert regimes(noisy(np.asarray(1.0 + spikes, np.float64), seed), "Nm") is None


@pytest.mark.parametrize("value", [0.0, 1.0, -9e37])
def test_a_dead_signal_has_none(value: float) -> None:
    assert regimes(np.full(500, value), "Nm") is None
    assert regimes(np.full(5, value), "Nm") is None
