"""Where a machine ran: the mean of what was recorded there, with its uncertainty."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from benchtool.analysis import Instruments, Measurement, speed_beside_angle
from benchtool.block import Block
from benchtool.plan.cases import cases
from benchtool.plan.model import OperatingPoint, Plan
from benchtool.plan.operating_point import CaseReadings, Target, measure_held, measure_reached
from benchtool.profile import Bench, Sensor
from benchtool.results.repetitions import over_repetitions
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR


def test_the_scatter_over_parts_has_their_degrees_of_freedom() -> None:
    """100 values are 50 parts, whose mean is that of all; k is Student's for about as many."""
    speed = 100.0 + np.random.default_rng(3).normal(size=100)
    (found,) = measure_held(Block.from_arrays(1e3, {"omega_m": "rad/s"}, omega_m=speed))
    assert found.uncertainty is not None
    assert found.uncertainty.standard == pytest.approx(0.1, rel=0.3)
    assert 10.0 < found.uncertainty.dof < 60.0
    factor = stats.t.ppf(0.975, found.uncertainty.dof)
    assert found.uncertainty.expanded == pytest.approx(factor * found.uncertainty.experimental)
    assert found.uncertainty.experimental < found.uncertainty.standard
    assert math.isfinite(found.uncertainty.expanded)


def held(u_dc_V: np.ndarray, **stated: float) -> Measurement:
    """Return the mean dc link of these samples, with a stated sensor if there is one."""
    block = Block.from_arrays(1e3, {"u_dc": "V"}, u_dc=u_dc_V)
    bench = Bench(channels={"u_dc": Sensor.model_validate(stated)} if stated else {})
    (found,) = Instruments(bench, [block]).applied(tuple(measure_held(block)))
    return found


def test_of_samples_that_are_all_the_same_the_stated_resolution_is_what_is_known() -> None:
    still_V = np.full(200, 122.559)
    unknown = held(still_V, gain_limit_percent=0.5)
    assert unknown.uncertainty is None
    assert "state resolution_V in [bench.channels.u_dc] of the profile" in unknown.uncertainty_reason
    found = held(still_V, gain_limit_percent=0.5, offset_limit_V=0.2, resolution_V=0.488)
    assert not found.uncertainty_reason
    assert found.uncertainty is not None
    shares = 0.005 * 122.559 / math.sqrt(3.0), 0.2 / math.sqrt(3.0), 0.488 / math.sqrt(12.0)
    assert found.uncertainty.standard == pytest.approx(math.hypot(*shares), rel=0.03)


def test_samples_on_two_levels_tell_their_step_once() -> None:
    """Their scatter over parts is a fifth of what the step leaves."""
    steps = (np.random.default_rng(4).random(2000) < 0.02).astype(np.float64)
    seen, stated = held(122.0 + 0.5 * steps), held(122.0 + 0.5 * steps, resolution_V=0.5)
    assert seen.uncertainty is not None
    assert seen.uncertainty.standard > 0.5 / math.sqrt(12.0)
    assert "resolution of u_dc" in seen.uncertainty.source
    assert stated.uncertainty is not None
    assert stated.uncertainty.standard == pytest.approx(seen.uncertainty.standard)


def test_the_error_of_a_mean_is_within_it_wherever_the_value_lies() -> None:
    random = np.random.default_rng(6)
    for noise in (0.0, 0.1, 0.4):
        over_u = []
        for value in random.uniform(120.0, 121.0, 40):
            read = 0.5 * np.round((value + 0.5 * noise * random.standard_normal(200)) / 0.5)
            found = held(read, resolution_V=0.5)
            assert found.uncertainty is not None
            over_u.append((found.value - value) / found.uncertainty.standard)
        assert 0.5 < math.sqrt(np.mean(np.square(over_u))) < 1.4, noise
        assert np.mean(np.abs(over_u) < 2.0) > 0.9, noise


def plan_of(repetitions: int) -> Plan:
    return Plan.model_validate(
        {
            "title": "test",
            "profile": "zhu2011",
            "repetitions": repetitions,
            "operating_point": {"omega_m_rad_s": 10.0},
            "record": {"duration_s": 0.1, "channels": ("torque",)},
        }
    )


def test_repetitions_of_one_reading_do_not_show_its_resolution_either() -> None:
    plan = plan_of(3)
    named = [case.name for case in cases(plan)]
    still_V = [np.full(200, level) for level in (122.0, 122.0, 122.5)]
    unknown = {name: (held(each),) for name, each in zip(named, still_V, strict=True)}
    ((found,),) = over_repetitions(plan, unknown).values()
    assert found.uncertainty is None
    assert "resolution of u_dc" in found.uncertainty_reason
    known = {name: (held(each, resolution_V=0.5),) for name, each in zip(named, still_V, strict=True)}
    ((found,),) = over_repetitions(plan, known).values()
    assert found.uncertainty is not None


def test_what_the_drive_is_read_just_before_counts_its_steps_once() -> None:
    read_V, capture = (
        [122.0] * 15 + [122.5] * 5,
        Block.from_arrays(1e3, {"torque": "Nm"}, torque=np.ones(100)),
    )
    seen, (case, *_) = CaseReadings({"u_dc": read_V}), cases(plan_of(1))
    wanted = (Target("u_dc_reached", 122.0, "V", 12.0),)
    found = measure_reached(wanted, plan_of(1), case.operating_point, EXAMPLE_MOTOR, capture, None, seen)
    bench = Bench(channels={"u_dc": Sensor.model_validate({"resolution_V": 0.5})})
    (stated,) = Instruments(bench, [capture, *seen.blocks]).applied(found)
    assert found[0].uncertainty is not None
    (line,) = (each for each in found[0].uncertainty.budget if each.evaluation == "B")
    assert line.name == "resolution of u_dc"
    assert stated.uncertainty == found[0].uncertainty


def test_the_slope_of_the_speed_is_in_the_load_that_it_tells() -> None:
    """In torque mode, whose noise of the torque alone is a tenth of it."""
    random, over_u = np.random.default_rng(8), []
    plan = plan_of(1)
    point = OperatingPoint(mode="torque", torque_Nm=2.0, load_torque_Nm=1.5)
    wanted = (Target("load_torque_reached", 1.5, "Nm", 0.15),)
    for _ in range(40):
        omega_m = (
            50.0 + 0.5 / EXAMPLE_MOTOR.J_kgm2 * 1e-4 * np.arange(400) + 0.2 * random.standard_normal(400)
        )
        torque = 2.0 + 0.001 * random.standard_normal(400)
        capture = Block.from_arrays(1e4, {"torque": "Nm", "omega_m": "rad/s"}, torque=torque, omega_m=omega_m)
        (found,) = measure_reached(wanted, plan, point, EXAMPLE_MOTOR, capture, None, CaseReadings())
        assert found.uncertainty is not None
        over_u.append((found.value - 1.5) / found.uncertainty.standard)
    assert 0.7 < math.sqrt(np.mean(np.square(over_u))) < 1.4
    assert found.sensitivities.named == ("torque", "omega_m")


def test_a_speed_that_reads_the_same_in_every_sample_leaves_its_slope_open() -> None:
    wanted, point = (
        (Target("load_torque_reached", 2.0, "Nm", 0.2),),
        OperatingPoint(mode="torque", torque_Nm=2.0),
    )
    capture = Block.from_arrays(
        1e3,
        {"torque": "Nm", "omega_m": "rad/s"},
        torque=2.0 + 0.001 * np.random.default_rng(9).standard_normal(100),
        omega_m=np.zeros(100),
    )
    (found,) = measure_reached(wanted, plan_of(1), point, EXAMPLE_MOTOR, capture, None, CaseReadings())
    assert found.uncertainty is None
    assert "omega_m" in found.uncertainty_reason
    bench = Bench(channels={"omega_m": Sensor.model_validate({"resolution_rad_s": 0.5})})
    (stated,) = Instruments(bench, [capture]).applied([found])
    assert stated.uncertainty is not None
    # means of both halves of 0.1 s, each off by a step over sqrt(12), are half of it apart
    by_slope = EXAMPLE_MOTOR.J_kgm2 * 0.5 / math.sqrt(12.0) * math.sqrt(2.0) / 0.05
    assert stated.uncertainty.standard == pytest.approx(by_slope, rel=0.01)


def test_of_a_speed_beside_its_angle_what_both_show_is_no_error() -> None:
    """It swings less than once in the record; the mean over that is what the angle says, whatever it is."""
    random, rate_Hz, count = np.random.default_rng(8), 1e3, 800
    errors, alone = [], []
    for _ in range(30):
        time_s = np.arange(count) / rate_Hz
        phase_rad = random.uniform(0.0, 2.0 * np.pi)
        swing = 2.0 * np.cos(2.0 * np.pi * 0.9 * time_s + phase_rad)
        turned = 2.0 / (2.0 * np.pi * 0.9) * np.sin(2.0 * np.pi * 0.9 * time_s + phase_rad)
        theta_m = (50.0 * time_s + turned + 1e-3 * random.standard_normal(count)) % (2.0 * np.pi)
        omega_m = 50.0 + swing + 0.05 * random.standard_normal(count)
        units = {"omega_m": "rad/s", "theta_m": "rad"}
        both = Block.from_arrays(rate_Hz, units, omega_m=omega_m, theta_m=theta_m)
        found, of_speed = (
            next(measure_held(each))
            for each in (both, Block.from_arrays(rate_Hz, {"omega_m": "rad/s"}, omega_m=omega_m))
        )
        assert found.uncertainty is not None
        assert "beside the course of theta_m" in found.uncertainty.source
        assert found.repeatability is not None
        errors.append((found.value - 50.0 - np.mean(swing)) / found.uncertainty.standard)
        alone.append(math.inf if of_speed.uncertainty is None else of_speed.uncertainty.standard)
        assert found.uncertainty.standard < 0.05 * alone[-1]
    assert 0.4 < np.sqrt(np.mean(np.square(errors))) < 1.4


def test_of_a_speed_beside_a_current_its_slow_course_is_no_error() -> None:
    random, rate_Hz, count, errors = np.random.default_rng(10), 1e4, 4000, []
    for _ in range(20):
        time_s = np.arange(count) / rate_Hz
        swing = 1.5 * np.cos(2.0 * np.pi * 1.2 * time_s + random.uniform(0.0, 2.0 * np.pi))
        turned = np.cumsum(50.0 + swing) / rate_Hz
        i_a = 5.0 * np.cos(4.0 * turned + 0.7) + 0.2 * np.cos(20.0 * turned)
        omega_m = 50.0 + swing + 0.05 * random.standard_normal(count)
        found = speed_beside_angle(omega_m, rate_Hz, i_a=i_a, pole_pairs=4)
        assert found is not None
        assert found.channel == "i_a"
        errors.append((np.mean(omega_m) - 50.0 - np.mean(swing)) / found.error.standard)
        assert speed_beside_angle(omega_m, rate_Hz, i_a=np.zeros(count), pole_pairs=4) is None
        assert speed_beside_angle(omega_m, rate_Hz) is None
    assert np.sqrt(np.mean(np.square(errors))) < 1.2


def test_a_current_has_the_direction_of_a_speed_that_reverses() -> None:
    """Its phase rises whichever way the rotor turns: the error was that of a speed of the other sign."""
    rate_Hz = 5e3
    speed = 60.0 * np.clip(1.0 - (np.arange(10_000) / rate_Hz - 0.5) / 0.4, -1.0, 1.0)
    i_a = 5.0 * np.cos(4.0 * np.cumsum(speed) / rate_Hz)
    omega_m = speed + 0.02 * np.random.default_rng(12).standard_normal(len(speed))
    found = speed_beside_angle(omega_m, rate_Hz, i_a=i_a, pole_pairs=4)
    assert found is not None
    assert found.error.standard < 1.0
    assert abs(found.value - np.mean(speed)) < 3.0 * found.error.standard


def test_an_angle_that_does_not_turn_with_the_speed_tells_nothing_of_it() -> None:
    random, rate_Hz, count = np.random.default_rng(9), 1e3, 500
    omega_m = 50.0 + 0.05 * random.standard_normal(count)
    slips = np.cumsum(50.0 + 40.0 * random.standard_normal(count)) / rate_Hz
    for theta_m in (slips, np.zeros(count), np.arange(count) % 7.0):
        units = {"omega_m": "rad/s", "theta_m": "rad"}
        both = Block.from_arrays(rate_Hz, units, omega_m=omega_m, theta_m=theta_m)
        (found,) = measure_held(both)
        (alone,) = measure_held(Block.from_arrays(rate_Hz, {"omega_m": "rad/s"}, omega_m=omega_m))
        assert found.uncertainty == alone.uncertainty
        assert found.repeatability is None
