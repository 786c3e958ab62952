"""Link supervision: the drive stops the motor when the host's heartbeat stops."""

from __future__ import annotations

from enum import IntEnum
from typing import Final

LONGEST_TIMEOUT_MS: Final = 2000
"""A link that may be lost for longer is not watched."""


class LinkState(IntEnum):
    """Object `link_state`."""

    OFF = 0
    WAITING = 1
    ALIVE = 2
    LOST = 3


class LinkSupervision:
    """A watchdog fed by the host's heartbeat and by setpoint frames, and by nothing else.

    It starts with the first heartbeat after it is configured, and a loss is latched until `rearm`.

    Args:
        reaction_s: from the expiry until the torque has ended; by so much it expires before the time that is
            configured, in which the torque is to end.
    """

    def __init__(self, reaction_s: float = 0.0) -> None:
        self._reaction_s = reaction_s
        self.state = LinkState.OFF
        self.losses = 0
        self.host_node_id = 0
        self._timeout_s = 0.0
        self._deadline_s = 0.0

    def configure(self, host_heartbeat: int) -> None:
        """Take object 0x1016: bits 16-22 the host's node id, bits 0-15 the timeout in ms; 0 is off."""
        self.host_node_id = host_heartbeat >> 16 & 0x7F
        self._timeout_s = (host_heartbeat & 0xFFFF) / 1000.0
        self.rearm()

    def rearm(self) -> None:
        """Clear a loss and wait for the next heartbeat."""
        supervised = self.host_node_id != 0 and self._timeout_s > 0.0
        self.state = LinkState.WAITING if supervised else LinkState.OFF

    def feed(self, now_s: float) -> None:
        """The host was heard."""
        if self.state in (LinkState.WAITING, LinkState.ALIVE):
            self.state = LinkState.ALIVE
            self._deadline_s = now_s + max(self._timeout_s - self._reaction_s, 0.0)

    def deadline_s(self) -> float:
        """Return when the link counts as lost; infinity while it is not watched."""
        return self._deadline_s if self.state is LinkState.ALIVE else float("inf")

    def expire(self, now_s: float) -> bool:
        """Return whether the link was lost just now."""
        if now_s < self.deadline_s():
            return False
        self.state = LinkState.LOST
        self.losses += 1
        return True

    @property
    def may_enable(self) -> bool:
        """Whether the power stage may be switched on: supervised and heard, or not supervised at all."""
        return self.state in (LinkState.OFF, LinkState.ALIVE)
