"""A drive with the state machine of CiA 402: enabled and disabled step by step, each step confirmed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Protocol

from benchtool.clock import Clock
from benchtool.drive.node import RemoteNode
from benchtool.errors import BenchError, DriveFault, LinkClosed, LinkError, NoAnswer, SdoAbort, StateError
from benchtool.link import Link
from benchtool.protocol import Command, Mode, State, next_command, state_of
from benchtool.protocol.canopen import Abort, Emergency, NmtCommand, error_text
from benchtool.protocol.dictionary import Dictionary, Role

_TRANSITION_TIMEOUT_S = 1.0
_DISABLING_TRIES = 3
_POLL_S = 0.001
_POLL_PERIOD_S = 0.5
_TARGETS: tuple[Role | str, ...] = (
    *(Role.TARGET_TORQUE, Role.TARGET_VELOCITY),
    *("torque_command", "omega_m_command"),  # last: the standard's objects set these
)
_NOTING_S = 60.0
_ROUNDING_S = 1e-9


class Observer(Protocol):
    """Observer of the states and emergencies of a drive; its methods must return quickly.

    Exceptions that they raise are ignored. `tick` is the drive's tick at that moment, None where it is
    unknown.
    """

    def state(self, state: State, tick: int | None) -> None:
        """The statusword was read."""

    def emergency(self, emergency: Emergency, tick: int | None) -> None:
        """An emergency had arrived."""


class Cia402Node(RemoteNode):
    """A node that is enabled and disabled; arguments as of `RemoteNode`."""

    def __init__(self, link: Link, dictionary: Dictionary, source: str, clock: Clock) -> None:
        super().__init__(link, dictionary, source, clock)
        self._touched = False
        self._commanded = False
        self._observers: list[Observer] = []
        self._polled_s = -math.inf

    @contextmanager
    def observed(self, observer: Observer) -> Iterator[None]:
        """Register an observer for the length of a `with` block."""
        self._observers.append(observer)
        try:
            yield
        finally:
            self._observers.remove(observer)

    def state(self) -> State:
        """Return the state of the CiA 402 state machine."""
        state = state_of(int(self.number(Role.STATUSWORD)))
        tick = self.tick_now()
        for observer in self._observers:
            with suppress(Exception):  # an observer must not keep a drive from being disabled
                observer.state(state, tick)
        return state

    def poll(self) -> None:
        """Read the state for the observers, at most every half second, and the tick once a minute."""
        now_s = self.clock.now_s()
        if now_s - self._polled_s < _POLL_PERIOD_S - _ROUNDING_S:
            return
        self._polled_s = now_s
        if self._anchor is not None and now_s - self._anchor.at_s >= _NOTING_S:
            self._note_tick()
        self.state()

    def emergencies(self) -> tuple[Emergency, ...]:
        """Return the emergencies that have arrived since the last call, oldest first."""
        arrived = self.link.emergencies()
        for emergency, arrival_s in arrived:
            for observer in self._observers:
                with suppress(Exception):
                    observer.emergency(emergency, self.tick_at(arrival_s))
        return tuple(emergency for emergency, _ in arrived)

    def raise_emergencies(self) -> None:
        """Raise the first error that has arrived in an emergency.

        Raises:
            DriveFault: there was one.
        """
        for emergency in self.emergencies():
            if emergency.code != 0:
                raise DriveFault(
                    f"the drive reports {emergency.text}: remove the cause, then reset the fault"
                )

    def enable(self, mode: Mode) -> None:
        """Walk to operation enabled in `mode`, with every target set to zero, as a drive keeps earlier
        targets.

        Raises:
            DriveFault: the drive is or goes into fault.
            StateError: a transition does not happen.
            SdoAbort, WriteNotVerified: a target cannot be set to zero; the drive was not enabled.
        """
        self.link.nmt(NmtCommand.START)
        self._touched = self._commanded = True
        self.write(Role.MODE_OF_OPERATION, self._code_of(mode))
        self._zero_targets()
        self._walk_to(State.OPERATION_ENABLED)

    def disable(self) -> None:
        """Switch the power stage off from any state, and clear the targets.

        Raises:
            StateError: the drive does not confirm; its link supervision will have to stop it.
            LinkClosed: likewise, as the link has gone.
        """
        try:
            self._walk_down()
        except DriveFault:
            self._touched = False
            return
        except BenchError as reason:
            failure: type[StateError | LinkClosed] = StateError
            try:
                self.link.nmt(NmtCommand.STOP)
                stop = "NMT stop was sent"
            except LinkError:  # the link has gone: raise the same message
                failure, stop = LinkClosed, "NMT stop could not be sent"
            raise failure(
                f"the drive did not confirm that it is disabled ({reason}); {stop} and the host's "
                f"heartbeat ends now: check that the motor has stopped, or use the emergency stop; "
                f"`benchtool reset` then has it answer again"
            ) from reason
        self._touched = False  # only now, so that an interrupted exit is repeated
        with suppress(BenchError):  # the power stage is off, and `enable` sees to it again
            self._zero_targets()

    @contextmanager
    def enabled(self, mode: Mode) -> Iterator[None]:
        """Enable operation in `mode` for the length of a `with` block, and disable it on every exit.

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
                f"the drive is still in '{state.value}', {self.last_error()}: remove the cause first"
            )

    def quick_stop(self) -> None:
        """Ask for a quick stop; what it does is the drive's quick stop option (CiA 402-2, object 0x605A)."""
        self._ask(Command.QUICK_STOP)

    def _code_of(self, mode: Mode) -> int:
        """Return code of a mode: the cyclic mode's on a drive that has not the profile one, by its 0x6502."""
        supported = self.optional_number(Role.SUPPORTED_MODES) if len(mode.codes) > 1 else None
        code = None if supported is None else mode.supported_code(supported)
        return int(mode) if code is None else code

    def _zero_targets(self) -> None:
        for name in _TARGETS:
            target = self.dictionary.get(name)
            if target is None or not target.writable:
                continue
            try:
                self.write(target, 0)
            except SdoAbort as abort:
                if abort.code not in (Abort.NO_OBJECT, Abort.NO_SUB_INDEX):
                    raise

    def _walk_to(self, target: State) -> None:
        deadline_s = self.clock.now_s() + _TRANSITION_TIMEOUT_S
        asked = None
        while (state := self.state()) is not target:
            command = next_command(state, target)
            if state in (State.FAULT, State.FAULT_REACTION_ACTIVE):
                raise DriveFault(
                    f"the drive is in fault: {self.last_error()}; remove the cause, then reset it"
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

    def _walk_down(self) -> None:
        """Walk to switch on disabled; ask again where an answer was lost, as that does no harm here."""
        for _ in range(_DISABLING_TRIES - 1):
            with suppress(NoAnswer):
                self._walk_to(State.SWITCH_ON_DISABLED)
                return
        self._walk_to(State.SWITCH_ON_DISABLED)

    def _ask(self, command: Command) -> None:
        variable = self.dictionary[Role.CONTROLWORD]
        with self._naming(f"asking for '{command.value}'"):
            for word in command.controlwords:
                self.link.download(variable.index, variable.sub, variable.encode(word))

    def last_error(self) -> str:
        """Return the drive's last error, in words."""
        code = self.optional_number(Role.ERROR_CODE)
        return "no error code" if code is None else f"0x{code:04X} {error_text(code)}"
