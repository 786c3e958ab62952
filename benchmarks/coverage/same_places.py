"""Families of records whose rows are at the same few places of all periods, as computed ones often are, in
digits of a text or steps of a converter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.named_truths import of_groups, of_harmonics
from benchmarks.coverage.noise import converted
from benchtool.analysis import (
    analyze_steady_state,
    current_unbalance,
    spectral_lines,
    track_tone,
)
from benchtool.block import Block

RATE_HZ = 10_000.0


@dataclass(frozen=True)
class SamePlaces:
    """Three currents of 5 A and a negative sequence of 3 %, with harmonics: `rows` in so many `periods`, over
    and over again; they are rounded to `digits` behind the decimal point or to steps of `step_A`, and stored
    as numbers of 32 bits or not."""

    rows: int = 200
    periods: int = 1
    digits: int | None = None
    step_A: float = 0.0
    is_32_bit: bool = False


def _same_places(what: SamePlaces, random: np.random.Generator) -> Iterator[Compared]:
    count = what.rows * round(20_000 / what.rows)
    theta = 2 * np.pi * what.periods / what.rows * np.arange(count) + random.uniform(0, 2 * np.pi)
    size_A, negative = 5.0 * random.uniform(0.9, 1.1), 0.03 * np.exp(2j * np.pi * random.uniform())
    turns = {order: random.uniform(0, 2 * np.pi) for order in (5, 7)}
    third, currents = 2 * np.pi / 3, {}
    for name, turn in (("i_a", 0.0), ("i_b", third), ("i_c", -third)):
        wave = np.cos(theta - turn) + np.real(negative * np.exp(-1j * (theta + turn)))
        wave += sum(0.02 * np.cos(order * (theta - turn) + at) for order, at in turns.items())
        currents[name] = _read(what, size_A * wave, random)
    block = Block.from_arrays(RATE_HZ, dict.fromkeys(currents, "A"), **currents)
    own_A = size_A * float(np.abs(1.0 + np.conj(negative)))
    amplitudes = {1: own_A, 5: 0.02 * size_A, 7: 0.02 * size_A}
    steady = analyze_steady_state(block, pole_pairs=1, torque_rated_Nm=1.0)
    truths = {
        "fundamental_frequency": RATE_HZ * what.periods / what.rows,
        **of_harmonics(amplitudes),
        **of_groups(amplitudes, 0.0, what.rows / what.periods),
    }
    yield from selected(steady.measurements, truths)
    truths = {
        "current_sequence_positive": size_A,
        "current_sequence_negative": 0.03 * size_A,
        "current_sequence_zero": 0.0,
        "current_unbalance_percent": 3.0,
        "current_unbalance_zero_percent": 0.0,
    }
    yield from selected(current_unbalance(block, track_tone(currents["i_a"], "i_a")), truths)
    torque = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=currents["i_a"])
    truths = {"torque_line_frequency": RATE_HZ * what.periods / what.rows, "torque_line_amplitude": own_A}
    yield from selected(spectral_lines(torque, "torque").measurements, truths)


def _read(what: SamePlaces, current: NDArray[np.float64], random: np.random.Generator) -> NDArray[np.float64]:
    if what.digits is not None:
        current = np.round(current, what.digits)
    if what.step_A:
        current = converted(current, what.step_A, random)
    return current.astype(np.float32).astype(np.float64) if what.is_32_bit else current


RECORDS: Mapping[str, SamePlaces] = {
    "same_places_3_digits": SamePlaces(digits=3),
    "same_places_5_digits": SamePlaces(digits=5),
    "same_places_64_rows_4_digits": SamePlaces(rows=64, digits=4),
    "same_places_of_3_periods": SamePlaces(rows=500, periods=3, digits=4),
    "same_places_12_bits": SamePlaces(step_A=11.0 / 2**12),
    "same_places_16_bits": SamePlaces(step_A=11.0 / 2**16),
    "same_places_12_bits_of_32": SamePlaces(step_A=11.0 / 2**12, is_32_bit=True),
}

FAMILIES = families_of(_same_places, RECORDS)
