"""The open session that a bench and its drive share, closed on every way out of the process."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import warnings
import weakref
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import TYPE_CHECKING, NoReturn

from benchtool.api.signals import shielded, uninterrupted
from benchtool.errors import BenchError, UsageError

if TYPE_CHECKING:
    from benchtool.api.enabled import EnabledDrive
    from benchtool.api.stream import Stream
    from benchtool.bench import Session


class Use(Enum):
    """What the drive of a connection is used for, in the order in which it is ended."""

    ENABLED = auto()
    STREAM = auto()


class Connection:
    """A session on a bench, used by one call at a time.

    Calls from several threads wait for each other. If nothing refers to it any more, or the interpreter ends,
    it is closed, with the drive disabled. In a process that was forked off it is of no use, and is not closed
    there: the drive is its parent's.

    Args:
        stack: closes the session.
        session: with a drive that was checked.
        link: address of the link, for messages.
    """

    def __init__(self, stack: ExitStack, session: Session, link: str) -> None:
        self.link = link
        self.enabled: EnabledDrive | None = None
        self.stream: Stream | None = None
        self._session: Session | None = session
        self._held = _Held(stack, link, os.getpid())
        self._lock = threading.RLock()
        self._finalizer = weakref.finalize(self, _close_forgotten, self._held)
        _open.add(self)

    def __reduce__(self) -> NoReturn:
        """An open bench stays in its process.

        Raises:
            UsageError: always.
        """
        raise UsageError(
            "an open bench cannot be pickled or sent to another process: open it where it is used, and pass "
            "blocks and results"
        )

    @property
    def closed(self) -> bool:
        """Whether it was closed, or is that of another process."""
        return self._session is None or not self._held.is_own

    @contextmanager
    def use(self) -> Iterator[Session]:
        """The session, for this thread alone.

        Raises:
            UsageError: it is closed, or was opened by the process that this one was forked off.
        """
        if not self._held.is_own:  # first: another thread of the parent may have held the lock
            raise UsageError(
                f"this bench was opened by process {self._held.process_id} and is used by {os.getpid()}, "
                f"which was forked off it: open it in the process that uses it"
            )
        with self._lock:
            if self._session is None:
                raise UsageError("this bench is closed: open it again with benchtool.open_bench(...)")
            yield self._session

    def close(self, error: BaseException | None = None) -> None:
        """Disable the drive and close what was opened; nothing if that was done already.

        Args:
            error: why, which what goes wrong here must not hide.

        Raises:
            StateError, LinkError: the drive does not confirm that it is disabled.
        """
        uninterrupted(lambda: self._end(error))

    def _end(self, error: BaseException | None) -> None:
        if not self._held.is_own:
            return
        with self._lock:
            if self._session is None:
                return
            self._session, self.enabled, self.stream = None, None, None
            self._finalizer.detach()
            _open.discard(self)
            self._held.close(error)

    def hold(self, what: Use, stack: ExitStack) -> None:
        """Take what ends a use of the drive, for the case that the bench is closed before it."""
        self._held.uses[what] = stack

    def give_up(self, what: Use) -> ExitStack:
        """Give back what `hold` took; it is the caller's to close."""
        return self._held.uses.pop(what)


@dataclass
class _Held:
    """What is to be closed by the process that opened it: the uses of the drive, then the session."""

    stack: ExitStack
    link: str
    process_id: int
    uses: dict[Use, ExitStack] = field(default_factory=dict)

    @property
    def is_own(self) -> bool:
        return self.process_id == os.getpid()

    def close(self, error: BaseException | None = None) -> None:
        """Close all of it, whatever of it fails, and let no signal cut that short."""
        everything = ExitStack()
        everything.push(self.stack)
        for use in reversed(Use):
            if use in self.uses:
                everything.push(self.uses[use])
        with shielded():
            everything.__exit__(type(error) if error else None, error, None)


_open: weakref.WeakSet[Connection] = weakref.WeakSet()


def _leave_to_parent() -> None:
    """In a process that was just forked off: have nothing of its parent's be closed when it ends.

    What is never freed runs no `finally` either, which would speak to the drive over the parent's link.
    """
    for connection in _open:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(connection))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


def _close_forgotten(held: _Held) -> None:
    """Close a connection that was not closed: nothing refers to it any more, or the interpreter ends."""
    if not held.is_own:
        return
    if sys.is_finalizing() or threading.current_thread() is threading.main_thread():
        _close(held)
        return
    # Any thread may collect garbage, also one that the link needs to receive what disabling waits for.
    threading.Thread(target=_close, args=(held,), name="benchtool-closing").start()


def _close(held: _Held) -> None:
    warnings.warn(f"a bench on '{held.link}' was not closed", ResourceWarning, stacklevel=2)
    try:
        held.close()
    except BenchError as failed:
        sys.stderr.write(f"benchtool: {failed}\n")
