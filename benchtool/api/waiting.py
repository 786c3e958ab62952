"""Waiting in the time of a bench, in which other threads may use it."""

from __future__ import annotations

import math

from benchtool.api.connection import Connection
from benchtool.errors import ValueRefused

_SLICE_S = 0.05
_ROUNDING_S = 1e-9


def wait(connection: Connection, duration_s: float) -> None:
    """See `Bench.wait`."""
    if not (isinstance(duration_s, int | float) and 0.0 <= duration_s < math.inf):
        raise ValueRefused(f"a wait of {duration_s!r} s, a number of seconds from 0 on is expected")
    with connection.use() as session:
        clock = session.clock
    end_s = clock.now_s() + duration_s
    while (left_s := end_s - clock.now_s()) > _ROUNDING_S:
        slice_s = min(_SLICE_S, left_s)
        if clock.virtual:
            with connection.use() as session:  # time passes by one thread's computing it
                session.drive.wait(slice_s)
        else:
            clock.wait(slice_s)
            with connection.use() as session:
                session.drive.wait(0.0)
                session.drive.raise_emergencies()
