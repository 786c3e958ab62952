"""What loads the shaft of a bench: its load machine, or a person."""

from __future__ import annotations

import math
from collections.abc import Callable

from benchtool.api.connection import Connection
from benchtool.errors import UsageError, ValueRefused

Ask = Callable[[str], object]
"""Told what a person has to do at the bench; returns once it is done."""


class Load:
    """The load of the shaft; it is taken off when the bench is closed.

    Of a bench without a load machine, what is to be done is asked of the person that `open_bench(ask=...)`
    names; without one it is refused.
    """

    def __init__(self, connection: Connection, ask: Ask | None) -> None:
        self._connection = connection
        self._ask = ask

    def torque(self, torque_Nm: float) -> None:
        """Load the shaft; positive torque opposes positive speed.

        Raises:
            ValueRefused: no finite number.
            UsageError: there is no load machine, and no person to be asked.
        """
        _require_finite(torque_Nm, "Nm")
        with self._connection.use() as session:
            if session.load is not None:
                session.load.apply(float(torque_Nm))
                return
        side = "against" if torque_Nm > 0.0 else "towards"
        self._request(f"load the shaft with {abs(torque_Nm):g} Nm {side} positive rotation")

    def hold(self, omega_m_rad_s: float) -> None:
        """Hold the shaft at this speed at any torque.

        Raises:
            ValueRefused: no finite number.
            UsageError: there is no load machine, and no person to be asked.
        """
        _require_finite(omega_m_rad_s, "rad/s")
        with self._connection.use() as session:
            if session.load is not None:
                session.load.hold(float(omega_m_rad_s))
                return
        self._request(f"turn the shaft at {omega_m_rad_s:g} rad/s")

    def free(self) -> None:
        """Take the load off: the shaft turns as it likes.

        Raises:
            UsageError: there is no load machine, and no person to be asked.
        """
        with self._connection.use() as session:
            if session.load is not None:
                session.load.apply(0.0)
                return
        self._request("free the shaft")

    def _request(self, what: str) -> None:
        if self._ask is None:
            raise UsageError(
                f"this bench has no load machine, a person has to {what}: do so by hand, or have "
                f"benchtool.open_bench(..., ask=input) ask for it"
            )
        self._ask(f"Please {what}, then go on. ")


def _require_finite(value: float, unit: str) -> None:
    if not (isinstance(value, int | float) and math.isfinite(value)):
        raise ValueRefused(f"a load of {value!r} {unit}, a finite number is expected; nothing was changed")
