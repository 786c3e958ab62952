"""The mean frequency of a line whose phase swings slowly, hidden in its main lobe."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.spectra.lines import sinusoids_of

_COUNT, _PLACE = 1500, 80.3


def _errors(swing_rad: float, cycles: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Errors over their uncertainties of the place of a line in 40 records."""
    found = []
    for seed in range(40):
        random = np.random.default_rng(seed)
        time = np.arange(_COUNT) / _COUNT
        phase = 2 * np.pi * _PLACE * time + random.uniform(0, 2 * np.pi)
        phase += swing_rad * np.sin(2 * np.pi * cycles * time + random.uniform(0, 2 * np.pi))
        line = sinusoids_of(2.0 + np.cos(phase) + 0.3 * random.standard_normal(_COUNT))[0]
        mean = (phase[-1] - phase[0]) / (2 * np.pi) * _COUNT / (_COUNT - 1)
        if not line.reason:
            found.append((line.place - mean) / line.of_place)
    return np.array(found)


@pytest.mark.parametrize(("swing_rad", "cycles"), [(0.0, 1.0), (0.4, 0.7), (0.3, 0.9)])
def test_the_mean_is_within_its_uncertainty_under_a_slow_swing(swing_rad: float, cycles: float) -> None:
    errors = _errors(swing_rad, cycles)

    assert len(errors) >= 30
    assert 0.6 < float(np.sqrt(np.mean(errors**2))) < 1.5
