"""The operating points of a recording are found where they are, and changes are none."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from benchtool.block import Block
from benchtool.results.regimes import Regime, regimes
from tests.unit.results.recorded_specimen import PROFILE, stream, with_gaps

MOTOR = PROFILE.motor


def _steady(block: Block) -> list[Regime]:
    return [each for each in regimes(block, MOTOR) if each.steady]


def _with_speed(omega_m: np.ndarray, rate_Hz: float = 250.0) -> Block:
    block = stream([(len(omega_m) / rate_Hz, 0.0, 0.65)], rate_Hz)
    data = block.data.copy()
    data[:, block.names.index("omega_m")] += omega_m
    return replace(block, data=data)


@pytest.mark.parametrize("rate_Hz", [10.0, 100.0, 1000.0])
def test_operating_points_are_told_apart_by_speed_and_by_torque(rate_Hz: float) -> None:
    points = [(6.0, 0.0, 0.0), (6.0, 15.7, 0.65), (6.0, 15.7, 2.0), (6.0, -40.0, 2.0)]
    found = _steady(stream(points, rate_Hz))
    assert [round(each.levels["omega_m"], 1) for each in found] == [0.0, 15.7, 15.7, -40.0]
    assert [each.levels["torque"] for each in found] == pytest.approx([0.0, 0.65, 2.0, 2.0], abs=0.02)
    for number, each in enumerate(found):
        assert 6.0 * number <= each.from_s < 6.0 * number + 1.3, "what belongs to the change is left out"
        assert 6.0 * (number + 1) - 1.3 < each.to_s <= 6.0 * (number + 1) + 1e-9


def test_regimes_cover_the_recording_without_overlap() -> None:
    block = stream([(2.0, 0.0, 0.0), (3.0, 15.7, 0.65), (0.2, 30.0, 0.65), (2.0, 15.7, 0.65)])
    found = regimes(block, MOTOR)
    assert [each.first for each in found[1:]] == [each.last for each in found[:-1]]
    assert (found[0].first, found[-1].last) == (0, len(block.data))
    assert not any(one.steady and two.steady for one, two in itertools.pairwise(found))


def test_one_operating_point_is_the_whole_recording() -> None:
    block = stream([(20.0, 15.7, 0.65)])
    (only,) = regimes(block, MOTOR)
    assert only.steady
    assert only.from_s == 0.0
    assert only.to_s == pytest.approx(20.0)
    assert len(only.of(block).data) == len(block.data)


def test_a_ramp_is_no_steady_state() -> None:
    (only,) = regimes(_with_speed(np.linspace(0.0, 100.0, 5000)), MOTOR)
    assert not only.steady


def test_an_approach_is_left_out_until_it_is_near() -> None:
    time_s = np.arange(5000) / 250.0
    found = _steady(_with_speed(15.7 * (1.0 - np.exp(-time_s))))
    assert len(found) == 1
    assert 2.0 < found[0].from_s < 5.0
    assert found[0].levels["omega_m"] == pytest.approx(15.7, rel=0.02)


def test_another_ripple_at_the_same_torque_is_another_regime() -> None:
    block = stream([(10.0, 15.7, 0.65)], 1000.0)
    data = block.data.copy()
    swing = 0.5 * np.sin(2.0 * np.pi * 60.0 * np.arange(5000) / 1000.0)
    data[5000:, block.names.index("torque")] += swing
    found = _steady(replace(block, data=data))
    assert [round(each.to_s) for each in found] == [5, 10]


def test_missing_rows_do_not_divide_what_goes_on() -> None:
    block = with_gaps(stream([(10.0, 15.7, 0.65)]), (500, 1), (1000, 250))
    (only,) = regimes(block, MOTOR)
    assert only.steady
    assert only.to_s == pytest.approx(11.004)
    assert only.of(block).gaps == block.gaps


def test_without_a_channel_that_tells_there_is_one_regime() -> None:
    (only,) = regimes(stream([(3.0, 0.0, 0.0), (3.0, 20.0, 0.0)], channels=("i_a",)), MOTOR)
    assert only.steady
    assert only.levels == {}
    assert only.text == "0 s to 6 s steady"


def test_what_is_not_finite_is_no_level() -> None:
    block = stream([(5.0, 15.7, 0.65)])
    data = block.data.copy()
    data[7, block.names.index("torque")] = np.nan
    (only,) = regimes(replace(block, data=data), MOTOR)
    assert set(only.levels) == {"omega_m", "u_dc"}
