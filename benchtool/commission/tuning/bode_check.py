"""A loop's measured Bode plot against what it was designed to be."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchtool.analysis import Bode, Measurement, analyze_response
from benchtool.block import Block
from benchtool.commission.steps.step import Finding
from benchtool.commission.tuning.loops import LEAST_GAIN, MOST_SENSITIVITY
from benchtool.commission.tuning.margins import Margins
from benchtool.drive import Stimulus

_CROSSOVER, _PHASE_DEG = 0.10, 5.0
_UNSURE_DB, _UNSURE_PEAK = 12.0, 2.0  # U of the margins with limits of 6 dB and 2
_LEAST_GAIN_DB = 20.0 * math.log10(LEAST_GAIN)
CHECKED = ("crossover", "phase_margin", "gain_margin", "sensitivity_peak")


@dataclass(frozen=True)
class ExcitedRows:
    """Rows of a capture in which a repeated stimulus plays, its first repetition left out."""

    begin_row: int
    end_row: int
    period_rows: int

    @classmethod
    def of(cls, stimulus: Stimulus, T_s: float, stride: int) -> ExcitedRows:
        """Return those of a capture that begins with its stimulus."""
        period = stimulus.ticks(T_s) // stride
        return cls(period, period * stimulus.repetitions, period)


def repetitions(sequence_s: float, longest_s: float, fewest: int, most: int) -> int:
    """Return how often a binary sequence is played: as often as there is time for, within bounds."""
    return min(max(math.floor(longest_s / sequence_s), fewest), most)


def measured(block: Block, input: str, output: str, rows: ExcitedRows) -> Bode:
    """Return the response of a closed loop.

    Raises:
        AnalysisError: it cannot be told from the capture.
    """
    return analyze_response(block, input, output, **vars(rows))


def numbers(bode: Bode, loop: str) -> dict[str, Measurement]:
    """Return the margins of a measured response, each named after its loop.

    Beside them, what the frequencies used tell where a margin is beyond them: by how much the open loop has
    fallen below 1 at the highest, and the greatest sensitivity, at least 1.
    """
    found = [each for each in bode.measurements if each.name in CHECKED]
    closed = bode.response.response[bode.response.trusted]
    opened = closed[-1] / (1.0 - closed[-1])
    found.append(
        Measurement(
            "attenuation",
            -20.0 * math.log10(max(abs(opened), 1e-12)),
            "dB",
            "gain of the open loop below 1 at the highest frequency used",
        )
    )
    peak = max(1.0, float(np.max(np.abs(1.0 - closed))))
    found.append(Measurement("sensitivity_seen", peak, "", "greatest |1 - T| of the frequencies used"))
    return {f"{loop}_{each.name}": replace(each, name=f"{loop}_{each.name}") for each in found}


def deviations(found: Mapping[str, Measurement], loop: str, design: Margins) -> tuple[Finding, ...]:
    """Return what of a measured loop is not as it was designed: nothing is to be saved of it."""
    design_Hz, design_deg = design.crossover_rad_s / (2.0 * math.pi), math.degrees(design.phase_rad)
    crossover, phase = found[f"{loop}_crossover"], found[f"{loop}_phase_margin"]
    gain = _defined(found[f"{loop}_gain_margin"], found[f"{loop}_attenuation"], _UNSURE_DB)
    peak = _defined(found[f"{loop}_sensitivity_peak"], found[f"{loop}_sensitivity_seen"], _UNSURE_PEAK)
    wrong = (
        (crossover, f"{design_Hz:.4g} Hz within 10 %", abs(crossover.value / design_Hz - 1.0) <= _CROSSOVER),
        (phase, f"{design_deg:.3g} deg within 5 deg", abs(phase.value - design_deg) <= _PHASE_DEG),
        (gain, "6 dB or more", gain.value >= _LEAST_GAIN_DB),
        (peak, "2 or less", peak.value <= MOST_SENSITIVITY),
    )
    return tuple(_finding(loop, seen, expected) for seen, expected, holds in wrong if not holds)


def _defined(one: Measurement, other: Measurement, unsure: float) -> Measurement:
    """Return a margin, or what the frequencies used tell in its place where its uncertainty is so large that
    it tells nothing: at low frequencies, where the loop's gain is large, noise makes a phase of -180
    degrees."""
    U = 0.0 if one.uncertainty is None else one.uncertainty.expanded
    return one if math.isfinite(one.value) and unsure >= U else other


def _finding(loop: str, seen: Measurement, expected: str) -> Finding:
    what = seen.name.removeprefix(f"{loop}_").replace("_", " ")
    return Finding(
        f"{what} of the {loop.replace('_', ' ')} is {seen}, {expected} is expected",
        "the plant is not as it was identified, or the loop does not stay linear: a limit, dead time, a load",
        "look at the Bode plot and its coherence, free the shaft, and identify the motor again",
    )
