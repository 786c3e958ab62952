"""What the step of the resistance says of a nameplate."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.commission.known import Known
from benchtool.commission.steps.resistance import StandingCurrents, of_winding
from benchtool.profile import load_profile

MOTOR = load_profile("zhu2011").motor


def told(found_ohm: float, stated_ohm: float, series_ohm: float | None = None) -> str:
    known = Known(MOTOR.model_copy(update={"R_s_ohm": stated_ohm}), 1e-4, 122.6, series_ohm=series_ohm)
    names = ("R_s", "R_a", "R_b", "R_c")
    found = {name: Measurement(name, found_ohm, "ohm", "resistance") for name in names}
    return " ".join(each.what for each in StandingCurrents().findings(found, known))


@pytest.mark.parametrize(
    ("found_ohm", "stated_ohm", "words"),
    [
        (1.0, 1.0, ""),
        (0.5, 1.0, "R looks line to line"),
        (0.55, 1.0, "R looks line to line"),
        (0.0092, 0.016, "R looks line to line"),  # 8 mOhm, and devices and cable beside
        (0.014, 0.016, ""),
        (0.012, 0.008, ""),
        (0.6, 1.0, "within a factor of 1.5"),
        (0.3, 1.0, "within a factor of 1.5"),
        (1.7, 1.0, "within a factor of 1.5"),
    ],
)
def test_a_resistance_near_half_of_the_stated_one_looks_line_to_line(
    found_ohm: float, stated_ohm: float, words: str
) -> None:
    said = told(found_ohm, stated_ohm)
    assert words in said
    assert bool(said) == bool(words)


@pytest.mark.parametrize(
    ("found_ohm", "stated_ohm", "series_ohm", "is_told"),
    [
        (0.0126, 0.016, 0.0038, True),  # 8 mOhm beside devices of 4.5 mOhm, by their data sheet of 3.8 mOhm
        (0.0126, 0.016, None, False),
        (0.0126, 0.008, 0.0038, False),
        (0.0126, 0.008, 0.0056, False),
    ],
)
def test_what_a_data_sheet_states_in_series_is_taken_off_before(
    found_ohm: float, stated_ohm: float, series_ohm: float | None, is_told: bool
) -> None:
    assert ("line to line" in told(found_ohm, stated_ohm, series_ohm)) is is_told


@pytest.mark.parametrize("series_ohm", [None, 0.0, 0.0025])
def test_the_winding_alone_is_told_as_well_as_what_is_in_series_is_known(series_ohm: float | None) -> None:
    R_s = Measurement("R_s", 0.0062, "ohm", "", uncertainty=Uncertainty(3e-5, "scatter"))
    found = of_winding(R_s, Known(MOTOR, 1e-4, 122.6, series_ohm=series_ohm))
    if not series_ohm:
        assert math.isnan(found.value)
        assert "drive.on_resistance_ohm" in found.reason
        return
    assert found.value == pytest.approx(0.0037)
    assert found.uncertainty is not None
    assert found.uncertainty.standard == pytest.approx(math.hypot(3e-5, 1.5 * 0.0025 / math.sqrt(12.0)))
