"""The incremental encoder: angle of its disc, edges, and the counter that the drive reads.

The disc's angle is `turn` times the shaft's, plus `zero`. Its lines may be eccentric to its axis; then the
position that they show is ahead of the disc by

    A_1 sin(angle + phi_1) + A_2 sin(2 angle + phi_2)

A counter that starts at power-up counts from zero wherever the disc is, until the index pulse sets it to
zero at the disc's own. A count that is lost stays lost until then.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.jit import njit


class Eccentricity(NamedTuple):
    """Amplitudes in rad and phases of the position's error, once and twice in a revolution."""

    once: float
    once_phase: float
    twice: float
    twice_phase: float


class Counter(NamedTuple):
    """How the drive counts edges.

    `relative`: from zero at power-up. `has_index`: it is set to zero by an index pulse. Of every `lost_every`
    edges one is not counted; 0: none.
    """

    relative: bool
    has_index: bool
    lost_every: int


class Encoder(NamedTuple):
    """Edges per revolution, negative where the encoder counts backwards, and the disc's angle."""

    edges: int
    turn: float
    zero: float
    eccentricity: Eccentricity | None
    counter: Counter | None


@njit
def encoder_count(theta_m: float, encoder: Encoder, sensor: Any) -> int:
    """Return the count that the drive reads, 0 to edges per revolution less 1.

    That of ideal lines is floor(angle edges / 2 pi) modulo these. `sensor` keeps the state of the counter.
    """
    angle = shown(encoder.eccentricity, theta_m * encoder.turn + encoder.zero)
    counts = abs(encoder.edges)
    count = math.floor(angle * encoder.edges / (2.0 * math.pi))
    count = counted(encoder.counter, count, counts, sensor)
    return int(count - math.floor(count / counts) * counts)


@njit
def found(counter: Counter | None, sensor: Any) -> int:
    """Return by how much the first index since power-up has just moved the counter, in counts, once."""
    if counter is None:
        return 0
    counts = int(sensor.found)
    sensor.found = 0
    return counts


@njit
def shown(eccentricity: Eccentricity | None, angle: float) -> float:
    """Return the position that the lines of a disc at this angle show."""
    if eccentricity is None:
        return angle
    once = eccentricity.once * math.sin(angle + eccentricity.once_phase)
    return angle + once + eccentricity.twice * math.sin(2.0 * angle + eccentricity.twice_phase)


@njit
def counted(counter: Counter | None, edge: int, counts: int, sensor: Any) -> int:
    """Return the position of the drive's counter when the disc is past its edge number `edge`, which counts
    on over the revolutions."""
    if counter is None:
        return edge
    if sensor.counting == 0:
        sensor.counting, sensor.edge = 1, edge
        sensor.error = -edge if counter.relative else 0
    moved = edge - sensor.edge
    turn, turn_before = math.floor(edge / counts), math.floor(sensor.edge / counts)
    since = abs(moved)  # edges that an error may come from
    if counter.has_index and turn != turn_before:
        sensor.found = -sensor.error if sensor.index_passed == 0 else 0
        sensor.error, sensor.index_passed = 0, 1
        since = edge - turn * counts if moved > 0 else (turn + 1) * counts - 1 - edge
    travelled = sensor.travelled + abs(moved)
    if counter.lost_every > 0:
        lost = travelled // counter.lost_every - (travelled - since) // counter.lost_every
        sensor.error += -lost if moved > 0 else lost
    sensor.edge, sensor.travelled = edge, travelled
    position: int = edge + sensor.error
    return position
