"""Circles, offset circles and hexagons as flux trajectories."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from benchtool.analysis.flux.radius_errors import length_of_mean
from benchtool.analysis.flux.trajectory import flux_trajectory
from benchtool.analysis.measurement import Measurement
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError
from tests.at_length import at_length

CHANNELS = (Channel("psi_alpha", "Wb"), Channel("psi_beta", "Wb"))
ROWS = 5000


def _turns(turns: float) -> NDArray[np.float64]:
    return 2 * np.pi * turns * np.arange(ROWS) / ROWS + 0.3


def _measured(psi: NDArray[np.complex128]) -> dict[str, float]:
    block = Block(CHANNELS, 0, 1, 1e-4, np.column_stack([psi.real, psi.imag]))
    return {each.name: each.value for each in flux_trajectory(block)}


@given(
    st.floats(0.01, 1.0),
    st.floats(0.0, 0.2),
    st.floats(-3.0, 3.0),
    st.floats(2.1, 9.0),
    st.sampled_from([1.0, -1.0]),
)
@settings(max_examples=settings().max_examples // 2)
def test_an_offset_circle_in_either_direction(
    radius: float, offset: float, towards: float, turns: float, sense: float
) -> None:
    centre = offset * radius * np.exp(1j * towards)
    found = _measured(centre + radius * np.exp(sense * 1j * _turns(turns)))
    assert found["flux_centre_offset"] == pytest.approx(abs(centre), abs=1e-3 * radius)
    assert found["flux_radius_pp"] == pytest.approx(2 * abs(centre), abs=2e-3 * radius)
    assert found["flux_radius_order_6"] < 1e-3 * radius
    assert found["flux_radius_rms"] == pytest.approx(abs(centre) / np.sqrt(2), rel=2e-2, abs=1e-6)


def test_the_basis_is_the_whole_revolutions() -> None:
    psi = np.exp(1j * _turns(5.5))
    block = Block(CHANNELS, 0, 2, 1e-4, np.column_stack([psi.real, psi.imag]))
    for each in flux_trajectory(block):
        basis = each.basis
        assert basis is not None
        assert basis.samples is not None
        assert basis.samples == pytest.approx(5.0 / 5.5 * ROWS, abs=2)
        assert basis.sample_rate_Hz == pytest.approx(5e3)
        assert basis.duration_s == pytest.approx(basis.samples / 5e3)
        assert basis.bandwidth_Hz == pytest.approx(2.5e3)


def test_a_hexagon_run_along_its_sides_evenly() -> None:
    corners = np.exp(1j * np.pi / 3 * np.arange(7))
    along = np.mod(_turns(5.0) / (np.pi / 3), 6)
    side, share = np.divmod(along, 1.0)
    psi = corners[side.astype(int)] * (1 - share) + corners[side.astype(int) + 1] * share
    first_order = 0.5 / np.cos(np.pi / 6) * np.sqrt(3) * 3 / np.pi * 3 / np.pi
    found = _measured(np.asarray(psi))
    assert found["flux_radius_order_6"] == pytest.approx((1 / 25 + 1 / 49) * first_order, rel=1e-2)
    assert found["flux_radius_pp"] == pytest.approx(1.0 - np.sqrt(3) / 2, abs=2e-3)
    assert found["flux_centre_offset"] == pytest.approx(0.0, abs=1e-3)


def test_scatter_over_the_revolutions_is_the_uncertainty() -> None:
    noise = np.random.default_rng(0)
    means = []
    for _ in range(40):
        psi = (0.17 + 0.01 * noise.standard_normal(ROWS)) * np.exp(1j * _turns(8.2))
        block = Block(CHANNELS, 0, 1, 1e-4, np.column_stack([psi.real, psi.imag]))
        means.append(flux_trajectory(block)[0])
    stated = [each.uncertainty.standard for each in means if each.uncertainty is not None]
    values = np.array([each.value for each in means])
    assert len(stated) == len(means)
    # of eight revolutions each: the standard uncertainty is Student's, and larger where the scatter is small
    relative = (values - np.mean(values)) / np.array(stated)
    assert 0.7 < np.sqrt(np.mean(relative**2)) < 1.3


def _number(psi: NDArray[np.complex128], name: str) -> Measurement:
    block = Block(CHANNELS, 0, 1, 1e-4, np.column_stack([psi.real, psi.imag]))
    return next(each for each in flux_trajectory(block) if each.name == name)


def test_a_radius_that_changes_is_no_one_regime() -> None:
    size = np.where(np.arange(ROWS) < ROWS // 2, 0.17, 0.12)
    found = _number(size * np.exp(1j * _turns(20.3)), "flux_radius_mean")
    assert np.isnan(found.value)
    assert found.reason.startswith("the radius of the flux changes from 0.12 to 0.17")


def test_steps_that_repeat_in_every_revolution_are_uncertain_as_such() -> None:
    step = 2e-3
    psi = 0.17 * np.exp(1j * _turns(20.0))
    stepped = np.round(psi.real / step) * step + 1j * np.round(psi.imag / step) * step
    found = _number(stepped, "flux_radius_mean")
    assert found.uncertainty is not None
    assert found.uncertainty.standard > 1e-5  # no scatter over revolutions shows them
    assert abs(found.value - 0.17) < found.uncertainty.expanded


def test_less_than_two_revolutions_are_refused() -> None:
    with pytest.raises(AnalysisError, match=r"covers 1\.50 electrical periods, at least 2"):
        _measured(np.exp(1j * _turns(1.5003)).astype(np.complex128))
    with pytest.raises(AnalysisError, match="'psi_beta' is constant"):
        _measured(np.linspace(0.0, 1.0, ROWS).astype(np.complex128))


def _all(psi: NDArray[np.complex128]) -> dict[str, Measurement]:
    block = Block(CHANNELS, 0, 1, 1e-4, np.column_stack([psi.real, psi.imag]))
    return {each.name: each for each in flux_trajectory(block)}


def _noise(seed: int, size: float = 1e-4) -> NDArray[np.complex128]:
    parts = np.random.default_rng(seed).standard_normal((2, ROWS))
    return np.asarray(size * (parts[0] + 1j * parts[1]))


def _holds(found: Measurement, truth: float) -> None:
    assert found.uncertainty is not None
    assert abs(found.value - truth) < 4.0 * found.uncertainty.standard
    assert found.uncertainty.standard < 4e-4 * 0.17


@pytest.mark.parametrize("seed", range(4))
def test_order_6_turns_with_a_speed_that_swings(seed: int) -> None:
    angle = _turns(40.0) + 0.25 * np.sin(_turns(2.3) + seed)
    psi = np.exp(1j * angle) + 0.04 * np.exp(-5j * angle) + 0.02 * np.exp(7j * angle) + 0.01j
    found = _all(0.17 * psi + _noise(seed))
    _holds(found["flux_radius_order_6"], 0.17 * 0.06)
    _holds(found["flux_centre_offset"], 0.17 * 0.01)


@pytest.mark.parametrize("seed", range(4))
def test_a_radius_that_ramps_moves_no_centre(seed: int) -> None:
    ramp = 1.0 + 0.06 * (np.arange(ROWS) / ROWS - 0.5)
    centre = 0.17 * 0.005 * np.exp(1j * seed)
    found = _all(0.17 * ramp * np.exp(1j * _turns(40.4)) + centre + _noise(seed, 1e-5))
    # 0.06 / 40.4 of the radius over 2 pi would be a twentieth of it
    _holds(found["flux_centre_offset"], 0.17 * 0.005)
    _holds(found["flux_radius_mean"], 0.17)


def test_a_radius_that_remembers_for_long_has_no_rms_also_where_that_seems_short() -> None:
    random = np.random.default_rng(7)
    for _ in range(3):
        radius = np.empty(60)
        radius[0] = random.standard_normal()
        for number in range(1, 60):
            radius[number] = 0.9 * radius[number - 1] + np.sqrt(1.0 - 0.81) * random.standard_normal()
        angle = 2 * np.pi * 60 * np.arange(12_000) / 12_000
        psi = 0.17 * (1.0 + 0.01 * np.repeat(radius, 200)) * np.exp(1j * angle)
        block = Block(CHANNELS, 0, 1, 1e-4, np.column_stack([psi.real, psi.imag]))
        found = next(each for each in flux_trajectory(block) if each.name == "flux_radius_rms")
        assert np.isnan(found.value), found
        assert "record longer" in found.reason


def test_a_line_that_revolutions_cut_moves_their_means_and_not_the_mean_of_all() -> None:
    random, error = np.random.default_rng(3), []
    turns = np.arange(12 * 200 + 1) / 200
    for _ in range(20):
        line = 0.02 * np.cos(2 * np.pi * (2.37 * turns + random.random()))
        psi = (1.0 + line + 0.01 * random.standard_normal(len(turns))) * np.exp(2j * np.pi * turns)
        block = Block(CHANNELS, 0, 1, 1e-4, np.column_stack([psi.real, psi.imag]))
        found = {each.name: each for each in flux_trajectory(block)}["flux_radius_mean"]
        assert found.uncertainty is not None
        error.append((found.value - 1.0) / found.uncertainty.standard)
    assert 0.45 < np.std(error) < 1.2


@pytest.mark.parametrize("begin_rad", np.linspace(0.0, 2.0, 5))
def test_a_ramp_of_few_revolutions_is_half_in_order_6_and_half_in_its_uncertainty(begin_rad: float) -> None:
    ramp = 1.0 + 0.003 * (np.arange(ROWS) / ROWS - 0.5)
    turned = _turns(3.6) + begin_rad
    found = _all(0.17 * (ramp * np.exp(1j * turned) + 0.02 * np.exp(-5j * turned)) + _noise(3, 1e-5))
    _holds(found["flux_radius_order_6"], 0.17 * 0.02)


def _pink(seed: int) -> NDArray[np.complex128]:
    """Return noise of unit rms in each coordinate whose density is that of 1/f noise, shape (rows,)."""
    random = np.random.default_rng(seed)
    size = 1.0 / np.sqrt(np.arange(1, 8 * ROWS + 1))  # a record is a sixteenth: it goes on below its lowest
    white = random.standard_normal((2, len(size))) + 1j * random.standard_normal((2, len(size)))
    parts = np.fft.irfft(np.hstack([np.zeros((2, 1)), size * white]), 16 * ROWS)[:, :ROWS]
    return np.asarray((parts[0] + 1j * parts[1]) / np.std(parts))


def test_pink_noise_of_few_revolutions_is_in_the_centre() -> None:
    """Its density within the revolutions tells what so few of these do not."""
    errors = []
    for seed in range(22):
        path = np.exp(1j * _turns(9.3)) + 0.01
        found = _all(0.17 * (path + 3e-3 * _pink(seed)))["flux_centre_offset"]
        if found.uncertainty is not None:
            errors.append((found.value - 0.17 * 0.01) / found.uncertainty.standard)
    assert len(errors) > 14
    assert 0.6 < float(np.sqrt(np.mean(np.square(errors)))) < 1.4


def test_the_rms_of_a_radius_has_what_moves_its_centre_slowly() -> None:
    """Pink noise over far more than the record: the mean of it there is the same in all revolutions."""
    revolutions, rows, times, errors = 9.3, 4650, 16, []
    frequency = np.fft.rfftfreq(times * rows)
    for seed in range(24):
        random = np.random.default_rng(seed)
        white = np.fft.rfft(random.standard_normal((2, times * rows)), axis=1)[:, 1:]
        pink = np.fft.irfft(np.pad(white / np.sqrt(frequency[1:]), ((0, 0), (1, 0))), axis=1)
        noise = (pink / np.std(pink))[:, :rows]
        circle = np.exp(2j * np.pi * (revolutions * np.arange(rows) / rows + random.uniform()))
        psi = circle + 0.03 + 2e-3 * (noise[0] + 1j * noise[1])
        columns = {"psi_alpha": np.asarray(psi.real), "psi_beta": np.asarray(psi.imag)}
        block = Block.from_arrays(10e3, dict.fromkeys(columns, "Wb"), **columns)
        found = {each.name: each for each in flux_trajectory(block)}["flux_radius_rms"]
        if found.uncertainty is not None:
            error = found.value - float(np.hypot(0.03 / np.sqrt(2.0), 2e-3))
            errors.append(error / found.uncertainty.standard)
    assert len(errors) > 16
    assert np.sqrt(np.mean(np.square(errors))) < 1.4


def test_a_radius_that_swings_slowly_has_its_extremes_in_every_record() -> None:
    random = np.random.default_rng(7)
    turns, found = np.arange(55 * 160) / 160, []
    for begin in random.uniform(0.0, 2.0 * np.pi, 8):
        swing = 1.0 + 0.01 * np.sin(2.0 * np.pi * 0.046 * turns + begin)
        psi = 0.12 * swing * np.exp(2j * np.pi * turns)
        psi += 5e-5 * (random.standard_normal(len(turns)) + 1j * random.standard_normal(len(turns)))
        block = Block(CHANNELS, 0, 1, 1.25e-4, np.column_stack([psi.real, psi.imag]))
        span = {each.name: each for each in flux_trajectory(block)}["flux_radius_pp"]
        assert span.uncertainty is not None
        found.append((span.value, span.uncertainty.standard))
    values, stated = np.array(found).T
    assert 0.5 < np.median(stated) / np.std(values, ddof=1) < 2.0


@pytest.mark.parametrize("noise", [0.02, *at_length(0.3)])
def test_steps_make_the_extremes_of_a_radius_larger_and_its_hexagon_another(noise: float) -> None:
    """In steps, of both coordinates: the noise is a part of one."""
    random, errors = np.random.default_rng(3), []
    angle = _turns(20.3)
    for radius in 0.12 + 1e-3 * random.uniform(-1.0, 1.0, 12):
        step = 1.2e-3
        psi = radius * np.exp(1j * angle) + 0.003 * np.exp(-5j * angle)
        psi += noise * step * (random.standard_normal(ROWS) + 1j * random.standard_normal(ROWS))
        read = step * (np.round(psi.real / step) + 1j * np.round(psi.imag / step))
        truth = {"flux_radius_pp": float(np.ptp(np.abs(psi))), "flux_radius_order_6": 0.003}
        found = {name: _number(read, name) for name in truth}
        standards = [each.uncertainty.standard for each in found.values() if each.uncertainty is not None]
        errors.append(
            [(found[name].value - truth[name]) / u for name, u in zip(truth, standards, strict=True)]
        )
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert np.all(rms < 1.6)
    assert np.all(rms > 0.3)


def test_a_centre_that_drifts_is_no_hexagon() -> None:
    """Within a revolution a line is in all orders, over 2 pi and their distance from the centre."""
    turns = 41.3
    psi = 0.12 * np.exp(1j * _turns(turns)) + (0.008 + 0.003j) * np.linspace(-0.5, 0.5, ROWS)
    noise = np.random.default_rng(4).standard_normal((2, ROWS))
    found = _number(psi + 1e-5 * (noise[0] + 1j * noise[1]), "flux_radius_order_6")
    assert found.uncertainty is not None
    assert found.value < 2.0 * found.uncertainty.standard
    assert found.uncertainty.standard < 1e-6


def test_samples_at_the_same_places_of_all_revolutions_show_their_noise() -> None:
    """Neighbouring places are several steps apart, which is no noise that would hide the steps."""
    random, errors, step = np.random.default_rng(9), [], 4e-4
    for radius in 0.17 + step * random.uniform(-1.0, 1.0, 12):
        psi = radius * np.exp(1j * _turns(50.0)) + 0.002
        psi += 0.15 * step * (random.standard_normal(ROWS) + 1j * random.standard_normal(ROWS))
        read = step * (np.round(psi.real / step) + 1j * np.round(psi.imag / step))
        found = _number(read, "flux_centre_offset")
        assert found.uncertainty is not None
        errors.append((found.value - 0.002) / found.uncertainty.standard)
    assert np.sqrt(np.mean(np.square(errors))) < 1.6


def test_a_centre_at_zero_is_within_its_uncertainty() -> None:
    random, held = np.random.default_rng(5), []
    for _ in range(150):
        length, bias, along = length_of_mean(
            random.standard_normal(20) + 1j * random.standard_normal(20), 0.0
        )
        held.append(length < 2.0 * np.hypot(along.standard, bias))
    assert np.mean(held) > 0.95


def test_a_ripple_below_the_steps_is_no_exact_nothing() -> None:
    """What steps add on average may be more than the whole reading."""
    random, none = np.random.default_rng(8), 0
    for radius in 0.17 + 1e-3 * random.uniform(-1.0, 1.0, 3):
        step, noise = 1.5e-3, 2e-5 * random.standard_normal((2, ROWS))
        psi = radius * np.exp(1j * _turns(20.3)) + noise[0] + 1j * noise[1]
        found = _number(
            step * (np.round(psi.real / step) + 1j * np.round(psi.imag / step)), "flux_radius_rms"
        )
        assert found.uncertainty is not None
        assert abs(found.value - 2e-5) < 3.0 * found.uncertainty.standard
        none += found.value == 0.0
    assert none


def test_a_centre_that_drifts_across_its_distance_from_zero_is_told() -> None:
    psi = 0.12 * np.exp(1j * _turns(30.3)) + 0.002 + 0.004j * np.linspace(-0.5, 0.5, ROWS)
    noise = np.random.default_rng(4).standard_normal((2, ROWS))
    found = _number(psi + 1e-4 * (noise[0] + 1j * noise[1]), "flux_centre_offset")
    assert found.uncertainty is not None
    assert found.value == pytest.approx(0.002, abs=3.0 * found.uncertainty.standard)
    assert found.uncertainty.standard < 2e-5
