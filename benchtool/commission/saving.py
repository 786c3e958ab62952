"""Parameters of a commissioning on the drive: tried while its host is there, kept all at once or not at all.

A drive keeps its parameters by one command (CiA 301, object 0x1010), so that what it has stored is old until
that command and new after it. What is in force meanwhile is a trial (object `parameter_trial`): should the
host die, the drive switches off by its link supervision, and has in force what it has stored.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Final

from benchtool.drive import Capability, RemoteDrive
from benchtool.drive.parameters import parameters, reset, snapshot, store, write_all
from benchtool.errors import BenchError, WriteNotVerified
from benchtool.protocol.dictionary import Value, toml_key

_TRIAL: Final = "parameter_trial"
_HEARD_S: Final = 0.05
_LONGEST_S: Final = 1.0


@contextmanager
def trial(drive: RemoteDrive) -> Iterator[None]:
    """Have the drive put in force what it has stored, should this host die within the `with` block.

    A drive without that object is left as it is: killed, its host leaves there what it tried, until a reset.

    Raises:
        SdoAbort: the drive does not hear its host, or refused.
    """
    if _TRIAL not in drive.dictionary:
        yield
        return
    waited_s = 0.0
    while drive.read("link_state") != "alive" and waited_s < _LONGEST_S:
        drive.clock.wait(_HEARD_S)
        waited_s += _HEARD_S
    drive.write(_TRIAL, "on")
    try:
        yield
    except BaseException:
        with suppress(BenchError):  # the failure that is under way is the one to report
            drive.write(_TRIAL, "off")
        raise
    drive.write(_TRIAL, "off")


@contextmanager
def through_a_loss(drive: RemoteDrive) -> Iterator[None]:
    """Have the drive hold after the `with` block what it holds now, though it loses its host within, which
    ends a trial.

    Raises:
        SdoAbort, WriteNotVerified: it does not take a value again.
    """
    if _TRIAL not in drive.dictionary or drive.read(_TRIAL) != "on":
        yield
        return
    settable = [each.name for each in parameters(drive.dictionary) if each.writable and each.readable]
    values = {name: drive.read(name) for name in settable}
    try:
        yield
    finally:
        drive.write(_TRIAL, "on")
        write_all(drive, {name: value for name, value in values.items() if drive.read(name) != value})


def save(drive: RemoteDrive, values: Mapping[str, Value]) -> None:
    """Write values by name, read each back, store them by one command, and read all back after a reset.

    On any failure before the drive has stored them the old values are in force again. After this the drive
    has been reset: it is not supervised, and has to be connected again before it is enabled.

    Raises:
        CapabilityMissing, ValueRefused, SdoAbort: the drive cannot store, or refused: it keeps what it had.
        WriteNotVerified: what is in force after the reset is not what was stored.
        LinkError: it does not answer; what it has stored is old or new, all of it.
    """
    drive.capabilities.require(Capability.STORAGE, purpose="keeping the parameters of a commissioning")
    with trial(drive):
        before = write_all(drive, values)
        try:
            store(drive)
        except BaseException as failure:
            try:
                write_all(drive, before)
            except BenchError as lost:
                failure.add_note(str(lost))
            raise
        expected = snapshot(drive)
    reset(drive)
    kept = snapshot(drive)
    others = [key for key, value in expected.items() if kept[key] != value]
    if others:
        raise WriteNotVerified(
            f"after a reset {', '.join(others)} are not what was stored: the drive does not keep them, or "
            f"another master wrote; commission it again, or look at its memory"
        )


def settings_by_key(drive: RemoteDrive, values: Mapping[str, Value]) -> dict[str, Value]:
    """Return values by the keys of a profile."""
    return {toml_key(drive.dictionary[name]): value for name, value in values.items()}
