"""What the step of the resistance says of a nameplate."""

from __future__ import annotations

import pytest

from benchtool.analysis import Measurement
from benchtool.commission.known import Known
from benchtool.commission.steps.resistance import StandingCurrents
from benchtool.profile import load_profile

MOTOR = load_profile("zhu2011").motor


def told(found_ohm: float, stated_ohm: float) -> str:
    known = Known(MOTOR.model_copy(update={"R_s_ohm": stated_ohm}), 1e-4, 122.6)
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
