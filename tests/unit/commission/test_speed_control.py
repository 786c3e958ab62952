"""The sequence by which the speed loop is measured, on every motor that ships."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchtool.commission.known import Known
from benchtool.commission.steps.speed_control import SpeedControl
from benchtool.profile import load_profile, shipped_profiles

MOTORS = [name for name in shipped_profiles() if name.startswith("motors/")]


@pytest.mark.parametrize("motor", MOTORS)
def test_the_shaft_keeps_its_direction_and_turns_no_faster_than_that_takes(motor: str) -> None:
    profile = load_profile(motor)
    omega_N = profile.motor.omega_m_N_rad_s
    known = Known(profile.motor, profile.control_period_s, 48.0, series_ohm=profile.series_ohm)
    (played,) = SpeedControl().plan(known)
    assert played.stimulus is not None
    amplitude = played.stimulus.amplitude
    assert 0.0 < amplitude <= 0.1 * omega_N
    assert played.omega_m_rad_s >= 2.0 * amplitude, "a step of twice that overshoots by less than half"
    assert 0.1 * omega_N <= played.omega_m_rad_s <= max(0.1 * omega_N, 2.5 * amplitude)
    assert played.omega_m_rad_s <= 0.25 * omega_N
    once = replace(played, most_times=1)
    of_once, of_all = (each.energy_range_J(known.R_s_range_ohm) for each in (once, played))
    assert of_all[0] == of_once[0]
    assert of_all[1] == pytest.approx(SpeedControl().most_rounds * of_once[1])
