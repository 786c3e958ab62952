"""What steps of a sensor do to a waveform that was read with it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import signal, special

from benchtool.analysis.sensors.lag import Response
from benchtool.analysis.sensors.waveform import Undone, Waveform, before_sensor, by_steps, moved_small_line

RATE_HZ, STEP = 10_000.0, 0.1


def _errors_over_uncertainties(later: float) -> tuple[float, float]:
    """Return the rms of error / u of mean and rms of a ripple of twelve steps with a third harmonic, whose
    steps noise of `later` of them hides."""
    random, found = np.random.default_rng(3), []
    for _ in range(40):
        turns = random.uniform(17.0, 23.0) / 2000 * np.arange(2000) + random.uniform()
        mean, large, small = (
            STEP * random.uniform(0, 1),
            STEP * random.uniform(5, 7),
            STEP * random.uniform(1, 2),
        )
        clean = large * np.cos(2 * np.pi * turns) + small * np.cos(6 * np.pi * turns + random.uniform(0, 6))
        read = STEP * np.round((mean + clean) / STEP) + later * STEP * random.standard_normal(2000)
        waveform, rms = Waveform(read, RATE_HZ), float(np.std(clean))
        of_rms = math.sqrt(max(0.0, waveform.rms**2 - (later * STEP) ** 2)) - rms
        found.append(
            [
                (waveform.mean - mean - float(np.mean(clean))) / by_steps(waveform, STEP, lambda of: of.mean),
                of_rms / by_steps(waveform, STEP, lambda of: of.rms),
            ]
        )
    of_mean, of_rms_too = np.sqrt(np.mean(np.square(found), axis=0))
    return float(of_mean), float(of_rms_too)


@pytest.mark.parametrize("later", [0.02, 0.2])
def test_steps_that_later_noise_hides_move_a_mean_and_an_rms_as_stated(later: float) -> None:
    of_mean, of_rms = _errors_over_uncertainties(later)
    assert 0.6 < of_mean < 1.5
    assert 0.6 < of_rms < 1.5


def test_noise_of_a_step_before_it_was_read_leaves_no_error_of_the_mean() -> None:
    random = np.random.default_rng(1)
    torque = 1.03 + 0.8 * STEP * random.standard_normal(20_000)
    read = STEP * np.round(torque / STEP) + 0.05 * STEP * random.standard_normal(20_000)
    assert by_steps(Waveform(read, RATE_HZ), STEP, lambda of: of.mean) < 0.02 * STEP
    still = Waveform(1.0 + 0.05 * STEP * random.standard_normal(20_000), RATE_HZ)
    assert by_steps(still, STEP, lambda of: of.mean) == pytest.approx(STEP / math.sqrt(12.0), rel=0.05)


@pytest.mark.parametrize("steps", [1.0, 2.0, 3.3])
def test_steps_move_a_small_line_by_what_a_large_one_leaves_of_them(steps: float) -> None:
    """The mean slope of the readings is 1 + 2 sum((-1)^k J_0(2 pi k A / q) cos(2 pi k x_0 / q)), of a large
    line of amplitude A about x_0 (Widrow and Kollar, Quantization Noise, 2008, ch. 19)."""
    count, small = 20_000, 0.1
    large = steps * np.cos(2 * np.pi * 0.0137 * np.arange(count))
    waveform = Waveform(large + 0.02 * np.random.default_rng(1).standard_normal(count), 1.0)
    expected = math.sqrt(sum(2.0 * float(special.j0(2.0 * np.pi * k * steps)) ** 2 for k in range(1, 4)))
    assert moved_small_line(waveform, 1.0, small) == pytest.approx(small * expected, rel=0.35)
    assert moved_small_line(waveform, 1.0, 0.3) == 0.0
    assert moved_small_line(waveform, 1.0, 0.0) == 0.0


def test_what_was_before_a_sensor_has_the_noise_of_the_reading() -> None:
    """White noise up to half the rate has not passed a sensor of a tenth of that."""
    by, noise = Response(500.0), 2e-3
    of_sensor = [1.0 / (2.0 * math.pi * by.bandwidth_Hz), 1.0]
    before, read = (_answer(np.polymul([3e-3, 1.0], each)) for each in ([1.0], of_sensor))
    beside = noise * np.random.default_rng(2).standard_normal(len(read))
    found = before_sensor(read + beside, RATE_HZ, by, Undone.SIGNAL)
    assert np.std(found[-3000:]) == pytest.approx(noise, rel=0.06)
    # at a corner the noise hides most
    assert (found - beside)[420:] == pytest.approx(before[420:], abs=3.0 * noise)
    assert before_sensor(read, RATE_HZ, by, Undone.SIGNAL)[420:] == pytest.approx(
        before[420:], abs=0.4 * noise
    )
    divided = before_sensor(read + beside, RATE_HZ, by, Undone.ALL)
    assert np.std(divided[-3000:]) > 3.0 * noise
    # the step of a corner is lost with the highest frequencies
    lower = before_sensor(read + beside, RATE_HZ, by, Undone.LOWER)
    assert _rms((lower - before)[380:420]) > _rms((found - before)[380:420])


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _answer(poles: np.ndarray) -> np.ndarray:
    """Return the answer to a step in row 400 of lags with this denominator."""
    _, answer = signal.step(([1.0], poles), T=np.arange(4000) / RATE_HZ)
    return np.concatenate([np.zeros(400), answer])
