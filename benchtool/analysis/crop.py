"""Crop one block to the time span of another."""

from __future__ import annotations

import math
from dataclasses import replace

from benchtool.block import Block
from benchtool.errors import AnalysisError


def crop_to(block: Block, reference: Block) -> Block:
    """Return the rows of `block` inside the span of `reference`: from its first row to one row past its last.

    Both count ticks from the same origin, each in its own `tick_s` (a 200 kHz transducer beside a 10 kHz
    capture), so a row stands at `tick * tick_s`. An end may be missing up to one row of the reference.
    The data are a view, not a copy.

    Raises:
        AnalysisError: a gap in either, or `block` does not cover the span.
    """
    block.require_uniform()
    reference.require_uniform()
    step_s, reference_step_s = block.stride * block.tick_s, reference.stride * reference.tick_s
    begin_s = reference.first_tick * reference.tick_s - block.first_tick * block.tick_s
    end_s = begin_s + len(reference.data) * reference_step_s
    duration_s = len(block.data) * step_s
    if begin_s < -1.001 * reference_step_s or end_s > duration_s + 1.001 * reference_step_s:
        raise AnalysisError(
            f"'{block.names[0]}' covers {-begin_s:.6g} s to {duration_s - begin_s:.6g} s of the capture's "
            f"time, 0 s to {end_s - begin_s:.6g} s is needed: record it during the whole capture"
        )
    # ticks are integers: the small share of a step only takes up the rounding of tick * tick_s
    first = max(0, math.ceil(begin_s / step_s - 1e-3))
    last = min(len(block.data), math.ceil(end_s / step_s - 1e-3))
    return replace(block, first_tick=block.first_tick + first * block.stride, data=block.data[first:last])
