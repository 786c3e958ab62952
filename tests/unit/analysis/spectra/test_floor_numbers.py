"""Numbers of the noise between the harmonics of a current."""

from __future__ import annotations

import pytest

from benchtool.analysis.measurement import Basis
from benchtool.analysis.noise.noise_of_periods import NoFloor
from benchtool.analysis.spectra.floor_numbers import noise_numbers


@pytest.mark.parametrize("why", NoFloor)
def test_a_floor_that_is_not_known_is_missing_for_its_own_reason(why: NoFloor) -> None:
    found = list(noise_numbers(why, 50.0, "A", "i_a", Basis()))
    assert [each.name for each in found] == ["current_noise_floor", "current_noise_density"]
    assert {each.reason for each in found} == {why.value}
    assert ("8 bins" in why.value) == (why is NoFloor.FEW_BINS)
