"""Sensors and clock in the uncertainty of measurements."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis import (
    Measurement,
    Uncertainty,
    measurements_from_json,
    measurements_to_json,
)
from benchtool.analysis.catalogue import catalogue, measure
from benchtool.analysis.measurement import Basis
from benchtool.analysis.sensitivity import NO_SENSORS
from benchtool.analysis.sensors.instruments import UNSTATED, Instruments, Perturbed
from benchtool.analysis.uncertainty import Contribution, InstrumentError, combined, of_difference
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.profile import Bench, ReferenceClock, Sensor
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR, steady_capture
from tests.unit.analysis.stated_sensors import applied, reading, sensor_of, uncertainty_of

ROOT_3 = math.sqrt(3.0)


def test_the_headline_contains_gain_and_offset_and_the_budget_names_sensor_and_certificate() -> None:
    sensor = sensor_of(
        sensor="T40B", serial_number="7", certificate="D-K 1", gain_U_percent=0.5, offset_limit_Nm=0.02
    )
    (mean,) = applied(Bench(channels={"torque": sensor}), reading("torque_mean", -4.0, 0.003))
    gain, offset = 4.0 * 0.0025, 0.02 / ROOT_3
    u = uncertainty_of(mean)
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
    assert mean.basis.sensors == ()


def test_a_half_width_grows_as_a_standard_uncertainty_does() -> None:
    plain = reading("torque_ripple_pp", 1.0)
    ripple = replace(plain, uncertainty=Uncertainty(0.1, "x", half_width=0.3))
    (found,) = applied(Bench(channels={"torque": sensor_of(gain_U_percent=20.0)}), ripple)
    assert uncertainty_of(found).expanded == pytest.approx(math.hypot(0.3, 1.959964 * 0.1))


def test_without_a_bench_nothing_changes_but_what_is_said() -> None:
    before = [
        reading("torque_mean", 1.0, 0.1),
        reading("current_thd_f", 2.0, 0.1, "%"),
        reading("torque_error", 0.1, 0.1),
    ]
    after = applied(Bench(), *before)
    assert [each.basis.sensors for each in after] == [(UNSTATED,)] * 3
    assert [replace(each, basis=Basis()) for each in after] == before
    stated = Bench(channels={"torque": sensor_of(gain_U_percent=1.0)})
    (error,) = applied(stated, reading("torque_error", 0.1, 0.1))[:1]
    assert error.basis.sensors == ("the uncertainty of torque_transducer is not stated",)


@pytest.mark.parametrize(("unit", "told"), [("Hz", True), ("s", True), ("Nm", False)])
def test_a_time_or_frequency_says_that_the_clock_is_not_stated(unit: str, told: bool) -> None:
    plain = replace(reading("fundamental_frequency", 50.0, 0.1, unit), sensitivities=NO_SENSORS)
    (bare,) = applied(Bench(), plain)
    assert bare.basis.sensors == (("the tolerance of the drive's clock is not stated",) if told else ())
    (stated,) = applied(Bench(clock=ReferenceClock(tolerance_ppm=50.0)), plain)
    assert stated.basis.sensors == ()


def test_an_uncertainty_that_is_not_known_stays_so() -> None:
    bench = Bench(channels={"torque": sensor_of(gain_U_percent=1.0)})
    (unknown, undefined) = applied(
        bench, reading("torque_mean", 1.0, None), Measurement.undefined("torque_ripple_pp", "Nm", "", "none")
    )
    assert unknown.uncertainty is None
    assert unknown.basis.sensors == (
        "the data give no uncertainty, that of the sensors alone is u = 0.005 Nm",
    )
    assert undefined.uncertainty is None


def _standing(step: float) -> Block:
    """Two values, a step apart, of which the second is there once in 20 000 rows."""
    torque = np.full(20_000, 0.3)
    torque[7] += step
    return Block.from_arrays(1e3, {"torque": "Nm"}, torque=torque)


@pytest.mark.parametrize(
    ("stated", "in_data", "rest"),
    [(0.05, 0.03, 0.04), (0.05, 0.05, 0.0), (0.03, 0.05, 0.0), (0.05 * (1.0 + 1e-9), 0.05, 0.0)],
)
def test_a_resolution_counts_once(stated: float, in_data: float, rest: float) -> None:
    """The analyses count the steps that they find; of the stated one the rest is left, in squares."""
    bench = Bench(channels={"torque": sensor_of(resolution_Nm=stated)})
    (mean,) = applied(bench, reading("torque_mean", 0.3), blocks=[_standing(in_data)])
    assert uncertainty_of(mean).standard == pytest.approx(rest / math.sqrt(12.0), rel=0.02, abs=1e-8)
    assert any("beyond that" in line.name for line in uncertainty_of(mean).budget) == (rest > 0.0)


def test_a_resolution_averages_out_where_the_signal_spans_its_steps() -> None:
    """1 Nm in steps of 50 mNm: of a mean, an rms and a line of many samples next to nothing is left."""
    turned = 2.0 * math.pi * 5.0 * np.arange(10_000) / 1e3
    random = np.random.default_rng(2).normal(size=len(turned))
    bench = Bench(channels={"torque": sensor_of(resolution_Nm=0.05)})
    small = (
        reading("torque_mean", 0.3),
        reading("torque_ripple_rms", math.sqrt(0.5)),
        reading("torque_line_amplitude", 1.0, frequency_Hz=5.0),
    )
    read = Block.from_arrays(1e3, {"torque": "Nm"}, torque=0.3 + np.cos(turned) + 0.03 * random)
    for each in applied(bench, *small, blocks=[read]):
        assert 0.0 < uncertainty_of(each).standard < 0.1 * 0.05 / math.sqrt(12.0), each.name
        assert uncertainty_of(each).budget[-1].name == "resolution of 0.05 Nm of torque"
    # the extremes are two readings: step / sqrt(6)
    (pp,) = applied(bench, reading("torque_ripple_pp", 2.0), blocks=[read])
    assert uncertainty_of(pp).standard == pytest.approx(0.05 / math.sqrt(6.0))


def test_a_resolution_is_in_currents_and_their_harmonics() -> None:
    bench = Bench(channels={"i_a": sensor_of(resolution_A=0.5)})
    turned = 2.0 * math.pi * 50.0 * np.arange(4_000) / 4e3
    block = Block.from_arrays(4e3, {"i_a": "A"}, i_a=np.cos(turned) + 0.1 * np.cos(5.0 * turned))
    frequency = reading("fundamental_frequency", 50.0, unit="Hz")
    thd = replace(reading("current_thd_f", 10.0, unit="%"), basis=Basis(harmonics=20))
    amplitude, thd, frequency = applied(
        bench,
        reading("current_fundamental", 1.0, unit="A", frequency_Hz=50.0),
        thd,
        frequency,
        blocks=[block],
    )
    # two steps to either side: some percent, as of a three-level sine
    assert 0.005 < uncertainty_of(amplitude).standard < 0.1
    assert 1.0 < uncertainty_of(thd).standard < 20.0
    assert len(uncertainty_of(frequency).budget) == 1


# --- measured again -------------------------------------------------------------------------------------


def _measure(block: Block, transducer: Block, titles: Sequence[str]) -> Iterator[Measurement]:
    window = Window.of(block, EXAMPLE_MOTOR, transducer)
    for analysis in catalogue().steady:
        if analysis.title in titles:
            yield from measure(analysis, window, analysis.settings()).measurements


def _with_sensors(bench: Bench, block: Block, transducer: Block, titles: Sequence[str]) -> list[Measurement]:
    instruments = Instruments(bench, (block, transducer))

    def again(altered: Perturbed) -> Iterator[Measurement]:
        return _measure(altered.of(block), altered.of(transducer), titles)

    return list(instruments.applied(tuple(_measure(block, transducer, titles)), again))


def test_unequal_gains_look_like_unbalance_even_where_there_is_none() -> None:
    """A magnitude near zero moves the same way for both signs of an error: their difference would be 0."""
    sensors = {name: sensor_of(gain_limit_percent=1.0) for name in ("i_a", "i_b", "i_c")}
    found = _with_sensors(Bench(channels=sensors), *steady_capture(), ["current unbalance"])
    unbalance = next(each for each in found if each.name == "current_unbalance_percent")
    assert unbalance.value < 0.01
    # each phase adds a third of its relative error
    assert uncertainty_of(unbalance).standard == pytest.approx(1.0 / ROOT_3 / 3.0 * ROOT_3, rel=0.1)


def test_a_residual_that_is_a_difference_knows_the_gain_of_what_it_is_made_from() -> None:
    sensors = {"torque_transducer": sensor_of(gain_U_percent=1.0, offset_limit_Nm=0.1)}
    found = _with_sensors(Bench(channels=sensors), *steady_capture(), ["torque residual on the shaft"])
    mean = next(each for each in found if each.name == "transducer_torque_residual_mean")
    lines = {line.instrument.effect: line for line in uncertainty_of(mean).budget if line.instrument}
    assert lines["gain"].standard == pytest.approx(0.005, rel=1e-3)  # mean torque of 1 Nm
    assert lines["offset"].standard == pytest.approx(0.1 / ROOT_3, rel=1e-3)
    assert lines["gain"].sign == -1


def test_what_cannot_be_measured_again_has_no_known_uncertainty() -> None:
    sensors = {"i_a": sensor_of(gain_U_percent=1.0)}
    read = reading("something_else", 1.0, 0.1, rests_on=("i_a",))
    (found,) = Instruments(Bench(channels=sensors)).applied([read], lambda _: ())
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
        "i_a": sensor_of(gain_limit_percent=2.0, offset_limit_A=0.05),
        "torque": sensor_of(gain_U_percent=3.0, offset_U_Nm=0.04),
        "torque_transducer": sensor_of(gain_U_percent=2.0, offset_U_Nm=0.03),
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
    sensors = {name: sensor_of(gain_limit_percent=2.0) for name in ("i_a", "i_b", "i_c")}
    share = covered(sensors, ["current unbalance"], 30, seed=7)
    assert share["current_sequence_positive"] >= 0.88
    assert share["current_unbalance_percent"] >= 0.88


# --- in common ------------------------------------------------------------------------------------------


def _result(value: float, scatter: float, serial_number: str, certificate: str = "C1") -> Uncertainty:
    sensor = sensor_of(
        serial_number=serial_number, certificate=certificate, gain_U_percent=1.0, offset_U_Nm=0.1
    )
    (mean,) = applied(Bench(channels={"torque": sensor}), reading("torque_mean", value, scatter))
    return uncertainty_of(mean)


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
    sensor = sensor_of(sensor="x", serial_number="7", gain_U_percent=1.0)
    (mean,) = applied(Bench(channels={"torque": sensor}), reading("torque_mean", -3.0, 0.1))
    (again,) = measurements_from_json(measurements_to_json([mean]))
    assert again == mean
    (line,) = [each for each in uncertainty_of(again).budget if each.instrument is not None]
    assert line.instrument == InstrumentError("gain", "torque", "x", "7", "")
    assert line.scaled(-2.0) == replace(line, standard=2.0 * line.standard, sign=1)
    assert Contribution("x", "A", 1.0).scaled(-1.0).sign == -1


def test_three_inputs_of_one_instrument_are_paired_channel_by_channel() -> None:
    """Each was set against all three, so that the difference of two sequences counted them sqrt(3) times."""

    def of_three(amplitude: float) -> Uncertainty:
        lines = [
            Contribution(
                f"gain of {channel}",
                "B",
                0.01 * amplitude / 3.0,
                instrument=InstrumentError("gain", channel, "analyser", "77"),
            )
            for channel in ("i_a", "i_b", "i_c")
        ]
        return uncertainty_of(replace(reading("x", amplitude), uncertainty=combined(lines, "three")))

    difference = of_difference(of_three(2.0), of_three(4.0))
    assert difference.standard == pytest.approx(math.sqrt(3.0) * 0.01 * 2.0 / 3.0)
    moved = replace(of_three(2.0).budget[0], instrument=InstrumentError("gain", "i_b", "analyser", "77"))
    one = Uncertainty(moved.standard, "one", budget=(moved,))
    assert of_difference(one, of_three(2.0)).standard == pytest.approx(math.sqrt(2.0) * moved.standard)


@pytest.mark.parametrize(("steps", "kind"), [(0.05, "A"), (0.2, "B")])
def test_a_budget_in_one_line_is_of_the_type_that_most_of_it_is(steps: float, kind: str) -> None:
    """A ripple in percent of the mean had the steps of the ripple as type A, which repetitions would show."""
    lines = Contribution("scatter", "A", 0.1, 9.0, of_student=True), Contribution("resolution", "B", steps)
    whole = combined(lines, "test")
    assert whole is not None
    line = whole.line("torque_ripple_pp", 2.0)
    assert line.evaluation == kind
    assert line.standard == pytest.approx(2.0 * whole.standard)
    assert line.experimental == pytest.approx(2.0 * whole.experimental)
