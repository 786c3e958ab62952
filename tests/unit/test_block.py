"""A block made of plain arrays, what it refuses, and the example of the documentation."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchtool import analysis
from benchtool.analysis import (
    amplitude_spectrum,
    coherent_spectrum,
    frequency_response,
    ripple,
    ripple_numbers,
    track_tone,
)
from benchtool.block import Block, Gap
from benchtool.errors import AnalysisError

TIME_S = np.arange(4000) / 10e3
CURRENT_A = 5.0 * np.cos(2 * np.pi * 43.7 * TIME_S)


def test_arrays_become_channels_with_units_at_their_rate() -> None:
    counts = [1, 2, 3]
    block = Block.from_arrays(2000.0, {"i_a": "A"}, i_a=np.array([1, 2, 4]), ticks_seen=counts)
    assert block.names == ("i_a", "ticks_seen")
    assert [block.unit(name) for name in block.names] == ["A", ""]
    assert block.sample_rate_Hz == 2000.0
    assert block.time_s().tolist() == [0.0, 0.0005, 0.001]
    assert block.data.dtype == np.float64
    assert block.column("i_a").tolist() == [1.0, 2.0, 4.0]


def test_the_arrays_are_copied_and_the_block_is_read_only() -> None:
    mine = CURRENT_A.copy()
    block = Block.from_arrays(10e3, {}, i_a=mine)
    mine[0] = 99.0
    assert block.column("i_a")[0] == 5.0
    with pytest.raises(ValueError, match="read-only"):
        block.data[0, 0] = 1.0


@pytest.mark.parametrize(
    ("channels", "units", "rate_Hz", "message"),
    [
        ({"i_a": CURRENT_A[:, np.newaxis]}, {}, 10e3, r"'i_a' has the shape \(4000, 1\).*array\[:, 0\]"),
        ({"i_a": CURRENT_A, "i_b": CURRENT_A[1:]}, {}, 10e3, "'i_a' has 4000 rows, 'i_b' has 3999 rows"),
        ({}, {}, 10e3, "no channel was passed"),
        ({"i_a": CURRENT_A}, {"i_b": "A"}, 10e3, "a unit is stated for 'i_b'"),
        ({"i_a": CURRENT_A}, {}, 0.0, "the sample rate is 0 Hz"),
        ({"i_a": CURRENT_A}, {}, float("nan"), "the sample rate is nan Hz"),
        ({"i_a": ["one", "two"]}, {}, 10e3, "'i_a' holds what is no real number"),
        ({"i_a": CURRENT_A + 0j}, {}, 10e3, "'i_a' holds what is no real number"),
    ],
)
def test_what_is_no_channel_is_refused_in_one_line(
    channels: dict[str, Any], units: dict[str, str], rate_Hz: float, message: str
) -> None:
    with pytest.raises(AnalysisError, match=message) as refused:
        Block.from_arrays(rate_Hz, units, **channels)
    assert "\n" not in str(refused.value)


def test_missing_rows_are_counted_in_words_that_fit() -> None:
    whole = Block.from_arrays(10e3, {}, i_a=CURRENT_A)
    with pytest.raises(AnalysisError, match=r"^1 row is missing in 1 gap, "):
        replace(whole, gaps=(Gap(5, 1),)).require_uniform()
    with pytest.raises(AnalysisError, match=r"^3 rows are missing in 2 gaps, "):
        replace(whole, gaps=(Gap(5, 1), Gap(9, 2))).require_uniform()


def test_analyses_of_arrays_refuse_columns_and_rates_that_are_none() -> None:
    column = CURRENT_A[:, np.newaxis]
    track = track_tone(CURRENT_A)
    with pytest.raises(AnalysisError, match=r"the shape \(4000, 1\)"):
        ripple(column, "A")
    with pytest.raises(AnalysisError, match=r"the shape \(4000, 1\)"):
        amplitude_spectrum(column, 10e3)
    with pytest.raises(AnalysisError, match=r"the shape \(4000, 1\)"):
        coherent_spectrum(column, 10e3, track)
    with pytest.raises(AnalysisError, match=r"'output' has the shape \(4000, 1\)"):
        frequency_response(CURRENT_A, column, 10e3)
    for rate_Hz in (-1.0, 0.0):
        with pytest.raises(AnalysisError, match="a positive one is needed"):
            amplitude_spectrum(CURRENT_A, rate_Hz)
        with pytest.raises(AnalysisError, match="a positive one is needed"):
            coherent_spectrum(CURRENT_A, rate_Hz, track)
        with pytest.raises(AnalysisError, match="a positive one is needed"):
            frequency_response(CURRENT_A, CURRENT_A, rate_Hz)


def test_integers_and_lists_are_samples_too() -> None:
    assert ripple(np.array([1, 2, 3, 4]), "A").peak_to_peak == 3.0
    few: Any = CURRENT_A.tolist()
    assert coherent_spectrum(few, 10e3, track_tone(CURRENT_A)).amplitude.max() == pytest.approx(5.0, rel=1e-3)


def test_results_cannot_be_overwritten_and_the_callers_arrays_can() -> None:
    spectrum = coherent_spectrum(CURRENT_A, 10e3, track_tone(CURRENT_A))
    noise = np.random.default_rng(0).normal(0.0, 1.0, 4000)
    response = frequency_response(noise, noise + 0.1 * CURRENT_A, 10e3)
    for array in (
        spectrum.amplitude,
        spectrum.phasor,
        amplitude_spectrum(CURRENT_A, 10e3).frequency_Hz,
        response.response,
        response.coherence,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 9.0
    noise[0] = 1.0


def test_every_analysis_is_exported() -> None:
    wanted = {
        "analyze_step",
        "order_analysis",
        "fitted_orders",
        "analyze_response",
        "frequency_response",
        "switching_states",
        "torque_residual",
        "flux_trajectory",
    }
    assert wanted <= set(dir(analysis))
    assert all(callable(getattr(analysis, name)) for name in wanted)


def test_the_example_of_the_documentation_runs_and_says_what_it_says() -> None:
    page = (Path(__file__).parents[2] / "docs" / "reference" / "measurements.md").read_text(encoding="utf-8")
    found = re.search(r"## From numpy arrays.*?```python\n(.*?)```", page, re.DOTALL)
    assert found is not None
    names: dict[str, Any] = {}
    exec(found[1], names)
    assert f"{names['thd'].value:.2f} %" in found[1]
    assert names["thd"].value == pytest.approx(5.0, abs=0.01)
    assert {each.name: each.value for each in names["orders"].measurements}["torque_order_largest"] == 24
    numbers = {each.name: each.value for each in names["bode"].measurements}
    # |1 - 0.9 / z| = 0.1 sqrt(2), so cos = (1 + 0.81 - 0.02) / 1.8
    expected_Hz = 10e3 / (2 * np.pi) * np.arccos((1.81 - 0.02) / 1.8)
    assert numbers["bandwidth_3dB"] == pytest.approx(expected_Hz, rel=0.05)
    numbers_of_torque = ripple_numbers(names["block"], "torque", "torque")
    assert numbers_of_torque[0].value == pytest.approx(1.2, abs=1e-4)
