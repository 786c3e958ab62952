"""The receive loop of a CAN bus, which tolerates errors of drivers and disturbed lines."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Final

import can

from benchtool.link.canopen.virtual import FrameBurst, Received, VirtualTimeBus

_RECEIVE_S = 0.05
_ERROR_PAUSE_S = 0.001
_ERRORS_IN_A_ROW = 100

FAILING_S: Final = _ERRORS_IN_A_ROW * _ERROR_PAUSE_S * 10.0
"""Time for which a failing bus may still count as working."""


def receive_frames(
    bus: can.BusABC,
    stopping: threading.Event,
    handle: Callable[[can.Message], None],
    on_error: Callable[[], None] = lambda: None,
    handle_burst: Callable[[FrameBurst], None] | None = None,
) -> Exception | None:
    """Hand every frame of a bus to `handle` until `stopping` is set, in the calling thread.

    Args:
        bus: open bus.
        stopping: ends the loop, within 0.05 s.
        handle: takes a frame; what it raises counts as an error of the bus.
        on_error: called for each error.
        handle_burst: takes frames that were sent at once, on a bus that knows; None: `handle` takes each.

    Returns:
        The last of 100 errors in a row, which end the loop; None where it was stopped.
    """

    def take(received: Received) -> None:
        if not isinstance(received, FrameBurst):
            handle(received)
        elif handle_burst is not None:
            handle_burst(received)
        else:
            for frame in received:
                handle(frame)

    def receive() -> None:
        frame = bus.recv(_RECEIVE_S)
        if frame is not None:
            handle(frame)

    if isinstance(bus, VirtualTimeBus) and bus.handle_with(take):
        try:
            return _repeat(partial(bus.serve, _RECEIVE_S), stopping, on_error)
        finally:
            bus.leave()
    return _repeat(receive, stopping, on_error)


def _repeat(
    receive: Callable[[], None], stopping: threading.Event, on_error: Callable[[], None]
) -> Exception | None:
    errors = 0
    while not stopping.is_set():
        try:
            receive()
        except Exception as error:  # noqa: BLE001 # drivers raise anything at a line that is disturbed
            on_error()
            errors += 1
            if errors == _ERRORS_IN_A_ROW:
                return error
            stopping.wait(_ERROR_PAUSE_S)
        else:
            errors = 0
    return None


def stop_receiving(bus: can.BusABC, stopping: threading.Event) -> None:
    """Set `stopping`, and have a loop that waits for frames see it at once, where the bus can be woken."""
    stopping.set()
    if isinstance(bus, VirtualTimeBus):
        bus.wake()
