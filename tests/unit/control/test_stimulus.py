"""The shapes of the on-drive stimulus against closed forms, and how a stimulus begins, repeats and ends."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray
from scipy.signal import chirp, max_len_seq

from benchtool.emulator.control.stimulus import (
    Shape,
    StimulusState,
    chirp_cycles,
    direction_of,
    feedback,
    halt,
    play,
    shifted,
    waveform,
)
from benchtool.emulator.memory import STIMULUS

T_S = 1e-4


def _stimulus(**values: Any) -> Any:
    record = np.zeros(1, STIMULUS)[0]
    given = {"state": StimulusState.RUNNING, "amplitude": 1.0, "ticks": 1, "repetitions": 1, "T_s": T_S}
    for name, value in {**given, "steps": 1, "clock": 1, "f_start": 1.0, "f_end": 1.0, **values}.items():
        setattr(record, name, value)
    return record


def _prbs(length: int, seed: int, **values: Any) -> Any:
    prbs = {"kind": Shape.PRBS, "length": length, "mask": feedback(length), "seed": seed}
    return _stimulus(**{"ticks": (1 << length) - 1, **prbs, **values})


def _played(stimulus: Any) -> NDArray[np.float64]:
    """Every value until it is done."""
    values: list[float] = []
    for tick in itertools.count(1):
        value = play(stimulus, tick)
        if stimulus.state != StimulusState.RUNNING:
            return np.array(values)
        values.append(value)
    raise AssertionError


def _form(
    shape: Shape, ticks: int, *, steps: int = 1, f_start: float = 1.0, f_end: float = 1.0
) -> list[float]:
    return [waveform(int(shape), k, ticks, steps, f_start, f_end, T_S) for k in range(ticks)]


def test_constant_step_staircase_and_ramp() -> None:
    assert _form(Shape.CONSTANT, 4) == [1, 1, 1, 1]
    assert _form(Shape.STEP, 6) == [1, 1, 1, 0, 0, 0]
    assert _form(Shape.STEP, 5) == [1, 1, 1, 0, 0]
    assert _form(Shape.STAIRCASE, 8, steps=4) == [0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1, 1]
    assert _form(Shape.RAMP, 5) == [0, 0.2, 0.4, 0.6, 0.8]


def test_a_sine_keeps_its_phase_over_hours() -> None:
    """A period of 50 Hz is 200 ticks; 22 hours later it is where it was."""
    ticks = 10**9
    first = [waveform(int(Shape.SINE), k, ticks, 1, 50.0, 1.0, T_S) for k in range(200)]
    late = [waveform(int(Shape.SINE), 200 * 4_000_000 + k, ticks, 1, 50.0, 1.0, T_S) for k in range(200)]
    assert first == pytest.approx(np.sin(2 * np.pi * np.arange(200) / 200), abs=1e-12)
    assert late == pytest.approx(first, abs=1e-8)


@given(st.floats(0.1, 5000.0), st.floats(0.1, 5000.0), st.integers(2, 5000))
def test_chirps_are_those_of_scipy(f_start: float, f_end: float, ticks: int) -> None:
    t = np.arange(ticks) * T_S
    for shape, method in ((Shape.CHIRP_LINEAR, "linear"), (Shape.CHIRP_LOGARITHMIC, "logarithmic")):
        expected = chirp(t, f_start, ticks * T_S, f_end, method=method, phi=-90.0)  # type: ignore[call-overload] # literals
        assert _form(shape, ticks, f_start=f_start, f_end=f_end) == pytest.approx(expected, abs=1e-8)


@given(st.floats(0.1, 5000.0), st.floats(0.1, 5000.0), st.booleans())
def test_a_chirp_starts_and_ends_at_its_frequencies(f_start: float, f_end: float, logarithmic: bool) -> None:
    ticks = 100_000
    step = [chirp_cycles(k, ticks, f_start, f_end, T_S, logarithmic) for k in (0, 1, ticks - 1, ticks)]
    a_tick = abs(f_end - f_start) / ticks
    assert (step[1] - step[0]) / T_S == pytest.approx(f_start, rel=1e-3, abs=a_tick)
    assert (step[3] - step[2]) / T_S == pytest.approx(f_end, rel=1e-3, abs=a_tick)


@pytest.mark.parametrize("length", range(2, 13))
def test_a_binary_sequence_is_the_maximum_length_sequence_of_scipy(length: int) -> None:
    seed = (0b1011_0010_1110_0101_0110 & (1 << length) - 1) or 1
    state = [seed >> bit & 1 for bit in range(length)]
    bits = _played(_prbs(length, seed)) > 0
    assert np.array_equal(bits, max_len_seq(length, state=state)[0] > 0)
    assert bits.sum() == 1 << (length - 1), "one 1 more than there are 0"


@pytest.mark.parametrize("length", range(2, 21))
def test_the_register_comes_back_after_its_period_and_not_before(length: int) -> None:
    """The period divides 2^n - 1 when the register comes back then; it is that when no divisor does."""
    period, mask = (1 << length) - 1, feedback(length)
    register, seen = 1, 0
    for seen in range(1, period + 1):  # noqa: B007 # where it came back first
        register = shifted(register, mask, length)
        if register == 1:
            break
    assert seen == period


@given(
    st.sampled_from(list(Shape)),
    st.floats(-100.0, 100.0),
    st.floats(-100.0, 100.0),
    st.integers(1, 200),
    st.integers(1, 3),
    st.floats(0.0, 5000.0),
    st.floats(0.001, 5000.0),
)
def test_every_stimulus_stays_within_its_amplitude_for_exactly_its_ticks(
    shape: Shape, amplitude: float, offset: float, ticks: int, repetitions: int, f_start: float, f_end: float
) -> None:
    f_start = max(f_start, 0.001) if shape is Shape.CHIRP_LOGARITHMIC else f_start
    prbs = {"length": 5, "mask": feedback(5), "seed": 9, "clock": 3}
    values = {"amplitude": amplitude, "offset": offset, "f_start": f_start, "f_end": f_end, **prbs}
    stimulus = _stimulus(kind=shape, ticks=ticks, repetitions=repetitions, **values)
    played = _played(stimulus)
    assert len(played) == ticks * repetitions
    assert np.all(np.abs(played - offset) <= abs(amplitude) * (1 + 1e-12) + 1e-12)
    assert np.array_equal(played, np.tile(played[:ticks], repetitions))
    assert play(stimulus, 0) == 0.0


def test_bits_last_for_the_clock() -> None:
    slow = _played(_prbs(4, 1, clock=7, ticks=7 * 15))
    assert np.array_equal(slow, np.repeat(_played(_prbs(4, 1)), 7))


def test_the_beginning_is_marked_in_its_tick_alone() -> None:
    stimulus = _stimulus(ticks=2, repetitions=2)
    marks = []
    for tick in range(100, 105):
        play(stimulus, tick)
        marks.append(int(stimulus.began))
    assert marks == [1, 0, 0, 0, 0]
    assert stimulus.start_tick == 100
    assert stimulus.state == StimulusState.DONE


def test_halting_ends_what_runs_and_nothing_else() -> None:
    stimulus = _stimulus(ticks=5)
    play(stimulus, 1)
    halt(stimulus)
    assert stimulus.state == StimulusState.IDLE
    assert play(stimulus, 2) == 0.0
    done = _stimulus(state=StimulusState.DONE)
    halt(done)
    assert done.state == StimulusState.DONE


def test_a_vector_lies_along_its_angle_or_along_the_rotor() -> None:
    stimulus = _stimulus(cos_angle=0.6, sin_angle=0.8)
    assert direction_of(stimulus, 0.0, 1.0) == (0.6, 0.8)
    stimulus.in_rotor_frame = 1
    assert direction_of(stimulus, 0.0, 1.0) == (0.0, 1.0)


@pytest.mark.parametrize(("turn", "ramp"), [(0.01, 0), (-0.02, 40), (0.03, 500)])
def test_a_turning_one_comes_up_to_its_speed_and_to_rest_where_it_ends(turn: float, ramp: int) -> None:
    """The angle is the sum of the speeds so far, each in the middle between two ticks.

    It comes to rest by the ramp that it began with, where both have room.
    """
    stimulus = _stimulus(ticks=60, repetitions=3, cos_angle=1.0, angle=0.7, turn=turn, turn_ticks=ramp)
    angles = []
    for tick in range(200):
        play(stimulus, tick)
        cosine, sine = direction_of(stimulus, 1.0, 0.0)
        angles.append(np.arctan2(sine, cosine))
    middle = np.arange(179) + 0.5
    speed = turn * np.minimum(1.0, middle / max(ramp, 0.5))
    if 0 < ramp <= 90:
        speed = np.copysign(np.minimum(np.abs(speed), abs(turn) * (180 - middle) / ramp), turn)
    expected = 0.7 + np.concatenate(([0.0], np.cumsum(speed)))
    assert np.unwrap(angles)[:180] == pytest.approx(expected, abs=1e-9)
    assert angles[180:] == [angles[179]] * 20
