"""Parameters of a drive: checked as a whole, written all or none.

A parameter is an object whose `role` is parameter: what `store_parameters` keeps. Writes go to the drive's
working memory. They are undone on any failure that leaves this process alive; a process that is killed half
way leaves a mixture, which a reset of the drive replaces by what was last stored.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial

from benchtool.drive.remote import RemoteDrive
from benchtool.errors import BenchError, LinkError, ValueRefused, WriteNotVerified, of_each
from benchtool.protocol import State
from benchtool.protocol.dictionary import (
    Dictionary,
    Relation,
    Value,
    Variable,
    relations,
    toml_key,
    variable_of,
)


def parameters(dictionary: Dictionary) -> tuple[Variable, ...]:
    """Return every parameter, in the order of the dictionary.

    Raises:
        ValueRefused: the EDS does not say which of its objects are parameters.
    """
    found = tuple(variable for variable in dictionary if variable.role == "parameter")
    if not found:
        raise ValueRefused(
            f"{dictionary.source} names no parameters; benchtool expects 'Role=parameter' with each of them, "
            f"in the object's section or in [Comments]: add it"
        )
    return found


def named(dictionary: Dictionary, name: str) -> Variable:
    """Return the variable of a name, a TOML key or an index such as `0x2000:2`.

    Raises:
        ValueRefused: there is none.
    """
    by_key = next((variable for variable in dictionary if toml_key(variable) == name), None)
    return by_key or dictionary[name]


def readable(dictionary: Dictionary, name: str) -> Variable:
    """As `named`, for objects that can be read.

    Raises:
        ValueRefused: there is none, or it is write-only.
    """
    variable = named(dictionary, name)
    if not variable.readable:
        raise ValueRefused(f"'{variable.name}' is write-only: it cannot be read")
    return variable


def parameter(dictionary: Dictionary, name: str) -> Variable:
    """As `named`, for parameters only.

    Raises:
        ValueRefused: there is none, or the object is no parameter.
    """
    variable = named(dictionary, name)
    if variable.role != "parameter":
        raise ValueRefused(
            f"'{variable.name}' ({variable.label}) is a {variable.role}, a parameter is expected: "
            f"see benchtool params list"
        )
    return variable


def default_of(variable: Variable) -> Value | None:
    """Return the default as the drive would hold it; None without one."""
    try:
        return None if variable.default is None else variable.decode(variable.encode(variable.default))
    except ValueRefused:
        return variable.default


def snapshot(drive: RemoteDrive) -> dict[str, int | float | str]:
    """Return every readable parameter of the drive by its TOML key."""
    values = {
        toml_key(variable): drive.read(variable.name)
        for variable in drive.dictionary
        if variable.role == "parameter" and variable.readable
    }
    return {key: value for key, value in values.items() if not isinstance(value, bytes)}


# ---- writing -----------------------------------------------------------------------------------------------


def require_settable(drive: RemoteDrive, values: Mapping[str, Value]) -> None:
    """Check that every value, by name, can be written now: access, limits and the state of the drive.

    Raises:
        ValueRefused: one cannot; nothing was sent.
    """
    variables = of_each(partial(_settable, drive.dictionary), values.items())
    _require_consistent(drive, values)
    locked = [variable.name for variable in variables if not variable.enabled_write]
    if locked:
        require_disabled(drive, f"{', '.join(locked)} can be set")


def _settable(dictionary: Dictionary, assigned: tuple[str, Value]) -> Variable:
    """Return the parameter of that name, which can have this value.

    Raises:
        ValueRefused: it cannot.
    """
    name, value = assigned
    variable = parameter(dictionary, name)
    if not (variable.writable and variable.readable):
        raise ValueRefused(
            f"'{variable.name}' has access '{variable.access}', 'rw' is expected: it cannot be set; "
            f"nothing was sent"
        )
    variable.encode(value)
    return variable


def _related(drive: RemoteDrive, values: Mapping[str, Value]) -> list[Relation]:
    """Return the relations that these values, by name, are part of."""
    return [
        each for each in relations(drive.dictionary) if each.lower.name in values or each.upper.name in values
    ]


def _require_consistent(drive: RemoteDrive, values: Mapping[str, Value]) -> None:
    """Check values against those of the drive that limit them, or that they limit.

    Raises:
        ValueRefused: one is beyond another; nothing was sent.
    """
    for relation in _related(drive, values):
        pair = {
            variable.name: variable.decode(variable.encode(values[variable.name]))
            if variable.name in values
            else drive.read(variable.name)
            for variable in (relation.lower, relation.upper)
        }
        if breach := relation.breach(pair):
            raise ValueRefused(f"{breach}; nothing was sent")


def require_disabled(drive: RemoteDrive, purpose: str) -> None:
    """Check that the power stage is off.

    Raises:
        ValueRefused: it is on, or its state is not one of CiA 402.
    """
    state = drive.state()
    if state.power_stage_on or state is State.UNKNOWN:
        raise ValueRefused(
            f"the drive is in '{state.value}', {purpose} with the power stage off only: disable it first; "
            f"nothing was sent"
        )


def write_all(drive: RemoteDrive, values: Mapping[str, Value]) -> dict[str, Value]:
    """Write values by name, each read back, all or none; return the previous values by name.

    Values are checked first (`require_settable`). On any failure, also Ctrl-C, the old values are written
    back and a note of the exception says whether they are in force.

    Raises:
        ValueRefused: a value cannot be written now; nothing was sent.
        SdoAbort, WriteNotVerified, LinkError: as `RemoteDrive.write`.
    """
    require_settable(drive, values)
    before: dict[str, Value] = {}
    try:
        _write(drive, values, before)
    except BaseException as error:
        try:
            _restore(drive, before)
        except BenchError as failed:
            error.add_note(str(failed))
        else:
            error.add_note("the old values are in force again")
        raise
    return before


@contextmanager
def temporary(drive: RemoteDrive, values: Mapping[str, Value]) -> Iterator[None]:
    """Write values by TOML key for the length of a `with` block, and restore the previous ones on exit.

    Raises:
        ValueRefused: a key or a value is wrong; checked for all before the first is sent.
        WriteNotVerified: a previous value could not be restored.
    """
    by_name: dict[str, Value] = {}
    for key, value in values.items():
        variable = variable_of(drive.dictionary, key)
        variable.encode(value)
        by_name[variable.name] = value
    _require_consistent(drive, by_name)
    with _restored(drive, by_name):
        yield


@contextmanager
def held(drive: RemoteDrive, values: Mapping[str, Value]) -> Iterator[None]:
    """As `temporary`, of values by name.

    Raises:
        ValueRefused: as `require_settable`; nothing was sent.
        WriteNotVerified: a previous value could not be restored.
    """
    require_settable(drive, values)
    with _restored(drive, values):
        yield


@contextmanager
def _restored(drive: RemoteDrive, values: Mapping[str, Value]) -> Iterator[None]:
    before: dict[str, Value] = {}
    try:
        _write(drive, values, before)
        yield
    except BaseException as error:
        try:
            _restore(drive, before)
        except BenchError as failed:
            error.add_note(str(failed))
        raise
    else:
        _restore(drive, before)


def _write(drive: RemoteDrive, values: Mapping[str, Value], before: dict[str, Value]) -> None:
    """Write in order; `before` takes each old value ahead of its write.

    Of two values of which one limits the other, the write that widens the limit comes first.
    """
    order = list(values)
    for relation in _related(drive, values):
        lower, upper = relation.lower, relation.upper
        if lower.name in values and upper.name in values:
            room = drive.number(upper.name) < float(upper.decode(upper.encode(values[upper.name])))
            first, second = (upper.name, lower.name) if room else (lower.name, upper.name)
            order.remove(first)
            order.insert(order.index(second), first)
    for name in order:
        before[name] = drive.read(name)
        drive.write(name, values[name])


def _restore(drive: RemoteDrive, before: Mapping[str, Value]) -> None:
    """Write back what differs, newest first; one that fails does not keep the others from being restored."""
    lost: list[str] = []
    reasons: list[BenchError] = []
    for name, value in reversed(list(before.items())):
        if reasons and isinstance(reasons[-1], LinkError):
            lost.append(name)  # no answer: avoid one timeout per parameter
            continue
        try:
            # A write that the drive refused needs no undoing, and would be refused again.
            if drive.read(name) != value:
                drive.write(name, value)
        except BenchError as reason:
            lost.append(name)
            reasons.append(reason)
    if reasons:
        raise WriteNotVerified(
            f"the old value of {', '.join(f'{name} ({before[name]!r})' for name in lost)} could not be "
            f"restored ({reasons[0]}): set it by hand, or reset the drive to what it has stored"
        )
