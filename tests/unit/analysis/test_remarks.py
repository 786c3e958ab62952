"""Notes on how numbers are to be read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis import (
    Contribution,
    Correction,
    Measurement,
    Uncertainty,
    analyze_step,
    correction_notes,
    pulse_note,
    repeatability_notes,
)
from benchtool.block import Block, Channel

CHANNELS = (Channel("torque", "Nm"), Channel("torque_reference", "Nm"))


@pytest.mark.parametrize("held_rows", [400, 900])
def test_the_settling_time_of_a_pulse_is_said_to_contain_how_long_it_was_held(held_rows: int) -> None:
    """A settling time of 40.8 ms stood beside a rise time of 0.2 ms without a word."""
    rows = np.arange(1000)
    reference = ((rows >= 100) & (rows < 100 + held_rows)).astype(float)
    answer = np.zeros(1000)
    for row in rows[1:]:
        answer[row] = answer[row - 1] + 0.4 * (reference[row - 1] - answer[row - 1])
    answer += 1e-3 * np.random.default_rng(0).standard_normal(1000)
    block = Block(CHANNELS, 0, 1, 1e-4, np.column_stack([answer, reference]))
    found = pulse_note(analyze_step(block, "torque", "torque_reference", held=True).measurements)
    if held_rows == 900:
        assert found == ""
        return
    assert found.startswith(
        "settling_time counts from the step on: the reference was held for 0.04 s and fell"
    )
    assert found.endswith("s later")


def test_how_far_another_record_differs_is_told_where_it_shows() -> None:
    """A frequency of 10.0017 ± 0.0009 Hz stood beside 10.0062 Hz of the next record without a word."""

    def of(repeatability: float) -> Measurement:
        wander = Contribution("wander of the speed", "A", repeatability)
        own = Uncertainty(0.001, "noise")
        return Measurement("fundamental_frequency", 10.0, "Hz", "", uncertainty=own, repeatability=wander)

    assert list(repeatability_notes([of(0.0002)])) == []
    assert list(repeatability_notes([of(0.002), of(0.003), of(0.0002)])) == [
        "fundamental_frequency differs between records of this state by u = 0.0030 Hz besides its U: "
        "wander of the speed"
    ]


def test_a_correction_that_shows_beside_u_is_told() -> None:
    def of(name: str, added: float, of: str = "bandwidth of torque") -> Measurement:
        own = Uncertainty(0.01, "noise")
        return Measurement(name, 1.0, "Nm", "", uncertainty=own, correction=Correction(added, of))

    told = [of("a", 0.1), of("a", -0.3), of("b", 0.019), of("c", 0.02), of("d", 0.5, "another")]
    assert list(correction_notes([*told, replace(told[-1], uncertainty=None)])) == [
        "corrected by more than U: a by −0.30 Nm from 1.30 Nm as read and 1 more (bandwidth of torque)",
        "corrected by more than U: d by 0.50 Nm from 0.500 Nm as read (another)",
    ]
