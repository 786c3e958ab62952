"""The drive's ticks: on the wire they are counted modulo 2**32, which a drive at 10 kHz reaches after 119 h.

Here alone is known what follows from that. On the wire, in headers and in the dictionary a tick has 32 bits;
in Blocks, marks and events it is counted on, so that ticks of one session can be compared and subtracted.
"""

from __future__ import annotations

TICKS = 1 << 32
"""How many ticks the wire can tell apart."""


def on_wire(tick: int) -> int:
    """A tick as the wire has it."""
    return tick % TICKS


def ahead(later: int, earlier: int) -> int:
    """Ticks from `earlier` on to `later`, 0 to 2**32 - 1; either may be wrapped or counted on."""
    return (later - earlier) % TICKS


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
