"""Edges of the legs and what dead time takes at them."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.balances.pwm_period import Edges

T_S, U_DC = 1e-4, 120.0


@pytest.mark.parametrize("angle_rad", [0.2, 1.3, 2.4, 3.5, 4.6, 5.7])
def test_pulses_about_the_middle_are_late_by_half_the_dead_time_whatever_the_currents(
    angle_rad: float,
) -> None:
    """The mean current of a period is then off along the voltage."""
    u_s = 40.0 * np.exp(0.3j * np.arange(50))
    i_s = np.full(51, 50.0 * np.exp(1j * angle_rad))  # no ripple changes its signs
    found = Edges.of(u_s, np.full(50, U_DC), T_S).before_middle(i_s, 1e-2)
    np.testing.assert_allclose(found, 0.5 * u_s / U_DC, atol=1e-12)


def test_edges_of_held_vectors_are_half_a_period_before_the_middle() -> None:
    axes = 2.0 / 3.0 * U_DC * np.exp(1j * np.pi / 3.0 * np.arange(6.0))
    u_s, i_s = axes[[0, 1, 1, 2, 3, 3, 4, 5]], np.full(9, 4.0 + 1.0j)
    edges = Edges.of(u_s, np.full(8, U_DC), T_S)
    signs, _ = edges.signs(i_s, 1e-2, 0.1, 0.0)
    assert np.count_nonzero(signs) > 2
    np.testing.assert_allclose(edges.before_middle(i_s, 1e-2), 0.5 * signs, atol=1e-12)
