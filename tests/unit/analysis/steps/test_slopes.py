"""Slopes before and after a step: a drift goes on, slow noise does not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.coverage.noise import pink
from benchtool.analysis.measurement import Measurement
from benchtool.analysis.steps.arrived_samples import ArrivedSamples
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.passages import Instant
from benchtool.analysis.steps.slopes import Slope, are_along_a_line
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.step import analyze_step
from benchtool.block import Block
from tests.at_length import at_length

RATE_HZ, BEFORE, ROWS, DECAY = 10_000.0, 250, 1250, 10.0
NOISE, DRIFT = 3e-3, 1e-4
SINCE = np.maximum(np.arange(ROWS) - BEFORE, 0)
WAY = 1.0 - np.exp(-SINCE / DECAY)


def _found(samples: NDArray[np.float64], height: float) -> dict[str, Measurement]:
    reference = np.where(np.arange(ROWS) < BEFORE, 0.0, height)
    block = Block.from_arrays(RATE_HZ, {"y": "A", "r": "A"}, y=samples, r=reference)
    return {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}


def _popcorn(random: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Return white noise of a tenth of the power, and a level that jumps once in fifty samples."""
    level = np.where(np.cumsum(random.random(count) < 0.02) % 2, 1.0, -1.0)
    return np.asarray(np.sqrt(0.9) * level + np.sqrt(0.1) * random.standard_normal(count))


@pytest.mark.parametrize("drift", [DRIFT, -DRIFT])
@pytest.mark.parametrize("height", [1.0, *at_length(-1.0)])
def test_samples_that_drift_at_rest_scatter_about_a_line(drift: float, height: float) -> None:
    random = np.random.default_rng(11)
    line = drift * (np.arange(ROWS) - BEFORE)
    plateau = np.log(50.0) * DECAY <= SINCE
    truth = float(np.mean((height * WAY + line)[plateau]))
    for _ in range(4):
        noise = NOISE * random.standard_normal(ROWS)
        mean = _found(height * WAY + line + noise, height)["plateau_mean"]
        assert mean.uncertainty is not None
        assert abs(mean.value - truth) < 3.0 * mean.uncertainty.standard
        assert mean.uncertainty.standard < 5e-4  # noise 1e-4, first row 2e-4; about a level 0.03


def test_a_drift_beside_the_step_is_no_noise_of_the_row_in_which_it_arrives() -> None:
    """Of a signal that drifts out of every band the noise is that about its drift."""
    random, line = np.random.default_rng(3), 2.0 * DRIFT * (np.arange(ROWS) - BEFORE)
    mean = _found(WAY + line + NOISE * random.standard_normal(ROWS), 1.0)["plateau_mean"]
    assert mean.uncertainty is not None
    assert mean.uncertainty.standard < 2e-4  # noise 1e-4; with the drift as slow noise 2.7e-4


def test_a_drift_goes_on_and_the_slope_of_popcorn_noise_does_not() -> None:
    random, line = np.random.default_rng(13), DRIFT * np.arange(ROWS)
    goes_on: dict[str, list[bool]] = {"drift": [], "popcorn": []}
    for _ in range(160):
        drifting = line + NOISE * random.standard_normal(ROWS)
        for name, samples in (("drift", drifting), ("popcorn", NOISE * _popcorn(random, ROWS))):
            before = Slope.of(samples[:BEFORE])
            assert before is not None
            if before.is_certain:
                goes_on[name].append(before.goes_on_in(samples[BEFORE + 200 :]))
    assert np.mean(goes_on["drift"]) > 0.97
    assert len(goes_on["popcorn"]) >= 4
    assert not any(goes_on["popcorn"])


def test_a_slope_that_is_certain_before_a_step_and_at_rest_is_a_drift() -> None:
    """Of four standard uncertainties before the step it is certain, and after it of thirty."""
    random, line, found = np.random.default_rng(17), 1.4e-5 * (np.arange(ROWS) - BEFORE), []
    for _ in range(12):
        samples = WAY + line + NOISE * random.standard_normal(ROWS)
        before = Slope.of(samples[:BEFORE])
        assert before is not None
        if before.is_certain and not before.is_certain_at_rest:
            mean = _found(samples, 1.0)["plateau_mean"]
            assert mean.uncertainty is not None
            found.append(mean.uncertainty.standard)
    assert len(found) >= 2
    assert max(found) < 2e-4  # of noise 1e-4; with the drift as slow noise 4e-3


def test_samples_are_about_their_mean_where_a_slope_before_them_does_not_go_on() -> None:
    random = np.random.default_rng(14)
    begin, noise = Instant(BEFORE + DECAY * np.log(50.0), 0.1), Noise(np.zeros(1))
    line = WAY + DRIFT * np.arange(ROWS)
    popcorn, drifting = NOISE * _popcorn(random, ROWS), NOISE * random.standard_normal(ROWS)

    def of_mean(course: NDArray[np.float64], left: NDArray[np.float64], slope: Slope | None) -> float:
        curve = NoisyCurve(course, np.empty((0, ROWS)), 0.0)
        samples = ArrivedSamples.of(course + left, curve, begin, 0.2, noise, 0.0, BEFORE, slope)
        found = samples.of_mean()
        assert found is not None
        return found.standard

    for slope in (Slope(5e-5, 1e-5), Slope(-5e-5, 1e-5)):
        assert of_mean(WAY, popcorn, slope) == of_mean(WAY, popcorn, None)
    about_mean = of_mean(line, drifting, Slope(-DRIFT, 1e-5))
    assert of_mean(line, drifting, Slope(DRIFT, 1e-5)) < 0.1 * about_mean
    assert of_mean(line, drifting, None) < 0.1 * about_mean


def test_samples_at_rest_show_by_themselves_that_they_drift_evenly() -> None:
    """It is too little to be certain before the step. No walk, jumps, creep, slow noise or hum passes for it,
    but for hum that hardly bends within the record."""
    random, row, count = np.random.default_rng(15), np.arange(ROWS), 40
    turned = 2.0 * np.pi * row / ROWS
    found: dict[str, list[bool]] = {}
    for _ in range(count):
        white = random.standard_normal(ROWS)
        for name, samples in (
            ("drift", white + 2e-3 * row),
            ("drift", white - 2e-3 * row),
            ("walk", white + np.cumsum(0.1 * random.standard_normal(ROWS))),
            ("popcorn", _popcorn(random, ROWS)),
            ("creep", white + 6.0 * np.exp(-row / (0.5 * ROWS))),
            ("hum", white + 2.0 * np.cos(0.4 * turned + random.uniform(0.0, 2.0 * np.pi))),
            ("slow noise", pink(random, ROWS)),
            ("white", white),
        ):
            found.setdefault(name, []).append(are_along_a_line(samples))
    shares = {name: float(np.mean(each)) for name, each in found.items()}
    assert shares.pop("drift") > 0.95
    assert shares.pop("hum") < 0.2
    assert max(shares.values()) < 0.05


def test_a_slope_seen_from_below_is_the_other_way_and_as_uncertain() -> None:
    assert Slope(2.0, 0.5).seen_from(-1.0) == Slope(-2.0, 0.5)
    assert Slope(2.0, 0.5).seen_from(1.0) == Slope(2.0, 0.5)


def test_few_samples_have_no_slope() -> None:
    assert Slope.of(np.arange(19.0)) is None
    assert not Slope(1.0, 0.1).goes_on_in(np.arange(19.0))


def test_a_slight_drift_before_a_step_moves_the_level_that_the_answer_leaves() -> None:
    """It moves the mean of 0.6 s before the step by up to 0.9 % of that, and the start by a tenth."""
    relative, row, lag = [], np.arange(9000.0), 150.0
    for seed in range(5):
        random = np.random.default_rng(seed)
        since = np.maximum(row - 6000.0 + random.uniform(), 0.0) / lag
        slope = 0.03 * (-1.0) ** seed * random.uniform(0.5, 1.0)
        way = 1.0 - (1.0 + since) * np.exp(-since) + slope * (row - 6000.0) / 10e3
        speed = 100.0 + 50.0 * (way + 0.002 * random.standard_normal(len(row)))
        reference = np.where(row < 6000.0, 100.0, 150.0)
        block = Block.from_arrays(10e3, {"y": "rad/s", "r": "rad/s"}, y=speed, r=reference)
        found = analyze_step(block, "y", "r").measurements
        latency = next(each for each in found if each.name == "step_latency")
        assert latency.uncertainty is not None
        assert latency.uncertainty.standard < 1e-3
        true_s = 0.21470 * lag / 10e3  # 1 - (1 + x) exp(-x) is 2 % there
        relative.append((latency.value - true_s) / latency.uncertainty.standard)
    assert np.sqrt(np.mean(np.square(relative))) < 1.5


def test_a_drift_that_goes_on_is_no_slow_noise() -> None:
    """It moves the signal by a fifth of the band in the whole record, and by far less until it settles."""
    random, line = np.random.default_rng(17), 4e-6 * (np.arange(ROWS) - BEFORE)
    for _ in range(4):
        found = _found(WAY + line + 2e-4 * random.standard_normal(ROWS), 1.0)
        for name, true in (("reach_time", np.log(50.0)), ("rise_time", np.log(9.0))):
            standard = found[name].uncertainty
            assert standard is not None
            assert abs(found[name].value - true * DECAY / RATE_HZ) < 3.0 * standard.standard
            assert standard.standard < 0.25 / RATE_HZ  # as slow noise, 0.8 of a row
        rms = found["tracking_error_rms"].uncertainty
        assert rms is not None
        assert rms.standard < 0.02 * found["tracking_error_rms"].value
