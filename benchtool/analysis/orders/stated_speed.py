"""The speed that was stated for a record, held against the lines of a signal that repeat with the rotor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchtool.analysis.lines.lines import sinusoids_of
from benchtool.analysis.lines.steadiness import Line
from benchtool.block import Block
from benchtool.errors import AnalysisError

_MOST_SLIP = 0.01  # of the stated speed
_NEAREST = 0.25  # of an order: a line further away belongs to none
_WITHIN = 0.5  # bins: nearer than that a line cannot be told from one at an order
_CLEARLY = 3.0  # standard uncertainties
_ALIKE = 0.05  # bins: 0.4 % of an amplitude


@dataclass(frozen=True)
class ConstantSpeed:
    """A constant mechanical speed and its standard uncertainty, rad/s; 0 where no line tells it."""

    omega_m_rad_s: float
    standard_rad_s: float


@dataclass(frozen=True)
class _Slip:
    """Share by which the rotor turned faster than stated, with its standard uncertainty."""

    share: float
    standard: float


def speed_of_record(block: Block, channel: str, omega_m_rad_s: float) -> ConstantSpeed:
    """Return the speed at which the rotor turned by the lines of a channel, where it was stated.

    Lines within 1 % of multiples of the stated speed are orders, or there by chance. The speed of the record
    is the one at which most of them are orders. It is taken in place of the stated one where it moves the
    largest of them by less than half a bin.

    Raises:
        AnalysisError: the speed of the record is another, or the largest of the lines is not steady.
    """
    samples = np.ascontiguousarray(block.column(channel))
    duration_s = len(samples) / block.sample_rate_Hz
    stated = abs(omega_m_rad_s)
    turns = stated * duration_s / (2.0 * math.pi)
    near = [each for each in sinusoids_of(samples) if _is_near(each.place / turns)]
    if not near:
        return ConstantSpeed(omega_m_rad_s, 0.0)
    if not _is_steady(near[0]):
        raise AnalysisError(
            f"{_at(near[0], turns, duration_s, stated)} is not steady: nor may the speed be; record an angle"
        )
    lines = [each for each in near if _is_steady(each)]
    slips = [_Slip(0.0, 0.0), *(_slip(each, turns) for each in lines)]
    explained = max((_explained(lines, each, turns) for each in slips), key=_weight)
    found, largest = _mean([_slip(each, turns) for each in explained]), explained[0]
    order = round(largest.place / turns)
    if abs(found.share) * order * turns > _WITHIN:
        raise AnalysisError(
            f"{_at(largest, turns, duration_s, stated)} would be order {order} of "
            f"{stated * (1.0 + found.share):.6g} rad/s: state the speed of the record, or record an angle"
        )
    share = found.share if abs(found.share) > _CLEARLY * found.standard else 0.0
    return ConstantSpeed(omega_m_rad_s * (1.0 + share), stated * found.standard)


def _is_near(order: float) -> bool:
    return abs(order - round(order)) <= min(_NEAREST, _MOST_SLIP * round(order))


def _is_steady(line: Line) -> bool:
    return math.isfinite(line.of_place) and not line.width


def _at(line: Line, turns: float, duration_s: float, stated_rad_s: float) -> str:
    return (
        f"the line at {line.place / duration_s:.6g} Hz, order {line.place / turns:.5g} of the stated "
        f"{stated_rad_s:.6g} rad/s,"
    )


def _slip(line: Line, turns: float) -> _Slip:
    """Return the slip at which a line is the order that it is nearest to."""
    place = round(line.place / turns) * turns
    return _Slip(line.place / place - 1.0, line.of_place / place)


def _explained(lines: Sequence[Line], slip: _Slip, turns: float) -> list[Line]:
    """Return the lines that are orders at a slip, within what is known of both."""

    def off(line: Line) -> bool:
        place = round(line.place / turns) * turns
        unknown = math.hypot(line.of_place, slip.standard * place)
        return abs(line.place - (1.0 + slip.share) * place) > _ALIKE + _CLEARLY * unknown

    return [each for each in lines if not off(each)]


def _weight(lines: Sequence[Line]) -> tuple[int, float]:
    """Return how much lines count: their number, then their power."""
    return len(lines), sum(each.amplitude**2 for each in lines)


def _mean(slips: Sequence[_Slip]) -> _Slip:
    """Return the weighted mean, with the larger of the uncertainties by the parts and by their scatter."""
    share = np.array([each.share for each in slips])
    weight = np.array([each.standard**-2.0 for each in slips])
    mean = float(np.average(share, weights=weight))
    excess = float(np.sum(weight * (share - mean) ** 2)) / max(1, len(slips) - 1)
    return _Slip(mean, math.sqrt(max(1.0, excess) / float(np.sum(weight))))
