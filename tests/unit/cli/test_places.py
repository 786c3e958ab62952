"""To which place `compare` tells a value that has no uncertainty."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.analysis import Measurement
from benchtool.block import Block, Channel
from benchtool.cli.compare import _value
from benchtool.results import Assessment
from benchtool.results.comparison import SideBySide

BLOCK = Block((Channel("torque", "Nm"),), 0, 1, 1e-4, np.zeros((1, 1)))


def _run(value: float) -> Assessment:
    measured = Measurement("torque_ripple_pp", value, "Nm", "maximum minus minimum")
    return Assessment("tpc", Path("bundle"), (measured,), (), {}, {}, BLOCK, None, None)


@pytest.mark.parametrize(
    ("reference", "other", "shown"),
    [(29.264, 9.564, "9.564"), (9.5643, 9.564, "9.56400"), (9.564, 9.564, "9.564")],
)
def test_a_value_has_the_place_of_a_small_difference_and_four_digits_at_least(
    reference: float, other: float, shown: str
) -> None:
    runs = SideBySide.of("tpc", {"A": _run(reference), "B": _run(other)})
    assert _value(runs, "B", "torque_ripple_pp") == shown
