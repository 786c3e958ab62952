"""Quantities of a drive on one line that renews itself."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress

from benchtool.api.connection import Connection
from benchtool.api.values import Values
from benchtool.api.waiting import wait
from benchtool.errors import ValueRefused

_DEFAULT = ("omega_m", "torque", "i_q")
_ROUNDING_S = 1e-9


def watch(connection: Connection, names: Sequence[str], duration_s: float, period_s: float) -> None:
    """See `Drive.watch`."""
    if not (period_s > 0.0 and duration_s >= 0.0):
        raise ValueRefused(
            f"every {period_s:g} s for {duration_s:g} s: a period above 0 and a duration are expected"
        )
    values = Values(connection)
    chosen = names or tuple(name for name in _DEFAULT if name in values)
    with connection.use() as session:
        clock = session.clock
    start_s, shown = clock.now_s(), 0
    with suppress(KeyboardInterrupt):
        while True:
            now_s = clock.now_s() - start_s
            numbers = [f"{name} {values[name]:.5g} {values.unit(name)}".rstrip() for name in chosen]
            line = f"{now_s:8.2f} s   {'   '.join(numbers)}"
            sys.stdout.write("\r" + line.ljust(shown))
            sys.stdout.flush()
            shown = len(line)
            if (left_s := duration_s - now_s) <= _ROUNDING_S:
                break
            wait(connection, min(period_s, left_s))
    sys.stdout.write("\n")
