"""Keys of the sensors: each reaches the emulated bench, is bounded, and can be computed with."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Iterator
from typing import Any, cast

import annotated_types
import pytest
from hypothesis import given, settings, strategies as st
from pydantic import BaseModel

from benchtool.emulator import EmulatedBench
from benchtool.emulator.bench import _sensors
from benchtool.emulator.core.kernel import run_ticks
from benchtool.errors import ProfileError, ValueRefused
from benchtool.profile import CurrentSensor, Profile, Sensors, altered
from docs.generate.models import EXAMPLES
from tests.physics.paper_machine import make_core


def example(name: str) -> Profile:
    return Profile.model_validate(tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")))


def numbers_of(model: type[BaseModel], path: str = "") -> Iterator[tuple[str, Any, tuple[float, float]]]:
    """Path, type and bounds of every number of a section and of the tables in it."""
    for name, field in model.model_fields.items():
        stated = field.annotation
        if isinstance(stated, type) and issubclass(stated, BaseModel):
            yield from numbers_of(stated, f"{path}{name}.")
            continue
        if stated is bool:
            continue
        metadata = [*field.metadata, *getattr(stated, "__metadata__", ())]
        for each in getattr(stated, "__args__", ()):
            metadata += getattr(each, "__metadata__", ())
        flat: list[Any] = [item for each in metadata for item in getattr(each, "metadata", [each])]
        low = [cast(float, each.ge) for each in flat if isinstance(each, annotated_types.Ge)]
        low += [cast(float, each.gt) + 1.0 for each in flat if isinstance(each, annotated_types.Gt)]
        high = [cast(float, each.le) for each in flat if isinstance(each, annotated_types.Le)]
        assert low, f"{path}{name} has no lower bound"
        assert high, f"{path}{name} has no upper bound"
        yield f"{path}{name}", int if stated is int else float, (max(low), min(high))


NUMBERS = list(numbers_of(Sensors))


def test_every_key_of_a_profile_reaches_the_emulated_sensors() -> None:
    for name in ("profile_emulated", "profile_shunts"):
        emulator = example(name).emulator
        assert emulator is not None
        stated = emulator.sensors.model_dump(exclude={"temperature"})
        assert dataclasses.asdict(_sensors(emulator.sensors)) == stated


def test_one_phase_is_altered_by_a_plan_and_the_bench_has_it() -> None:
    profile = altered(example("profile_shunts"), {"sensors.i_b.gain": 1.02, "motor.power_up_angle_rad": 0.5})
    bench = EmulatedBench(profile)
    try:
        assert bench._core._truth.sensing.gain_b == 1.02
        assert bench._core.shaft.theta_e == 7 * 0.5
        assert bench._core._truth.sensing.shunts is not None
        assert profile.emulator is not None
        stuck = CurrentSensor(stuck_A=1.5)
        bench.set_sensors(profile.emulator.sensors.model_copy(update={"i_b": stuck}))
        assert bench._core._truth.sensing.gain_b == 0.0
        assert bench._core._truth.sensing.offset_b == 1.5
    finally:
        bench.close()
    with pytest.raises(ProfileError, match=r"sensors\.adc_bits"):
        altered(profile, {"sensors.adc_bits.gain": 1.0})


def test_a_shunt_with_a_bandwidth_is_refused_by_its_keys() -> None:
    profile = altered(example("profile_shunts"), {"sensors.i_b.bandwidth_Hz": 1e5})
    with pytest.raises(ValueRefused, match="shunt_settling_s with bandwidth_Hz"):
        EmulatedBench(profile)


@settings(max_examples=40, deadline=None)
@given(
    st.fixed_dictionaries({path: st.sampled_from([None, 0.0, 1.0]) for path, _, _ in NUMBERS}),
    st.booleans(),
    st.booleans(),
)
def test_readings_are_finite_at_every_corner_of_the_bounds(
    corners: dict[str, float | None], flagged: bool, on: bool
) -> None:
    """Some keys at their lower bound, some at their upper one, the others left out."""
    content: dict[str, Any] = {"i_full_scale_A": 10.0, "u_full_scale_V": 300.0}
    content["encoder"] = dict.fromkeys(("reversed", "relative", "index"), flagged)
    for path, kind, (low, high) in NUMBERS:
        if (corner := corners[path]) is not None:
            table, _, name = path.rpartition(".")
            place = content.setdefault(table, {}) if table else content
            place[name] = kind(low + corner * (high - low))
    content.pop("temperature", None)
    try:
        sensors = _sensors(Sensors.model_validate(content))
        core = make_core(sensors={f.name: getattr(sensors, f.name) for f in dataclasses.fields(sensors)})
    except ValueRefused:
        return
    core.command.pwm_enabled = on
    core.shaft.omega_m = 100.0
    core.run_with(run_ticks, 3)
    measured = core._measurements[0]
    for current in (measured.i_a, measured.i_b, measured.i_c):
        assert abs(current) <= 2.0 * sensors.i_full_scale_A
    assert 0.0 <= measured.u_dc <= sensors.u_full_scale_V
    assert 0 <= measured.count < 4 * sensors.encoder_lines
    assert math.isfinite(core.shaft.i_d + core.shaft.omega_m)
