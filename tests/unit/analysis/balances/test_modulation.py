"""Windows of a balance of torque and the noise in them."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.coverage.families import LARGEST_RMS, LEAST_RMS
from benchtool.analysis.balances.modulation import HOP, WINDOW, Modulation

T_S = 1e-4


def windows(ticks: int) -> Modulation:
    return Modulation.of(np.ones(ticks, dtype=np.int64), T_S)


def test_an_even_acceleration_is_found_to_rounding() -> None:
    """By sampled derivatives of the curve it would be 2e-4 off."""
    found = windows(600)
    time_s = T_S * np.arange(600.0)
    angle = found.samples(0.5 * 800.0 * time_s**2 + 30.0 * time_s + 1.0)
    assert angle @ found.second == pytest.approx(800.0 * np.sum(found.weight), rel=1e-9)
    speed = found.samples(800.0 * time_s + 30.0) @ found.weight
    assert -angle @ found.first == pytest.approx(speed, rel=1e-9)


def test_windows_in_which_the_direction_changes_are_left_out() -> None:
    direction = np.ones(2000, dtype=np.int64)
    direction[800:] = -1
    direction[1200:1210] = 0
    starts = Modulation.of(direction, T_S).starts
    assert starts[0] == 0
    assert set(np.diff(starts)) == {HOP, *np.diff(starts)[np.diff(starts) > HOP]}
    for start in starts:
        within = direction[start : start + WINDOW + 2]
        assert abs(np.sum(within)) == len(within)
    assert len(Modulation.of(direction[:WINDOW], T_S).starts) == 0


@pytest.mark.parametrize(("torque_Nm", "angle_rad"), [(5e-3, 0.0), (5e-3, 2e-4), (0.0, 2e-4)])
def test_errors_of_whitened_windows_are_those_of_least_squares(torque_Nm: float, angle_rad: float) -> None:
    """A slow regressor is known better than windows say that are taken for independent: fast noise of the
    angle makes most of what they leave."""
    random = np.random.default_rng(11)
    inertia, ticks = 1e-3, 4000
    found = windows(ticks)
    slow = found.samples(np.sin(2.0 * np.pi * 6.0 * T_S * np.arange(ticks))) @ found.weight
    columns = np.column_stack([slow, np.full(len(slow), np.sum(found.weight))])
    errors = []
    for _ in range(40):
        noise = found.samples(torque_Nm * random.standard_normal(ticks)) @ found.weight
        noise += inertia * found.samples(angle_rad * random.standard_normal(ticks)) @ found.second
        turned, left = found.whitened(columns, noise[:, np.newaxis])
        estimate, rest, *_ = np.linalg.lstsq(turned, left[:, 0], rcond=None)
        variance = rest[0] / (len(left) - 2)
        errors.append(estimate / np.sqrt(variance * np.diag(np.linalg.inv(turned.T @ turned))))
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert np.all((rms > LEAST_RMS) & (rms < LARGEST_RMS)), rms


def test_few_windows_do_not_take_noise_of_the_torque_for_that_of_the_angle() -> None:
    """They are as likely without any, and a load would be known better than that many torques tell it."""
    random = np.random.default_rng(5)
    ticks, torque_Nm, inertia_rad = 1300, 5e-3, 3e-7
    found = windows(ticks)
    columns = np.full((len(found.starts), 1), np.sum(found.weight))
    standard: dict[float, list[float]] = {0.0: [], torque_Nm: []}
    for _ in range(20):
        noise = found.samples(torque_Nm * random.standard_normal(ticks)) @ found.weight
        noise += found.samples(inertia_rad * random.standard_normal(ticks)) @ found.second
        for least_Nm, of_load in standard.items():
            turned, left = found.whitened(columns, noise[:, np.newaxis], least_Nm)
            _, rest, *_ = np.linalg.lstsq(turned, left[:, 0], rcond=None)
            of_load.append(np.sqrt(rest[0] / (len(left) - 1) / np.sum(turned**2)))
    best = torque_Nm / np.sqrt(ticks)
    untold, told = (min(each) for each in standard.values())
    assert untold < best < told
