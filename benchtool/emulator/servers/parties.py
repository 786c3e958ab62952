"""Other nodes on the drive's CAN bus, which ought not to be there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from benchtool.protocol.canopen import NmtState, cob_id

NEVER = 1 << 62
_UPLOAD, _DOWNLOAD = 0x40, 0x20
_HEARTBEAT_S = 0.1
_OTHER_SERIAL_NUMBER = 0x0BADCAFE

CanFrame = tuple[int, bytes]


class Party(Protocol):
    """A node beside the drive; it counts in the drive's ticks."""

    def hear(self, can_id: int, data: bytes) -> Iterator[CanFrame]:
        """Yield the answers to a frame of the host."""

    def next_tick(self, tick: int) -> int:
        """Return the first tick after `tick` in which it sends by itself."""

    def sends(self, tick: int) -> Iterator[CanFrame]:
        """Yield what it sends by itself in this tick."""


class Impostor:
    """A second drive with the same node number, just switched on: disabled, with another serial number.

    Args:
        node_id: the number.
        tick: at which it is switched on.
        period_s: of a tick.
    """

    def __init__(self, node_id: int, tick: int, period_s: float) -> None:
        self._node_id = node_id
        self._every = max(1, round(_HEARTBEAT_S / period_s))
        self._next = tick + 1
        self._booted = False

    def hear(self, can_id: int, data: bytes) -> Iterator[CanFrame]:
        """See `Party.hear`: expedited transfers are answered, as the host's first questions are such."""
        if can_id != cob_id.SDO_REQUEST + self._node_id or len(data) != 8:
            return
        answer = cob_id.SDO_RESPONSE + self._node_id
        if data[0] == _UPLOAD:
            yield answer, bytes([0x43, *data[1:4]]) + _OTHER_SERIAL_NUMBER.to_bytes(4, "little")
        elif data[0] & 0xE0 == _DOWNLOAD:
            yield answer, bytes([0x60, *data[1:4], 0, 0, 0, 0])

    def next_tick(self, tick: int) -> int:
        """See `Party.next_tick`."""
        return self._next

    def sends(self, tick: int) -> Iterator[CanFrame]:
        """See `Party.sends`: the boot-up message, then heartbeats."""
        if tick < self._next:
            return
        self._next = tick + self._every
        state = NmtState.PRE_OPERATIONAL if self._booted else NmtState.BOOT_UP
        self._booted = True
        yield cob_id.HEARTBEAT + self._node_id, bytes([state])


class Babbler:
    """A node that sends one frame again and again.

    Args:
        can_id: its identifier.
        every: ticks between two frames.
        tick: after which it begins.
    """

    def __init__(self, can_id: int, every: int, tick: int) -> None:
        self._can_id = can_id
        self._every = max(1, every)
        self._next = tick + 1

    def hear(self, can_id: int, data: bytes) -> Iterator[CanFrame]:
        """See `Party.hear`."""
        yield from ()

    def next_tick(self, tick: int) -> int:
        """See `Party.next_tick`."""
        return self._next

    def sends(self, tick: int) -> Iterator[CanFrame]:
        """See `Party.sends`."""
        if tick >= self._next:
            self._next = tick + self._every
            yield self._can_id, bytes(8)
