"""A drive at the other end of a link: supervised while it is commanded, disabled on every exit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import Self

from benchtool.clock import Clock
from benchtool.drive.identity import Identity
from benchtool.drive.quantities import SPEED, in_si
from benchtool.drive.reconnection import Reconnection
from benchtool.drive.states import Cia402Node
from benchtool.drive.supervision import LINK_TIMEOUT_S, LinkSupervision
from benchtool.drive.watch import Watch, require_alone
from benchtool.errors import BenchError, LinkClosed, LinkError, StateError
from benchtool.link import Link, StreamSupervisor
from benchtool.protocol import Command, Mode, State
from benchtool.protocol.dictionary import Dictionary

_REOPEN_S = 0.2
_WATCH_S = 0.05
_QUICK_STOP_S = 1.0
_QUICK_STOP_POLL_S = 0.005
_BRAKES_WITHIN_S = 0.1
_SLOWER = 0.95
ANGLE_KNOWN = "angle_known"
"""Object of a drive that does not know its rotor angle at power-up."""


class RemoteDrive(Cia402Node):
    """A drive that is disabled on every exit of its `with` block.

    Args:
        link: open link to the drive's node.
        dictionary: what its EDS says.
        source: name of that EDS, for messages.
        clock: the clock that waiting and heartbeats go by.
        reopen: opens the same link again, for `reconnect`.
        allow_unsupervised: allow enabling without link supervision.
        link_timeout_s: time without a heartbeat of this host after which the drive stops the motor.
        prove_watchdog: prove that by silence before the drive is enabled for the first time.

    Attributes:
        supervisor: looks at what an enabled drive streams; None where nothing is to be looked at.
        index_search: has the index of its encoder pass, where its angle is not known; None: it is not to turn
            the shaft for that.
    """

    def __init__(
        self,
        link: Link,
        dictionary: Dictionary,
        source: str,
        clock: Clock,
        *,
        reopen: Callable[[], Link] | None = None,
        allow_unsupervised: bool = False,
        link_timeout_s: float = LINK_TIMEOUT_S,
        prove_watchdog: bool = False,
    ) -> None:
        super().__init__(link, dictionary, source, clock)
        self.supervision = LinkSupervision(
            self, allow_unsupervised=allow_unsupervised, timeout_s=link_timeout_s
        )
        self._prove_watchdog = prove_watchdog
        self._proven: Identity | None = None
        self.supervisor: StreamSupervisor | None = None
        self.index_search: Callable[[], None] | None = None
        self._reopen = reopen
        self._watch = Watch(self)
        self._watches: list[Callable[[], None]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._touched:
                self.disable()
        except BenchError:
            # Report the first failure; the drive stops by itself when the host's heartbeat ends.
            if error is None:
                raise
        finally:
            self.release()

    # ---- connection ---------------------------------------------------------------------------------------

    def connect(self) -> Identity:
        """Check identity and dictionary, and start the supervision of the link.

        Raises:
            NoAnswer: the drive does not answer. IdentityMismatch, DictionaryMismatch: it is another drive.
            StateError: another host supervises the drive; nothing was changed.
            CapabilityMissing, SdoAbort, WriteNotVerified: the supervision cannot be armed, and the profile
                demands it.
        """
        identity = self.check()
        self.supervision.require_no_other_host()
        self.supervise()
        return identity

    def reconnect(self, timeout_s: float) -> Reconnection:
        """Open the link again after it was lost, and check the identity of the drive.

        A drive that was supervised or enabled from here is so again, supervised and left disabled: its link
        supervision has stopped the motor meanwhile, and if that made a fault, `reset_fault` is needed before
        it can be enabled. A drive that was only read is left as it is.

        Raises:
            LinkError: the link could not be opened within `timeout_s`.
            IdentityMismatch, DictionaryMismatch: another drive answers.
            StateError: the drive does not confirm that it is disabled.
        """
        if self._reopen is None:
            raise LinkClosed("this link cannot be opened again: open another session")
        before = self._anchor
        deadline_s = self.clock.now_s() + timeout_s
        while True:
            self._drop_link()
            try:
                self.link = self._reopen()
                identity = self.check()
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
        if before is not None and self._anchor is not None:
            restarted = before.restarted_since(self._anchor)
        return Reconnection(identity, restarted)

    def close_link(self) -> None:
        """Close the link that is in use, the first one or one that `reconnect` opened."""
        self.link.close()

    # ---- waiting -----------------------------------------------------------------------------------------

    def wait(self, duration_s: float) -> None:
        """Let drive time pass; a fault or an exception of a watch ends it.

        Raises:
            DriveFault, StateError, NoAnswer: as `raise_emergencies`.
        """
        remaining_s = duration_s
        while remaining_s > 0.0:
            step_s = min(_WATCH_S, remaining_s)
            self.clock.wait(step_s)
            remaining_s -= step_s
            self.raise_emergencies()

    def raise_emergencies(self) -> None:
        """As `Cia402Node.raise_emergencies`; of an enabled drive also what it cannot report itself, and what
        its supervisor and the watches found.

        Raises:
            DriveFault: it reported an error, or is in fault.
            StateError: it restarted, or is not enabled any more.
            NoAnswer: it is not heard any more.
            LimitTrip: a limit was passed; it was stopped.
        """
        super().raise_emergencies()
        self._watch.check()
        if self.supervisor is not None:
            self.supervisor.check()
        for check in self._watches:
            check()

    @contextmanager
    def watched(self, check: Callable[[], None]) -> Iterator[None]:
        """Call `check` while `wait` waits; it may raise an exception to end the run."""
        self._watches.append(check)
        try:
            yield
        finally:
            self._watches.remove(check)

    # ---- link supervision -------------------------------------------------------------------------------

    def supervise(self, timeout_s: float | None = None) -> None:
        """Send the host's heartbeat, and have the drive stop the motor when it is missing for `timeout_s`, by
        default what was asked for last.

        Raises:
            CapabilityMissing, SdoAbort, WriteNotVerified: it cannot be armed, and the profile demands it.
            StateError: another host has the drive enabled.
        """
        self.supervision.arm(timeout_s)
        self._commanded = True

    def release(self) -> None:
        """End the supervision of a drive and the heartbeat: another host may command it.

        One that has not confirmed that it is disabled watches on, and this host is silent.
        """
        try:
            if not self._touched:
                self.supervision.disarm()
        finally:
            self.stop_heartbeat()

    def stop_heartbeat(self) -> None:
        """Stop the heartbeat; a supervised drive stops the motor after its timeout."""
        self.supervision.stop_sending()

    def enable(self, mode: Mode) -> None:
        """As `Cia402Node.enable`, of a drive that watches this host, and whose number is its own.

        Raises:
            CapabilityMissing, SdoAbort, WriteNotVerified, StateError: it does not watch, two nodes have its
                number, or it does not know its rotor angle, which `mode` needs; it was not enabled.
            DictionaryMismatch: its firmware has become another one.
        """
        self.require_dictionary()
        self.supervision.require()
        self._require_proof()
        require_alone(self)
        self._require_angle(mode)
        if self.supervisor is not None:
            self.supervisor.begin()
        super().enable(mode)
        self._watch.begin()

    def _require_angle(self, mode: Mode) -> None:
        if not mode.needs_rotor_angle or self.optional_number(ANGLE_KNOWN) != 0:
            return
        if self.index_search is None:
            raise StateError(
                "the drive does not know its rotor angle: the index of its encoder (encoder_reference) has "
                "not passed since power-up; turn the shaft by hand, up to one revolution, or state "
                "drive.index_search_A in the profile, the current by which the drive turns it; it was not "
                "enabled"
            )
        self.index_search()

    def _require_proof(self) -> None:
        if not self._prove_watchdog:
            return
        identity = self.identify()
        if identity != self._proven:
            self.supervision.prove()
            self._proven = identity

    def quick_stop(self) -> None:
        """Brake to standstill as the drive's quick stop does it, for a second at most, and disable the drive.

        A drive whose rotor angle is wrong does not brake the shaft: one that is not slower after a tenth of a
        second, or after the next, is disabled at once.

        Raises:
            BenchError: the drive does not answer, or refuses; it is disabled if it can be.
        """
        self._watch.end()
        try:
            speed = in_si(self, SPEED)
            before = abs(self.number(speed))
            self._ask(Command.QUICK_STOP)
            begin_s = looked_s = self.clock.now_s()
            while self.state() is State.QUICK_STOP_ACTIVE:
                self.clock.wait(_QUICK_STOP_POLL_S)
                now_s = self.clock.now_s()
                if now_s - begin_s >= _QUICK_STOP_S:
                    break
                if now_s - looked_s >= _BRAKES_WITHIN_S:
                    looked_s, present = now_s, abs(self.number(speed))
                    if not present < _SLOWER * before:
                        break
                    before = present
        finally:
            self.disable()

    def disable(self) -> None:
        """As `Cia402Node.disable`; a drive that does not confirm keeps watching, and the heartbeat stops.

        Raises:
            StateError, LinkClosed: as there.
        """
        self._watch.end()
        try:
            super().disable()
        except BenchError:
            with suppress(LinkError):  # the heartbeat failed when the link was lost
                self.stop_heartbeat()
            raise
        finally:
            if self.supervisor is not None:
                self.supervisor.end()

    def _drop_link(self) -> None:
        with suppress(LinkError):  # the heartbeat failed when the link was lost
            self.stop_heartbeat()
        self.link.close()
