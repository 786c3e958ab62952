"""A drive that is enabled: its setpoints, and disabled on every way out."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Self, overload

from benchtool.api.connection import Connection, Use
from benchtool.api.drive import Drive
from benchtool.api.parameters import Given, physical
from benchtool.api.signals import ending_in_order, shielded, uninterrupted
from benchtool.errors import UsageError, ValueRefused
from benchtool.protocol import Mode

if TYPE_CHECKING:
    from benchtool.bench import Session
    from benchtool.protocol.dictionary import Variable

SETPOINTS: Final = ("omega_m_command", "torque_command", "psi_s_command")
"""What an enabled drive is told, by the names of the dictionary."""

_OF_MODE: Final = {"omega_m_command": Mode.VELOCITY, "torque_command": Mode.TORQUE}


class _Setpoint:
    """An attribute that is a setpoint of the drive."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, running: None, owner: type) -> Self: ...
    @overload
    def __get__(self, running: EnabledDrive, owner: type) -> float: ...
    def __get__(self, running: EnabledDrive | None, owner: type) -> Self | float:
        return self if running is None else running._told(self._name)

    def __set__(self, running: EnabledDrive, value: Given) -> None:
        running._tell(self._name, value)


class EnabledDrive(Drive):
    """A drive that is enabled within a `with` block, which it is entered by.

    A setpoint is written and read back. One that is beyond the rating of the motor, beyond the limits of the
    drive or of another mode is refused, and not sent. While Python code thinks, the host's heartbeat goes on
    in a thread of its own; if the process dies, the heartbeat stops and the drive stops the motor itself.
    After the block this object is of no use any more.
    """

    omega_m_command = _Setpoint()
    """Speed that velocity mode holds, in rad/s."""
    torque_command = _Setpoint()
    """Torque that torque mode makes, in Nm."""
    psi_s_command = _Setpoint()
    """Stator flux linkage that the law holds, in Wb; 0 leaves it to the law."""

    def __init__(self, connection: Connection, mode: Mode) -> None:
        super().__init__(connection)
        self._mode = mode
        self._active = False
        self._ended = False
        self._variables: dict[str, Variable] = {}

    @property
    def mode(self) -> Mode:
        """Its mode of operation."""
        return self._mode

    # ---- life ----------------------------------------------------------------------------------------------

    def __enter__(self) -> Self:
        """Enable the drive, with every target at zero.

        Raises:
            UsageError: it is enabled already, from here.
            ValueRefused, CapabilityMissing: the drive has not this mode.
            DriveFault, StateError, LinkError: it cannot be enabled; it is disabled.
        """
        from benchtool.run import require_mode

        if self._ended:
            raise UsageError("this enabling has ended: call drive.enabled(mode) again")
        with self._connection.use() as session:
            if (running := self._connection.enabled) is not None:
                raise UsageError(
                    f"the drive is enabled in {running.mode.name.lower()} mode already: leave that `with` "
                    f"block first, or call drive.disable()"
                )
            require_mode(session.drive, self._mode)
            with ExitStack() as stack:
                stack.enter_context(ending_in_order())
                try:
                    with shielded() as came:
                        self._begin(session, stack)
                        if came:  # the caller's block is not entered
                            self.__exit__(None, None, None)
                except BaseException as error:
                    if self._active:
                        self.__exit__(type(error), error, error.__traceback__)
                    raise
        return self

    def _begin(self, session: Session, stack: ExitStack) -> None:
        with stack.pop_all() as use:
            session.drive.connect()
            use.callback(session.drive.release)  # then another host may have it
            use.enter_context(session.drive.enabled(self._mode))
            self._connection.hold(Use.ENABLED, use.pop_all())
            self._active, self._connection.enabled = True, self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Disable the drive.

        Raises:
            StateError, LinkClosed: it does not confirm that it is disabled; a note of the exception that ends
                the block says so where there is one.
        """
        uninterrupted(lambda: self._end(kind, error, trace))

    def _end(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        active, self._active, self._ended = self._active, False, True
        if not active or self._connection.closed:
            return  # which has disabled it
        with self._connection.use():
            self._connection.enabled = None
            self._connection.give_up(Use.ENABLED).__exit__(kind, error, trace)

    # ---- setpoints -----------------------------------------------------------------------------------------

    def _tell(self, name: str, value: Given) -> None:
        from benchtool.run import within_rating

        with self._use() as session:
            variable = self._setpoint(session, name)
            number = float(physical(variable, value))
            if name in _OF_MODE:
                within_rating(number, self._mode, session.profile.motor)
            session.drive.raise_emergencies()
            session.drive.write(variable, number)

    def _told(self, name: str) -> float:
        with self._use() as session:
            return float(session.drive.number(self._setpoint(session, name)))

    def _setpoint(self, session: Session, name: str) -> Variable:
        """Return the object of a setpoint, in SI.

        Raises:
            ValueRefused: it is of another mode.
            CapabilityMissing: the drive has no such object, or not in SI.
        """
        from benchtool.drive import SPEED_SETPOINT, TORQUE_SETPOINT, in_si

        wanted = _OF_MODE.get(name, self._mode)
        if wanted is not self._mode:
            raise ValueRefused(
                f"the drive is enabled in {self._mode.name.lower()} mode, which has no {name}: enable it "
                f"with drive.enabled('{wanted.name.lower()}'); nothing was sent"
            )
        if name not in self._variables:
            quantities = {"omega_m_command": SPEED_SETPOINT, "torque_command": TORQUE_SETPOINT}
            self._variables[name] = (
                in_si(session.drive, quantities[name])
                if name in quantities
                else session.drive.dictionary[name]
            )
        return self._variables[name]

    @contextmanager
    def _use(self) -> Iterator[Session]:
        with super()._use() as session:
            if not self._active:
                seen = "has ended, and the drive is disabled" if self._ended else "has not begun"
                raise UsageError(
                    f"this enabling {seen}: use it within `with bench.drive.enabled(mode) as drive:`, and "
                    f"bench.drive outside"
                )
            yield session

    def __setattr__(self, name: str, value: Any) -> None:
        if name in SETPOINTS:
            object.__setattr__(self, name, value)
        else:
            super().__setattr__(name, value)

    def _no_attribute(self, name: str) -> str:
        close = difflib.get_close_matches(name, SETPOINTS, n=1)
        meant = f"did you mean '{close[0]}'? " if close else ""
        return f"no setpoint '{name}': {meant}the setpoints are {', '.join(SETPOINTS)}"


def mode_named(mode: str | Mode) -> Mode:
    """Return a mode by its name.

    Raises:
        ValueRefused: there is none.
    """
    if isinstance(mode, Mode):
        return mode
    names = {each.name.lower(): each for each in Mode}
    found = names.get(str(mode).lower())
    if found is None:
        close = difflib.get_close_matches({"speed": "velocity"}.get(str(mode), str(mode)), names, n=1)
        meant = f"did you mean '{close[0]}'? " if close else ""
        raise ValueRefused(f"no mode '{mode}': {meant}the modes are {', '.join(names)}; nothing was sent")
    return found
