"""What a drive measures and estimates, read when asked for."""

from __future__ import annotations

from collections.abc import Iterator

from benchtool.api.connection import Connection
from benchtool.api.named import Named
from benchtool.errors import ValueRefused
from benchtool.notebook import table_html


class Values(Named[float]):
    """Signals of a drive by name, in SI; each is asked for on its own, so that several are not of one moment.

    A capture or a stream has its channels of one tick.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __getitem__(self, name: str) -> float:
        """Return the number of a signal now.

        Raises:
            ValueRefused: no such signal, or it is not a number; the message names the nearest.
            NoAnswer, SdoAbort: the drive did not answer, or refused.
        """
        with self._connection.use() as session:
            variable = session.drive.dictionary[name]
            if not variable.readable or variable.type.numpy is None:
                raise ValueRefused(f"'{name}' is not a number that can be read: choose a signal")
            return float(session.drive.number(name))

    def read(self, *names: str) -> dict[str, float]:
        """Read several signals, one after the other; all without a name."""
        return {name: self[name] for name in names or tuple(self)}

    def unit(self, name: str) -> str:
        """Return the unit of a signal."""
        with self._connection.use() as session:
            return session.drive.dictionary[name].unit

    def __iter__(self) -> Iterator[str]:
        with self._connection.use() as session:
            found = [each for each in session.drive.dictionary if each.role == "signal" and each.readable]
            return iter([each.name for each in found if each.type.numpy is not None])

    def __repr__(self) -> str:
        return "<closed>" if self._connection.closed else f"<{len(self)} signals: {', '.join(self)}>"

    def _repr_html_(self) -> str:
        rows = [(name, f"{value:.6g}", self.unit(name)) for name, value in self.read().items()]
        return table_html(("signal", ">value", "unit"), rows)
