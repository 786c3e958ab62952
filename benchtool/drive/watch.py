"""Watching an enabled drive from the host: whether it is heard, has not restarted, and is still enabled.

What a drive reports by an emergency is told by that. This is for what it cannot report: a lost emergency, a
restart, silence, another node with its number.
"""

from __future__ import annotations

from typing import Final

from benchtool.drive.states import Cia402Node
from benchtool.errors import DriveFault, NoAnswer, SdoAbort, StateError
from benchtool.link import CountsAnswers
from benchtool.protocol import State
from benchtool.protocol.dictionary import Role

SILENCE_S: Final = 0.5
"""Time without a heartbeat of the drive after which it counts as silent, or three of its heartbeats."""

_STATE_PERIOD_S: Final = 0.5
_MISSED: Final = 3
_MILLI: Final = 1e-3  # 0x1017 is in ms where a dictionary states no unit


class Watch:
    """What is looked at while a drive is enabled; `check` is called while its caller waits."""

    def __init__(self, drive: Cia402Node) -> None:
        self._drive = drive
        self._enabled = False
        self._silence_s: float | None = None
        self._boots = self._heartbeats = 0
        self._heard_s = self._looked_s = 0.0

    def begin(self) -> None:
        """The drive is enabled from now on."""
        drive = self._drive
        period_s = _heartbeat_period_s(drive)
        self._silence_s = max(SILENCE_S, _MISSED * period_s) if period_s > 0.0 else None
        counters = drive.link.counters
        self._boots, self._heartbeats = counters.boots_received, counters.heartbeats_received
        self._heard_s = self._looked_s = drive.clock.now_s()
        self._enabled = True

    def end(self) -> None:
        """The drive is being disabled."""
        self._enabled = False

    def check(self) -> None:
        """Raise what has happened to the drive.

        Raises:
            StateError: it restarted, or was disabled by something else.
            DriveFault: it is in fault, and its emergency did not arrive.
            NoAnswer: it is not heard any more.
        """
        if not self._enabled:
            return
        counters, now_s = self._drive.link.counters, self._drive.clock.now_s()
        if counters.boots_received != self._boots:
            self.end()
            raise StateError(
                f"the drive restarted while it was enabled, as its boot-up message tells, or another node "
                f"with number {self._drive.link.node_id} was switched on: look for a dip of its supply, its "
                f"watchdog, or that node, then connect again"
            )
        if counters.heartbeats_received != self._heartbeats:
            self._heartbeats, self._heard_s = counters.heartbeats_received, now_s
        if self._silence_s is not None and now_s - self._heard_s > self._silence_s:
            self.end()
            raise NoAnswer(
                f"nothing was heard of the drive for {now_s - self._heard_s:.1f} s, its heartbeat was "
                f"expected: it has stopped the motor if it lives; make sure of that, then check cable, "
                f"adapter and supply"
            )
        if self._silence_s is not None and now_s - self._heard_s > 0.5 * self._silence_s:
            return  # it may be silent: a question would only take longer to find that out
        if now_s - self._looked_s >= _STATE_PERIOD_S:
            self._looked_s = now_s
            self._require_enabled()

    def _require_enabled(self) -> None:
        try:
            state = self._drive.state()
        except NoAnswer:
            if self._silence_s is None:
                raise
            return  # its heartbeat, its boot-up or its emergency will tell more
        if state.power_stage_on:
            return
        self.end()
        if state is State.FAULT:
            raise DriveFault(
                f"the drive is in fault and its emergency did not arrive, {self._drive.last_error()}: remove "
                f"the cause, then reset the fault"
            )
        raise StateError(
            f"the drive is in '{state.value}' and this host left it in '{State.OPERATION_ENABLED.value}': "
            f"another master or an enable input switched it off; find out which, then enable it again"
        )


def _heartbeat_period_s(drive: Cia402Node) -> float:
    """Return the period of the drive's heartbeat; 0 of one that sends none."""
    if (variable := drive.dictionary.get(Role.PRODUCER_HEARTBEAT)) is None:
        return 0.0
    try:
        period = drive.number(variable)
    except SdoAbort:  # optional
        return 0.0
    return period if variable.unit == "s" else period * _MILLI


def require_alone(drive: Cia402Node) -> None:
    """Refuse a node number that two nodes answer to, where the link can tell.

    Raises:
        StateError: one question was answered more than once.
    """
    link = drive.link
    if not isinstance(link, CountsAnswers):
        return
    answers = link.answers(*Role.SERIAL_NUMBER.key)
    if answers > 1:
        raise StateError(
            f"{answers} nodes answer as node {link.node_id}, one is expected: give each node of the bus a "
            f"number of its own; the drive was not enabled"
        )
