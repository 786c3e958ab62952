"""Consumer of a drive's heartbeats and emergency messages (EMCY), on any wire."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from benchtool.clock import Clock
from benchtool.errors import NoAnswer
from benchtool.link.interface import ReceivedEmergency
from benchtool.protocol.canopen import Emergency, NmtState

_EMERGENCIES = 256
_POLL_S = 0.01


class HeartbeatEmcyConsumer:
    """Filled in a link's receive thread, read in any other.

    The first 256 emergencies are kept until they are taken, as the cause is among the first.

    Args:
        node_id: the drive's, for messages.
        clock: what waiting goes by.
        require_open: raises LinkClosed once the link is closed.
    """

    def __init__(self, node_id: int, clock: Clock, require_open: Callable[[], None]) -> None:
        self._node_id = node_id
        self._clock = clock
        self._require_open = require_open
        self._state: NmtState | None = None
        self._heartbeats = self._boots = self._heard = self._overruns = 0
        self._emergencies: deque[ReceivedEmergency] = deque()

    @property
    def counts(self) -> dict[str, int]:
        """Counts of received messages, by the names of `LinkCounters`."""
        return {
            "heartbeats_received": self._heartbeats,
            "boots_received": self._boots,
            "emcy_received": self._heard,
            "overruns": self._overruns,
        }

    def on_state_read(self, state: NmtState) -> None:
        """Note a state that the drive returned to a request: it is newer than earlier heartbeats."""
        self._state = state

    def on_heartbeat(self, state: NmtState) -> None:
        """Note the state in a heartbeat."""
        self._state = state
        self._heartbeats += 1
        self._boots += state is NmtState.BOOT_UP

    def on_emergency(self, emergency: Emergency, arrival_s: float) -> None:
        """Keep an emergency, or count it where there is no room."""
        self._heard += 1
        if len(self._emergencies) < _EMERGENCIES:
            self._emergencies.append(ReceivedEmergency(emergency, arrival_s))
        else:
            self._overruns += 1

    def heartbeat_state(self) -> NmtState | None:
        """See `Link.heartbeat_state`."""
        self._require_open()
        return self._state

    def wait_heartbeat(self, timeout_s: float) -> NmtState:
        """See `Link.wait_heartbeat`."""
        heard = self._heartbeats
        deadline_s = self._clock.now_s() + timeout_s
        while True:
            state = self.heartbeat_state()
            if state is not None and self._heartbeats != heard:
                return state
            if self._clock.now_s() >= deadline_s:
                raise NoAnswer(
                    f"no heartbeat of node {self._node_id} within {timeout_s:g} s; "
                    f"check that the drive is powered and its producer_heartbeat (0x1017) is not 0"
                )
            self._clock.wait(min(_POLL_S, timeout_s))

    def emergencies(self) -> tuple[ReceivedEmergency, ...]:
        """See `Link.emergencies`."""
        self._require_open()
        return tuple(self._emergencies.popleft() for _ in range(len(self._emergencies)))
