"""Parameters by the keys of profiles and plans, and their restoration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from benchtool.drive.remote import RemoteDrive
from benchtool.errors import BenchError
from benchtool.protocol.keys import toml_key, variable_of
from benchtool.protocol.variable import Value


def snapshot(drive: RemoteDrive) -> dict[str, int | float | str]:
    """Every readable parameter of the drive by its TOML key."""
    values = {
        toml_key(variable): drive.read(variable.name)
        for variable in drive.dictionary
        if variable.role == "parameter" and variable.readable
    }
    return {key: value for key, value in values.items() if not isinstance(value, bytes)}


@contextmanager
def temporary(drive: RemoteDrive, values: Mapping[str, Value]) -> Iterator[None]:
    """Write values by TOML key, and restore what was there on the way out.

    Raises:
        ValueRefused: a key or a value is wrong; checked for all before the first is sent.
    """
    variables = {key: variable_of(drive.dictionary, key) for key in values}
    for key, value in values.items():
        variables[key].encode(value)
    before: dict[str, Value] = {}
    try:
        for key, value in values.items():
            name = variables[key].name
            before[name] = drive.read(name)
            drive.write(name, value)
        yield
    except BaseException as error:
        try:
            _restore(drive, before)
        except BenchError as failed:
            error.add_note(f"the parameters could not be restored: {failed}")
        raise
    else:
        _restore(drive, before)


def _restore(drive: RemoteDrive, before: Mapping[str, Value]) -> None:
    """Write back what differs; one value that cannot be restored does not keep the others from it."""
    failures = []
    for name, value in reversed(list(before.items())):
        try:
            if drive.read(name) != value:
                drive.write(name, value)
        except BenchError as failed:
            failures.append(failed)
    if failures:
        raise failures[0]
