"""Disturbed transmission, one direction of one wire: a pure, seeded stage between wire and server.

Frames go in with the time at which they were sent, and come out when they arrive. The same seed, faults and
frames give the same arrivals.
"""

from __future__ import annotations

import heapq
import itertools
import random
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Generic, TypeVar

T = TypeVar("T")

NEVER_S = float("inf")


class Way(StrEnum):
    """Direction of frames."""

    TO_DRIVE = "to_drive"
    TO_HOST = "to_host"


class Harm(StrEnum):
    """What happens to a frame that is hit."""

    LOST = "lost"
    LATE = "late"
    TWICE = "twice"
    OVERTAKEN = "overtaken"
    CORRUPTED = "corrupted"
    HELD = "held"
    """It arrives at `until_s`."""


@dataclass(frozen=True, eq=False)
class Disturbance:
    """One disturbance of a wire: `share` of the frames of these ways is hit; `time_s` is the delay of a late
    or overtaken one."""

    harm: Harm
    ways: frozenset[Way]
    share: float = 1.0
    time_s: float = 0.0
    until_s: float = NEVER_S


@dataclass
class Disturbances:
    """What disturbs all wires of a drive at present; `seed` is of the random draws."""

    seed: int = 0
    active: tuple[Disturbance, ...] = ()
    harmed: dict[Harm, int] = field(default_factory=dict)
    """Frames that were hit, by what happened to them."""

    def begin(self, disturbance: Disturbance) -> None:
        self.active = (*self.active, disturbance)

    def end(self, disturbance: Disturbance) -> None:
        self.active = tuple(each for each in self.active if each is not disturbance)

    def count(self, harm: Harm) -> None:
        self.harmed[harm] = self.harmed.get(harm, 0) + 1


class Stage(Generic[T]):
    """One direction of one wire.

    Args:
        way: its direction.
        disturbances: of all wires of the drive.
        corrupt: returns the frame as it arrives with one bit flipped; None if the controller drops it.
    """

    def __init__(
        self,
        way: Way,
        disturbances: Disturbances,
        corrupt: Callable[[T, random.Random], T | None],
    ) -> None:
        self._way = way
        self._disturbances = disturbances
        self._random = random.Random(f"{disturbances.seed} {way}")
        self._corrupt = corrupt
        self._order = itertools.count()
        self._waiting: list[tuple[float, int, T]] = []
        self._overtaken: list[tuple[float, T]] = []
        self._lock = threading.Lock()  # a serial server's writer sends as well

    @property
    def is_undisturbed(self) -> bool:
        """Whether all that is sent now arrives now."""
        return not self._disturbances.active and not self._waiting and not self._overtaken

    def passed(self, frame: T, now_s: float) -> Sequence[T]:
        """Return what arrives now, of a frame that is sent now."""
        if self.is_undisturbed:
            return (frame,)
        with self._lock:
            arriving: list[T] = []
            for each, delay_s, overtaken in self._fate(frame, now_s):
                if overtaken:
                    self._overtaken.append((now_s + delay_s, each))
                elif delay_s > 0.0:
                    heapq.heappush(self._waiting, (now_s + delay_s, next(self._order), each))
                else:
                    arriving.append(each)
            if arriving:  # what these have overtaken follows them
                arriving += [each for _, each in self._overtaken]
                self._overtaken.clear()
            return arriving

    def due(self, now_s: float) -> Sequence[T]:
        """Return what has waited until now, in the order in which it arrives."""
        if not self._waiting and not self._overtaken:
            return ()
        with self._lock:
            arriving: list[T] = []
            while self._waiting and self._waiting[0][0] <= now_s:
                arriving.append(heapq.heappop(self._waiting)[2])
            arriving += [each for at_s, each in self._overtaken if at_s <= now_s]
            self._overtaken = [each for each in self._overtaken if each[0] > now_s]
            return arriving

    def next_s(self) -> float:
        """Return when the next frame that waits arrives."""
        if not self._waiting and not self._overtaken:
            return NEVER_S
        with self._lock:
            moments = [at_s for at_s, _ in self._overtaken]
            return min([*moments, self._waiting[0][0]] if self._waiting else moments, default=NEVER_S)

    def clear(self) -> None:
        """Drop what waits: the client has gone."""
        with self._lock:
            self._waiting.clear()
            self._overtaken.clear()

    def _fate(self, frame: T, now_s: float) -> list[tuple[T, float, bool]]:
        """Return the copies of a frame, each with its delay and whether the next frame overtakes it."""
        copies: list[tuple[T, float, bool]] = [(frame, 0.0, False)]
        for each in self._disturbances.active:
            if self._way not in each.ways:
                continue
            if self._random.random() >= each.share:
                continue
            self._disturbances.count(each.harm)
            match each.harm:
                case Harm.LOST:
                    return []
                case Harm.LATE:
                    copies = [(copy, delay_s + each.time_s, held) for copy, delay_s, held in copies]
                case Harm.HELD:
                    copies = [(copy, each.until_s - now_s, False) for copy, _, _ in copies]
                case Harm.TWICE:
                    copies = [*copies, *copies]
                case Harm.OVERTAKEN:
                    copies = [(copy, each.time_s, True) for copy, _, _ in copies]
                case Harm.CORRUPTED:
                    damaged = [(self._corrupt(copy, self._random), *rest) for copy, *rest in copies]
                    copies = [(copy, *rest) for copy, *rest in damaged if copy is not None]  # type: ignore[misc]
        return copies
