"""The receive thread of a server; the exception that ends it is kept."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Receiver:
    """Calls `receive` repeatedly until it is stopped, or until `receive` raises.

    Args:
        name: of the thread.
        receive: waits for what comes, a fraction of a second at most, and handles it.
        at_end: gives the wire back, in whichever way the thread ends.
        wake: has a `receive` that waits return, so that `stop` need not wait for it.

    Attributes:
        gone: the OSError raised when the wire was lost.
        failure: any other exception: a defect.
    """

    def __init__(
        self,
        name: str,
        receive: Callable[[], None],
        at_end: Callable[[], None],
        wake: Callable[[], None] = lambda: None,
    ) -> None:
        self.gone: OSError | None = None
        self.failure: BaseException | None = None
        self._receive = receive
        self._at_end = at_end
        self._wake = wake
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """End the thread and wait for it; a second call does nothing."""
        self._stopping.set()
        self._wake()
        self._thread.join()

    def lose(self, reason: OSError) -> None:
        """Note that a write found the wire lost."""
        if not self._stopping.is_set():
            self.gone = self.gone or reason
        self._stopping.set()

    def pause(self, duration_s: float) -> None:
        """Let the wire recover, or return at once when the thread is to end."""
        self._stopping.wait(duration_s)

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                self._receive()
        except OSError as reason:
            self.lose(reason)
        except BaseException as failure:  # noqa: BLE001 # raised again by the node
            self.failure = failure
        finally:
            self._at_end()
