"""Limits that were missed, in words, and numbers of the drive that the transducer contradicts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis import (
    BANDWIDTH,
    Basis,
    Contribution,
    Correction,
    InstrumentError,
    Measurement,
    Uncertainty,
    combined,
)
from benchtool.block import Block
from benchtool.plan.limits import Limit, Verdict
from benchtool.profile import Bench, Sensor
from benchtool.results.agreement import disagreements
from benchtool.results.block_result import analyze_block
from benchtool.results.calibration import Calibration
from tests.at_length import at_length
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR, steady_capture


def _number(name: str, value: float, standard: float | None = None) -> Measurement:
    uncertain = None if standard is None else Uncertainty(standard, "test")
    return Measurement(name, value, "Nm", "a number", uncertainty=uncertain)


def test_a_ripple_that_the_shaft_contradicts_is_told_with_the_verdict_there() -> None:
    measured = (
        _number("torque_ripple_pp", 0.0501, 0.0016),
        _number("transducer_torque_ripple_pp", 0.194, 0.002),
        _number("flux_ripple_pp", 1.0),
        _number("transducer_torque_ripple_rms", 0.03),
    )
    (found,) = disagreements(measured, {"torque_ripple_pp": Limit(max=0.06)})
    assert found.name == "torque_ripple_pp"
    assert found.verdict is Verdict.FAIL
    assert found.to_json()["transducer"] == 0.194
    assert found.to_json()["standard_uncertainty"] == pytest.approx(math.hypot(0.0016, 0.002))


def test_a_mean_is_held_by_the_difference_over_the_same_time() -> None:
    """A load that wanders is in both means and not in their difference."""
    both = (_number("torque_mean", 3.0, 0.1), _number("transducer_torque_mean", 3.02, 0.1))
    assert disagreements(both, {}) == ()
    (found,) = disagreements((*both, _number("torque_error", -0.02, 0.002)), {})
    assert (found.name, found.to_json()["standard_uncertainty"]) == ("torque_mean", 0.002)
    assert disagreements((*both, _number("torque_error", -0.02)), {}) == ()


def test_in_its_band_the_estimate_is_held_against_what_the_transducer_read() -> None:
    """0.10 Nm behind the transducer's lag, as it read it, of 0.14 Nm without."""
    estimate = _number("torque_ripple_rms", 0.14, 0.001)
    true = replace(
        _number("transducer_torque_ripple_rms", 0.14, 0.001), correction=Correction(0.04, "bandwidth")
    )
    narrow = replace(estimate, in_common_band=_number("torque_ripple_rms", 0.10, 0.001))
    assert disagreements((narrow, true), {}) == ()
    assert disagreements((estimate, true), {}) == ()
    assert len(disagreements((replace(estimate, in_common_band=estimate), true), {})) == 1


def test_what_the_transducer_read_in_its_band_is_told_beside_the_estimate_there() -> None:
    """It read 0.20 Nm, which were 2.0 Nm before its lag; what scatters was enlarged with it."""
    lag = Contribution("lag", "B", 0.030, instrument=InstrumentError(BANDWIDTH, "torque_transducer"))
    scatter = Contribution("scatter", "A", 0.040)
    true = replace(
        _number("transducer_torque_ripple_pp", 2.0),
        uncertainty=combined((scatter, lag), "test"),
        correction=Correction(1.8, "bandwidth"),
    )
    in_band = replace(_number("torque_ripple_pp", 0.024, 0.003), basis=Basis(bandwidth_Hz=1000.0))
    estimate = replace(_number("torque_ripple_pp", 0.0514, 0.003), in_common_band=in_band)
    (found,) = disagreements((estimate, true), {"torque_ripple_pp": Limit(max=0.06)})
    assert "(0.0240 ± 0.0059 Nm in the transducer's band, up to 1000 Hz, where the transducer reads" in str(
        found
    )
    assert "reads 0.2000 ± 0.0078 Nm); on the shaft it is 2.000 ± 0.098 Nm" in str(found)
    document = found.to_json()
    assert (document["transducer"], document["estimate_in_band"]) == (2.0, 0.024)
    assert document["transducer_in_band"] == pytest.approx(0.2)
    assert document["standard_uncertainty"] == pytest.approx(math.hypot(0.003, 0.004))


@pytest.mark.parametrize(
    ("difference", "own", "true", "told"),
    [
        (0.009, 0.003, 0.004, False),  # twice 0.005 is 0.01
        (0.011, 0.003, 0.004, True),
        (0.007, 0.003, None, True),
        (0.005, 0.003, None, False),
        (1e-6, None, None, True),
        (0.0, None, None, False),
        (math.nan, 0.1, 0.1, False),
    ],
)
def test_any_pair_of_names_is_compared(
    difference: float, own: float | None, true: float | None, told: bool
) -> None:
    pair = (_number("anything", 1.0, own), _number("transducer_anything", 1.0 + difference, true))
    assert bool(disagreements(pair, {})) is told
    assert all(each.verdict is None for each in disagreements(pair, {}))


def _shaft(rate_Hz: float, lag_Hz: float, highest_Hz: float, factor: float = 1.0) -> Block:
    """Return the torque of `steady_capture` behind a first-order lag, sampled without what it cannot show."""
    time_s = np.arange(round(0.3 * rate_Hz)) / rate_Hz
    phase = 2.0 * np.pi * 300.0 * time_s - math.atan(300.0 / lag_Hz)
    amplitude = 0.1 * factor / math.hypot(1.0, 300.0 / lag_Hz) if highest_Hz > 300.0 else 0.0
    noise = 1e-5 * np.random.default_rng(1).standard_normal(len(time_s))
    torque = 1.0 + amplitude * np.cos(phase) + noise
    return Block.from_arrays(rate_Hz, {"torque_transducer": "Nm"}, torque_transducer=torque)


@pytest.mark.parametrize(
    ("rate_Hz", "lag_Hz", "factor", "told"),
    [
        (2e4, 100.0, 1.0, False),  # of a stated bandwidth
        (2e4, 100.0, 1.5, True),
        (2e3, 100.0, 1.0, False),
        (2e4, math.inf, 1.0, False),  # as fast as the capture
        *at_length((2e4, math.inf, 1.5, True)),
    ],
)
def test_a_slow_transducer_is_compared_with_the_estimate_in_its_band(
    rate_Hz: float, lag_Hz: float, factor: float, told: bool
) -> None:
    capture, _ = steady_capture()
    sensors = {"torque_transducer": Sensor(bandwidth_Hz=lag_Hz)} if math.isfinite(lag_Hz) else {}
    calibration = Calibration(Bench(channels=sensors))
    shaft = _shaft(rate_Hz, lag_Hz, 0.5 * rate_Hz, factor)
    found = analyze_block(capture, EXAMPLE_MOTOR, transducer=shaft, calibration=calibration)
    by_name = {each.name: each for each in disagreements(found.measurements, {})}
    assert ("torque_ripple_rms" in by_name) is told
    if not told:
        return
    each = by_name["torque_ripple_rms"]
    if math.isinf(lag_Hz):
        assert not each.band_text
        return
    assert "in the transducer's band, up to 100 Hz" in each.band_text
    assert each.to_json()["band_Hz"] == 100.0
    in_band = 0.1 / math.sqrt(2.0) / math.hypot(1.0, 3.0)
    assert each.to_json()["estimate_in_band"] == pytest.approx(in_band, rel=2e-3)


def test_a_transducer_of_a_low_rate_is_not_held_against_what_it_cannot_show() -> None:
    capture, _ = steady_capture()
    found = analyze_block(capture, EXAMPLE_MOTOR, transducer=_shaft(500.0, math.inf, 250.0))
    rms = found["torque_ripple_rms"]
    assert rms.value == pytest.approx(0.1 / math.sqrt(2.0), rel=1e-3)
    assert rms.in_common_band is not None
    assert rms.in_common_band.value < 1e-3
    assert rms.in_common_band.basis.bandwidth_Hz == 250.0
