from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.steps.step_shape import find_step
from benchtool.analysis.steps.treads import answered_tread, long_tread
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError

Floats = NDArray[np.float64]
_RAMP = np.clip((np.arange(4000) - 500) / 1500, 0.0, 1.0)


def _lag(samples: Floats, rows: float) -> Floats:
    answer, share = np.zeros(len(samples)), 1.0 - np.exp(-1.0 / rows)
    for row in range(1, len(samples)):
        answer[row] = answer[row - 1] + share * (samples[row - 1] - answer[row - 1])
    return answer


def _staircase(levels: Floats, rows: NDArray[np.int64]) -> Floats:
    return np.concatenate([np.zeros(300), np.repeat(levels[:-1], rows), np.ones(500)])


def _level(way: Floats, answer: Floats) -> float | None:
    long = long_tread(way)
    return answered_tread(way, answer) if long is None else long


@pytest.mark.parametrize("step", [0.0, 0.002])
@pytest.mark.parametrize("uneven", [False, True])
@pytest.mark.parametrize("treads", [2, 3, 5, 6, 7, 8, 10, 15, 30, 60])
def test_a_staircase_is_told_by_its_treads(treads: int, uneven: bool, step: float) -> None:
    draws = np.random.default_rng(treads)
    rows = draws.integers(40, 80, treads - 1) if uneven else np.full(treads - 1, 60)
    way = _staircase(np.arange(1, treads + 1) / treads, rows)
    answer = _lag(way, 10.0)
    assert _level(way, np.round(answer / step) * step if step else answer) is not None


@pytest.mark.parametrize("treads", [7, 20])
def test_treads_that_the_answer_smooths_are_a_ramp(treads: int) -> None:
    way = _staircase(np.arange(1, treads + 1) / treads, np.full(treads - 1, 60))
    assert _level(way, _lag(way, 60.0)) is None


@pytest.mark.parametrize("step", [0.01, 0.02, 0.05, 0.1])
@pytest.mark.parametrize("lag_rows", [1.0, 30.0, 300.0])
def test_a_ramp_through_a_coarse_converter_is_one_step(step: float, lag_rows: float) -> None:
    way, answer = np.round(_RAMP / step) * step, _lag(_RAMP, lag_rows)
    assert _level(way, answer) is None
    assert _level(way, np.round(answer / step) * step) is None


@pytest.mark.parametrize("held_rows", [2, 5, 10])
def test_a_ramp_of_a_slow_setpoint_loop_is_one_step(held_rows: int) -> None:
    way = _RAMP[np.arange(len(_RAMP)) // held_rows * held_rows]
    assert _level(way, _lag(way, 1.0)) is None


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_staircase_of_many_treads_is_refused_as_a_step(sign: float) -> None:
    r = _staircase(np.arange(1.0, 9.0) / 8.0, np.full(7, 100))
    noise = 2e-3 * np.random.default_rng(3).standard_normal(len(r))
    rows = sign * np.column_stack([_lag(r, 5.0) + noise, r])
    channels = Channel("torque", "Nm"), Channel("torque_reference", "Nm")
    with pytest.raises(AnalysisError, match=f"rests near {sign * 0.125:g} Nm on its way to {sign:g} Nm"):
        find_step(Block(channels, 0, 1, 1e-4, rows), "torque", "torque_reference")
