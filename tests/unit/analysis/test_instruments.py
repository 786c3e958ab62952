"""Sensors and clock in the uncertainty of measurements."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis import (
    Measurement,
    Table,
    Uncertainty,
    measurements_from_json,
    measurements_to_json,
    tables_from_json,
    tables_to_json,
)
from benchtool.analysis.catalogue import catalogue
from benchtool.analysis.instruments import UNSTATED, Instruments, Perturbed
from benchtool.analysis.measurement import Basis
from benchtool.analysis.sensor_tables import AS_READ
from benchtool.analysis.uncertainty import Contribution, InstrumentError, of_difference
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.profile import Bench, Sensor
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR, steady_capture

ROOT_3 = math.sqrt(3.0)


def _sensor(**stated: object) -> Sensor:
    return Sensor.model_validate(stated)


def _of(name: str, value: float, standard: float | None = 0.0, unit: str = "Nm") -> Measurement:
    uncertain = None if standard is None else Uncertainty(standard, "scatter", 10.0)
    return Measurement(name, value, unit, "", uncertainty=uncertain)


def _applied(bench: Bench, *measurements: Measurement, blocks: Sequence[Block] = ()) -> list[Measurement]:
    return list(Instruments(bench, blocks, pole_pairs=4).applied(measurements))


def _uncertainty(measurement: Measurement) -> Uncertainty:
    assert measurement.uncertainty is not None
    return measurement.uncertainty


def test_the_headline_contains_gain_and_offset_and_the_budget_names_sensor_and_certificate() -> None:
    sensor = _sensor(
        sensor="T40B", serial_number="7", certificate="D-K 1", gain_U_percent=0.5, offset_limit_Nm=0.02
    )
    (mean,) = _applied(Bench(channels={"torque": sensor}), _of("torque_mean", -4.0, 0.003))
    gain, offset = 4.0 * 0.0025, 0.02 / ROOT_3
    u = _uncertainty(mean)
    assert u.standard == pytest.approx(math.hypot(0.003, gain, offset))
    assert u.expanded > 1.9 * math.hypot(gain, offset)
    assert u.dof == pytest.approx(u.standard**4 / (0.003**4 / 10.0))
    scatter, of_gain, of_offset = u.budget
    assert (scatter.name, scatter.evaluation, scatter.standard, scatter.dof) == ("scatter", "A", 0.003, 10.0)
    assert of_gain.name == "gain of torque (T40B, no. 7, certificate D-K 1); U = 0.5 %, k = 2"
    assert (of_gain.evaluation, of_gain.sign) == ("B", -1)
    assert of_gain.standard == pytest.approx(gain)
    assert of_offset.name.endswith("limits of 0.02 Nm, rectangular")
    assert of_offset.standard == pytest.approx(offset)
    assert mean.basis.sensors == ""


def test_a_half_width_grows_as_a_standard_uncertainty_does() -> None:
    ripple = Measurement("torque_ripple_pp", 1.0, "Nm", "", uncertainty=Uncertainty(0.1, "x", half_width=0.3))
    (found,) = _applied(Bench(channels={"torque": _sensor(gain_U_percent=20.0)}), ripple)
    assert _uncertainty(found).expanded == pytest.approx(math.hypot(0.3, 1.959964 * 0.1))


def test_without_a_bench_nothing_changes_but_what_is_said() -> None:
    before = [
        _of("torque_mean", 1.0, 0.1),
        _of("current_thd_f", 2.0, 0.1, "%"),
        _of("torque_error", 0.1, 0.1),
    ]
    after = _applied(Bench(), *before)
    assert [each.basis.sensors for each in after] == [UNSTATED] * 3
    assert [replace(each, basis=Basis()) for each in after] == before
    stated = Bench(channels={"torque": _sensor(gain_U_percent=1.0)})
    (error,) = _applied(stated, _of("torque_error", 0.1, 0.1))[:1]
    assert error.basis.sensors == "the uncertainty of torque_transducer is not stated"


def test_an_uncertainty_that_is_not_known_stays_so() -> None:
    bench = Bench(channels={"torque": _sensor(gain_U_percent=1.0)})
    (unknown, undefined) = _applied(
        bench, _of("torque_mean", 1.0, None), Measurement.undefined("torque_ripple_pp", "Nm", "", "none")
    )
    assert unknown.uncertainty is None
    assert unknown.basis.sensors == (
        "the data give no uncertainty, that of the sensors alone is u = 0.005 Nm"
    )
    assert undefined.uncertainty is None


def _standing(step: float) -> Block:
    """Two values, a step apart, of which the second is there once in 20 000 rows."""
    torque = np.full(20_000, 0.3)
    torque[7] += step
    return Block.from_arrays(1e3, {"torque": "Nm"}, torque=torque)


@pytest.mark.parametrize(
    ("stated", "in_data", "rest"),
    [(0.05, 0.03, 0.04), (0.05, 0.05, 0.0), (0.03, 0.05, 0.0)],
)
def test_a_resolution_counts_once(stated: float, in_data: float, rest: float) -> None:
    """The analyses count the steps that they find; of the stated one the rest is left, in squares."""
    bench = Bench(channels={"torque": _sensor(resolution_Nm=stated)})
    (mean,) = _applied(bench, _of("torque_mean", 0.3), blocks=[_standing(in_data)])
    assert _uncertainty(mean).standard == pytest.approx(rest / math.sqrt(12.0), rel=0.02, abs=1e-8)


def test_a_resolution_averages_out_where_the_signal_spans_its_steps() -> None:
    """1 Nm in steps of 50 mNm: of a mean, an rms and a line of many samples next to nothing is left."""
    turned = 2.0 * math.pi * 5.0 * np.arange(10_000) / 1e3
    random = np.random.default_rng(2).normal(size=len(turned))
    bench = Bench(channels={"torque": _sensor(resolution_Nm=0.05)})
    small = (
        _of("torque_mean", 0.3),
        _of("torque_ripple_rms", math.sqrt(0.5)),
        _of("torque_line_amplitude", 1.0),
    )
    line = _of("torque_line_frequency", 5.0, unit="Hz")
    read = Block.from_arrays(1e3, {"torque": "Nm"}, torque=0.3 + np.cos(turned) + 0.03 * random)
    for each in _applied(bench, *small, line, blocks=[read])[:3]:
        assert 0.0 < _uncertainty(each).standard < 0.1 * 0.05 / math.sqrt(12.0), each.name
        assert _uncertainty(each).budget[-1].name == "resolution of 0.05 Nm of torque"
    # the extremes are two readings: step / sqrt(6)
    (pp,) = _applied(bench, _of("torque_ripple_pp", 2.0), blocks=[read])
    assert _uncertainty(pp).standard == pytest.approx(0.05 / math.sqrt(6.0))


def test_a_resolution_is_in_currents_and_their_harmonics() -> None:
    bench = Bench(channels={"i_a": _sensor(resolution_A=0.5)})
    turned = 2.0 * math.pi * 50.0 * np.arange(4_000) / 4e3
    block = Block.from_arrays(4e3, {"i_a": "A"}, i_a=np.cos(turned) + 0.1 * np.cos(5.0 * turned))
    frequency = _of("fundamental_frequency", 50.0, unit="Hz")
    thd = replace(_of("current_thd_f", 10.0, unit="%"), basis=Basis(harmonics=20))
    amplitude, thd, frequency = _applied(
        bench, _of("current_fundamental", 1.0, unit="A"), thd, frequency, blocks=[block]
    )
    # two steps to either side: some percent, as of a three-level sine
    assert 0.005 < _uncertainty(amplitude).standard < 0.1
    assert 1.0 < _uncertainty(thd).standard < 20.0
    assert len(_uncertainty(frequency).lines) == 1


def _lines(**amplitudes: float) -> Block:
    """A second of lines of i_a or torque, by their frequency: `f250=0.1`."""
    time_s = np.arange(20_000) / 20e3
    parts = (a * np.cos(2.0 * math.pi * float(f[1:]) * time_s) for f, a in amplitudes.items())
    values = np.sum(list(parts), axis=0)
    return Block.from_arrays(20e3, {"i_a": "A", "torque": "Nm"}, i_a=values, torque=values)


def _between(found: Measurement, read: float, before: float) -> None:
    """A guarantee: the middle of what was read and what it may have been, half of the interval as u."""
    assert found.value == pytest.approx(0.5 * (read + before), rel=1e-3)
    assert _uncertainty(found).standard == pytest.approx(0.5 * (before - read), rel=2e-2)
    assert found.correction is not None
    assert found.as_read == pytest.approx(read, rel=1e-9)


def test_a_bandwidth_counts_for_each_harmonic_at_its_frequency() -> None:
    """A fifth of 250 Hz behind 500 Hz: 1.118, over the 1.005 of the fundamental."""
    bench = Bench(channels={"i_a": _sensor(bandwidth_Hz=500.0)})
    found = (
        _of("current_fundamental", 2.0, unit="A"),
        replace(_of("current_thd_f", 10.0, unit="%"), basis=Basis(harmonics=9)),
        replace(_of("current_tdd", 10.0, unit="%"), basis=Basis(harmonics=50)),
        replace(_of("current_max_low_harmonic", 0.2, unit="A"), basis=Basis(bandwidth_Hz=1000.0)),
        _of("current_noise_floor", 1e-3, unit="A"),
        _of("fundamental_frequency", 50.0, unit="Hz"),
    )
    line, thd, tdd, low, floor, _ = _applied(bench, *found, blocks=[_lines(f50=2.0, f250=0.2)])
    _between(line, 2.0, 2.0 * math.hypot(1.0, 0.1))
    _between(thd, 10.0, 10.0 * math.hypot(1.0, 0.5) / math.hypot(1.0, 0.1))
    _between(tdd, 10.0, 10.0 * math.hypot(1.0, 0.5))
    _between(low, 0.2, 0.2 * math.hypot(1.0, 0.5))
    assert (floor.value, floor.correction) == (1e-3, None)
    assert "noise is that of the reading" in floor.basis.sensors
    (blind, _) = _applied(bench, found[1], found[-1])
    _between(blind, 10.0, 10.0 * math.hypot(1.0, 0.9))  # the ninth is the highest
    (unknown,) = _applied(bench, found[1])
    assert unknown.uncertainty is None
    assert "not known without a record of even samples" in unknown.uncertainty_reason


def test_beyond_its_bandwidth_a_sensor_may_have_two_poles() -> None:
    bench = Bench(channels={"i_a": _sensor(bandwidth_Hz=50.0)})
    found = _of("current_fundamental", 2.0, unit="A"), _of("fundamental_frequency", 60.0, unit="Hz")
    line, _ = _applied(bench, *found)
    _between(line, 2.0, 2.0 * math.hypot(1.0, 1.2**2))
    lost, _ = _applied(bench, found[0], replace(found[1], value=200.0))
    assert (lost.value, lost.uncertainty, lost.correction) == (2.0, None, None)
    assert "may have taken off as much as is left" in lost.uncertainty_reason


def test_a_lag_that_is_known_is_corrected_within_its_tolerance() -> None:
    sensor = _sensor(bandwidth_Hz=500.0, bandwidth_tolerance_percent=5.0, serial_number="7")
    found = (
        _of("torque_line_amplitude", 0.2, 0.01),
        _of("torque_ripple_pp", 0.4),
        _of("torque_line_frequency", 250.0, unit="Hz"),
    )
    line, pp, _ = _applied(Bench(channels={"torque": sensor}), *found, blocks=[_lines(f250=0.2)])
    size = math.hypot(1.0, 0.5)
    assert line.value == pytest.approx(0.2 * size)
    assert pp.value == pytest.approx(0.4 * size, rel=1e-3)
    # d(size) / size = x^2 / (1 + x^2) of the relative error of the bandwidth; scatter grows with the value
    by_bandwidth = 0.2 * size * 0.25 / 1.25 * 0.05 / ROOT_3
    assert _uncertainty(line).standard == pytest.approx(math.hypot(by_bandwidth, 0.01 * size), rel=1e-3)
    assert _uncertainty(pp).standard == pytest.approx(2.0 * by_bandwidth, rel=0.03)
    document = measurements_to_json([line])["torque_line_amplitude"]
    assert document["correction"]["added"] == pytest.approx(0.2 * (size - 1.0))
    assert document["correction"]["of"].startswith("bandwidth of 500 Hz of torque (no. 7) at 250 Hz; known")
    assert measurements_from_json({line.name: document}) == (line,)


def test_a_bandwidth_counts_for_a_ripple_by_its_waveform() -> None:
    """250 Hz behind 500 Hz: the sensor has taken a share of 0.118 of what it shows off a peak and an rms."""
    bench = Bench(channels={"torque": _sensor(bandwidth_Hz=500.0)})
    read = (
        *(_of("torque_ripple_pp", 0.4), _of("torque_ripple_percent_of_rated", 20.0, unit="%")),
        *(_of("torque_ripple_rms", 0.2 / math.sqrt(2.0)), _of("torque_mean", 0.0)),
    )
    *ripples, mean = _applied(bench, *read, blocks=[_lines(f250=0.2)])
    for each, before in zip(ripples, read, strict=False):
        _between(each, before.value, before.value * math.hypot(1.0, 0.5))
    assert (mean.value, mean.correction, _uncertainty(mean).standard) == (0.0, None, 0.0)


def test_noise_of_the_converter_is_not_taken_for_lost() -> None:
    noise = 0.02 * np.random.default_rng(3).standard_normal(20_000)
    torque = 0.2 * np.cos(2.0 * math.pi * 250.0 * np.arange(20_000) / 20e3) + noise
    block = Block.from_arrays(20e3, {"torque": "Nm"}, torque=torque)
    bench = Bench(channels={"torque": _sensor(bandwidth_Hz=500.0, bandwidth_tolerance_percent=0.0)})
    (found,) = _applied(bench, _of("torque_ripple_rms", float(np.std(torque))), blocks=[block])
    assert found.value == pytest.approx(
        math.hypot(0.2 * math.hypot(1.0, 0.5) / math.sqrt(2.0), 0.02), rel=0.01
    )


@pytest.mark.parametrize("phases", [("i_a",), ("i_a", "i_b", "i_c")])
def test_lags_of_phases_turn_them_and_equal_ones_leave_no_unbalance(phases: tuple[str, ...]) -> None:
    """30 Hz behind 300 Hz turns a phase by 0.1 rad: of one phase a third of it is seen as unbalance."""
    sensor = _sensor(bandwidth_Hz=300.0, bandwidth_tolerance_percent=0.0)
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
    found = _applied(
        Bench(channels=dict.fromkeys(phases, sensor)),
        *read,
        _of("fundamental_frequency", 30.0, unit="Hz"),
        blocks=[block],
    )
    values = {each.name: each.value for each in found}
    assert values["current_sequence_positive"] == pytest.approx(6.0, rel=1e-5)
    assert values["current_unbalance_percent"] == pytest.approx(0.0, abs=1e-3)
    before = {each.name: each.value for each in read}["current_unbalance_percent"]
    assert before == pytest.approx(10.0 / 3.0 if len(phases) == 1 else 0.0, abs=0.1)


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
        yield _of("rise_time", float(high - low), 0.0, "s")

    (read,) = measured(Perturbed("torque"))
    sensor = _sensor(bandwidth_Hz=300.0, resolution_Nm=0.02)
    instruments = Instruments(Bench(channels={"torque": sensor}), [block], rests_on=lambda _: ("torque",))
    (found,) = instruments.applied([read], measured)
    by_steps, by_lag = sorted(_uncertainty(found).budget[1:], key=lambda each: each.name, reverse=True)
    late_s = read.value - math.log(9.0) / slow
    assert late_s == pytest.approx(0.31e-3, rel=0.01)  # 3.81 ms of both in a row
    assert by_lag.name.startswith("bandwidth of 300 Hz of torque; a guarantee")
    assert found.correction is not None
    assert found.correction.added == pytest.approx(-0.5 * late_s, rel=0.25)
    assert by_lag.standard == pytest.approx(0.5 * late_s, rel=0.25)
    # 0.1 and 0.9 are crossed at 563 and 66 1/s: half a step of either moves them by some 0.1 ms
    assert 3e-5 < by_steps.standard < 3e-4


def test_an_order_counts_revolutions_by_the_pole_pairs() -> None:
    bench = Bench(channels={"torque": _sensor(bandwidth_Hz=300.0)})
    order, _ = _applied(bench, _of("torque_order_24", 0.1), _of("fundamental_frequency", 50.0, unit="Hz"))
    _between(order, 0.1, 0.1 * math.sqrt(2.0))
    assert " at 300 Hz; " in _uncertainty(order).budget[-1].name


def test_a_row_of_a_table_is_the_measurement_of_that_line() -> None:
    sensor = _sensor(gain_U_percent=1.0, resolution_Nm=0.001, bandwidth_Hz=300.0)
    bench = Bench(channels={"torque": sensor})
    measured = (_of("torque_order_24", 0.1, 0.002), _of("fundamental_frequency", 50.0, unit="Hz"))
    columns = (
        *(("order", ""), ("amplitude", "Nm"), ("percent_of_mean", "%")),
        *(("percent_of_largest", "%"), ("uncertainty", "Nm")),
    )
    rows = ((12.0, 0.2, 20.0, 100.0, 0.002), (24.0, 0.1, 10.0, 50.0, 0.002), (200.0, 0.1, 10.0, 50.0, 0.002))
    table = Table("torque_orders", "", columns, (*rows, (23.0, 0.01, 1.0, 5.0, math.nan)))
    instruments = Instruments(bench, [_lines(f150=0.2, f300=0.1)], pole_pairs=4)
    order, _ = instruments.applied(measured)
    (found,) = instruments.applied_to([table], measured)
    assert [name for name, _ in found.columns] == [*(name for name, _ in columns), "correction"]
    _, amplitude, of_mean, of_largest, standard, added = found.rows[1]
    assert order.correction is not None
    assert (amplitude, standard, added) == (order.value, _uncertainty(order).standard, order.correction.added)
    assert of_mean == pytest.approx(10.0 * amplitude / 0.1)
    assert of_largest == pytest.approx(100.0 * amplitude / found.rows[0][1])
    assert found.rows[2][1] == 0.1
    assert math.isnan(found.rows[2][4])
    assert "order 200: the sensor may have taken off as much" in found.uncertainty_reason
    assert "order 23: the noise around the line is not known" in found.uncertainty_reason
    (again,) = tables_from_json(tables_to_json([found]))
    assert (again.uncertainty_reason, again.rows[1]) == (found.uncertainty_reason, found.rows[1])
    (groups,) = instruments.applied_to([Table("current_groups", "", (("order", ""),), ((1.0,),))], measured)
    assert groups.uncertainty_reason == AS_READ


# --- measured again -------------------------------------------------------------------------------------


def _rests_on(name: str) -> tuple[str, ...]:
    found = catalogue().measuring(name)
    return () if found is None else (*found.channels, *(("torque_transducer",) if found.transducer else ()))


def _measure(block: Block, transducer: Block, titles: Sequence[str]) -> Iterator[Measurement]:
    window = Window.of(block, EXAMPLE_MOTOR, transducer)
    for analysis in catalogue().steady:
        if analysis.title in titles:
            yield from analysis.measure(window, analysis.settings()).measurements


def _with_sensors(bench: Bench, block: Block, transducer: Block, titles: Sequence[str]) -> list[Measurement]:
    instruments = Instruments(bench, (block, transducer), rests_on=_rests_on, pole_pairs=4)

    def again(altered: Perturbed) -> Iterator[Measurement]:
        return _measure(altered.of(block), altered.of(transducer), titles)

    return list(instruments.applied(tuple(_measure(block, transducer, titles)), again))


def test_unequal_gains_look_like_unbalance_even_where_there_is_none() -> None:
    """A magnitude near zero moves the same way for both signs of an error: their difference would be 0."""
    sensors = {name: _sensor(gain_limit_percent=1.0) for name in ("i_a", "i_b", "i_c")}
    found = _with_sensors(Bench(channels=sensors), *steady_capture(), ["current unbalance"])
    unbalance = next(each for each in found if each.name == "current_unbalance_percent")
    assert unbalance.value < 0.01
    # each phase adds a third of its relative error
    assert _uncertainty(unbalance).standard == pytest.approx(1.0 / ROOT_3 / 3.0 * ROOT_3, rel=0.1)


def test_a_residual_that_is_a_difference_knows_the_gain_of_what_it_is_made_from() -> None:
    sensors = {"torque_transducer": _sensor(gain_U_percent=1.0, offset_limit_Nm=0.1)}
    found = _with_sensors(Bench(channels=sensors), *steady_capture(), ["torque residual on the shaft"])
    mean = next(each for each in found if each.name == "transducer_torque_residual_mean")
    lines = {line.instrument.effect: line for line in _uncertainty(mean).budget if line.instrument}
    assert lines["gain"].standard == pytest.approx(0.005, rel=1e-3)  # mean torque of 1 Nm
    assert lines["offset"].standard == pytest.approx(0.1 / ROOT_3, rel=1e-3)
    assert lines["gain"].sign == -1


def test_what_cannot_be_measured_again_has_no_known_uncertainty() -> None:
    sensors = {"i_a": _sensor(gain_U_percent=1.0)}
    instruments = Instruments(Bench(channels=sensors), rests_on=lambda _: ("i_a",))
    (found,) = instruments.applied([_of("something_else", 1.0, 0.1)], lambda _: ())
    assert found.uncertainty is None


# --- Monte Carlo ----------------------------------------------------------------------------------------


def _drawn(sensor: Sensor, channel: str, random: np.random.Generator) -> Perturbed:
    """Errors of a sensor as they are stated: normal for a certificate, uniform within limits."""

    def one(expanded: float | None, limit: float | None) -> float:
        if expanded is not None:
            return float(random.normal(0.0, expanded / sensor.k))
        return float(random.uniform(-1.0, 1.0)) * (limit or 0.0)

    gain = 0.01 * one(sensor.gain_U_percent, sensor.gain_limit_percent)
    return Perturbed(channel, gain, one(sensor.offset_U, sensor.offset_limit))


def covered(
    sensors: dict[str, Sensor], titles: Sequence[str], repetitions: int, seed: int = 4
) -> dict[str, float]:
    """Share of repetitions in which value +- U holds what sensors without errors read."""
    random = np.random.default_rng(seed)
    block, transducer = steady_capture()
    rows = 1500
    block = replace(block, data=block.data[:rows])
    transducer = replace(transducer, data=transducer.data[: 2 * rows])
    truth = {each.name: each.value for each in _measure(block, transducer, titles)}
    inside: dict[str, list[bool]] = {}
    for _ in range(repetitions):
        read, shaft = block, transducer
        for channel, sensor in sensors.items():
            error = _drawn(sensor, channel, random)
            read, shaft = error.of(read), error.of(shaft)
        for each in _with_sensors(Bench(channels=sensors), read, shaft, titles):
            if each.uncertainty is not None and each.name in truth:
                held = abs(each.value - truth[each.name]) <= each.uncertainty.expanded
                inside.setdefault(each.name, []).append(held)
    return {name: sum(each) / len(each) for name, each in inside.items()}


@pytest.mark.slow
def test_the_interval_covers_what_sensors_with_such_errors_read() -> None:
    sensors = {
        "i_a": _sensor(gain_limit_percent=2.0, offset_limit_A=0.05),
        "torque": _sensor(gain_U_percent=3.0, offset_U_Nm=0.04),
        "torque_transducer": _sensor(gain_U_percent=2.0, offset_U_Nm=0.03),
    }
    titles = [
        "torque ripple",
        "torque ripple on the shaft",
        "error of the torque estimate",
        "current spectrum",
    ]
    share = covered(sensors, titles, 80, seed=7)
    means = "torque_mean", "transducer_torque_mean", "torque_error"
    for name in (*means, "torque_ripple_rms", "current_fundamental"):
        assert share[name] >= 0.88, name
    assert min(share[name] for name in means) < 1.0  # they are not simply wide


def test_the_interval_of_an_unbalance_covers_that_of_unequal_gains() -> None:
    sensors = {name: _sensor(gain_limit_percent=2.0) for name in ("i_a", "i_b", "i_c")}
    share = covered(sensors, ["current unbalance"], 50, seed=7)
    assert share["current_sequence_positive"] >= 0.88
    assert share["current_unbalance_percent"] >= 0.88


# --- in common ------------------------------------------------------------------------------------------


def _result(value: float, scatter: float, serial_number: str, certificate: str = "C1") -> Uncertainty:
    sensor = _sensor(
        serial_number=serial_number, certificate=certificate, gain_U_percent=1.0, offset_U_Nm=0.1
    )
    (mean,) = _applied(Bench(channels={"torque": sensor}), _of("torque_mean", value, scatter))
    return _uncertainty(mean)


def test_errors_in_common_leave_what_they_move_one_result_more() -> None:
    one, two = _result(10.0, 0.01, "7"), _result(9.0, 0.02, "7")
    difference = of_difference(one, two)
    assert difference.standard == pytest.approx(math.hypot(0.01, 0.02, 0.005 * (10.0 - 9.0)))
    against = of_difference(one, _result(-10.0, 0.02, "7"))  # a gain moves both apart
    assert against.standard == pytest.approx(math.hypot(0.01, 0.02, 0.005 * 20.0))
    same = of_difference(one, one)
    assert same.standard == pytest.approx(math.hypot(0.01, 0.01))
    assert same.dof == pytest.approx(20.0)


@pytest.mark.parametrize(("serial_number", "certificate"), [("8", "C1"), ("7", "C2")])
def test_another_instrument_or_calibration_counts_in_full(serial_number: str, certificate: str) -> None:
    one, two = _result(10.0, 0.01, "7"), _result(10.0, 0.01, serial_number, certificate)
    assert of_difference(one, two).standard == pytest.approx(math.hypot(one.standard, two.standard))


def test_without_a_number_or_certificate_nothing_is_taken_for_common() -> None:
    one = _result(10.0, 0.01, "", "")
    assert of_difference(one, one).standard == pytest.approx(math.sqrt(2.0) * one.standard)
    certified = _result(10.0, 0.01, "", "C1")
    assert of_difference(certified, certified).standard == pytest.approx(math.sqrt(2.0) * 0.01)


def test_the_budget_comes_back_from_json() -> None:
    sensor = _sensor(sensor="x", serial_number="7", gain_U_percent=1.0)
    (mean,) = _applied(Bench(channels={"torque": sensor}), _of("torque_mean", -3.0, 0.1))
    (again,) = measurements_from_json(measurements_to_json([mean]))
    assert again == mean
    (line,) = [each for each in _uncertainty(again).budget if each.instrument is not None]
    assert line.instrument == InstrumentError("gain", "torque", "x", "7", "")
    assert line.scaled(-2.0) == replace(line, standard=2.0 * line.standard, sign=1)
    assert Contribution("x", "A", 1.0).scaled(-1.0).sign == -1
