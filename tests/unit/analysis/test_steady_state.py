"""The analysis of a whole capture, on a synthetic drive whose every number is known."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import SteadyState, analyze_steady_state, coherent_samples, crop_to, track_angle
from benchtool.block import Block, Channel, Gap
from benchtool.errors import AnalysisError

SAMPLES = 5200
TICK_S = 1e-4
NAMES = [
    "torque_mean",
    "torque_ripple_pp",
    "torque_ripple_rms",
    "torque_ripple_percentile_range",
    "torque_ripple_percent_of_mean",
    "torque_ripple_rms_percent_of_mean",
    "torque_ripple_percent_of_rated",
    "torque_ripple_rms_percent_of_rated",
    "flux_ripple_pp",
    "fundamental_frequency",
    "current_fundamental",
    "current_max_low_harmonic",
    "current_thd_f",
    "current_thd_r",
    "current_tdd",
    "current_thd_f_plus_noise",
    "current_thd_f_groups",
    "current_thd_f_subgroups",
    "current_noise_floor",
    "current_noise_density",
    "switching_frequency_mean",
]


def capture(torque_offset_Nm: float = 0.65) -> Block:
    """10 Hz electrical, 0.24 A, a fifth harmonic of 7 mA, torque ripple 0.06 Nm at six times 10 Hz."""
    number = np.arange(SAMPLES)
    theta_e = 2 * np.pi * 10.0 * number * TICK_S
    columns: dict[str, tuple[str, NDArray[np.float64]]] = {
        "theta_m": ("rad", np.mod(theta_e / 4, 2 * np.pi)),
        "i_a": ("A", 0.24 * np.cos(theta_e) + 0.007 * np.cos(5 * theta_e)),
        "torque": ("Nm", torque_offset_Nm + 0.03 * np.cos(6 * theta_e)),
        "psi_s": ("Wb", 0.1685 + 0.001 * np.cos(6 * theta_e)),
        "switching_count": ("", np.mod(2.0**32 - 300 + 2.0 * number, 2.0**32)),
    }
    channels = tuple(Channel(name, unit) for name, (unit, _) in columns.items())
    return Block(channels, 7000, 1, TICK_S, np.stack([column for _, column in columns.values()], axis=1))


def transducer(first_tick: int = 7000, ticks: int = SAMPLES) -> Block:
    """True torque, 20 samples a tick, with a spike before tick 7000 and one after the capture."""
    tick = first_tick + np.arange(20 * ticks) / 20
    torque = 0.65 + 0.05 * np.cos(2 * np.pi * tick)
    torque[(tick < 7000) | (tick >= 7000 + SAMPLES)] = 9.0
    return Block(
        (Channel("torque_transducer", "Nm"),), 20 * first_tick, 1, TICK_S / 20, torque[:, np.newaxis]
    )


def analyze(block: Block, transducer_torque: Block | None = None) -> SteadyState:
    return analyze_steady_state(
        block, pole_pairs=4, torque_rated_Nm=9.55, transducer=transducer_torque, current_rated_A_rms=3.0
    )


def without(block: Block, name: str) -> Block:
    keep = [number for number, channel in enumerate(block.names) if channel != name]
    return replace(block, channels=tuple(block.channels[k] for k in keep), data=block.data[:, keep])


def test_the_torque_error_is_what_the_estimate_has_too_much() -> None:
    assert analyze(capture(0.68), transducer())["torque_error"].value == pytest.approx(0.03, abs=2e-4)


def test_the_torque_error_scatters_over_the_periods_as_both_means_where_these_are_independent() -> None:
    noise = np.random.default_rng(8).standard_normal
    block, shaft = capture(0.68), transducer()
    block, shaft = (replace(each, data=each.data + 1e-3 * noise(each.data.shape)) for each in (block, shaft))
    steady = analyze(block, shaft)
    stated = (steady[name].uncertainty for name in ("torque_error", "torque_mean", "transducer_torque_mean"))
    error, *means = (each for each in stated if each is not None)

    assert error.standard == pytest.approx(sum(each.standard**2 for each in means) ** 0.5, rel=0.2)
    assert math.isfinite(error.dof)
    (line,) = error.budget
    assert line.name.startswith("scatter of the difference over the periods")


def test_every_number_of_a_known_capture() -> None:
    steady = analyze(capture(), transducer())

    values = {each.name: each.value for each in steady.measurements}
    assert values.pop("torque_error") == pytest.approx(0.0, abs=2e-4), "not whole periods of the ripple"
    assert values.pop("current_noise_floor") < 1e-5
    assert values.pop("current_noise_density") < 1e-5
    ratio = 0.007 / 0.24
    assert values == pytest.approx(
        {
            "torque_mean": 0.65,
            "torque_ripple_pp": 0.06,
            "torque_ripple_rms": 0.03 / np.sqrt(2),
            # a cosine of random phase stays below cos(pi (1 - P)) with probability P
            "torque_ripple_percentile_range": 0.06 * np.cos(0.005 * np.pi),
            "torque_ripple_percent_of_mean": 100 * 0.06 / 0.65,
            "torque_ripple_rms_percent_of_mean": 100 * 0.03 / np.sqrt(2) / 0.65,
            "torque_ripple_percent_of_rated": 100 * 0.06 / 9.55,
            "torque_ripple_rms_percent_of_rated": 100 * 0.03 / np.sqrt(2) / 9.55,
            "transducer_torque_mean": 0.65,
            "transducer_torque_ripple_pp": 0.1,
            "transducer_torque_ripple_rms": 0.05 / np.sqrt(2),
            "transducer_torque_ripple_percentile_range": 0.1 * np.cos(0.005 * np.pi),
            "transducer_torque_ripple_percent_of_mean": 100 * 0.1 / 0.65,
            "transducer_torque_ripple_rms_percent_of_mean": 100 * 0.05 / np.sqrt(2) / 0.65,
            "transducer_torque_ripple_percent_of_rated": 100 * 0.1 / 9.55,
            "transducer_torque_ripple_rms_percent_of_rated": 100 * 0.05 / np.sqrt(2) / 9.55,
            "flux_ripple_pp": 0.002,
            "fundamental_frequency": 10.0,
            "current_fundamental": 0.24,
            "current_thd_f": 100 * ratio,
            "current_thd_r": 100 * ratio / np.hypot(1.0, ratio),
            "current_tdd": 100 * 0.007 / (3.0 * np.sqrt(2)),
            "current_thd_f_plus_noise": 100 * ratio,
            "current_thd_f_groups": 100 * ratio,
            "current_thd_f_subgroups": 100 * ratio,
            "current_max_low_harmonic": 0.007,
            "switching_frequency_mean": 2 / 3 / TICK_S,
        },
        rel=1e-3,
    )
    assert steady.periods == 5
    assert steady.fundamental_Hz == pytest.approx(10.0)


def test_every_number_states_its_definition_and_what_it_rests_on() -> None:
    steady = analyze(capture())

    assert [each.name for each in steady.measurements] == NAMES
    for each in steady.measurements:
        assert "\n" not in each.definition
        assert each.basis.sample_rate_Hz == pytest.approx(10e3)
        assert each.basis.samples == pytest.approx((each.basis.duration_s or 0.0) * 10e3, abs=1)
        assert each.basis.gaps == 0
        if each.name != "switching_frequency_mean":
            assert each.basis.window
            assert 0.0 < (each.basis.bandwidth_Hz or 0.0) <= 5e3
    assert steady["current_thd_f"].basis.harmonics == 50
    assert steady["current_thd_f"].basis.reference == "fundamental"
    assert steady["current_tdd"].basis.reference == "rated current of 3 A rms, a reference of benchtool's own"
    assert "over the 5 periods there are in place of 10" in steady["current_thd_f_groups"].definition
    assert "here at 50 Hz; all bins, 2 Hz apart" in steady["current_max_low_harmonic"].definition
    assert "rated torque of 9.55 Nm" in steady["torque_ripple_percent_of_rated"].definition


def test_the_tables_hold_what_the_numbers_are_made_from() -> None:
    steady = analyze(capture())

    harmonics, groups = steady.tables
    assert (harmonics.name, groups.name) == ("current_harmonics", "current_groups")
    assert all(len(row) == len(table.columns) for table in steady.tables for row in table.rows)
    assert [row[0] for row in harmonics.rows] == list(range(1, 51))
    order, frequency_Hz, amplitude_A, percent, phase_rad, uncertainty_A = harmonics.rows[4]
    assert order == 5
    assert frequency_Hz == pytest.approx(50.0)
    assert amplitude_A == pytest.approx(0.007, rel=1e-3)
    assert percent == pytest.approx(100 * 0.007 / 0.24, rel=1e-3)
    assert phase_rad == pytest.approx(0.0, abs=1e-2)
    assert 0.0 < uncertainty_A < 1e-4
    assert groups.rows[4][1:3] == pytest.approx((0.007 / np.sqrt(2),) * 2, rel=1e-3)


def test_percent_of_a_zero_mean_is_undefined_and_null_in_json() -> None:
    document = analyze(replace(capture(0.0), data=capture(0.0).data[:5000])).to_json()

    assert document["torque_ripple_percent_of_mean"]["value"] is None
    assert "the mean torque is zero" in str(document["torque_ripple_percent_of_mean"])
    json.dumps(document, allow_nan=False)


def test_percent_of_a_rated_torque_of_zero_is_undefined() -> None:
    steady = analyze_steady_state(capture(), pole_pairs=4, torque_rated_Nm=0.0)

    assert steady.to_json()["torque_ripple_percent_of_rated"]["value"] is None


def test_thd_at_a_speed_with_no_harmonic_in_the_band_is_undefined() -> None:
    block = capture()
    number = np.arange(SAMPLES)
    data = block.data.copy()
    data[:, block.names.index("i_a")] = np.cos(2 * np.pi * 0.3 * number)
    data[:, block.names.index("theta_m")] = np.mod(2 * np.pi * 0.3 / 4 * number, 2 * np.pi)

    steady = analyze(replace(block, data=data))

    assert steady["current_thd_f"].reason == "no harmonic is within the band"
    assert steady["current_fundamental"].value == pytest.approx(1.0, rel=1e-3)
    assert "below 4500 Hz" in steady["current_max_low_harmonic"].definition


def test_without_an_angle_the_periods_come_from_the_current() -> None:
    steady = analyze(without(capture(), "theta_m"))

    assert steady["fundamental_frequency"].value == pytest.approx(10.0, rel=1e-5)
    assert "largest sinusoid of i_a" in steady["fundamental_frequency"].basis.window
    assert steady["current_max_low_harmonic"].value == pytest.approx(0.007, rel=1e-2)


def test_without_the_current_the_rest_is_measured_and_the_spectrum_is_refused() -> None:
    steady = analyze(without(capture(), "i_a"))
    assert {"torque_ripple_pp", "flux_ripple_pp", "switching_frequency_mean"} <= steady.names
    assert not [name for name in steady.names if name.startswith("current_")]
    assert steady.spectrum is None
    with pytest.raises(AnalysisError, match="without channel 'i_a'"):
        _ = steady.periods


@pytest.mark.parametrize(
    ("channel", "begin"),
    [("torque", "torque_"), ("psi_s", "flux_"), ("switching_count", "switching_")],
)
def test_what_was_not_recorded_is_not_measured(channel: str, begin: str) -> None:
    steady = analyze(without(capture(), channel), transducer())

    expected = [name for name in NAMES if not name.startswith(begin)]
    names = [each.name for each in steady.measurements]
    assert [
        name for name in names if not name.startswith("transducer_") and name != "torque_error"
    ] == expected
    assert ("torque_error" in names) is (channel != "torque")


@pytest.mark.parametrize("name", ["i_a", "theta_m", "torque", "psi_s"])
@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_dead_channel_is_refused_by_name(name: str, value: float) -> None:
    block = capture()
    data = block.data.copy()
    data[:, block.names.index(name)] = value

    with pytest.raises(AnalysisError, match=f"'{name}'"):
        analyze(replace(block, data=data))


def test_a_gap_in_either_recording_is_refused() -> None:
    with pytest.raises(AnalysisError, match="3 rows are missing"):
        analyze(replace(capture(), gaps=(Gap(100, 3),)))
    with pytest.raises(AnalysisError, match="5 rows are missing"):
        analyze(capture(), replace(transducer(), gaps=(Gap(100, 5),)))


def test_the_captured_tick_must_advance_by_the_stride() -> None:
    block = capture()
    tick = np.mod(2.0**32 - 100 + np.arange(SAMPLES), 2.0**32)
    channels = (*block.channels, Channel("tick", ""))
    counted = replace(block, channels=channels, data=np.column_stack([block.data, tick]))

    assert analyze(counted).measurements == analyze(block).measurements
    slipped = counted.data.copy()
    slipped[300:, -1] += 1
    with pytest.raises(
        AnalysisError, match="advances by 2 at row 300 and not by the stride of 1 in 1 places"
    ):
        analyze(replace(counted, data=slipped))


def test_an_unknown_measurement_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(AnalysisError, match=r"no measurement 'thd'.*current_thd_f"):
        analyze(capture())["thd"]


def test_the_transducer_is_cut_to_the_time_of_the_capture() -> None:
    longer = transducer(6990, SAMPLES + 25)

    cut = crop_to(longer, capture())

    assert cut.first_tick == 7000 * 20
    assert len(cut.data) == 20 * SAMPLES
    assert np.shares_memory(cut.data, longer.data)
    assert analyze(capture(), longer)["transducer_torque_ripple_pp"].value == pytest.approx(0.1)


def test_a_definition_names_the_rows_that_were_used() -> None:
    longer = transducer(6990, SAMPLES + 25)

    steady = analyze(capture(), longer)

    for name in ("transducer_torque_ripple_pp", "transducer_torque_ripple_rms", "torque_error"):
        found = re.search(r"its rows (\d+) to (\d+), from 0", steady[name].definition)
        assert found is not None
        rows = longer.column("torque_transducer")[int(found[1]) : int(found[2]) + 1]
        value = {
            "transducer_torque_ripple_pp": float(np.ptp(rows)),
            "transducer_torque_ripple_rms": float(np.std(rows)),
            "torque_error": steady["torque_mean"].value - float(np.mean(rows)),
        }[name]
        # the mean of the difference leaves out what the incomplete period makes of the ripple
        within = 1e-6 if name == "torque_error" else 1e-12
        assert steady[name].value == pytest.approx(value, rel=1e-9, abs=within)
    assert steady["torque_error"].basis.reference == f"torque_transducer, {20 * SAMPLES} samples at 200000 Hz"
    begun = re.search(r"from row (\d+) \(from 0\) on", steady["current_thd_f"].basis.window)
    assert begun is not None
    # the first sample of the periods is that row of the record
    assert coherent_samples(
        capture().column("i_a"), 1 / TICK_S, track_angle(capture().column("theta_m"), 4)
    ).values[0] == pytest.approx(capture().column("i_a")[int(begun[1])], rel=1e-4)
    assert "one of them" in steady["current_thd_f_groups"].basis.window


@pytest.mark.parametrize(("first_tick", "ticks"), [(7002, SAMPLES), (7000, SAMPLES - 2), (90000, 10)])
def test_a_transducer_that_misses_part_of_the_capture_is_refused(first_tick: int, ticks: int) -> None:
    with pytest.raises(AnalysisError, match=r"'torque_transducer' covers .* 0 s to 0\.52 s is needed"):
        analyze(capture(), transducer(first_tick, ticks))


def test_a_transducer_one_tick_short_at_either_end_is_enough() -> None:
    steady = analyze(capture(), transducer(7001, SAMPLES - 2))

    assert steady["transducer_torque_ripple_pp"].value == pytest.approx(0.1)


def test_a_capture_with_a_stride_keeps_its_time_base() -> None:
    block = capture()
    every_second = replace(block, stride=2, data=block.data[::2])

    steady = analyze(every_second)

    assert steady["fundamental_frequency"].value == pytest.approx(10.0)
    assert steady["switching_frequency_mean"].value == pytest.approx(2 / 3 / TICK_S)
    assert steady["torque_mean"].basis.samples == 2600
    assert steady["torque_mean"].basis.sample_rate_Hz == pytest.approx(5000)


def test_the_transducer_is_taken_apart_by_the_periods_of_the_capture() -> None:
    rms = analyze(capture(), transducer(6990, SAMPLES + 25))["transducer_torque_ripple_rms"]

    # the torque repeats every tick, so that every period is like every other
    assert rms.uncertainty is not None
    assert "over 5 electrical periods" in rms.uncertainty.source
    assert rms.uncertainty.standard < 1e-6


def test_every_number_without_an_uncertainty_says_why() -> None:
    found = analyze(capture(), transducer()).measurements
    assert [
        each.name
        for each in found
        if each.uncertainty is None and not (each.uncertainty_reason or each.reason)
    ] == []


@pytest.mark.parametrize("seed", [1, 2])
def test_sources_name_what_is_in_the_budget_and_nothing_else(seed: int) -> None:
    clean = capture()
    noise = 1e-3 * np.random.default_rng(seed).standard_normal(clean.data.shape)
    noise[:, [clean.names.index("theta_m"), clean.names.index("switching_count")]] = 0.0

    found = analyze_steady_state(replace(clean, data=clean.data + noise), pole_pairs=4, torque_rated_Nm=2.0)

    of_budgets = [each.uncertainty for each in found.measurements if each.uncertainty is not None]
    for error in ("resolution", "resampling", "wander of the phase", "tones nearby", "noise too slow"):
        for uncertain in of_budgets:
            is_in_budget = any(error in line.name for line in uncertain.budget)
            assert is_in_budget or error not in uncertain.source, uncertain.source
