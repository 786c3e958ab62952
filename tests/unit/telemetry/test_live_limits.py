"""Limits on live data: the first row beyond one is told, and nothing within them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike

from benchtool.block import Block, Channel
from benchtool.errors import LimitTrip
from benchtool.profile import Limits
from benchtool.telemetry.live_limits import LiveLimits

TIMES_S = np.arange(20) * 0.01


def _block(first_tick: int = 0, /, **columns: ArrayLike) -> Block:
    rows = [np.broadcast_to(np.asarray(each, float), TIMES_S.shape) for each in columns.values()]
    data = np.column_stack(rows)
    return Block(tuple(Channel(name, "") for name in columns), first_tick, 100, 1e-4, data)


def _judged(limits: Limits, *blocks: Block) -> None:
    supervised = LiveLimits(limits)
    for block in blocks:
        supervised.take(block)
    supervised.check()


def test_the_first_row_beyond_a_limit_is_told_with_its_tick() -> None:
    torque = np.where(TIMES_S > 0.095, -3.5, 2.9)
    with pytest.raises(LimitTrip, match=r"torque is -3.5 Nm, the profile's limit is 3 Nm.*at tick 6000"):
        _judged(Limits(torque_Nm=3.0), _block(5000, torque=torque))


@pytest.mark.parametrize("value", [3.0, -3.0, 0.0])
def test_what_is_within_is_not_told(value: float) -> None:
    _judged(Limits(torque_Nm=3.0, omega_m_rad_s=1.0), _block(torque=value, i_a=99.0))


def test_what_is_no_number_is_beyond_every_limit() -> None:
    with pytest.raises(LimitTrip, match="omega_m is nan"):
        _judged(Limits(omega_m_rad_s=1e6), _block(omega_m=np.nan))


def test_currents_that_do_not_sum_to_zero_are_told() -> None:
    with pytest.raises(LimitTrip, match=r"i_a \+ i_b \+ i_c is 0.6"):
        _judged(Limits(current_sum_A=0.5), _block(i_a=1.0, i_b=1.0, i_c=-1.4))
    _judged(Limits(current_sum_A=0.5), _block(i_a=1.0, i_b=1.0, i_c=-1.6))


def _currents(i_a: float) -> dict[str, ArrayLike]:
    angle = 2.0 * np.pi * 31.8 * TIMES_S
    return {
        "i_a": i_a * np.cos(angle),
        "i_b": np.cos(angle - 2.0 * np.pi / 3.0),
        "i_c": np.cos(angle + 2.0 * np.pi / 3.0),
    }


def test_a_phase_without_current_is_told_while_the_shaft_turns() -> None:
    limits = Limits(current_unbalance_percent=30.0)
    _judged(limits, *(_block(omega_m=50.0, **_currents(1.0)) for _ in range(5)))
    _judged(limits, *(_block(omega_m=1.0, **_currents(0.0)) for _ in range(5)))
    with pytest.raises(LimitTrip, match="unbalance of the phase currents"):
        _judged(limits, *(_block(omega_m=50.0, **_currents(0.0)) for _ in range(2)))


def test_a_temperature_above_its_limit_is_told() -> None:
    supervised = LiveLimits(Limits(temperature_degC=120.0))
    supervised.take_temperature(120.0)
    supervised.take_temperature(None)
    supervised.check()
    supervised.take_temperature(121.0)
    with pytest.raises(LimitTrip, match="the winding's temperature is 121 degC"):
        supervised.check()
