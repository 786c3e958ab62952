"""Torque and its ripple: the drive's estimate, and the true torque of a transducer beside it."""

from __future__ import annotations

import math
from dataclasses import replace

from numpy.polynomial import Polynomial

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.ripple import ripple_numbers
from benchtool.analysis.span import cut_to_span
from benchtool.analysis.uncertainty import Uncertainty
from benchtool.block import Block


def torque_ripple(
    block: Block,
    channel: str = "torque",
    *,
    torque_rated_Nm: float | None = None,
    track: PhaseTrack | None = None,
    what: str = "",
) -> tuple[Measurement, ...]:
    """Mean torque and torque ripple of one channel, in Nm: `ripple_numbers` under the names torque_*.

    `torque_rated_Nm` is the base of the numbers "of rated", which are left out without it. The other
    arguments and the errors are those of `ripple_numbers`.
    """
    return ripple_numbers(block, channel, "torque", rated=torque_rated_Nm, track=track, what=what)


def true_torque(
    transducer: Block,
    block: Block,
    *,
    estimate: Measurement | None = None,
    torque_rated_Nm: float | None = None,
    track: PhaseTrack | None = None,
) -> tuple[Measurement, ...]:
    """Mean and ripple of the torque that a transducer measured, and the error of the drive's estimate of it.

    The numbers are those of `torque_ripple` under the names true_torque_*.

    Args:
        transducer: channel torque_transducer, at any rate, covering the time of `block`.
        block: the capture, without gaps.
        estimate: `torque_mean` of `block`; torque_error is left out without it.
        torque_rated_Nm: the base of the numbers "of rated", which are left out without it.
        track: phase over the rows of `block`.

    Raises:
        AnalysisError: a gap, a time that is not covered, or a dead signal.
    """
    inside = cut_to_span(transducer, block)
    rows = None if track is None else _at_rows_of(track, inside, block)
    first = (inside.first_tick - transducer.first_tick) // transducer.stride
    what = (
        f"torque_transducer in its rows {first} to {first + len(inside.data) - 1} (from 0), those at tick x "
        f"tick_s from the capture's first row to one row past its last"
    )
    numbers = ripple_numbers(
        inside, "torque_transducer", "true_torque", rated=torque_rated_Nm, track=rows, what=what
    )
    if estimate is None:
        return numbers
    mean, uncertain = numbers[0], None
    if estimate.uncertainty is not None and mean.uncertainty is not None:
        both = math.hypot(estimate.uncertainty.standard, mean.uncertainty.standard)
        uncertain = Uncertainty(both, "those of both means, taken as independent")
    text = f"mean of the drive's estimate torque minus mean of {what}"
    error_Nm = estimate.value - mean.value
    reference = f"torque_transducer, {len(inside.data)} samples at {inside.sample_rate_Hz:g} Hz"
    basis = replace(estimate.basis, reference=reference, alignment_s=inside.alignment_s or None)
    return (*numbers, Measurement("torque_error", error_Nm, "Nm", text, basis, uncertain))


def _at_rows_of(track: PhaseTrack, fine: Block, coarse: Block) -> PhaseTrack:
    """The same phase over the rows of a block of another rate."""
    step_s, coarse_step_s = fine.stride * fine.tick_s, coarse.stride * coarse.tick_s
    offset_s = fine.first_tick * fine.tick_s - coarse.first_tick * coarse.tick_s
    row = Polynomial([offset_s / coarse_step_s, step_s / coarse_step_s])
    return PhaseTrack(track.phase(row), len(fine.data), track.source, track.residual_rad)
