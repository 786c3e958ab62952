"""The error of a mean against the scatter of many means."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import signal

from benchtool.analysis.scatter import error_of_record


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_it_is_the_scatter_of_the_mean_also_of_correlated_samples(memory: float) -> None:
    records = np.random.default_rng(0).standard_normal((400, 5000))
    records = signal.lfilter([1.0], [1.0, -memory], records, axis=1)
    scatter = float(np.std(np.mean(records, axis=1)))
    stated = np.array([error_of_record(record).standard for record in records])
    assert np.sqrt(np.mean(stated**2)) == pytest.approx(scatter, rel=0.1)


def test_a_short_record_has_none() -> None:
    assert math.isnan(error_of_record(np.arange(19.0)).standard)
    assert error_of_record(np.ones(20)).standard == 0.0
