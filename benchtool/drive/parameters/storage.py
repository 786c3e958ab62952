"""Persistent parameters: storing on command, and restoring defaults."""

from __future__ import annotations

from benchtool.drive.capabilities import Capability
from benchtool.drive.parameters.transaction import default_of, parameters, require_disabled
from benchtool.drive.remote import RemoteDrive
from benchtool.errors import CapabilityMissing, NoAnswer, WriteNotVerified
from benchtool.protocol.canopen import NmtCommand
from benchtool.protocol.dictionary import Role, Value, Variable

_SAVE = b"save"
_LOAD = b"load"
_ON_COMMAND = 1
_BOOT_S = 3.0
_POLL_S = 0.005


def store(drive: RemoteDrive) -> None:
    """Store the parameters, so that they survive a reset (CiA 301, object 0x1010).

    Raises:
        CapabilityMissing: the dictionary has no such object.
        ValueRefused: the power stage is on.
        WriteNotVerified: the drive does not store on command.
        SdoAbort: the drive refused.
    """
    drive.capabilities.require(Capability.STORAGE, purpose="storing parameters")
    require_disabled(drive, "parameters are stored")
    _sign(drive, Role.STORE_PARAMETERS, _SAVE, "stores parameters")


def restore_defaults(drive: RemoteDrive) -> dict[str, Value]:
    """Restore the defaults (CiA 301, object 0x1011), and reset the drive, after which they are in force.

    Returns:
        Every parameter that has a default, as the drive read back after the reset.

    Raises:
        CapabilityMissing: the dictionary has no such object.
        ValueRefused: the power stage is on.
        WriteNotVerified: the drive does not restore on command, or another value than a default is in force.
        NoAnswer: it did not come back from the reset.
        SdoAbort: the drive refused.
    """
    if Role.RESTORE_DEFAULT_PARAMETERS not in drive.dictionary:
        raise CapabilityMissing(
            f"the defaults cannot be restored on command: {drive.dictionary.source} has not "
            f"{Role.RESTORE_DEFAULT_PARAMETERS.label}; set the parameters one by one; nothing was sent"
        )
    require_disabled(drive, "defaults are restored")
    _sign(drive, Role.RESTORE_DEFAULT_PARAMETERS, _LOAD, "restores defaults")
    reset(drive)
    known = [each for each in parameters(drive.dictionary) if each.default is not None and each.readable]
    values = {variable.name: drive.read(variable.name) for variable in known}
    others = [each.name for each in known if values[each.name] not in (default_of(each), _cut(drive, each))]
    if others:
        raise WriteNotVerified(
            f"after the reset {', '.join(others)} differ from their defaults in {drive.dictionary.source}: "
            f"check the EDS against the drive's firmware"
        )
    return values


def _cut(drive: RemoteDrive, variable: Variable) -> Value | None:
    """Return the default, cut or raised to what the variables that limit it allow; None where none does."""
    default = default_of(variable)
    if not isinstance(default, int | float):
        return None
    cut: float = default
    if variable.min_entry in drive.dictionary:
        cut = max(cut, variable.min_times * drive.number(variable.min_entry))
    if variable.max_entry in drive.dictionary:
        most = variable.max_times * drive.number(variable.max_entry)
        cut = min(cut, most) if most > 0 else cut
    return cut


def reset(drive: RemoteDrive) -> None:
    """Reset the node and wait for its boot-up message.

    Raises:
        NoAnswer: none came.
    """
    boots = drive.link.counters.boots_received
    drive.link.nmt(NmtCommand.RESET_NODE)
    deadline_s = drive.clock.now_s() + _BOOT_S
    while drive.link.counters.boots_received == boots:  # a heartbeat may follow the boot-up at once
        if drive.clock.now_s() >= deadline_s:
            raise NoAnswer(
                f"no boot-up message of node {drive.link.node_id} within {_BOOT_S:g} s of its reset; "
                f"switch it off and on"
            )
        drive.clock.wait(_POLL_S)


def _sign(drive: RemoteDrive, role: Role, signature: bytes, ability: str) -> None:
    """Write a signature; such an object reads as a capability (bit 0), never as the value written."""
    variable = drive.dictionary[role]
    if not int(drive.number(role)) & _ON_COMMAND:
        raise WriteNotVerified(
            f"{role.label} reads {drive.number(role):g}, bit 0 is expected to say that the drive {ability} "
            f"on command: this one does not"
        )
    drive.link.download(variable.index, variable.sub, signature)
    drive.read(role)
