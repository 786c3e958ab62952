"""A drive at the other end of a link: supervised while it is commanded, disabled on every way out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import Self

from benchtool.clock import Clock
from benchtool.drive.identity import Identity
from benchtool.drive.reconnection import Reconnection
from benchtool.drive.states import Cia402Node
from benchtool.drive.supervision import LINK_TIMEOUT_S, LinkSupervision
from benchtool.errors import BenchError, LinkClosed, LinkError, StateError
from benchtool.link import Link
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.modes import Mode

_REOPEN_S = 0.2
_WATCH_S = 0.05


class RemoteDrive(Cia402Node):
    """A drive that is left disabled on every way out of its `with` block.

    Args:
        link: open link to the drive's node.
        dictionary: what its EDS says.
        source: name of that EDS, for messages.
        clock: the clock that waiting and heartbeats go by.
        reopen: opens the same link anew, for `reconnect`.
        allow_unsupervised: let it be enabled although nothing stops it when this host falls silent.
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
    ) -> None:
        super().__init__(link, dictionary, source, clock)
        self.supervision = LinkSupervision(self, allow_unsupervised=allow_unsupervised)
        self._reopen = reopen
        self._watches: list[Callable[[], None]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._touched:
                self.disable()
            self.supervision.disarm()
        except BenchError:
            # The first failure is the one to report; silence of the host's heartbeat stops the drive itself.
            if error is None:
                raise
        finally:
            self.stop_heartbeat()

    # ---- connection ---------------------------------------------------------------------------------------

    def connect(self) -> Identity:
        """Check identity and dictionary, and start the supervision of the link.

        Raises:
            NoAnswer, IdentityMismatch, DictionaryMismatch: as their names say.
            StateError: another host supervises the drive; nothing was changed.
            CapabilityMissing, SdoAbort, WriteNotVerified: the supervision cannot be armed, and the profile
                demands it.
        """
        identity = self.check()
        self.supervision.require_no_other_host()
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
        before = self._mark
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
        if before is not None and self._mark is not None:
            restarted = before.restarted_since(self._mark)
        return Reconnection(identity, restarted)

    def close_link(self) -> None:
        """Close the link that is in use, the first one or one that `reconnect` opened."""
        self.link.close()

    # ---- waiting -----------------------------------------------------------------------------------------

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

    # ---- link supervision -------------------------------------------------------------------------------

    def supervise(self, timeout_s: float = LINK_TIMEOUT_S) -> None:
        """Send the host's heartbeat, and have the drive stop the motor when it stays out for `timeout_s`.

        Raises:
            CapabilityMissing, SdoAbort, WriteNotVerified: it cannot be armed, and the profile demands it.
            StateError: another host has the drive enabled.
        """
        self.supervision.arm(timeout_s)
        self._commanded = True

    def stop_heartbeat(self) -> None:
        """Fall silent; a drive that is supervised stops the motor after its timeout."""
        self.supervision.fall_silent()

    def enable(self, mode: Mode) -> None:
        """As `Cia402Node.enable`, of a drive that watches this host.

        Raises:
            CapabilityMissing, SdoAbort, WriteNotVerified, StateError: it does not; it was not enabled.
        """
        self.supervision.require()
        super().enable(mode)

    def disable(self) -> None:
        """As `Cia402Node.disable`; a drive that does not confirm watches on, and this host is silent.

        Raises:
            StateError, LinkClosed: as there.
        """
        try:
            super().disable()
        except BenchError:
            with suppress(LinkError):  # what the heartbeat ran into when the link went
                self.stop_heartbeat()
            raise

    def _drop_link(self) -> None:
        with suppress(LinkError):  # what the heartbeat ran into when the link went
            self.stop_heartbeat()
        self.link.close()
