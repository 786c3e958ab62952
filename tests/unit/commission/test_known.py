"""What a commissioning may rest on before it has measured."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchtool.analysis import Measurement
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.drive import CaptureRequest
from benchtool.profile import load_profile

PROFILE = load_profile("motors/qs138_ebike")
KNOWN = Known(PROFILE.motor, 5e-5, 48.0, series_ohm=PROFILE.series_ohm)


def test_what_is_in_series_is_in_the_resistance_until_both_are_measured() -> None:
    assert PROFILE.series_ohm == PROFILE.drive.on_resistance_ohm == 0.0025
    assert pytest.approx(0.0065) == KNOWN.R_s_ohm
    assert KNOWN.with_estimates({"R_s": Measurement("R_s", 0.0061, "ohm", "")}).R_s_ohm == 0.0061
    commissioned = PROFILE.model_copy(update={"nameplate": PROFILE.motor})
    assert commissioned.series_ohm == 0.0


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
