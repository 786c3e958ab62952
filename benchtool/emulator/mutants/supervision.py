"""Mutants of the watchdog, of faults and of messages."""

from __future__ import annotations

from typing import Any, Final

from benchtool.emulator.firmware import device
from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.firmware.supervision import LinkState, LinkSupervision
from benchtool.emulator.mutants.mutant import Make, Mutant, Substitution
from benchtool.protocol import State
from benchtool.protocol.canopen import ErrorCode

_QUICK_STOP: Final = 3  # of the abort connection option


def of_firmware(name: str, make: Make) -> tuple[Substitution, ...]:
    """Return the substitution of a method of the firmware."""
    return (Substitution(Firmware, name, make),)


def _of_watchdog(name: str, make: Make) -> tuple[Substitution, ...]:
    return (Substitution(LinkSupervision, name, make),)


def nothing(_original: Any) -> Any:
    """Return a method that does nothing."""
    return lambda _self, *_arguments, **_named: None


def _twice_the_time(original: Any) -> Any:
    def configure(self: LinkSupervision, host_heartbeat: int) -> None:
        original(self, host_heartbeat)
        self._timeout_s *= 2.0

    return configure


def _fed_by_reads(original: Any) -> Any:
    def wire(self: Firmware) -> None:
        original(self)
        read = self.objects.read

        def feeding(index: int, sub: int) -> bytes:
            self.feed_link()
            return read(index, sub)

        self.objects.read = feeding  # type: ignore[method-assign]

    return wire


def _revived(_original: Any) -> Any:
    def feed(self: LinkSupervision, now_s: float) -> None:
        if self.state is not LinkState.OFF:
            self.state = LinkState.ALIVE
            self._deadline_s = now_s + self._timeout_s

    return feed


def _uncounted(original: Any) -> Any:
    def expire(self: LinkSupervision, now_s: float) -> bool:
        lost: bool = original(self, now_s)
        self.losses = 0
        return lost

    return expire


def _says_alive(original: Any) -> Any:
    def wire(self: Firmware) -> None:
        original(self)
        self.objects.compute("link_state", lambda: int(LinkState.ALIVE))

    return wire


def _only_reported(_original: Any) -> Any:
    def lose(self: Firmware) -> None:
        self.report(ErrorCode.HEARTBEAT)

    return lose


def _coasts(original: Any) -> Any:
    def lose(self: Firmware) -> None:
        if self.objects["abort_connection_option"] == _QUICK_STOP:
            self.report(ErrorCode.HEARTBEAT)
            self.stop()
        else:
            original(self)

    return lose


def _silent(original: Any) -> Any:
    def report(self: Firmware, code: ErrorCode) -> None:
        emit, self._emit = self._emit, lambda _: None
        try:
            original(self, code)
        finally:
            self._emit = emit

    return report


def _twice(original: Any) -> Any:
    def report(self: Firmware, code: ErrorCode) -> None:
        original(self, code)
        if code is not ErrorCode.NO_ERROR:
            original(self, code)

    return report


def _without_history(original: Any) -> Any:
    def report(self: Firmware, code: ErrorCode) -> None:
        kept = list(self._history)
        original(self, code)
        self._history = kept

    return report


def _error_stays(original: Any) -> Any:
    def report(self: Firmware, code: ErrorCode) -> None:
        before = self.objects["error_code"]
        original(self, code)
        if code is ErrorCode.NO_ERROR:
            self.objects["error_code"] = before

    return report


def _left_without_reset(original: Any) -> Any:
    def transition(state: State, word: int, before: int) -> State:
        if state is State.FAULT and word & 0x0F == 0x06:
            return State.READY_TO_SWITCH_ON
        found: State = original(state, word, before)
        return found

    return transition


def _swapped(original: Any) -> Any:
    low, high = ErrorCode.DC_LINK_UNDERVOLTAGE, ErrorCode.DC_LINK_OVERVOLTAGE
    other = {low: high, high: low}
    return {trip: other.get(code, code) for trip, code in original.items()}


SUPERVISION: Final = (
    Mutant(
        "watchdog_sleeps",
        "a watchdog that never expires",
        substitutions=_of_watchdog("expire", lambda _: lambda *_: False),
    ),
    Mutant(
        "watchdog_twice",
        "a watchdog that waits twice as long",
        substitutions=_of_watchdog("configure", _twice_the_time),
    ),
    Mutant(
        "watchdog_fed_by_reads",
        "a watchdog that any read feeds",
        substitutions=of_firmware("_wire_objects", _fed_by_reads),
    ),
    Mutant(
        "watchdog_not_latched",
        "a loss that ends with the next heartbeat",
        substitutions=_of_watchdog("feed", _revived),
    ),
    Mutant(
        "watchdog_reports_only",
        "a loss that is reported, and stops nothing",
        substitutions=of_firmware("_lose_link", _only_reported),
    ),
    Mutant(
        "loss_coasts",
        "a loss that coasts where it should quick stop",
        substitutions=of_firmware("_lose_link", _coasts),
    ),
    Mutant(
        "start_unsupervised",
        "a start without a host that was heard",
        substitutions=_of_watchdog("may_enable", lambda _: property(lambda _self: True)),
    ),
    Mutant(
        "losses_stuck",
        "a counter of losses that stays at 0",
        substitutions=_of_watchdog("expire", _uncounted),
    ),
    Mutant(
        "link_state_stuck",
        "a link state that always says alive",
        substitutions=of_firmware("_wire_objects", _says_alive),
    ),
    Mutant("emcy_missing", "no emergency message", substitutions=of_firmware("report", _silent)),
    Mutant("emcy_twice", "every emergency message twice", substitutions=of_firmware("report", _twice)),
    Mutant(
        "voltages_swapped",
        "over-voltage is called under-voltage",
        substitutions=(Substitution(device, "_ERROR_OF_TRIP", _swapped),),
    ),
    Mutant(
        "history_stuck",
        "an error history that takes nothing",
        substitutions=of_firmware("report", _without_history),
    ),
    Mutant(
        "error_code_stays",
        "an error code that outlives the reset",
        substitutions=of_firmware("report", _error_stays),
    ),
    Mutant(
        "fault_not_latched",
        "a fault that is left without a reset",
        substitutions=(Substitution(device, "transition", _left_without_reset),),
    ),
    Mutant(
        "targets_kept", "targets that outlive a fault", substitutions=of_firmware("_clear_targets", nothing)
    ),
)
"""Defects of supervision, faults and messages."""
