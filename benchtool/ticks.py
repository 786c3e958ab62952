"""The drive's ticks: on the wire they are counted modulo 2**32, which a drive at 10 kHz reaches after 119 h.

Here alone is known what follows from that. On the wire, in headers and in the dictionary a tick has 32 bits;
in Blocks, marks and events it is counted on, so that ticks of one session can be compared and subtracted.
Sequence numbers and the counters of the dictionary have 32 bits as well, and wrap in the same way.
"""

from __future__ import annotations

TICKS = 1 << 32
"""How many ticks, or counts, the wire can tell apart."""


def on_wire(tick: int) -> int:
    """A tick or a count as the wire has it."""
    return tick % TICKS


def ahead(later: int, earlier: int) -> int:
    """Ticks from `earlier` on to `later`, 0 to 2**32 - 1; either may be wrapped or counted on."""
    return (later - earlier) % TICKS


def follows(later: int, earlier: int) -> bool:
    """Whether `later` is the newer of two counts that lie less than 2**31 apart."""
    return 0 < ahead(later, earlier) < TICKS // 2


def apart(one: int, other: int) -> int:
    """Ticks between two that may be in either order, 0 to 2**31."""
    return min(ahead(one, other), ahead(other, one))


def counted_on(tick: int, near: int | None) -> int:
    """The count nearest to `near` that the wire has as `tick`, and not below 0; without one `tick` itself."""
    if near is None:
        return tick
    forward = ahead(tick, near)
    nearest = near + (forward if forward < TICKS // 2 else forward - TICKS)
    return nearest if nearest >= 0 else tick
