"""How far a track that follows a swing is off it between its knots."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from benchtool.analysis.phase.followed_swing import off_swing_rad


@pytest.mark.parametrize("cycles", [0.1, 0.25, 0.305])
def test_a_spline_of_the_same_means_is_off_by_what_its_images_say(cycles: float) -> None:
    count, fine = 120, 64
    knots, place = np.arange(float(count)), np.arange(0.0, count - 1.0, 1.0 / fine)
    window = np.sin(0.5 * np.pi * np.arange(2 * fine) / fine) ** 2
    window /= np.sum(window)
    # as large as makes both alike under a Hann window over two periods
    seen, sinusoid = (
        np.convolve(each, window, "same")[20 * fine : -20 * fine]
        for each in (
            CubicSpline(knots, np.cos(2 * np.pi * cycles * knots))(place),
            np.cos(2 * np.pi * cycles * place),
        )
    )
    at = slice(0, None, fine)
    size = float(seen[at] @ sinusoid[at]) / float(seen[at] @ seen[at])
    halfway = knots[20:-20] + 0.5
    spline = size * CubicSpline(knots, np.cos(2 * np.pi * cycles * knots))(halfway)
    off = float(np.std(spline - np.cos(2 * np.pi * cycles * halfway)))
    assert off_swing_rad(np.cos(2 * np.pi * cycles * knots)) == pytest.approx(off, rel=0.05)
