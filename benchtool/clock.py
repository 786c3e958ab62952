"""Clocks, real and virtual; the only module of the project that sleeps.

In virtual time waiting *is* simulating: `wait` brings every follower (the emulated drive) up to each moment
at which something is due, so that an experiment runs as fast as it computes, and its result does not depend
on thread timing.
"""

from __future__ import annotations

import heapq
import itertools
import threading
import time
from collections.abc import Callable
from typing import ClassVar, Protocol

_UNDER_WAY_S = 0.001


class Timer(Protocol):
    """A repeating call."""

    def cancel(self) -> None:
        """Stop it; on return the action is not running and will not run again."""


class Clock(Protocol):
    """Clock of host and emulator; seconds, monotonic, from an arbitrary origin."""

    virtual: ClassVar[bool]
    """Whether time advances only inside `wait`: periods are exact, whatever the computer does."""

    @property
    def paced(self) -> bool:
        """Whether time passes as that of the wall clock does."""

    def now_s(self) -> float:
        """Return the present."""

    def wait(self, duration_s: float) -> None:
        """Return when `duration_s` has passed."""

    def call_every(self, period_s: float, action: Callable[[], None]) -> Timer:
        """Call `action` now and then every `period_s`, until cancelled."""

    def settle(self) -> bool:
        """Wait until everything sent so far, and everything sent in response, is handled; return whether that
        is certain.

        If true, nothing more will come before time moves. A real clock cannot know, and returns False at
        once.
        """

    def register(self, settle: Callable[[], bool]) -> None:
        """Register a receiver: virtual time calls `settle()` before it moves, which waits until everything
        sent to the receiver is handled, and returns whether there was anything."""

    def unregister(self, callback: Callable[..., object]) -> None:
        """Undo `register`."""


class RealClock:
    """The wall clock."""

    virtual: ClassVar[bool] = False

    @property
    def paced(self) -> bool:
        """Always."""
        return True

    def now_s(self) -> float:
        return time.monotonic()

    def wait(self, duration_s: float) -> None:
        time.sleep(max(0.0, duration_s))

    def call_every(self, period_s: float, action: Callable[[], None]) -> Timer:
        return _RealTimer(period_s, action)

    def settle(self) -> bool:
        return False

    def register(self, settle: Callable[[], bool]) -> None:
        """Does nothing: this clock does not wait for receivers."""

    def unregister(self, callback: Callable[..., object]) -> None:
        """Does nothing."""


class _RealTimer:
    def __init__(self, period_s: float, action: Callable[[], None]) -> None:
        self._period_s = period_s
        self._action = action
        self._stop = threading.Event()
        self._failure: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="benchtool-timer", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        self._stop.set()
        if self._thread is not threading.current_thread():
            self._thread.join()
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure

    def _run(self) -> None:
        due_s = time.monotonic()
        try:
            while not self._stop.wait(max(0.0, due_s - time.monotonic())):
                self._action()
                due_s += self._period_s
        except BaseException as failure:  # noqa: BLE001 # re-raised at the caller of cancel
            self._failure = failure


class VirtualClock:
    """Simulated time that advances only inside `wait`.

    Args:
        paced: hold virtual time to the wall clock's, from the first `wait` on.
        catch_up_s: wall-clock seconds by which a paced clock may fall behind and catches up;
            a longer delay is given up, and counted in `late_s`.
        speed: virtual seconds in a wall-clock second, of a paced clock.
        step_s: longest virtual step of a paced clock: the longest delay of external input.

    Raises:
        ValueError: speed or step are not positive.
    """

    virtual: ClassVar[bool] = True

    def __init__(
        self, *, paced: bool = False, speed: float = 1.0, step_s: float = 0.02, catch_up_s: float = 1.0
    ) -> None:
        if not (speed > 0.0 and step_s > 0.0):
            raise ValueError(f"speed of {speed:g} and steps of {step_s:g} s: both must be positive")
        self.late_s = 0.0
        """Wall-clock seconds by which a paced clock has fallen behind for good."""
        self._now_s = 0.0
        self._pace = _Pace(speed, catch_up_s) if paced else None
        self._step_s = step_s
        self._order = itertools.count()
        self._due: list[tuple[float, int, _VirtualTimer]] = []
        self._followers: list[Callable[[float], None]] = []
        self._settlers: list[Callable[[], bool]] = []
        self._carriers: list[Callable[[], bool]] = []

    @property
    def paced(self) -> bool:
        """See `Clock.paced`."""
        return self._pace is not None

    def now_s(self) -> float:
        return self._now_s

    def follow(self, advance: Callable[[float], None]) -> None:
        """Call `advance(now_s)` for every new moment, for a process that runs on this clock."""
        self._followers.append(advance)

    def register(self, settle: Callable[[], bool]) -> None:
        """See `Clock.register`."""
        self._settlers.append(settle)

    def unregister(self, callback: Callable[..., object]) -> None:
        """Undo `follow` or `register`."""
        self._followers = [each for each in self._followers if each != callback]
        self._settlers = [each for each in self._settlers if each != callback]

    def carry(self, is_under_way: Callable[[], bool]) -> None:
        """Register a wire that may take its time: `is_under_way()` tells whether something is on it."""
        self._carriers.append(is_under_way)

    def is_under_way(self) -> bool:
        """Return whether something will arrive when time passes."""
        return any(each() for each in self._carriers)

    def settle(self) -> bool:
        """See `Clock.settle`."""
        busy = True
        while busy:
            outcomes = [settle() for settle in self._settlers]
            busy = any(outcomes)
        return True

    def wait(self, duration_s: float) -> None:
        end_s = self._now_s + max(0.0, duration_s)
        self.settle()
        while True:
            next_s = min(end_s, self._due[0][0]) if self._due else end_s
            if self._pace is not None:
                next_s = min(next_s, self._now_s + self._step_s)
                self.late_s += self._pace.until(self._now_s, next_s)
            self._move_to(next_s)
            if self._now_s >= end_s:
                return

    def call_every(self, period_s: float, action: Callable[[], None]) -> Timer:
        timer = _VirtualTimer(period_s, action)
        action()
        heapq.heappush(self._due, (self._now_s + period_s, next(self._order), timer))
        return timer

    def _move_to(self, now_s: float) -> None:
        for advance in list(self._followers):
            advance(now_s)
        self._now_s = now_s
        self.settle()
        while self._due and self._due[0][0] <= now_s:
            due_s, order, timer = heapq.heappop(self._due)
            if timer.cancelled:
                continue
            timer.action()
            heapq.heappush(self._due, (due_s + timer.period_s, order, timer))
            self.settle()


def drained(clock: Clock, arrived: Callable[[], bool], timeout_s: float) -> bool:
    """Return whether it is certain that nothing more will come, or `arrived` has become true.

    In virtual time what is under way for a while, on a wire with a delay, is waited for up to `timeout_s`.
    """
    if not clock.settle():
        return False
    if isinstance(clock, VirtualClock):
        end_s = clock.now_s() + timeout_s
        while not arrived() and clock.now_s() < end_s and clock.is_under_way():
            clock.wait(_UNDER_WAY_S)
    return True


class _Pace:
    """The moments of the wall clock at which those of virtual time are due."""

    def __init__(self, speed: float, catch_up_s: float) -> None:
        self._speed = speed
        self._catch_up_s = catch_up_s
        self._origin_s: float | None = None

    def until(self, now_s: float, next_s: float) -> float:
        """Sleep until virtual time may go from one moment to the next; return the wall-clock seconds given
        up."""
        wall_s = time.monotonic()
        if self._origin_s is None:
            self._origin_s = wall_s - now_s / self._speed
        ahead_s = self._origin_s + next_s / self._speed - wall_s
        if ahead_s >= -self._catch_up_s:
            time.sleep(max(0.0, ahead_s))
            return 0.0
        self._origin_s -= ahead_s
        return -ahead_s


class _VirtualTimer:
    def __init__(self, period_s: float, action: Callable[[], None]) -> None:
        self.period_s = period_s
        self.action = action
        self.cancelled = False

    def cancel(self) -> None:
        self.cancelled = True
