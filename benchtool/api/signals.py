"""Signals while a drive is enabled: one that would end the process ends it in order, none cuts that short."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import Final

_Handler = Callable[[int, FrameType | None], object]

_ENDING: Final = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)
)


@contextmanager
def ending_in_order() -> Iterator[None]:
    """Have SIGTERM and SIGHUP raise SystemExit, which leaves every `with` block, for the length of this one.

    Handlers that the program has set stay; in a thread other than the main one nothing is set.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    found = [each for each in _ENDING if signal.getsignal(each) is signal.SIG_DFL]
    for number in found:
        signal.signal(number, _end)
    try:
        yield
    finally:
        # A bench that is forgotten may be closed by another thread, which cannot set handlers.
        own = threading.current_thread() is threading.main_thread()
        for number in found if own else ():
            handler = signal.getsignal(number)
            while isinstance(handler, _Deferring) and isinstance(handler.before, _Deferring):
                handler = handler.before  # shielded blocks within one another
            if isinstance(handler, _Deferring) and handler.before is _end:
                handler.before = signal.SIG_DFL  # it is put back at the end of that block
            elif handler is _end:
                signal.signal(number, signal.SIG_DFL)


@contextmanager
def shielded() -> Iterator[list[Callable[[], object]]]:
    """Keep signals from interrupting what the block does; the first that came is handled at its end.

    Yields:
        What is to be handled then; empty while no signal has come.
    """
    if threading.current_thread() is not threading.main_thread():
        yield []
        return
    came: list[Callable[[], object]] = []
    deferring: dict[int, _Deferring] = {}
    try:
        for number in (signal.SIGINT, *_ENDING):
            if callable(handler := signal.getsignal(number)):
                deferring[number] = _Deferring(handler, came)
                signal.signal(number, deferring[number])
        yield came
    finally:
        try:
            _put_back(deferring)
        except BaseException:  # a signal that is put back already came in
            _put_back(deferring)
            raise
    if came:
        came[0]()


def _put_back(deferring: Mapping[int, _Deferring]) -> None:
    for number, handler in deferring.items():
        signal.signal(number, handler.before)


def uninterrupted(end: Callable[[], None]) -> None:
    """Call `end` shielded, and once more if a signal came in before the shield was there.

    Args:
        end: does nothing when called again.
    """
    try:
        with shielded():
            end()
    except BaseException:
        with shielded():
            end()
        raise


class _Deferring:
    """A handler that keeps what the one before it is to do with a signal."""

    def __init__(self, before: _Handler, came: list[Callable[[], object]]) -> None:
        self.before: _Handler | signal.Handlers = before
        self._handle = before
        self._came = came

    def __call__(self, number: int, frame: FrameType | None) -> None:
        self._came.append(partial(self._handle, number, frame))


def _end(number: int, _frame: FrameType | None) -> None:
    raise SystemExit(128 + number)
