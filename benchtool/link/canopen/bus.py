"""CAN buses by their addresses."""

from __future__ import annotations

from typing import Any

import can

from benchtool.errors import LinkError
from benchtool.link.address import Address
from benchtool.link.canopen.slcan import open_slcan


def open_bus(address: Address) -> can.BusABC:
    """The bus that an address of kind `can` names.

    Raises:
        LinkError: it cannot be opened.
    """
    bitrate: dict[str, Any] = {} if address.bitrate is None else {"bitrate": address.bitrate}
    try:
        if address.interface == "slcan":
            return open_slcan(address.channel, address.bitrate)
        return can.Bus(interface=address.interface, channel=address.channel, **bitrate)
    except (can.CanError, OSError, ImportError, ValueError, TypeError) as reason:
        raise LinkError(
            f"cannot open can:{address.interface}:{address.channel}: {reason}; "
            f"check the interface's name, its driver and the channel"
        ) from None
