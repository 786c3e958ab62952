"""What the steps of a sensor do to numbers of several kinds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis.catalogue import catalogue
from benchtool.analysis.measurement import Measurement
from benchtool.analysis.sensitivity import OF_EXTREMES_STEP, OF_MEAN_STEP, Error, Sensitivities, Sensitivity
from benchtool.analysis.sensors.effects import moved_by_steps
from benchtool.analysis.sensors.instruments import Instruments, Perturbed
from benchtool.analysis.sensors.waveform import Waveform
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.profile import Bench
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR
from tests.unit.analysis.stated_sensors import applied, reading, sensor_of, uncertainty_of

STEP_A = 0.5


def _errors_of_rounding(count: int, seed: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    read = np.random.default_rng(seed).uniform(0.0, 100.0, count)
    return np.asarray(np.round(read) - read)


def test_a_reading_and_a_difference_of_two_scatter_by_steps_as_stated() -> None:
    first, second = _errors_of_rounding(20_000, 1), _errors_of_rounding(20_000, 2)
    assert np.std(first) == pytest.approx(OF_MEAN_STEP, rel=0.02)
    assert np.std(first - second) == pytest.approx(OF_EXTREMES_STEP, rel=0.02)


@pytest.mark.parametrize(
    ("name", "value", "share"),
    [
        ("torque_mean", 2.0, OF_MEAN_STEP),
        ("torque_ripple_rms", 2.0, OF_MEAN_STEP),
        ("torque_ripple_pp", 2.0, OF_EXTREMES_STEP),
        ("fundamental_frequency", 50.0, 0.0),
    ],
)
def test_without_a_waveform_steps_count_as_declared(name: str, value: float, share: float) -> None:
    (found,) = applied(Bench(channels={"torque": sensor_of(resolution_Nm=STEP_A)}), reading(name, value))
    assert uncertainty_of(found).standard == pytest.approx(share * STEP_A)


def test_steps_of_a_signal_without_ripple_count_as_declared() -> None:
    read = reading("torque_ripple_rms", 0.0)
    (part,) = read.sensitivities.channels or ()
    moved = moved_by_steps(part, read, STEP_A, Waveform(np.full(4000, 1.3), 20e3))
    assert moved == pytest.approx(OF_MEAN_STEP * STEP_A)


def test_steps_of_three_phases_move_their_component() -> None:
    """By as much as readings in such steps scatter, under noise of three times their size."""
    step_A = 0.1
    angle = 2.0 * math.pi * 50.0 * np.arange(20_000) / 20e3
    noise = np.random.default_rng(4).normal(0.0, 0.3, (3, 20_000))
    currents = {
        name: 6.0 * np.cos(angle - 2.0 * k * math.pi / 3.0) + noise[k]
        for k, name in enumerate(("i_a", "i_b", "i_c"))
    }
    block = Block.from_arrays(20e3, dict.fromkeys(currents, "A"), **currents)
    bench = Bench(channels=dict.fromkeys(currents, sensor_of(resolution_A=step_A)))
    read = reading("current_sequence_positive", 6.0, unit="A", frequency_Hz=50.0)
    (found,) = applied(bench, read, blocks=[block])

    # errors of 3 x 20000 independent readings, of which the phasor takes what is in phase
    expected_A = OF_MEAN_STEP * step_A * math.sqrt(2.0 / (3.0 * 20_000))
    # the window takes sqrt(1.5) times as much of it, the stated gain is 5 % greater, and draws are few
    assert 0.9 * expected_A < uncertainty_of(found).standard < 1.8 * expected_A


def test_a_guarantee_beside_a_tolerance_is_told() -> None:
    """Of one phase the bandwidth is known within a tolerance, of the others it is a guarantee."""
    guaranteed = sensor_of(bandwidth_Hz=3000.0)
    known = sensor_of(bandwidth_Hz=3000.0, bandwidth_tolerance_percent=10.0)
    angle = 2.0 * math.pi * 30.0 * np.arange(20_000) / 20e3
    currents = {
        name: 6.0 * np.cos(angle - 2.0 * k * math.pi / 3.0) for k, name in enumerate(("i_a", "i_b", "i_c"))
    }
    block = Block.from_arrays(20e3, dict.fromkeys(currents, "A"), **currents)
    bench = Bench(channels={"i_a": known, "i_b": guaranteed, "i_c": guaranteed})
    read = reading("current_sequence_positive", 6.0, unit="A", frequency_Hz=30.0)
    (found,) = applied(bench, read, blocks=[block])
    # (30 / 3000)^2 / 2 of 6 A is what a lag takes off at most
    assert 0.0 < uncertainty_of(found).standard < 6.0 * 0.5e-4
    assert found.value == pytest.approx(6.0, rel=0.5e-4)


def test_a_factor_moves_a_number_by_gain_offset_and_steps() -> None:
    part = Sensitivity.of_factor("u_dc", -4.0, 200.0)
    assert part == Sensitivity("u_dc", -4.0, -0.02, 0.02 * OF_MEAN_STEP)
    assert Sensitivities((part,)).is_moved_by_steps(part)
    assert not Sensitivities((part,)).is_moved_by_steps(Sensitivity("i_a", 2.0))


def test_errors_that_depend_on_the_waveform_are_measured_again_beside_those_that_are_declared() -> None:
    """The gain of i_a is declared, its offset measured again: nothing is where only the gain is stated."""
    part = Sensitivity("i_a", 2.0, again=frozenset({Error.OFFSET}))
    read = replace(reading("resistance", 2.0, unit="ohm"), sensitivities=Sensitivities((part,)))
    asked: list[Perturbed] = []

    def again(altered: Perturbed) -> Iterator[Measurement]:
        asked.append(altered)
        yield replace(read, value=read.value + 3.0 * altered.offset)

    both = sensor_of(gain_U_percent=1.0, offset_U_A=0.1)
    (found,) = Instruments(Bench(channels={"i_a": both})).applied([read], again)
    assert sorted(line.standard for line in uncertainty_of(found).budget)[-2:] == pytest.approx([0.01, 0.15])
    assert {each.gain for each in asked} == {0.0}

    asked.clear()
    (found,) = Instruments(Bench(channels={"i_a": sensor_of(gain_U_percent=1.0)})).applied([read], again)
    assert uncertainty_of(found).standard == pytest.approx(0.01)
    assert not asked


def analyze_unbalance(block: Block) -> dict[str, Measurement]:
    analysis = next(each for each in catalogue().steady if each.name == "current_unbalance")
    found = analysis.measure(Window.of(block, EXAMPLE_MOTOR), analysis.settings())
    return {each.name: each for each in found.measurements}


def test_lags_that_are_not_alike_leave_in_a_component_what_is_in_phase_with_it() -> None:
    """Each phase is turned by up to 10 mrad: the negative sequence scatters by half the square of that of a
    phasor, and the positive one by what the negative one does to it."""
    random = np.random.default_rng(11)
    f_Hz, bandwidth_Hz, tolerance = 50.0, 5_000.0, 0.5
    angle = 2.0 * math.pi * f_Hz * np.arange(2_400) / 20e3
    bench_of = dict.fromkeys(
        ("i_a", "i_b", "i_c"),
        sensor_of(bandwidth_Hz=bandwidth_Hz, bandwidth_tolerance_percent=100.0 * tolerance),
    )
    truths = {"current_sequence_positive": 6.0, "current_sequence_negative": 0.3}
    errors: dict[str, list[float]] = {name: [] for name in truths}
    for _ in range(20):
        currents = {}
        negative = 0.3 * np.exp(2j * math.pi * random.random())
        for k, name in enumerate(bench_of):
            turn = np.exp(-2j * k * math.pi / 3.0)
            own_Hz = bandwidth_Hz * (1.0 + random.uniform(-tolerance, tolerance))
            phasor = (6.0 * turn + negative / turn) / (1.0 + 1j * f_Hz / own_Hz)
            currents[name] = np.real(phasor * np.exp(1j * angle))
        block = Block.from_arrays(20e3, dict.fromkeys(currents, "A"), **currents)
        read = analyze_unbalance(block)
        found = applied(Bench(channels=bench_of), *(read[name] for name in truths), blocks=[block])
        for each in found:
            errors[each.name].append((each.value - truths[each.name]) / uncertainty_of(each).standard)
    for name, each_over_u in errors.items():
        assert 0.75 < math.sqrt(np.mean(np.square(each_over_u))) < 1.25, name


@pytest.mark.parametrize(("steps_high", "is_all_of_one"), [(1.2, True), (4.0, False)])
def test_a_line_of_few_steps_may_have_been_larger_by_all_of_one(
    steps_high: float, is_all_of_one: bool
) -> None:
    step_Nm = 0.5
    size_Nm = 0.5 * steps_high * step_Nm
    time_s = np.arange(20_000) / 20e3
    block = Block.from_arrays(20e3, {"torque": "Nm"}, torque=size_Nm * np.cos(2.0 * math.pi * 41.3 * time_s))
    bench = Bench(channels={"torque": sensor_of(resolution_Nm=step_Nm)})
    read = reading("torque_line_amplitude", size_Nm, frequency_Hz=41.3)
    (found,) = applied(bench, read, blocks=[block])
    one = step_Nm / math.sqrt(12.0)
    u = uncertainty_of(found).standard
    assert u == pytest.approx(one, rel=0.01) if is_all_of_one else 0.0 < u < 0.5 * one


@pytest.mark.parametrize(
    ("name", "unit"), [("current_thd_f", "%"), ("current_tdd", "%"), ("current_sequence_negative", "A")]
)
def test_finer_steps_move_a_ratio_and_a_component_less(name: str, unit: str) -> None:
    """In proportion to their size, under noise that spans them; by more than nothing."""
    angle = 2.0 * math.pi * 50.0 * np.arange(20_000) / 20e3
    noise = np.random.default_rng(6).normal(0.0, 0.2, (3, 20_000))
    currents = {
        phase: 6.0 * np.cos(angle - turn)
        + 0.3 * np.cos(5.0 * angle + turn)
        + 0.3 * np.cos(angle + turn)
        + noise[k]
        for k, (phase, turn) in enumerate(
            (("i_a", 0.0), ("i_b", 2.0 * math.pi / 3.0), ("i_c", -2.0 * math.pi / 3.0))
        )
    }
    block = Block.from_arrays(20e3, dict.fromkeys(currents, "A"), **currents)

    def by(step_A: float) -> float:
        bench = Bench(channels=dict.fromkeys(currents, sensor_of(resolution_A=step_A)))
        read = reading(name, 5.0 if unit == "%" else 0.3, unit=unit, frequency_Hz=50.0)
        (found,) = applied(
            bench, replace(read, basis=replace(read.basis, bandwidth_Hz=2000.0)), blocks=[block]
        )
        return uncertainty_of(found).standard

    fine, coarse = by(0.02), by(0.1)
    assert 0.0 < fine < coarse < 0.05 * (5.0 if unit == "%" else 0.3)
    assert coarse / fine == pytest.approx(5.0, rel=0.5)
