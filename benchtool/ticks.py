"""The drive's ticks: on the wire they are counted modulo 2**32, which a drive at 10 kHz reaches after 119 h.

Only this module handles the wrap. On the wire, in headers and in the dictionary a tick has 32 bits; in
Blocks, anchors and events it is unwrapped, so that ticks of one session can be compared and subtracted.
Sequence numbers and the counters of the dictionary have 32 bits as well, and wrap in the same way.
"""

from __future__ import annotations

TICKS = 1 << 32
"""Number of ticks, or counts, before the wire wraps."""


def wrap_tick(tick: int) -> int:
    """Return a tick or a count modulo 2**32, as on the wire."""
    return tick % TICKS


def ticks_since(later: int, earlier: int) -> int:
    """Return the ticks from `earlier` on to `later`, 0 to 2**32 - 1; either may be wrapped or unwrapped."""
    return (later - earlier) % TICKS


def is_newer(later: int, earlier: int) -> bool:
    """Return whether `later` is the newer of two counts that lie less than 2**31 apart."""
    return 0 < ticks_since(later, earlier) < TICKS // 2


def ticks_between(one: int, other: int) -> int:
    """Return the ticks between two that may be in either order, 0 to 2**31."""
    return min(ticks_since(one, other), ticks_since(other, one))


def unwrap_tick(tick: int, near: int | None) -> int:
    """Return count nearest to `near`, not below 0, that wraps to `tick`; without `near`, `tick` itself."""
    if near is None:
        return tick
    forward = ticks_since(tick, near)
    nearest = near + (forward if forward < TICKS // 2 else forward - TICKS)
    return nearest if nearest >= 0 else tick
