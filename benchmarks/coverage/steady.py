"""All numbers of one steady or less steady record, with the truth of each."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from benchmarks.coverage.families import Compared, selected
from benchmarks.coverage.steady_records import (
    POLE_PAIRS,
    RATED_A_RMS,
    TORQUE_NM,
    Disturbance,
    record,
)
from benchmarks.coverage.steady_truths import true_numbers, true_orders
from benchtool.analysis import Measurement, Uncertainty, analyze_steady_state, order_analysis
from benchtool.errors import AnalysisError


def trial(what: Disturbance, random: np.random.Generator) -> Iterator[Compared]:
    """Yield all measurements of one record with a known truth."""
    made = record(what, random)
    steady = analyze_steady_state(
        made.block, pole_pairs=POLE_PAIRS, torque_rated_Nm=TORQUE_NM, current_rated_A_rms=RATED_A_RMS
    )
    truths = true_numbers(what, made, steady.spectrum, random)
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
