"""How the mean speed of the next record differs, against the scatter over many."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest
from scipy import signal

from benchtool.analysis.quantisation.resolution import counting_step
from benchtool.analysis.statistics.repeatability import wander_of_difference, wander_of_line


@pytest.mark.parametrize("kind", ["held", "let go", "of a memory", "behind noise"])
def test_the_wander_is_the_scatter_over_records(
    kind: Literal["held", "let go", "of a memory", "behind noise"],
) -> None:
    random = np.random.default_rng(4)
    records = random.standard_normal((80, 2000))
    if kind == "of a memory":  # of a fifteenth of the record
        memory = math.exp(-15.0 / 2000)
        records = signal.lfilter([1.0], [1.0, -memory], random.standard_normal((80, 4000)), axis=1)[:, 2000:]
    if kind != "held":
        records = np.cumsum(records, axis=1)
    turned = records[:, -1] - records[:, 0]
    if kind == "behind noise":  # of an encoder, which a fit over the record averages
        records = records + 15.0 * random.standard_normal(records.shape)
    stated = np.array([wander_of_difference(each).standard for each in records])
    assert 0.6 < float(np.sqrt(np.mean(turned**2 / stated**2))) < 1.3


def test_a_steady_drift_is_no_wander_and_few_values_tell_none() -> None:
    assert wander_of_difference(0.1 * np.arange(500.0) ** 2).standard < 1e-6
    assert math.isnan(wander_of_difference(np.arange(5.0)).standard)


def test_a_step_counts_where_it_is_one() -> None:
    values = np.random.default_rng(2).standard_normal(20_000)
    assert counting_step(values) == 0.0
    assert counting_step(values[:60]) == 0.0
    assert counting_step(np.round(values / 1e-3) * 1e-3) == pytest.approx(1e-3)
    assert counting_step((1.0 + 1e-3 * values).astype(np.float32).astype(np.float64)) == pytest.approx(0.0)


def test_the_wander_of_a_line_is_the_scatter_of_its_mean_frequency() -> None:
    """A line at 470 Hz whose phase walks at random; the mean frequency is by the phase at both ends."""
    random, rate_Hz, count = np.random.default_rng(9), 10e3, 4000
    walks = np.cumsum(0.02 * random.standard_normal((60, count)), axis=1)
    rows = np.arange(count)
    samples = np.cos(2.0 * np.pi * 470.0 / rate_Hz * rows + walks) + 0.05 * random.standard_normal(
        walks.shape
    )
    found = [wander_of_line(each, rate_Hz, 470.0) for each in samples]
    stated = np.sqrt(np.mean([each.standard**2 for each in found if each is not None]))
    true_Hz = float(np.std(walks[:, -1] - walks[:, 0])) * rate_Hz / (2.0 * np.pi * count)
    assert 0.7 < true_Hz / stated < 1.4
    assert wander_of_line(samples[0][:63], rate_Hz, 470.0) is None
