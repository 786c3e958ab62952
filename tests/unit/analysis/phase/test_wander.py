"""Phase and amplitude of the fundamental in each period."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.coherent.spectrum import CoherentSamples
from benchtool.analysis.phase.wander import wander


@pytest.mark.parametrize("begin_rad", [0.0, 0.7, 2.0])
def test_an_amplitude_that_settles_moves_no_phase(begin_rad: float) -> None:
    """What grows within a period has an image at the negative frequency, of up to 4 mrad here."""
    periods, per_period = 20, 64
    place = np.arange(periods * per_period) / per_period
    values = (1.0 + 0.3 * np.exp(-place / 4.0)) * np.cos(2.0 * np.pi * place + begin_rad)
    found = wander(CoherentSamples(values, periods, len(values), 10e3))
    assert np.ptp(found.phase_rad) < 1e-3
    assert found.amplitude == pytest.approx(1.0 + 0.3 * np.exp(-(np.arange(periods) + 0.5) / 4.0), rel=2e-3)
