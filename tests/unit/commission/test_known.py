"""What a commissioning may rest on before it has measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.drive import CaptureRequest
from benchtool.profile import load_profile
from benchtool.protocol.dictionary import DataType, Variable

PROFILE = load_profile("motors/qs138_ebike")
KNOWN = Known(PROFILE.motor, 5e-5, 48.0, series_ohm=PROFILE.series_ohm)


def test_what_is_in_series_is_in_the_resistance_until_both_are_measured() -> None:
    assert PROFILE.series_ohm == PROFILE.drive.on_resistance_ohm == 0.0025
    assert pytest.approx(0.0065) == KNOWN.R_s_ohm
    assert KNOWN.with_estimates({"R_s": Measurement("R_s", 0.0061, "ohm", "")}).R_s_ohm == 0.0061
    commissioned = PROFILE.model_copy(update={"nameplate": PROFILE.motor})
    assert commissioned.series_ohm == 0.0


@pytest.mark.parametrize(("U_rad", "told"), [(1e-3, True), (0.02, False)])
def test_an_eccentric_disc_within_its_uncertainty_is_none(U_rad: float, told: bool) -> None:
    u = Uncertainty(U_rad / 4.303, "deviations between both ways", 2.0)
    parts = {"eccentricity_2_cos": 0.006, "eccentricity_2_sin": -0.008}
    found = {name: Measurement(name, value, "rad", "", uncertainty=u) for name, value in parts.items()}
    known = KNOWN.with_estimates(found)
    assert known.eccentricity_rad == (0j, complex(0.006, -0.008) if told else 0j)
    assert known.eccentricity_left_rad == pytest.approx(0.0 if told else 0.01)
    theta = np.linspace(0.0, 6.0, 50)
    error = 0.006 * np.cos(2.0 * theta) - 0.008 * np.sin(2.0 * theta)
    assert known.without_eccentricity(theta) == pytest.approx(theta - (error if told else 0.0))


@pytest.mark.parametrize(("dof", "compensated"), [(100.0, True), (2.0, False)])
def test_a_dead_time_that_few_degrees_of_freedom_leave_open_is_not_compensated(
    dof: float, compensated: bool
) -> None:
    u = Uncertainty(0.1, "scatter", dof)
    drop = Measurement("dead_time_voltage", 0.5, "V", "", uncertainty=u)
    variable = Variable(0x2F00, 1, "dead_time_compensation", DataType.F32, role="parameter")
    known = replace(KNOWN, variables={variable.name: variable}).with_estimates({drop.name: drop})
    assert (known.in_force["dead_time_compensation"] != 0.0) is compensated


def test_the_range_of_an_energy_is_narrower_for_what_is_stated() -> None:
    excitation = Excitation("", None, CaptureRequest(("i_a",), 1), squares_A2s=1e5, work_J=100.0)
    ranges = [
        excitation.energy_range_J(replace(KNOWN, series_ohm=series_ohm).R_s_range_ohm)
        for series_ohm in (None, 0.0025)
    ]
    (least, most), (least_stated, most_stated) = ranges
    expected = excitation.energy_J(KNOWN.R_s_ohm)
    assert least < least_stated < expected < most_stated < most
    assert least == pytest.approx(1.5e5 * 0.65 * 0.004 + 25.0)
    assert most_stated == pytest.approx(1.5e5 * (1.5 * 0.004 + 2.0 * 0.0025) + 300.0)
