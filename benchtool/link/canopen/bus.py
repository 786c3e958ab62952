"""CAN buses by their addresses."""

from __future__ import annotations

from typing import Any

import can

from benchtool.errors import LinkError
from benchtool.link.canopen.slcan import open_slcan


def open_bus(interface: str, channel: str, bitrate: int | None = None) -> can.BusABC:
    """Return a bus of python-can; without a bit rate, in bit/s, the adapter stays as it is set.

    Raises:
        LinkError: it cannot be opened.
    """
    options: dict[str, Any] = {} if bitrate is None else {"bitrate": bitrate}
    try:
        if interface == "slcan":
            return open_slcan(channel, bitrate)
        return can.Bus(interface=interface, channel=channel, **options)
    except (can.CanError, OSError, ImportError, NameError, ValueError, TypeError) as reason:
        # NameError: an interface of python-can that goes on without its maker's library, as kvaser does
        raise LinkError(
            f"cannot open can:{interface}:{channel}: {reason}; "
            f"check the interface's name, its driver and the channel"
        ) from None
