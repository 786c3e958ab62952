"""An answer that rings in few rows a period, between which its peaks are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.steps.ringing import Ringing, ringing_about
from benchtool.analysis.steps.step import analyze_step
from benchtool.block import Block

DAMPING, NOISE, BEFORE = 0.25, 1e-3, 60
FINE = np.arange(0.0, 60.0, 1e-3)


def _answer(rows: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    """Return the answer of second order to a step at zero, so many rows after it."""
    rate = 2.0 * math.pi / period / math.sqrt(1.0 - DAMPING**2)
    angle, lag = 2.0 * math.pi / period, DAMPING * rate
    after = np.maximum(rows, 0.0)
    mode = np.cos(angle * after) + lag / angle * np.sin(angle * after)
    return np.asarray(1.0 - np.exp(-lag * after) * mode)


def _ringing(period: float, late: float, noise: float = NOISE, seed: int = 1) -> Ringing | None:
    random = np.random.default_rng(seed)
    samples = _answer(np.arange(80.0) + late, period) + noise * random.standard_normal(80)
    return ringing_about(samples, int(np.argmax(samples)), noise)


@pytest.mark.parametrize("period", [2.7, 3.1, 4.4, 6.5])
@pytest.mark.parametrize("late", [0.05, 0.35, 0.65, 0.95])
def test_peaks_are_those_between_the_samples(period: float, late: float) -> None:
    found = _ringing(period, late)
    assert found is not None
    values = _answer(FINE, period)
    top = int(np.argmax(values))
    for peak, truth in ((found.crest, values[top]), (found.trough, np.min(values[top:]))):
        assert abs(peak.height - float(truth)) < 4.0 * peak.height_error
        assert peak.height_error < 0.03
    assert found.crest.place + late == pytest.approx(FINE[top], abs=4.0 * found.crest.place_error + 1e-3)


@pytest.mark.parametrize(("late", "is_told"), [(0.4, True), (0.8, False)])
def test_a_crest_before_the_first_row_of_the_mode_is_not_the_next_one(late: float, is_told: bool) -> None:
    """A crest as much before its row as is `late`, and rows before that which are none of the mode."""
    values = _answer(FINE, 6.0)
    after = float(FINE[int(np.argmax(values))]) + late
    samples = np.concatenate([np.zeros(3), _answer(np.arange(80.0) + after, 6.0)])
    found = ringing_about(samples, 3, NOISE)
    if is_told:
        assert found is not None
        assert found.crest.height == pytest.approx(float(np.max(values)), abs=4.0 * found.crest.height_error)
    else:
        assert found is None


@pytest.mark.parametrize("late", [0.1, 0.5, 0.9])
def test_times_are_those_between_the_samples(late: float) -> None:
    found = _ringing(3.1, late)
    assert found is not None
    values = _answer(FINE, 3.1)
    rise = found.rise(0.0, 0.1, 0.9)
    assert rise is not None
    assert rise.place == pytest.approx(
        float(np.argmax(values > 0.9) - np.argmax(values > 0.1)) * 1e-3, abs=0.03
    )
    settled = found.last_outside(1.0, 0.02)
    assert settled is not None
    truth = float(np.flatnonzero(np.abs(values - 1.0) > 0.02)[-1]) * 1e-3
    assert abs(settled.place + late - truth) < 3.0 * settled.standard


def test_a_mode_that_is_not_tangent_to_the_level_before_tells_no_rise() -> None:
    found = _ringing(3.1, 0.5)
    assert found is not None
    assert found.rise(-0.1, 0.0, 0.9) is None
    assert found.rise(0.0, 0.1, 2.0) is None


def test_a_slow_mode_and_two_are_none_of_few_rows() -> None:
    assert _ringing(12.0, 0.5) is None
    rows = np.arange(80.0) + 0.5
    two = _answer(rows, 3.1) + 0.3 * _answer(rows, 4.7)
    assert ringing_about(two, int(np.argmax(two)), NOISE) is None
    noise = np.random.default_rng(2).standard_normal(80)
    assert ringing_about(noise, 30, 1.0) is None


def test_clicks_of_an_answer_that_has_arrived_are_no_mode_of_it() -> None:
    click = _answer(np.arange(60.0) + 0.2, 3.1) - 1.0
    samples = np.concatenate([1.0 - np.exp(-np.arange(80.0) / 11.0), 1.0 - 0.2 * click])
    samples += NOISE * np.random.default_rng(4).standard_normal(len(samples))
    top = int(np.argmax(samples))
    assert top >= 80
    assert ringing_about(samples, top, NOISE) is None


def _found(period: float, late: float, noise: float, seed: int) -> dict[str, Measurement]:
    random = np.random.default_rng(seed)
    rows = np.arange(200.0) - BEFORE + late
    y = np.where(rows < 0.0, 0.0, _answer(rows, period)) + noise * random.standard_normal(len(rows))
    r = np.where(rows < 0.0, 0.0, 1.0)
    block = Block.from_arrays(1e3, {"y": "A", "r": "A"}, y=y, r=r)
    return {each.name: each for each in analyze_step(block, "y", "r").measurements}


def test_a_step_response_has_the_excursions_and_times_of_its_mode() -> None:
    period = 3.1
    values = _answer(FINE, period)
    top = int(np.argmax(values))
    truths = {
        "overshoot": float(values[top]) - 1.0,
        "undershoot": 1.0 - float(np.min(values[top:])),
        "rise_time": float(np.argmax(values > 0.9) - np.argmax(values > 0.1)) * 1e-6,
        "settling_time": float(np.flatnonzero(np.abs(values - 1.0) > 0.02)[-1]) * 1e-6,
        "peak_time": float(top) * 1e-6,
    }
    errors = []
    for seed, late in enumerate((0.1, 0.5, 0.9)):
        found = _found(period, late, NOISE, seed)
        for name, truth in truths.items():
            uncertainty = found[name].uncertainty
            assert uncertainty is not None
            errors.append((found[name].value - truth) / uncertainty.standard)
            assert uncertainty.standard < (4e-4 if name.endswith("time") else 0.02)
    assert float(np.sqrt(np.mean(np.square(errors)))) < 1.4


def test_times_that_seem_to_scatter_are_even_where_the_samples_are_one_mode(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("benchtool.analysis.steps.noisy_curve.scatter_of_times", lambda *_: 0.2)
    overshoot = _found(3.1, 0.5, NOISE, 1)["overshoot"]
    assert overshoot.uncertainty is not None
    assert overshoot.uncertainty.standard < 0.02
    truth = float(np.max(_answer(FINE, 3.1))) - 1.0
    assert abs(overshoot.value - truth) < 3.0 * overshoot.uncertainty.standard


@pytest.mark.parametrize("slope", [0.25, 0.3, 0.45, 0.5])
def test_a_rise_that_ends_without_a_trough_beyond_noise_is_no_mode(slope: float) -> None:
    """Few samples on the way up and a level are of a mode that is gone within a row, too."""
    for seed in range(4):
        noise = 4e-3 * np.random.default_rng(seed).standard_normal(84)
        rise = np.concatenate([np.zeros(5), np.minimum(1.0, slope * np.arange(1.0, 80.0))]) + noise
        first = int(np.argmax(rise > 0.99))
        assert [ringing_about(rise, first + k, 4e-3) for k in range(3)] == [None] * 3


@pytest.mark.parametrize("late", [0.25, 0.5, 0.75])
def test_a_row_before_the_answer_is_none_of_its_mode(late: float) -> None:
    """It hardly leaves more than noise does of sixty rows, but a mode with it has other peaks."""
    values = _answer(FINE, 3.3)
    trough, errors = float(np.min(values[int(np.argmax(values)) :])), []
    for seed in range(20):
        noise = 3e-3 * np.random.default_rng(seed).standard_normal(84)
        samples = _answer(np.arange(84.0) - 3.0 - late, 3.3) + noise
        found = ringing_about(samples, int(np.argmax(samples)), 3e-3)
        if found is not None:
            errors.append((found.trough.height - trough) / found.trough.height_error)
    assert len(errors) > 15
    assert np.sqrt(np.mean(np.square(errors))) < 1.4
