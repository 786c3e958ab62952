"""A capture beside its twin."""

from __future__ import annotations

from pathlib import Path

from benchtool.profile import Bench, Sensor
from benchtool.results.twin import twin_of
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
