"""Rows at which an angle stood still though the rotor turned, as of an encoder or a link that was lost."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.validity import held_stretch

Floats = NDArray[np.float64]

_MOST = 64  # stretches
_LONGER = 4.0  # times as long as the rotor usually takes from move to move
_NEAR = 8  # moves to either side, by which the speed there is told
_JUMPS = 4.0  # moves: the angle goes on elsewhere
_TURNS = 0.5  # of the mean speed: a rotor that comes to rest is slower in its last rows, one that starts too


def held_angle(angle_rad: Floats) -> NDArray[np.bool_]:
    """Return which rows of an angle without jumps, shape (n,), are alike though the rotor turned.

    The first of them may be right, or be what the sensor reads when it is lost, and is one of them.
    A rotor that rests comes to it slowly, and leaves it slowly: these rows are set aside. An angle that was
    lost stands still at full speed, or goes on where the rotor is by then.
    """
    held = np.zeros(len(angle_rad), dtype=np.bool_)
    rows = np.flatnonzero(~_at_rest(angle_rad))
    above_zero = angle_rad - np.min(angle_rad) + 1.0  # at which a signal may rest, and no angle
    for _ in range(_MOST):
        stretch = held_stretch(above_zero[rows])
        if stretch is None:
            break
        held[rows[stretch]] = True
        rows = np.delete(rows, stretch)
    return held


def _at_rest(angle_rad: Floats) -> NDArray[np.bool_]:
    """Return which rows of an angle, shape (n,), repeat the one before in the longest stretches in which the
    rotor rested."""
    steps, rest = np.diff(angle_rad), np.zeros(len(angle_rad), dtype=np.bool_)
    moves = np.flatnonzero(steps)
    if not len(moves):
        return rest
    edges = np.concatenate([[-1], moves, [len(steps)]])
    lengths = np.diff(edges) - 1  # changes of zero before each move, and behind the last
    longest = np.argsort(lengths)[::-1][:_MOST]
    # an angle of few counts repeats rows between all of its moves
    longest = longest[lengths[longest] > _LONGER * (float(np.median(lengths)) + 1.0)]
    moving = len(steps) - int(np.sum(lengths[longest])) or 1
    usual = float(np.sum(np.abs(steps))) / moving
    for place in longest:
        if not _turned(steps, moves, int(place), usual):
            rest[edges[place] + 2 : edges[place + 1] + 1] = True
    return rest


def _turned(steps: Floats, moves: NDArray[np.intp], place: int, usual: float) -> bool:
    """Return whether the rotor turned before move number `place`, while its angle stood still: as fast as
    usual on either side, or the move is a jump."""
    before, after = moves[max(0, place - _NEAR) : place], moves[place + 1 : place + 1 + _NEAR]
    sides = []
    if len(before):
        sides.append((np.abs(steps[before]), int(before[-1] - before[0]) + 1))
    if len(after):
        sides.append((np.abs(steps[after]), int(after[-1] - moves[place])))
    if any(float(np.sum(sizes)) > _TURNS * usual * rows for sizes, rows in sides):
        return True
    most = max((float(np.median(sizes)) for sizes, _ in sides), default=np.inf)
    return place < len(moves) and abs(float(steps[moves[place]])) > _JUMPS * most
