"""Parameters of a drive by their names in the dictionary, in SI."""

from __future__ import annotations

import numbers
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

from benchtool.api.connection import Connection
from benchtool.api.named import Named
from benchtool.errors import ValueRefused
from benchtool.notebook import table_html

if TYPE_CHECKING:
    from benchtool.drive.parameters import Parameter
    from benchtool.protocol.dictionary import Variable

Given = float | str
"""A number in the unit of the dictionary, a name of the enumeration, or text with a unit, `123 mohm`."""


class Parameters(Named[Given]):
    """Every parameter of a drive: read when asked for, written and read back when set.

    drive.parameters["R_s"] = "123 mohm"
    drive.parameters.update({"u_s": 81.65, "law": "tpc"})     # both, or none of them
    drive.parameters.about("R_s").maximum
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __getitem__(self, name: str) -> Given:
        """Return the value of a parameter as the drive has it.

        Raises:
            ValueRefused: no such object; the message names the nearest.
            NoAnswer, SdoAbort: the drive did not answer, or refused.
        """
        from benchtool.drive.parameters import parameter

        with self._connection.use() as session:
            return plain(session.drive.read(parameter(session.drive.dictionary, name)))

    def __setitem__(self, name: str, value: Given) -> None:
        """Write a parameter and read it back.

        Raises:
            ValueRefused: no parameter, or outside its limits; nothing was sent.
            SdoAbort, WriteNotVerified: the drive refuses, or holds another value afterwards.
        """
        self.update({name: value})

    def __delitem__(self, name: str) -> None:
        raise ValueRefused(f"'{name}' is a parameter of the drive and stays: set it to another value")

    def __iter__(self) -> Iterator[str]:
        return iter(self._names())

    def update(self, values: Mapping[str, Given]) -> None:
        """Write several, each read back: all are checked before the first is sent, and all or none hold.

        Raises:
            ValueRefused: one cannot be written; nothing was sent.
            SdoAbort, WriteNotVerified, LinkError: as they come; the old values are in force again.
        """
        from benchtool.drive.parameters import write_all

        with self._connection.use() as session:
            write_all(session.drive, self._checked(values))

    @contextmanager
    def temporary(self, values: Mapping[str, Given]) -> Iterator[None]:
        """Hold other values for the length of a `with` block, and what was there before after it.

        Raises:
            ValueRefused: one cannot be written; nothing was sent.
            WriteNotVerified: a previous value could not be restored.
        """
        from benchtool.drive.parameters import held

        with self._connection.use() as session:
            checked = self._checked(values)
        with held(session.drive, checked):
            yield

    def overview(self, pattern: str = "") -> tuple[Parameter, ...]:
        """Return the parameters with value, unit, limits, default and description.

        Args:
            pattern: part of a name, or a pattern with * and ?; all without it.

        Raises:
            ValueRefused: it matches none.
        """
        from benchtool.drive.parameters import overview as found_in

        with self._connection.use() as session:
            return found_in(session.drive, pattern)

    def about(self, name: str) -> Parameter:
        """Return one parameter with value, unit, limits, default and description."""
        from benchtool.drive.parameters import Parameter, parameter

        with self._connection.use() as session:
            return Parameter.of(session.drive, parameter(session.drive.dictionary, name))

    def store(self) -> None:
        """Have the drive keep what it holds over a reset and power off.

        Raises:
            CapabilityMissing: it stores nothing.
            ValueRefused: the power stage is on.
        """
        from benchtool.drive.parameters import store

        with self._connection.use() as session:
            store(session.drive)

    def restore_defaults(self) -> None:
        """Set every parameter to its default; the drive forgets what it stored, and is reset.

        Raises:
            CapabilityMissing: it has no command for that.
            ValueRefused: the power stage is on.
        """
        from benchtool.drive.parameters import restore_defaults

        with self._connection.use() as session:
            restore_defaults(session.drive)

    def _checked(self, values: Mapping[str, Given]) -> dict[str, int | float | str | bytes]:
        """Return the values by name as `write_all` takes them."""
        from benchtool.drive.parameters import parameter

        with self._connection.use() as session:
            found: dict[str, int | float | str | bytes] = {}
            for name, value in values.items():
                variable = parameter(session.drive.dictionary, name)
                if variable.name in found:
                    raise ValueRefused(f"'{variable.name}' is given twice: give it once; nothing was sent")
                found[variable.name] = physical(variable, value)
            return found

    def _names(self) -> tuple[str, ...]:
        from benchtool.drive.parameters import parameters

        with self._connection.use() as session:
            return tuple(each.name for each in parameters(session.drive.dictionary))

    def __repr__(self) -> str:
        return "<closed>" if self._connection.closed else f"<{len(self)} parameters: {', '.join(self)}>"

    def _repr_html_(self) -> str:
        rows = [
            (each.name, f"{'*' if each.differs else ''}{each.shown}", each.unit, each.about, each.access)
            for each in self.overview()
        ]
        return table_html(
            ("parameter", ">value", "unit", "about", "access"), rows, footer="* differs from its default"
        )


def physical(variable: Variable, value: object) -> int | float | str:
    """Return a value as `Variable.encode` takes it, of a number or of text with or without a unit.

    Raises:
        ValueRefused: it is neither, or the text is no value of this variable.
    """
    from benchtool.protocol.dictionary import parse_value

    if isinstance(value, str):
        parsed = parse_value(variable, value)
        assert not isinstance(parsed, bytes)  # text does not become bytes
        return parsed
    if isinstance(value, numbers.Real):
        return int(value) if isinstance(value, numbers.Integral) else float(value)
    raise ValueRefused(
        f"{variable.name} = {value!r:.40} is of type {type(value).__name__}, a number"
        f"{f' in {variable.unit}' if variable.unit else ''} or text is expected; nothing was sent: give one"
    )


def plain(value: int | float | str | bytes) -> Given:
    """Return a value of the drive, bytes as hexadecimal digits."""
    return value.hex(" ") if isinstance(value, bytes) else value
