"""Host of an emulated bench in virtual time, on either wire."""

from __future__ import annotations

from typing import Final

from benchtool.drive import RemoteDrive
from benchtool.emulator.bench import EmulatedBench
from benchtool.link import Link
from benchtool.link.canopen import CanopenLink, timestamp
from benchtool.link.serial import SerialLink
from benchtool.protocol.dictionary import Dictionary
from benchtool.shipped import shipped

_EDS: Final = shipped("firmware_protocol") / "drive.eds"


def host_of(bench: EmulatedBench, wire: str) -> RemoteDrive:
    """Return the drive of a bench as a host on `wire`, "can" or "serial", has it; nothing has been sent."""
    link: Link
    if wire == "can":
        link = CanopenLink(bench.host_bus(), 1, bench.clock, arrival_s=timestamp)
    else:
        link = SerialLink(bench.host_port(), 1, bench.clock)
    return RemoteDrive(link, Dictionary.from_eds(_EDS, 1), _EDS.name, bench.clock)
