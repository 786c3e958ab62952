"""A thread with a bounded queue, which handles items in order and keeps failures for the caller."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Worker(Generic[Item]):
    """Handles items in a thread of its own until it is closed.

    After a failure of `handle` the remaining items are discarded, so that no caller blocks on a dead worker;
    the owner finds the failure by `check`.

    Args:
        name: of the thread.
        handle: called with each item.
        size: items that may wait.
    """

    def __init__(self, name: str, handle: Callable[[Item], None], size: int) -> None:
        self._handle = handle
        self._queue: queue.Queue[Item | None] = queue.Queue(size)
        self._failure: BaseException | None = None
        self._reported = False
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def failed(self) -> bool:
        return self._failure is not None

    def put(self, item: Item, timeout_s: float = 0.0) -> bool:
        """Put an item, waiting for room up to `timeout_s` of wall time; return whether there was room."""
        try:
            self._queue.put(item, block=timeout_s > 0.0, timeout=timeout_s or None)
        except queue.Full:
            return False
        return True

    def settle(self) -> bool:
        """Wait until every item so far has been handled; return whether there was one. For
        `Clock.register`."""
        with self._queue.all_tasks_done:
            if not self._queue.unfinished_tasks:
                return False
            while self._queue.unfinished_tasks:
                self._queue.all_tasks_done.wait()
        return True

    def check(self) -> None:
        """Raise the exception of `handle`, once."""
        if self._failure is not None and not self._reported:
            self._reported = True
            raise self._failure

    def close(self) -> None:
        """Handle queued items, and end the thread; a second call does nothing."""
        if not self._closed:
            self._closed = True
            self._queue.put(None)
            self._thread.join()

    def _run(self) -> None:
        while True:
            item = self._queue.get()
            try:
                if item is None:
                    return
                if self._failure is None:
                    self._handle(item)
            except BaseException as failure:  # noqa: BLE001 # re-raised at the caller of check
                self._failure = failure
            finally:
                self._queue.task_done()
