"""A capture beside its twin."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from benchtool.analysis.balances.flux_balance import flux_balance
from benchtool.analysis.balances.simulation import simulated_currents, simulated_speed
from benchtool.profile import Bench, Sensor
from benchtool.results.twin import Signal, twin_of
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR
from tests.unit.analysis.excited_machine import U_DC, excited_capture


def test_what_is_stated_of_the_sensors_is_in_the_estimates() -> None:
    """A gain of 5 % explains a rotor flux that is 8 % off, by less than three of its uncertainties."""
    believed = EXAMPLE_MOTOR.model_copy(update={"psi_r_Wb": 1.08 * EXAMPLE_MOTOR.psi_r_Wb})
    link = {"resolution_V": 1e-3 * U_DC, "gain_limit_percent": 5.0}
    bench = Bench(channels={"u_dc": Sensor.model_validate(link)})
    for stated, wrong in ((None, True), (bench, False)):
        found = twin_of(excited_capture(), believed, "swing", Path(), bench=stated)
        (psi_r,) = (each for each in found.deviations if each.name == "psi_r")
        assert psi_r.contradicts == wrong
        assert (psi_r.estimate.uncertainty is None) == (stated is None)


def test_a_simulation_that_diverges_has_no_number_and_a_reason() -> None:
    """A resistance of less than zero made 8e62 A of it, and a warning of numpy."""
    found = flux_balance(excited_capture(), EXAMPLE_MOTOR)
    i_dq = simulated_currents(found.ticks, found.belief._replace(R_s=-20.0))
    measured = found.ticks.measured_dq
    assert len(i_dq) == len(measured)
    assert math.isfinite(abs(i_dq[0]))
    assert np.nanmax(np.abs(i_dq)) < 200.0 * np.max(np.abs(measured))
    signal = Signal("i_d", "A", measured.real, measured.real, i_dq.real)
    assert math.isnan(signal.estimated_rms)
    assert "as estimated the simulation diverges" in signal.reason
    document = signal.to_json()
    assert document["residual_rms_estimated"] is None
    assert document["residual_rms_believed"] == 0.0
    assert document["reason"] == signal.reason


def test_a_speed_that_diverges_ends_where_it_does() -> None:
    speed = simulated_speed(np.ones(1000), np.full(1000, 10.0), 1e-3, 1e-3, -0.1, 0.0, 0.0)
    assert 10.0 < np.nanmax(speed) <= 1000.0
    assert math.isnan(speed[-1])
    steady = simulated_speed(np.ones(1000), np.full(1000, 10.0), 1e-3, 1e-3, 0.1, 0.0, 0.0)
    assert np.allclose(steady, 10.0)
    assert Signal("omega_m", "rad/s", steady, steady, steady).reason == ""
