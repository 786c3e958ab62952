"""Families of sensors of a stated bandwidth, which are as stated, faster, or of another order."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage import channels
from benchmarks.coverage.families import Compared, Family, families_of, selected
from benchmarks.coverage.named_truths import (
    HIGHEST_ORDER,
    of_groups,
    of_harmonics,
    of_orders,
    of_ripple,
    of_white_noise,
)
from benchtool.analysis import Measurement, Uncertainty, percentile_range
from benchtool.block import Block
from benchtool.profile import Bench, Sensor
from benchtool.results import Calibration
from benchtool.results.block_result import analyze_block

Floats = NDArray[np.float64]
Actual = Literal["lag", "faster", "second_order", "known", "any"]
KINDS: tuple[Actual, ...] = ("lag", "faster", "second_order")
"""Sensors that a statement of the least bandwidth allows; `any` draws one of them for each record."""

RATE_HZ, POLE_PAIRS = 20_000.0, 2
MOTOR = channels.MOTOR.model_copy(update={"pole_pairs": POLE_PAIRS})
_HARMONICS: Mapping[int, float] = {2: 0.01, 5: 0.02, 7: 0.02, 11: 0.02, 13: 0.01}
_ORDERS_NM: Mapping[int, float] = {1: 0.02, 12: 0.05, 24: 0.02}
_LOSS_OUTWEIGHS_NOISE = 2.0
_MOST_FASTER, _KNOWN_WITHIN_PERCENT = 3.0, 10.0


@dataclass(frozen=True)
class Sensed:
    """Current and torque behind sensors whose bandwidth is `ratio` times the tenth harmonic of the current.

    A sensor is a first-order lag of the stated bandwidth, one of up to three times it, a Butterworth response
    of second order, a lag whose bandwidth is stated within 10 % and lies anywhere there, or one of the first
    three.
    """

    ratio: float = 1.0
    actual: Actual = "lag"
    noise: float = 1e-3


class Behind(Protocol):
    """A signal behind sensors."""

    @property
    def actual(self) -> Actual: ...


def always_one_kind(what: Behind) -> bool:
    """Return whether every record is read by the same of the kinds that the statement allows."""
    return what.actual in KINDS


def own_response(actual: Actual, bandwidth_Hz: float, random: np.random.Generator) -> tuple[float, int]:
    """Return bandwidth and order of a sensor."""
    if actual == "any":
        actual = KINDS[random.integers(len(KINDS))]
    within = 0.01 * _KNOWN_WITHIN_PERCENT
    drawn = {"faster": random.uniform(1.0, _MOST_FASTER), "known": 1.0 + random.uniform(-within, within)}
    factor = drawn.get(actual, 1.0)
    return factor * bandwidth_Hz, 2 if actual == "second_order" else 1


def _gain(frequency_Hz: Floats | float, bandwidth_Hz: float, order: int) -> NDArray[np.complex128]:
    s = 1j * np.asarray(frequency_Hz) / bandwidth_Hz
    return np.asarray(1.0 / (1.0 + s if order == 1 else 1.0 + math.sqrt(2.0) * s + s**2))


def stated_sensor(actual: Actual, bandwidth_Hz: float) -> Sensor:
    known = {"bandwidth_tolerance_percent": _KNOWN_WITHIN_PERCENT} if actual == "known" else {}
    return Sensor.model_validate({"bandwidth_Hz": bandwidth_Hz, **known})


def _sensed(what: Sensed, random: np.random.Generator) -> Iterator[Compared]:
    f_Hz, count = random.uniform(45.0, 55.0), round(0.8 * RATE_HZ)
    stated_Hz = what.ratio * 10.0 * f_Hz
    own = own_response(what.actual, stated_Hz, random)
    theta = 2 * np.pi * (f_Hz / RATE_HZ * np.arange(count) + random.uniform())
    theta_m = theta / POLE_PAIRS
    amplitudes = {1: random.uniform(1.0, 5.0)}
    amplitudes |= {k: amplitudes[1] * each * random.uniform(0.5, 1.5) for k, each in _HARMONICS.items()}
    current = sum(
        a * abs(_gain(k * f_Hz, *own)) * np.cos(k * theta + random.uniform(0, 2 * np.pi) * (k > 1))
        for k, a in amplitudes.items()
    )
    orders = {k: each * random.uniform(0.5, 1.5) for k, each in _ORDERS_NM.items()}
    torque = torque_read = np.full(count, 1.0)
    for k, a in orders.items():
        phase, gain = random.uniform(0, 2 * np.pi), _gain(k * f_Hz / POLE_PAIRS, *own)
        torque = torque + a * np.cos(k * theta_m + phase)
        torque_read = torque_read + a * np.abs(gain) * np.cos(k * theta_m + phase + np.angle(gain))
    noise_Nm = what.noise * random.standard_normal(count)
    block = Block.from_arrays(
        RATE_HZ,
        {"i_a": "A", "torque": "Nm"},
        i_a=np.asarray(current) + what.noise * amplitudes[1] * random.standard_normal(count),
        torque=torque_read + noise_Nm,
        theta_m=np.mod(theta_m, 2 * np.pi),
        theta_e=np.mod(theta, 2 * np.pi),
    )
    bench = Bench(channels={name: stated_sensor(what.actual, stated_Hz) for name in ("i_a", "torque")})
    found = analyze_block(block, MOTOR, calibration=Calibration(bench))
    # noise makes a peak-to-peak value larger, of this record by so much
    by_noise = _read_pp(found.measurements) - float(np.ptp(torque_read)) if found.measurements else 0.0
    harmonics = of_harmonics(amplitudes)
    rms_Nm = math.sqrt(0.5 * sum(a * a for a in orders.values()) + what.noise**2)
    is_told = what.ratio <= _LOSS_OUTWEIGHS_NOISE
    truths = {
        "fundamental_frequency": f_Hz,
        **harmonics,
        "current_tdd": harmonics["current_thd_f"] * amplitudes[1] / (math.sqrt(2.0) * MOTOR.I_N_A_rms),
        "current_thd_f_subgroups": harmonics["current_thd_f"],
        "current_thd_f_groups": harmonics["current_thd_f"],
        **of_ripple(
            1.0,
            rms_Nm,
            float(np.ptp(torque)) + by_noise if is_told else None,
            percentile_range(torque + noise_Nm),
            MOTOR.T_N_Nm,
        ),
        **of_orders(orders, POLE_PAIRS, HIGHEST_ORDER),
        **of_white_noise(what.noise * amplitudes[1], RATE_HZ, found.measurements),
        "torque_line_frequency": max(orders, key=lambda k: orders[k]) * f_Hz / POLE_PAIRS,
        "torque_line_amplitude": max(orders.values()),
    }
    yield from selected(found.measurements, truths)
    for table in found.tables:
        lines = {"current_harmonics": amplitudes, "torque_orders": orders}.get(table.name, {})
        for k, amplitude in lines.items():
            row = dict(zip((name for name, _ in table.columns), table.rows[k - 1], strict=True))
            u = Uncertainty(row["uncertainty"], "") if math.isfinite(row["uncertainty"]) else None
            yield Measurement(f"{table.name}_{k}", row["amplitude"], "", "", uncertainty=u), amplitude


def _read_pp(measurements: tuple[Measurement, ...]) -> float:
    return next((each.as_read for each in measurements if each.name == "torque_ripple_pp"), math.nan)


@dataclass(frozen=True)
class SensedPhases:
    """Three currents of slight unbalance behind sensors whose bandwidth is `ratio` times their frequency."""

    ratio: float = 20.0
    actual: Actual = "lag"
    negative: float = 0.02
    zero: float = 0.01
    noise: float = 1e-3


def _phases(what: SensedPhases, random: np.random.Generator) -> Iterator[Compared]:
    f_Hz, count, size_A = random.uniform(45.0, 55.0), round(0.8 * RATE_HZ), random.uniform(1.0, 5.0)
    stated_Hz = what.ratio * f_Hz
    theta = 2 * np.pi * (f_Hz / RATE_HZ * np.arange(count) + random.uniform())
    third, angles = 2 * np.pi / 3, np.exp(2j * np.pi * random.random(2))
    currents, own = {}, 1.0
    for name, turn in (("i_a", 0.0), ("i_b", third), ("i_c", -third)):
        phasor = np.exp(-1j * turn) + what.negative * angles[0] * np.exp(1j * turn) + what.zero * angles[1]
        own = abs(phasor) if name == "i_a" else own
        read = phasor * complex(_gain(f_Hz, *own_response(what.actual, stated_Hz, random)))
        noise = what.noise * random.standard_normal(count)
        currents[name] = size_A * (np.real(read * np.exp(1j * theta)) + noise)
    block = Block.from_arrays(RATE_HZ, dict.fromkeys(currents, "A"), **currents)
    bench = Bench(channels=dict.fromkeys(currents, stated_sensor(what.actual, stated_Hz)))
    found = analyze_block(block, MOTOR, calibration=Calibration(bench))
    truths = {
        "fundamental_frequency": f_Hz,
        **of_harmonics({1: size_A * own}),
        "current_tdd": 0.0,
        **of_white_noise(size_A * what.noise, RATE_HZ, found.measurements),
        **of_groups({1: size_A * own}, size_A * what.noise, RATE_HZ / f_Hz),
        "current_sequence_positive": size_A,
        "current_sequence_negative": size_A * what.negative,
        "current_sequence_zero": size_A * what.zero,
        "current_unbalance_percent": 100.0 * what.negative,
        "current_unbalance_zero_percent": 100.0 * what.zero,
    }
    yield from selected(found.measurements, truths)


@dataclass(frozen=True)
class SensedSteps:
    """A torque read in stated steps, whose ripple is `span` steps high, and then by a finer converter whose
    noise of `later` steps hides them; `noise` is that before."""

    span: float = 2.0
    noise: float = 0.05
    later: float = 0.05


def _steps(what: SensedSteps, random: np.random.Generator) -> Iterator[Compared]:
    f_Hz, count, step_Nm = random.uniform(45.0, 55.0), round(0.8 * RATE_HZ), random.uniform(0.01, 0.1)
    theta_m = 2 * np.pi * (f_Hz / RATE_HZ * np.arange(count) + random.uniform()) / POLE_PAIRS
    mean_Nm = step_Nm * random.uniform(10.0, 50.0)
    orders = {12: step_Nm * what.span * random.uniform(0.5, 1.5), 2: step_Nm * random.uniform(0.05, 0.5)}
    noise_Nm = step_Nm * what.noise
    torque = mean_Nm + noise_Nm * random.standard_normal(count)
    for k, a in orders.items():
        torque += a * np.cos(k * theta_m + random.uniform(0, 2 * np.pi))
    read = step_Nm * np.round(torque / step_Nm) + step_Nm * what.later * random.standard_normal(count)
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=read, theta_m=np.mod(theta_m, 2 * np.pi))
    bench = Bench(channels={"torque": Sensor.model_validate({"resolution_Nm": step_Nm})})
    found = analyze_block(block, MOTOR, calibration=Calibration(bench))
    rms_Nm = math.sqrt(0.5 * sum(a * a for a in orders.values()) + noise_Nm**2)
    truths = of_ripple(mean_Nm, rms_Nm, rated=MOTOR.T_N_Nm) | of_orders(orders, POLE_PAIRS, HIGHEST_ORDER)
    largest = max(orders, key=lambda k: orders[k])
    truths |= {"torque_line_frequency": largest * f_Hz / POLE_PAIRS, "torque_line_amplitude": orders[largest]}
    yield from selected(found.measurements, truths)


ACTUAL: tuple[Actual, ...] = (*KINDS, "known", "any")

FAMILIES: tuple[Family, ...] = (
    *families_of(
        _sensed,
        {
            f"sensor_{actual}_{ratio:g}": Sensed(ratio, actual)
            for actual in ACTUAL
            for ratio in (0.5, 1.0, 2.0, 5.0, 20.0)
        },
        always_one_kind,
    ),
    *families_of(
        _steps,
        {
            **{f"sensor_steps_{span:g}": SensedSteps(span) for span in (0.5, 2.0, 8.0)},
            "sensor_steps_noise": SensedSteps(1.0, 0.4, 0.1),
            "sensor_steps_shown": SensedSteps(1.5, 0.1, 0.0),
        },
    ),
    *families_of(
        _phases,
        {
            f"sensor_{actual}_phases_{ratio:g}": SensedPhases(ratio, actual)
            for actual in ACTUAL[-2:]  # alike by chance only
            for ratio in (5.0, 50.0, 500.0)
        },
    ),
)
