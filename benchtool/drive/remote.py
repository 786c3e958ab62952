"""A drive at the other end of a link, by the names and units of its dictionary."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import Self

from benchtool.clock import Clock, Timer
from benchtool.drive.identity import Identity
from benchtool.drive.reconnection import Reconnection
from benchtool.errors import (
    BenchError,
    DriveFault,
    LinkClosed,
    LinkError,
    SdoAbort,
    StateError,
    ValueRefused,
    WriteNotVerified,
)
from benchtool.link import Link
from benchtool.link.ticks import TickMark
from benchtool.protocol.abort import Abort
from benchtool.protocol.cia402 import Command, State, next_command, state_of
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.emcy import error_text
from benchtool.protocol.modes import Mode
from benchtool.protocol.nmt import NmtCommand
from benchtool.protocol.variable import Value

_TRANSITION_TIMEOUT_S = 1.0
_POLL_S = 0.001
_REOPEN_S = 0.2
_WATCH_S = 0.05
HEARTBEAT_S = 0.1
LINK_TIMEOUT_S = 0.5
HOST_NODE_ID = 127


class RemoteDrive:
    """A drive that is left disabled on every way out of its `with` block.

    Args:
        link: open link to the drive's node.
        dictionary: what its EDS says.
        source: name of that EDS, for messages.
        clock: the clock that waiting and heartbeats go by.
        reopen: opens the same link anew, for `reconnect`.
    """

    def __init__(
        self,
        link: Link,
        dictionary: Dictionary,
        source: str,
        clock: Clock,
        *,
        reopen: Callable[[], Link] | None = None,
    ) -> None:
        self.link = link
        self.dictionary = dictionary
        self.clock = clock
        self._source = source
        self._reopen = reopen
        self._ticks: TickMark | None = None
        self._heartbeat: Timer | None = None
        self._touched = False
        self._commanded = False
        self._watches: list[Callable[[], None]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._touched:
                self.disable()
            self._end_supervision()
        except BenchError:
            # The first failure is the one to report; silence of the host's heartbeat stops the drive itself.
            if error is None:
                raise
        finally:
            self.stop_heartbeat()

    # ---- identity ---------------------------------------------------------------------------------------

    def identify(self) -> Identity:
        """Who answers.

        Raises:
            NoAnswer: nobody does.
        """
        return Identity(
            vendor_id=int(self.read("vendor_id")),
            product_code=int(self.read("product_code")),
            revision_number=self._optional_int("revision_number"),
            serial_number=self._optional_int("serial_number"),
            device_name=self._optional_text("device_name"),
            hardware_version=self._optional_text("hardware_version"),
            firmware_version=self._optional_text("firmware_version"),
            dictionary_hash=self._optional_int("dictionary_hash"),
        )

    def connect(self) -> Identity:
        """Check identity and dictionary, and start the supervision of the link.

        Raises:
            NoAnswer, IdentityMismatch, DictionaryMismatch: as their names say.
        """
        identity = self._checked()
        self.supervise()
        return identity

    def reconnect(self, timeout_s: float) -> Reconnection:
        """Open the link anew after it was lost, and check who answers.

        A drive that was supervised or enabled from here is so again, supervised and left disabled: its link
        supervision has stopped the motor meanwhile, and if that made a fault, `reset_fault` is needed before
        it can be enabled. One that was only read goes on with what it does.

        Raises:
            LinkError: there was no way back within `timeout_s`.
            IdentityMismatch, DictionaryMismatch: another drive answers.
            StateError: the drive does not confirm that it is disabled.
        """
        if self._reopen is None:
            raise LinkClosed("this link cannot be opened again: open another session")
        before = self._ticks
        deadline_s = self.clock.now_s() + timeout_s
        while True:
            self._drop_link()
            try:
                self.link = self._reopen()
                identity = self._checked()
                if self._commanded:
                    self.disable()  # first: a drive takes no other supervision while its power stage is on
                    self.supervise()
                break
            except (LinkError, StateError):
                if self.clock.now_s() >= deadline_s:
                    self._drop_link()
                    raise
                self.clock.wait(_REOPEN_S)
        restarted = None
        if before is not None and self._ticks is not None:
            restarted = before.restarted_since(self._ticks)
        return Reconnection(identity, restarted)

    def close_link(self) -> None:
        """Close the link that is in use, the first one or one that `reconnect` opened."""
        self.link.close()

    # ---- values -----------------------------------------------------------------------------------------

    def read(self, name: str) -> Value:
        """Physical value of `name`, in the unit of the dictionary; the name of an enumeration's value.

        Raises:
            ValueRefused: no such name.
            NoAnswer, SdoAbort: the drive did not answer, or refused.
        """
        variable = self.dictionary[name]
        with self._naming(f"reading '{name}'"):
            return variable.decode(self.link.upload(variable.index, variable.sub))

    def number(self, name: str) -> float:
        """Raw or physical number of `name`, an enumeration's value as its number."""
        variable = self.dictionary[name]
        value = variable.decode(self.link.upload(variable.index, variable.sub))
        if isinstance(value, str) and variable.values:
            return variable.values[value]
        if not isinstance(value, int | float):
            raise ValueRefused(f"'{name}' is {value!r}, a number is expected: choose a numeric object")
        return value

    def write(self, name: str, value: Value) -> None:
        """Check `value` against the dictionary, send it once, and read it back.

        Raises:
            ValueRefused: outside its limits; nothing was sent.
            SdoAbort: the drive refused.
            WriteNotVerified: the drive holds another value than was sent.
        """
        variable = self.dictionary[name]
        sent = variable.encode(value)
        with self._naming(f"writing {value!r} to '{name}'"):
            self.link.download(variable.index, variable.sub, sent)
            kept = self.link.upload(variable.index, variable.sub)
        if kept != sent:
            raise WriteNotVerified(
                f"'{name}' reads back {variable.decode(kept)!r} after {value!r} was written: "
                f"check whether another master writes it too"
            )

    # ---- states -----------------------------------------------------------------------------------------

    def state(self) -> State:
        """State of the CiA 402 state machine."""
        return state_of(int(self.read("statusword")))

    def enable(self, mode: Mode) -> None:
        """Walk to operation enabled in `mode`.

        Raises:
            DriveFault: the drive is or goes into fault.
            StateError: a transition does not happen.
        """
        self.link.nmt(NmtCommand.START)
        self._touched = self._commanded = True
        self.write("mode_of_operation", int(mode))
        self._walk_to(State.OPERATION_ENABLED)

    def disable(self) -> None:
        """Switch the power stage off, from whatever state.

        Raises:
            StateError: the drive does not confirm; its link supervision will have to stop it.
        """
        try:
            self._walk_to(State.SWITCH_ON_DISABLED)
        except DriveFault:
            return
        except BenchError as reason:
            self.link.nmt(NmtCommand.STOP)
            raise StateError(
                f"the drive did not confirm that it is disabled ({reason}); NMT stop was sent and the host's "
                f"heartbeat ends now: check that the motor has stopped, or use the emergency stop"
            ) from reason
        finally:
            self._touched = False

    @contextmanager
    def enabled(self, mode: Mode) -> Iterator[None]:
        """Operation enabled in `mode` for the length of a `with` block, disabled on every way out of it.

        Raises:
            DriveFault, StateError: as `enable` and `disable`.
        """
        try:
            self.enable(mode)
            yield
        except BaseException as error:
            try:
                self.disable()
            except BenchError as failed:
                error.add_note(str(failed))
            raise
        else:
            self.disable()

    def reset_fault(self) -> None:
        """Leave the fault state by the rising edge of bit 7.

        Raises:
            StateError: the drive stays in fault.
        """
        self._ask(Command.FAULT_RESET)
        if (state := self.state()) in (State.FAULT, State.FAULT_REACTION_ACTIVE):
            raise StateError(
                f"the drive is still in '{state.value}', {self._last_error()}: remove the cause first"
            )

    def wait(self, duration_s: float) -> None:
        """Let drive time pass, and stop at a fault or at what a watch raises.

        Raises:
            DriveFault: an emergency arrived.
        """
        remaining_s = duration_s
        while remaining_s > 0.0:
            step_s = min(_WATCH_S, remaining_s)
            self.clock.wait(step_s)
            remaining_s -= step_s
            self.raise_emergencies()
            for check in self._watches:
                check()

    @contextmanager
    def watched(self, check: Callable[[], None]) -> Iterator[None]:
        """Have `check` called while `wait` waits: it raises what is to end the run."""
        self._watches.append(check)
        try:
            yield
        finally:
            self._watches.remove(check)

    def raise_emergencies(self) -> None:
        """Raise the first emergency that has arrived.

        Raises:
            DriveFault: there was one.
        """
        for emergency in self.link.emergencies():
            if emergency.code != 0:
                raise DriveFault(
                    f"the drive reports {emergency.text}: remove the cause, then reset the fault"
                )

    # ---- link supervision -------------------------------------------------------------------------------

    def supervise(self, timeout_s: float = LINK_TIMEOUT_S) -> None:
        """Send the host's heartbeat, and have the drive stop the motor when it stays out for `timeout_s`."""
        self.stop_heartbeat()
        self._commanded = True
        if "host_heartbeat" in self.dictionary:
            self.write("host_heartbeat", HOST_NODE_ID << 16 | round(timeout_s * 1000.0))
        self._heartbeat = self.clock.call_every(min(HEARTBEAT_S, timeout_s / 3.0), self.link.send_heartbeat)

    def stop_heartbeat(self) -> None:
        """Fall silent; a drive that is supervised stops the motor after its timeout."""
        if self._heartbeat is not None:
            self._heartbeat.cancel()
            self._heartbeat = None

    def _end_supervision(self) -> None:
        """Set the drive's supervision back before the heartbeat ends, so that it takes no end for a loss."""
        if self._heartbeat is not None and "host_heartbeat" in self.dictionary:
            with suppress(BenchError):  # then the drive notices that the host has gone, and says so
                self.write("host_heartbeat", 0)

    def _checked(self) -> Identity:
        """Who answers, which is the drive of the dictionary; notes its tick."""
        identity = self.identify()
        identity.require(self.dictionary, self._source)
        if all(name in self.dictionary for name in ("tick", "control_period")):
            self._ticks = TickMark(
                int(self.number("tick")), self.clock.now_s(), self.number("control_period")
            )
        return identity

    def _drop_link(self) -> None:
        with suppress(LinkError):  # what the heartbeat ran into when the link went
            self.stop_heartbeat()
        self._heartbeat = None
        self.link.close()

    # ---- inside -----------------------------------------------------------------------------------------

    def _walk_to(self, target: State) -> None:
        deadline_s = self.clock.now_s() + _TRANSITION_TIMEOUT_S
        asked = None
        while (state := self.state()) is not target:
            command = next_command(state, target)
            if state in (State.FAULT, State.FAULT_REACTION_ACTIVE):
                raise DriveFault(
                    f"the drive is in fault: {self._last_error()}; remove the cause, then reset it"
                )
            if command is not None and (state, command) != asked:
                asked = (state, command)
                self._ask(command)
                continue
            if self.clock.now_s() >= deadline_s:
                raise StateError(
                    f"the drive stays in '{state.value}' and '{target.value}' was asked for: "
                    f"check supply, enable input and link supervision"
                )
            self.clock.wait(_POLL_S)

    def _ask(self, command: Command) -> None:
        variable = self.dictionary["controlword"]
        with self._naming(f"asking for '{command.value}'"):
            for word in command.controlwords:
                self.link.download(variable.index, variable.sub, variable.encode(word))

    def _last_error(self) -> str:
        code = self._optional_int("error_code")
        return "no error code" if code is None else f"0x{code:04X} {error_text(code)}"

    def _optional_int(self, name: str) -> int | None:
        value = self._optional(name)
        return value if isinstance(value, int) else None

    def _optional_text(self, name: str) -> str | None:
        value = self._optional(name)
        return value if isinstance(value, str) else None

    def _optional(self, name: str) -> Value | None:
        if name not in self.dictionary:
            return None
        try:
            return self.read(name)
        except SdoAbort as abort:
            if abort.code in (Abort.NO_OBJECT, Abort.NO_SUB_INDEX):
                return None
            raise

    @contextmanager
    def _naming(self, doing: str) -> Iterator[None]:
        try:
            yield
        except SdoAbort as abort:
            raise SdoAbort(f"{doing}: {abort}", abort.code) from abort
