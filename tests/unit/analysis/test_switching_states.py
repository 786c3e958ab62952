"""Dwell times of the inverter's vectors against the textbook's formula, and what must hold of any voltage."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.analysis import Instruments
from benchtool.analysis.switching import switching_frequency, switching_states, vector_shares
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError
from benchtool.profile import Bench, Sensor

CHANNELS = (Channel("u_alpha", "V"), Channel("u_beta", "V"), Channel("u_dc", "V"))


def _shares(magnitude: float, angle: float, u_dc: float) -> list[float]:
    u_alpha, u_beta = np.array([magnitude * math.cos(angle)]), np.array([magnitude * math.sin(angle)])
    return [float(share) for share in vector_shares(u_alpha, u_beta, np.array([u_dc]))[0]]


def _block(*rows: tuple[float, float, float]) -> Block:
    return Block(CHANNELS, 0, 1, 1e-4, np.array(rows))


@given(st.floats(0.0, 0.999), st.floats(0.0, 2 * math.pi, exclude_max=True), st.floats(1.0, 800.0))
def test_dwell_times_are_those_of_space_vector_modulation(share: float, angle: float, u_dc: float) -> None:
    magnitude = share * u_dc / math.sqrt(3.0)  # within the circle inside the hexagon
    sector, within = divmod(angle, math.pi / 3)
    index = magnitude * math.sqrt(3.0) / u_dc
    expected = np.zeros(7)
    expected[1 + int(sector) % 6] += index * math.sin(math.pi / 3 - within)
    expected[1 + (int(sector) + 1) % 6] += index * math.sin(within)
    expected[0] = 1.0 - expected.sum()
    assert _shares(magnitude, angle, u_dc) == pytest.approx(list(expected), abs=1e-9)


@given(st.floats(-2e3, 2e3), st.floats(-2e3, 2e3), st.floats(0.1, 1e3))
def test_shares_are_a_partition_and_make_the_voltage(u_alpha: float, u_beta: float, u_dc: float) -> None:
    shares = vector_shares(np.array([u_alpha]), np.array([u_beta]), np.array([u_dc]))[0]
    assert np.all(shares >= 0.0)
    assert shares.sum() == pytest.approx(1.0)
    assert np.count_nonzero(shares[1:]) <= 2
    vectors = 2.0 / 3.0 * u_dc * np.exp(1j * np.pi / 3 * np.arange(6))
    made, asked = complex(np.sum(shares[1:] * vectors)), complex(u_alpha, u_beta)
    if shares[0] > 1e-9:
        assert made == pytest.approx(asked, abs=1e-9 * u_dc)
    else:  # beyond the hexagon: shorter, in the same direction
        assert abs(made) <= abs(asked) * (1 + 1e-9)
        assert made.real * asked.imag == pytest.approx(made.imag * asked.real, abs=1e-9 * abs(asked) * u_dc)


@pytest.mark.parametrize("vector", range(1, 7))
def test_a_basic_vector_is_itself_for_the_whole_period(vector: int) -> None:
    expected = [1.0 if k == vector else 0.0 for k in range(7)]
    assert _shares(200.0, (vector - 1) * math.pi / 3, 300.0) == pytest.approx(expected, abs=1e-9)
    assert _shares(500.0, (vector - 1) * math.pi / 3, 300.0) == pytest.approx(expected, abs=1e-9)


def test_the_table_counts_time_and_periods() -> None:
    states = switching_states(_block((200.0, 0.0, 300.0), (100.0, 0.0, 300.0), (0.0, 0.0, 300.0)))
    (table,) = states.tables
    by_vector = {row[0]: row[2:] for row in table.rows}
    assert by_vector[0] == pytest.approx((50.0, 200.0 / 3))
    assert by_vector[1] == pytest.approx((50.0, 200.0 / 3))
    assert by_vector[4] == (0.0, 0.0)
    assert math.isnan(table.rows[0][1])
    found = {each.name: each.value for each in states.measurements}
    assert found == pytest.approx({"zero_vector_share": 50.0, "active_vectors_mean": 2.0 / 3})


def test_no_time_is_left_for_zero_vectors_beyond_the_hexagon() -> None:
    """Not even what rounding would leave, whose scatter were the uncertainty of nothing."""
    angle = np.linspace(0.0, 2.0 * math.pi, 500)
    beyond = vector_shares(250.0 * np.cos(angle), 250.0 * np.sin(angle), np.full(500, 300.0))
    assert np.all(beyond[:, 0] == 0.0)


def _of_turning(step_V: float, noise_V: float, random: np.random.Generator) -> tuple[float, float]:
    """Return zero share and its standard uncertainty of 42 V that turn, read in steps at any level."""
    angle = 2.0 * np.pi * (23.7e-4 * np.arange(6000) + random.random())
    axes = 42.0 * np.stack([np.cos(angle), np.sin(angle)]) + noise_V * random.standard_normal((2, 6000))
    level = step_V * random.random((2, 1))
    u_alpha, u_beta = np.round((axes - level) / step_V) * step_V + level
    block = Block.from_arrays(1e4, {}, u_alpha=u_alpha, u_beta=u_beta, u_dc=np.full(6000, 120.0))
    share = {each.name: each for each in switching_states(block).measurements}["zero_vector_share"]
    assert share.uncertainty is not None
    return share.value, share.uncertainty.standard


def test_steps_that_a_turning_voltage_is_read_wrong_by_in_every_period_are_in_the_budget() -> None:
    random, errors = np.random.default_rng(11), []
    # the greatest minus the least phase is on average 3 / pi times sqrt(3) of the size
    truth = 100.0 * (1.0 - 3.0 * math.sqrt(3.0) / math.pi * 42.0 / 120.0)
    for step_V in (1.5, 2.1, 3.0):
        for _ in range(4):
            value, standard = _of_turning(step_V, 0.05, random)
            errors.append((value - truth) / standard)
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.4


def test_steps_that_noise_hides_add_nothing_to_a_zero_share() -> None:
    _, hidden = _of_turning(0.1, 0.1, np.random.default_rng(5))
    _, fine = _of_turning(1e-7, 0.1, np.random.default_rng(5))
    assert hidden == pytest.approx(fine, rel=0.2)


def test_the_vectors_of_a_law_of_single_ones_are_no_steps_of_a_converter() -> None:
    random = np.random.default_rng(2)
    vector = 80.0 * np.exp(1j * np.pi / 3.0 * np.floor(6.0 * 23.7e-4 * np.arange(6000)))
    vector *= random.random(6000) < 0.6
    block = Block.from_arrays(
        1e4, {}, u_alpha=vector.real, u_beta=vector.imag, u_dc=np.full(6000, 120.0)
    )  # fmt: skip
    for each in switching_states(block).measurements:
        assert each.uncertainty is not None
        assert not any("resolution" in line.name for line in each.uncertainty.budget)


def test_refusals() -> None:
    with pytest.raises(AnalysisError, match="'u_dc' is 0 V in places"):
        switching_states(_block((1.0, 0.0, 300.0), (1.0, 0.0, 0.0)))
    with pytest.raises(AnalysisError, match="not finite"):
        switching_states(_block((1.0, math.nan, 300.0)))


def test_switching_frequency_is_known_to_a_count() -> None:
    block = Block((Channel("switching_count", ""),), 0, 1, 1e-4, 3.0 * np.arange(1001.0)[:, np.newaxis])
    found = switching_frequency(block)
    assert found.value == pytest.approx(10e3)
    assert found.uncertainty is not None
    assert found.uncertainty.standard == pytest.approx(1 / 0.1 / 3 / math.sqrt(2))


def test_a_number_of_vectors_that_was_always_the_same_is_not_certain() -> None:
    """Of 3000 periods with two vectors the next may have another: 1 / 3000, rectangular."""
    found = {
        each.name: each.uncertainty
        for each in switching_states(_block(*([(60.0, 20.0, 200.0)] * 3000))).measurements
    }
    active, zero = found["active_vectors_mean"], found["zero_vector_share"]
    assert active is not None
    assert zero is not None
    assert active.standard == pytest.approx(1.0 / (3000 * math.sqrt(3.0)))
    assert zero.standard < 1e-9  # each has as much of all vectors


def test_a_law_of_single_vectors_may_use_the_one_that_was_not_seen() -> None:
    """Of 3000 periods with an active vector the next may have a zero vector: 100 / 3000 %, rectangular."""
    measured = switching_states(_block(*([(60.0, 200.0 / 1.5, 200.0)] * 3000))).measurements
    share = next(each for each in measured if each.name == "zero_vector_share")
    assert share.value == pytest.approx(0.0, abs=1e-9)
    assert share.uncertainty is not None
    assert share.uncertainty.standard == pytest.approx(100.0 / (3000 * math.sqrt(3.0)))


def test_turn_ons_that_wander_over_the_whole_record_have_no_uncertainty_but_a_reason() -> None:
    random = np.random.default_rng(3)
    rate = 2.0 + np.cumsum(random.normal(0.0, 0.01, 4000))  # a random walk
    count = np.floor(np.cumsum(rate))
    found = switching_frequency(Block((Channel("switching_count", ""),), 0, 1, 1e-4, count[:, np.newaxis]))
    assert math.isfinite(found.value)
    assert found.uncertainty is None
    assert "wanders" in found.uncertainty_reason


def test_the_scatter_of_regular_turn_ons_holds_the_count_at_both_ends_once() -> None:
    random, time_s, errors = np.random.default_rng(6), np.arange(10_001) / 10_000.0, []
    for _ in range(40):
        count = sum(np.floor(1234.5 * time_s + random.random()) for _ in range(3))
        found = switching_frequency(Block.from_arrays(10_000.0, {}, switching_count=np.asarray(count)))
        assert found.uncertainty is not None
        errors.append((found.value - 1234.5) / found.uncertainty.standard)
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.2


def test_an_error_of_the_dc_link_does_not_move_times_that_the_drive_makes_by_its_reading() -> None:
    block = _block(*([(60.0, 20.0, 200.0), (50.0, -20.0, 200.0)] * 200))
    bench = Bench(channels={"u_dc": Sensor.model_validate({"gain_limit_percent": 2.0, "resolution_V": 1.0})})
    found = switching_states(block).measurements
    applied = Instruments(bench, [block]).applied(found, lambda _: pytest.fail("nothing is measured again"))
    assert [each.uncertainty for each in applied] == [each.uncertainty for each in found]
    assert {each.sensitivities.named for each in found} == {("u_alpha", "u_beta")}


def test_a_rate_that_swings_a_few_times_is_known_but_for_where_it_begins() -> None:
    """2.6 cycles of 30 % over 2000 rows; without the swing a count of each leg would remain."""
    swing = 0.3 * np.sin(2.0 * np.pi * (2.6 * np.arange(2000) / 2000 + 0.2))
    count = np.floor(np.cumsum(3.0 * 1234.5 * (1.0 + swing) / 10_000.0))
    found = switching_frequency(Block.from_arrays(10_000.0, {}, switching_count=count))
    assert found.uncertainty is not None
    moved_Hz = 0.3 * 1234.5 / math.sqrt(2.0) * abs(float(np.sinc(2.6)))
    assert found.uncertainty.standard == pytest.approx(moved_Hz, rel=0.2)
