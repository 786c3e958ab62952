"""Bandwidths of sensors: what they have taken off is corrected."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from benchtool.analysis import (
    Excitation,
    Measurement,
    Table,
    measurements_from_json,
    measurements_to_json,
    percentile_range,
    tables_from_json,
    tables_to_json,
)
from benchtool.analysis.catalogue import catalogue, measure
from benchtool.analysis.measurement import Basis, LineColumn
from benchtool.analysis.responses.bode import FREQUENCY_RESPONSE
from benchtool.analysis.sensitivity import Sensitivities
from benchtool.analysis.sensors.instruments import Instruments, Perturbed
from benchtool.analysis.sensors.tables import AS_READ, with_sensors
from benchtool.analysis.steps.step import analyze_step
from benchtool.analysis.torque.ripple_percentiles import LOW_PERCENT
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.profile import Bench
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR
from tests.unit.analysis.stated_sensors import applied, lines, reading, sensor_of, uncertainty_of

ROOT_3 = math.sqrt(3.0)


def _between(found: Measurement, read: float, before: float) -> None:
    """A guarantee: the middle of what was read and what it may have been, half of the interval as u."""
    assert found.value == pytest.approx(0.5 * (read + before), rel=1e-3)
    assert uncertainty_of(found).standard == pytest.approx(0.5 * (before - read), rel=2e-2)
    assert found.correction is not None
    assert found.as_read == pytest.approx(read, rel=1e-9)


def test_a_bandwidth_counts_for_each_harmonic_at_its_frequency() -> None:
    """A fifth of 250 Hz behind 500 Hz: 1.118, over the 1.005 of the fundamental."""
    bench = Bench(channels={"i_a": sensor_of(bandwidth_Hz=500.0)})
    found = (
        reading("current_fundamental", 2.0, unit="A", frequency_Hz=50.0),
        replace(reading("current_thd_f", 10.0, unit="%"), basis=Basis(harmonics=9)),
        replace(reading("current_tdd", 10.0, unit="%"), basis=Basis(harmonics=50)),
        replace(
            reading("current_max_low_harmonic", 0.2, unit="A"),
            basis=Basis(bandwidth_Hz=1000.0, frequency_Hz=250.0),
        ),
        reading("current_noise_floor", 1e-3, unit="A"),
        reading("fundamental_frequency", 50.0, unit="Hz"),
    )
    line, thd, tdd, low, floor, _ = applied(bench, *found, blocks=[lines(f50=2.0, f250=0.2)])
    _between(line, 2.0, 2.0 * math.hypot(1.0, 0.1))
    _between(thd, 10.0, 10.0 * math.hypot(1.0, 0.5) / math.hypot(1.0, 0.1))
    _between(tdd, 10.0, 10.0 * math.hypot(1.0, 0.5))
    _between(low, 0.2, 0.2 * math.hypot(1.0, 0.5))
    assert (floor.value, floor.correction) == (1e-3, None)
    assert any("noise is that of the reading" in text for text in floor.basis.sensors)
    (blind,) = applied(bench, found[1])
    _between(blind, 10.0, 10.0 * math.hypot(1.0, 0.9))  # the ninth is the highest
    (unknown,) = applied(bench, replace(found[1], basis=Basis()))
    assert unknown.uncertainty is None
    assert "not known without a record of even samples" in unknown.uncertainty_reason


def test_beyond_its_bandwidth_a_sensor_may_have_two_poles() -> None:
    bench = Bench(channels={"i_a": sensor_of(bandwidth_Hz=50.0, gain_U_percent=1.0)})
    (line,) = applied(bench, reading("current_fundamental", 2.0, unit="A", frequency_Hz=60.0))
    _between(line, 2.0, 2.0 * math.hypot(1.0, 1.2**2))
    (lost,) = applied(bench, reading("current_fundamental", 2.0, unit="A", frequency_Hz=200.0))
    assert (lost.value, lost.uncertainty, lost.correction) == (2.0, None, None)
    assert "may have changed it by as much as is left" in lost.uncertainty_reason
    # not that the data gave none, nor the gain alone as what the sensors come to
    assert lost.basis.sensors == (lost.uncertainty_reason,)
    (silent,) = applied(bench, reading("current_fundamental", 2.0, None, "A", frequency_Hz=200.0))
    assert silent.basis.sensors == ()


def test_a_lag_that_is_known_is_corrected_within_its_tolerance() -> None:
    sensor = sensor_of(bandwidth_Hz=500.0, bandwidth_tolerance_percent=5.0, serial_number="7")
    found = (
        reading("torque_line_amplitude", 0.2, 0.01, frequency_Hz=250.0),
        reading("torque_ripple_pp", 0.4),
    )
    line, pp = applied(Bench(channels={"torque": sensor}), *found, blocks=[lines(f250=0.2)])
    size = math.hypot(1.0, 0.5)
    assert line.value == pytest.approx(0.2 * size)
    assert pp.value == pytest.approx(0.4 * size, rel=1e-3)
    # d(size) / size = x^2 / (1 + x^2) of the relative error of the bandwidth; scatter grows with the value
    by_bandwidth = 0.2 * size * 0.25 / 1.25 * 0.05 / ROOT_3
    assert uncertainty_of(line).standard == pytest.approx(math.hypot(by_bandwidth, 0.01 * size), rel=1e-3)
    assert uncertainty_of(pp).standard == pytest.approx(2.0 * by_bandwidth, rel=0.03)
    document = measurements_to_json([line])["torque_line_amplitude"]
    assert document["correction"]["added"] == pytest.approx(0.2 * (size - 1.0))
    assert document["correction"]["of"].startswith("bandwidth of 500 Hz of torque (no. 7); known")
    assert measurements_from_json({line.name: document}) == (line,)


@pytest.mark.parametrize(("bandwidth_Hz", "is_known"), [(150.0, True), (140.0, False), (2.5, False)])
@pytest.mark.parametrize("standard", [0.01, None])
def test_what_a_known_lag_takes_off_is_corrected_up_to_as_much_as_it_leaves(
    bandwidth_Hz: float, is_known: bool, standard: float | None
) -> None:
    """A line of 250 Hz is halved at 144 Hz; a hundred times beyond its bandwidth no sensor follows a lag."""
    sensor = sensor_of(bandwidth_Hz=bandwidth_Hz, bandwidth_tolerance_percent=10.0)
    read = (
        reading("torque_line_amplitude", 0.2, standard, frequency_Hz=250.0),
        reading("torque_ripple_pp", 0.4, standard),
    )
    found = applied(Bench(channels={"torque": sensor}), *read, blocks=[lines(f250=0.2)])
    for each, before in zip(found, read, strict=True):
        if is_known:
            assert each.value == pytest.approx(before.value * math.hypot(1.0, 250.0 / 150.0), rel=1e-3)
            assert (each.uncertainty is None) == (standard is None)
            continue
        assert (each.value, each.correction, each.uncertainty) == (before.value, None, None)
        (not_known,) = (line.name for line in each.of_sensors)
        assert not_known == f"bandwidth of {bandwidth_Hz:g} Hz of torque"
        assert each.uncertainty_reason == (
            "the sensor takes off more than it leaves, this is as read "
            f"(bandwidth of {bandwidth_Hz:g} Hz of torque): use a faster one"
        )


def test_a_bandwidth_counts_for_a_ripple_by_its_waveform() -> None:
    """250 Hz behind 500 Hz: the sensor has taken a share of 0.118 of what it shows off a peak and an rms."""
    bench = Bench(channels={"torque": sensor_of(bandwidth_Hz=500.0)})
    read = (
        *(reading("torque_ripple_pp", 0.4), reading("torque_ripple_percent_of_rated", 20.0, unit="%")),
        *(reading("torque_ripple_rms", 0.2 / math.sqrt(2.0)), reading("torque_mean", 0.0)),
    )
    *ripples, mean = applied(bench, *read, blocks=[lines(f250=0.2)])
    for each, before in zip(ripples, read, strict=False):
        _between(each, before.value, before.value * math.hypot(1.0, 0.5))
    assert (mean.value, mean.correction, uncertainty_of(mean).standard) == (0.0, None, 0.0)


def test_noise_of_the_converter_is_not_taken_for_lost() -> None:
    noise = 0.02 * np.random.default_rng(3).standard_normal(20_000)
    torque = 0.2 * np.cos(2.0 * math.pi * 250.0 * np.arange(20_000) / 20e3) + noise
    block = Block.from_arrays(20e3, {"torque": "Nm"}, torque=torque)
    bench = Bench(channels={"torque": sensor_of(bandwidth_Hz=500.0, bandwidth_tolerance_percent=0.0)})
    (found,) = applied(bench, reading("torque_ripple_rms", float(np.std(torque))), blocks=[block])
    assert found.value == pytest.approx(
        math.hypot(0.2 * math.hypot(1.0, 0.5) / math.sqrt(2.0), 0.02), rel=0.01
    )


def test_percentiles_were_apart_by_what_they_and_not_the_extremes_say() -> None:
    """Of 250 Hz behind 500 Hz, with clicks in a few samples that the converter adds."""
    shape = np.cos(2.0 * math.pi * 250.0 * np.arange(20_000) / 20e3)
    random, clicks = np.random.default_rng(4), np.zeros(len(shape))
    clicks[random.integers(0, len(shape), 40)] = random.choice([-0.5, 0.5], 40)
    read, before = 0.2 * shape + clicks, 0.2 * math.hypot(1.0, 0.5) * shape + clicks
    block = Block.from_arrays(20e3, {"torque": "Nm"}, torque=read)
    bench = Bench(channels={"torque": sensor_of(bandwidth_Hz=500.0, bandwidth_tolerance_percent=0.0)})
    values = percentile_range(read)
    own = Sensitivities.of_extremes("torque", values, LOW_PERCENT)
    number = replace(reading("torque_ripple_percentile_range", values), sensitivities=own)
    (found,) = applied(bench, number, blocks=[block])
    assert found.value == pytest.approx(percentile_range(before), rel=0.02)


@pytest.mark.parametrize("phases", [("i_a",), ("i_a", "i_b", "i_c")])
def test_lags_of_phases_turn_them_and_equal_ones_leave_no_unbalance(phases: tuple[str, ...]) -> None:
    """30 Hz behind 300 Hz turns a phase by 0.1 rad: of one phase a third of it is seen as unbalance."""
    sensor = sensor_of(bandwidth_Hz=300.0, bandwidth_tolerance_percent=0.0)
    angle = 2.0 * math.pi * 30.0 * np.arange(20_000) / 20e3
    turned, size = math.atan(0.1), 6.0 / math.hypot(1.0, 0.1)
    currents = {}
    for k, name in enumerate(("i_a", "i_b", "i_c")):
        of_phase = angle - 2.0 * k * math.pi / 3.0
        currents[name] = size * np.cos(of_phase - turned) if name in phases else 6.0 * np.cos(of_phase)
    block = Block.from_arrays(20e3, dict.fromkeys(currents, "A"), **currents)
    window = Window.of(block, EXAMPLE_MOTOR)
    analysis = next(each for each in catalogue().steady if each.title == "current unbalance")
    read = analysis.measure(window, analysis.settings()).measurements
    found = applied(
        Bench(channels=dict.fromkeys(phases, sensor)),
        *read,
        blocks=[block],
    )
    values = {each.name: each.value for each in found}
    assert values["current_sequence_positive"] == pytest.approx(6.0, rel=1e-5)
    assert values["current_unbalance_percent"] == pytest.approx(0.0, abs=1e-3)
    before = {each.name: each.value for each in read}["current_unbalance_percent"]
    assert before == pytest.approx(10.0 / 3.0 if len(phases) == 1 else 0.0, abs=0.1)


@pytest.mark.parametrize("tolerance_percent", [None, 10.0])
def test_what_is_not_known_of_three_lags_looks_like_unbalance(tolerance_percent: float | None) -> None:
    """Neither a guarantee nor a tolerance says that three sensors are alike."""
    lag = {} if tolerance_percent is None else {"bandwidth_tolerance_percent": tolerance_percent}
    sensor = sensor_of(bandwidth_Hz=3000.0, **lag)
    found = (
        reading("current_sequence_positive", 6.0, unit="A", frequency_Hz=30.0),
        reading("current_sequence_negative", 0.3, unit="A", frequency_Hz=30.0),
        reading("current_unbalance_percent", 5.0, unit="%", frequency_Hz=30.0),
        reading("current_unbalance_zero_percent", 0.1, unit="%", frequency_Hz=30.0),
    )
    bench = Bench(channels=dict.fromkeys(("i_a", "i_b", "i_c"), sensor))
    _, negative, percent, zero = applied(bench, *found)
    # a third of each phase: a lag turns it by 0.01 rad, a Butterworth response by sqrt(2) times that
    turned = (0.01 / math.sqrt(2.0) if tolerance_percent is None else 0.1 * 0.01) / ROOT_3
    assert uncertainty_of(percent).standard == pytest.approx(100.0 * turned / ROOT_3, rel=1e-2)
    assert uncertainty_of(negative).standard == pytest.approx(6.0 * turned / ROOT_3, rel=1e-2)
    # of a tenth of a percent the sensors may have made all
    assert (zero.uncertainty is None) == (tolerance_percent is None)
    if tolerance_percent is None:
        assert "state bandwidth_tolerance_percent" in zero.uncertainty_reason


@pytest.mark.parametrize("seed", range(3))
def test_an_unbalance_that_lags_made_has_the_uncertainty_of_what_they_turn(seed: int) -> None:
    """Three lags of 400 Hz within 10 % turn phases of 45 Hz, in balance, apart; scatter is in proportion."""
    random = np.random.default_rng(seed)
    angle, currents = 2.0 * math.pi * 45.0 * np.arange(10_000) / 20e3, {}
    for k, name in enumerate(("i_a", "i_b", "i_c")):
        lag = 45.0 / (400.0 * (1.0 + random.uniform(-0.1, 0.1)))
        phase = angle - 2.0 * k * math.pi / 3.0 - math.atan(lag)
        currents[name] = 5.0 / math.hypot(1.0, lag) * np.cos(phase) + 0.01 * random.standard_normal(10_000)
    block = Block.from_arrays(20e3, dict.fromkeys(currents, "A"), **currents)
    analysis = next(each for each in catalogue().steady if each.title == "current unbalance")
    read = analysis.measure(Window.of(block, EXAMPLE_MOTOR), analysis.settings()).measurements
    sensor = sensor_of(bandwidth_Hz=400.0, bandwidth_tolerance_percent=10.0)
    for each in applied(Bench(channels=dict.fromkeys(currents, sensor)), *read, blocks=[block]):
        if each.name in ("current_unbalance_percent", "current_unbalance_zero_percent"):
            u = uncertainty_of(each).standard
            assert u == pytest.approx(100.0 * 0.1 * 45.0 / 400.0 / ROOT_3 / ROOT_3, rel=0.1)
            assert 0.0 < each.value < 2.0 * u


def test_a_response_is_divided_out_of_a_frequency_response() -> None:
    """A lag of 100 Hz behind one of 200 Hz: both together have the bandwidth of 84 Hz."""
    random, count, rate_Hz = np.random.default_rng(5), 20_000, 10e3
    f_Hz = np.fft.rfftfreq(count, 1.0 / rate_Hz)
    bins = np.where((f_Hz > 0.0) & (f_Hz < 400.0), np.exp(2j * np.pi * random.random(len(f_Hz))), 0.0)
    x = np.tile(np.fft.irfft(bins), 2)
    y = np.tile(np.fft.irfft(bins / (1.0 + 1j * f_Hz / 100.0) / (1.0 + 1j * f_Hz / 200.0)), 2)
    y += 1e-2 * np.std(y) * random.standard_normal(len(y))
    block = Block.from_arrays(rate_Hz, {"x": "Nm", "y": "Nm"}, x=x, y=y)

    def measured(altered: Perturbed) -> tuple[Measurement, ...]:
        window = Window.of(altered.of(block), EXAMPLE_MOTOR, None, Excitation(0, len(x), count))
        return measure(FREQUENCY_RESPONSE, window, settings).measurements

    settings = FREQUENCY_RESPONSE.settings(input="x", output="y")
    read = {each.name: each for each in measured(Perturbed("y"))}["bandwidth_3dB"]
    sensor = sensor_of(bandwidth_Hz=200.0, bandwidth_tolerance_percent=1.0)
    instruments = Instruments(Bench(channels={"y": sensor}), [block])
    (found,) = instruments.applied([read], measured)
    assert read.value == pytest.approx(83.7, rel=0.01)
    assert found.value == pytest.approx(100.0, abs=2.0 * uncertainty_of(found).standard)
    # 1 % of the bandwidth moves what is corrected by as much, within limits
    assert 0.05 < uncertainty_of(found).standard < 0.5


def test_a_step_behind_a_slow_sensor_contains_its_lag_and_its_steps() -> None:
    """A lag of 100 Hz rises in 2.197 / (2 pi 100 Hz) = 3.50 ms, and reads longer behind one of 300 Hz."""
    time_s = (np.arange(4_000) - 400) / 20e3
    slow, fast = 2.0 * math.pi * 100.0, 2.0 * math.pi * 300.0
    later = np.maximum(time_s, 0.0)
    rise = 1.0 - (fast * np.exp(-slow * later) - slow * np.exp(-fast * later)) / (fast - slow)
    block = Block.from_arrays(20e3, {"torque": "Nm"}, torque=rise)

    def measured(altered: Perturbed) -> Iterator[Measurement]:
        torque = altered.of(block).column("torque")
        low, high = (np.interp(level, torque, time_s) for level in (0.1, 0.9))
        yield reading("rise_time", float(high - low), 0.0, "s", rests_on=("torque",))

    (read,) = measured(Perturbed("torque"))
    sensor = sensor_of(bandwidth_Hz=300.0, resolution_Nm=0.02)
    instruments = Instruments(Bench(channels={"torque": sensor}), [block])
    (found,) = instruments.applied([read], measured)
    by_steps, by_lag = sorted(uncertainty_of(found).budget[1:], key=lambda each: each.name, reverse=True)
    late_s = read.value - math.log(9.0) / slow
    assert late_s == pytest.approx(0.31e-3, rel=0.01)  # 3.81 ms of both in a row
    assert by_lag.name.startswith("bandwidth of 300 Hz of torque; a guarantee")
    assert found.correction is not None
    assert found.correction.added == pytest.approx(-0.5 * late_s, rel=0.25)
    assert by_lag.standard == pytest.approx(0.5 * late_s, rel=0.25)
    # 0.1 and 0.9 are crossed at 563 and 66 1/s: half a step of either moves them by some 0.1 ms
    assert 3e-5 < by_steps.standard < 3e-4


def test_a_lobe_that_a_sensor_hides_within_a_band_counts() -> None:
    """Of a mode at 50 Hz the second lobe leaves 2 % by a twentieth; behind a lag of 150 Hz it does not."""
    rate_Hz, damping, corner, lag = 20e3, 0.523, 2.0 * math.pi * 50.0, 2.0 * math.pi * 150.0
    time_s = np.arange(4_000) / rate_Hz
    plant = [1.0 / corner**2, 2.0 * damping / corner, 1.0]
    before, read = (
        np.concatenate([np.zeros(400), signal.step(([1.0], poles), T=time_s)[1]])
        for poles in (plant, np.polymul(plant, [1.0 / lag, 1.0]))
    )

    def measured(torque: np.ndarray) -> Measurement:
        step = np.where(np.arange(len(torque)) >= 400, 1.0, 0.0)
        units = {"torque": "Nm", "reference": "Nm"}
        found = analyze_step(
            Block.from_arrays(rate_Hz, units, torque=torque, reference=step), "torque", "reference"
        )
        settled = next(each for each in found.measurements if each.name == "settling_time")
        return replace(settled, sensitivities=replace(settled.sensitivities, rests_on=("torque",)))

    noise = 1e-4 * np.random.default_rng(3).standard_normal(len(read))
    block = Block.from_arrays(rate_Hz, {"torque": "Nm"}, torque=read + noise)

    def again(altered: Perturbed) -> Iterator[Measurement]:
        yield measured(altered.of(block).column("torque"))

    bench = Bench(channels={"torque": sensor_of(bandwidth_Hz=150.0, bandwidth_tolerance_percent=1.0)})
    true, as_read = measured(before + noise), measured(read + noise)
    assert as_read.value < 0.8 * true.value
    (found,) = Instruments(bench, [block]).applied([as_read], again)
    assert found.value == pytest.approx(true.value, abs=2.0 * uncertainty_of(found).standard)
    assert uncertainty_of(found).standard < 0.1 * true.value


def test_a_line_counts_at_its_frequency() -> None:
    bench = Bench(channels={"torque": sensor_of(bandwidth_Hz=300.0)})
    order, unknown = applied(
        bench, reading("torque_order_24", 0.1, frequency_Hz=300.0), reading("torque_order_24", 0.1)
    )
    _between(order, 0.1, 0.1 * math.sqrt(2.0))
    assert unknown.uncertainty is None
    assert "not known without" in unknown.uncertainty_reason


def test_a_row_of_a_table_is_the_measurement_of_that_line() -> None:
    sensor = sensor_of(gain_U_percent=1.0, resolution_Nm=0.001, bandwidth_Hz=300.0)
    bench = Bench(channels={"torque": sensor})
    measured = [reading("torque_order_24", 0.1, 0.002, frequency_Hz=300.0)]
    columns = (
        *(("order", ""), ("amplitude", "Nm"), ("percent_of_mean", "%")),
        *(("percent_of_largest", "%"), ("uncertainty", "Nm")),
    )
    rows = ((12.0, 0.2, 20.0, 100.0, 0.002), (24.0, 0.1, 10.0, 50.0, 0.002), (200.0, 0.1, 10.0, 50.0, 0.002))
    table = Table(
        "orders",
        "",
        columns,
        (*rows, (23.0, 0.01, 1.0, 5.0, math.nan)),
        Basis(frequency_Hz=12.5),
        lines=(LineColumn("amplitude", "uncertainty", "torque"),),
    )
    instruments = Instruments(bench, [lines(f150=0.2, f300=0.1)])
    (order,) = instruments.applied(measured)
    (found,) = instruments.applied_to([table])
    assert [name for name, _ in found.columns] == [*(name for name, _ in columns), "correction"]
    _, amplitude, of_mean, of_largest, standard, added = found.rows[1]
    assert order.correction is not None
    assert (amplitude, standard, added) == (
        order.value,
        uncertainty_of(order).standard,
        order.correction.added,
    )
    assert of_mean == pytest.approx(10.0 * amplitude / 0.1)
    assert of_largest == pytest.approx(100.0 * amplitude / found.rows[0][1])
    assert found.rows[2][1] == 0.1
    assert math.isnan(found.rows[2][4])
    assert "order 200: the sensor may have changed it by as much" in found.uncertainty_reason
    assert "order 23: the noise around the line is not known" in found.uncertainty_reason
    (again,) = tables_from_json(tables_to_json([found]))
    assert (again.uncertainty_reason, again.rows[1]) == (found.uncertainty_reason, found.rows[1])
    (groups,) = instruments.applied_to([Table("groups", "", (("order", ""),), ((1.0,),))])
    assert groups.uncertainty_reason == AS_READ


def test_rows_without_an_uncertainty_are_counted_once() -> None:
    """A row that lacks that of its frequency and of its amplitude was row "1, 1"."""
    columns = (("f", "Hz"), ("u_f", "Hz"), ("amplitude", "Nm"), ("uncertainty", "Nm"))
    lines = (
        LineColumn("f", "u_f", "torque", is_amplitude=False),
        LineColumn("amplitude", "uncertainty", "torque"),
    )
    rows = tuple((10.0 * n, math.nan, 0.1, math.nan if n < 8 else 0.01) for n in range(1, 10))
    table = Table(
        "lines", "", columns, (*rows[:7], (80.0, 0.1, 0.1, 0.01), (90.0, 0.1, 0.1, 0.01)), lines=lines
    )
    found = with_sensors(table, lambda each: each)
    assert found.uncertainty_reason == "rows 1, 2, 3, 4, 5 and 2 more: the noise around the line is not known"
    found = with_sensors(replace(table, rows=table.rows[6:]), lambda each: each)
    assert found.uncertainty_reason == "row 1: the noise around the line is not known"
