"""All numbers of one steady or less steady record, with the truth of each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from benchmarks.coverage.families import Compared, selected
from benchmarks.coverage.steady_records import (
    AMPLITUDE_A,
    POLE_PAIRS,
    RATE_HZ,
    RATED_A_RMS,
    TORQUE_NM,
    Disturbance,
    Record,
    record,
)
from benchmarks.coverage.steady_truths import true_numbers, true_orders
from benchtool.analysis import Measurement, Uncertainty, analyze_steady_state, order_analysis
from benchtool.block import Block
from benchtool.errors import AnalysisError

_WHITE, _OF_OTHER_KINDS = 0.2, 1.0  # of a step: less noise does not make its errors white
_OTHERS, _OF_NOISE = 2, ("current_noise_floor", "current_noise_density")


def trial(what: Disturbance, random: np.random.Generator) -> Iterator[Compared]:
    """Yield all measurements of one record with a known truth."""
    made = record(what, random)
    steady = analyze_steady_state(
        made.block, pole_pairs=POLE_PAIRS, torque_rated_Nm=TORQUE_NM, current_rated_A_rms=RATED_A_RMS
    )
    truths = dict(true_numbers(what, made, steady.spectrum))
    least = _WHITE if what.kind == "white" else _OF_OTHER_KINDS
    if made.converter is not None and what.noise * AMPLITUDE_A < least * made.converter.step:
        truths |= _of_others(what, made, steady.measurements, random)
    yield from selected(steady.measurements, truths)
    for table in steady.tables:
        if table.name == "current_harmonics":
            for order, relative in what.harmonics.items():
                if order > len(table.rows):
                    reason = "no harmonic was measured"
                    yield Measurement.undefined(f"harmonic_{order}", "A", "", reason), math.nan
                    continue
                row = table.rows[order - 1]
                uncertain = Uncertainty(row[5], "") if math.isfinite(row[5]) else None
                number = Measurement(f"harmonic_{order}", row[2], "A", "", uncertainty=uncertain)
                yield number, truths["current_fundamental"] * relative
    if what.angle:
        try:
            orders = order_analysis(made.block, "torque", pole_pairs=POLE_PAIRS)
        except AnalysisError:
            return
        yield from selected(orders.measurements, true_orders(what, int(orders.spectrum.order[-1])))


def _of_others(
    what: Disturbance, made: Record, own: Iterable[Measurement], random: np.random.Generator
) -> Mapping[str, float]:
    """Return the floor of other records of the same waveform and converter, so far from the record's own as
    that would be from the mean of many.

    What a converter's steps leave between the harmonics is lines in part, which the definition leaves out.
    """
    found: dict[str, list[float]] = {name: [] for name in _OF_NOISE}
    for _ in range(_OTHERS):
        block = record(what, random, like=made).block
        names = [name for name in block.names if name != "torque"]
        columns = {name: block.column(name) for name in names}
        current = Block.from_arrays(RATE_HZ, {name: block.unit(name) for name in names}, **columns)
        steady = analyze_steady_state(current, pole_pairs=POLE_PAIRS, torque_rated_Nm=TORQUE_NM)
        for each in steady.measurements:
            if each.name in found and math.isfinite(each.value):
                found[each.name].append(each.value)
    of_mean = math.sqrt(1.0 + 1.0 / _OTHERS)
    return {
        each.name: each.value + (float(np.mean(found[each.name])) - each.value) / of_mean
        for each in own
        if found.get(each.name) and math.isfinite(each.value)
    }
