"""Where time is real, a breach of a limit stops the motor although no caller waits, once, and is told."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchtool.block import Block, Channel
from benchtool.errors import CapabilityMissing, LimitTrip
from benchtool.profile import Limits
from benchtool.telemetry.limit_supervision import LimitSupervision


class _Drive:
    """A drive that is disabled at the end of its quick stop, as one over a real link."""

    def __init__(self) -> None:
        self.clock: Any = SimpleNamespace(virtual=False, now_s=lambda: 0.0)
        self.stops: list[str] = []
        self.supervision: LimitSupervision | None = None

    def quick_stop(self) -> None:
        self.stops.append(threading.current_thread().name)
        assert self.supervision is not None
        self.supervision.end()


def _block(omega_m: float) -> Block:
    return Block((Channel("omega_m", "rad/s"),), 0, 100, 1e-4, np.full((20, 1), omega_m))


def test_a_breach_that_no_caller_waits_for_stops_the_motor() -> None:
    drive = _Drive()
    told: list[str] = []
    supervised = LimitSupervision(drive, Limits(omega_m_rad_s=15.0), tell=told.append)  # type: ignore[arg-type]
    drive.supervision = supervised
    supervised.stream_opens(("omega_m",))
    for _ in range(2):  # it can be enabled again
        supervised.begin()
        supervised.take(_block(12.0))
        supervised.check()
        for _ in range(3):
            supervised.take(_block(18.0))
        supervised.end()  # waits for what stops it
        with pytest.raises(LimitTrip, match="omega_m is 18 rad/s"):
            supervised.check()
        supervised.check()
    assert drive.stops == ["benchtool-limits"] * 2
    assert len(told) == 2


def test_a_caller_and_the_thread_stop_it_once() -> None:
    drive = _Drive()
    supervised = LimitSupervision(drive, Limits(omega_m_rad_s=15.0))  # type: ignore[arg-type]
    drive.supervision = supervised
    supervised.stream_opens(("omega_m",))
    supervised.begin()
    supervised.take(_block(18.0))
    with pytest.raises(LimitTrip):
        supervised.check()
    supervised.end()
    assert len(drive.stops) == 1


@pytest.mark.parametrize("reads", [None, lambda: None])
def test_a_limited_temperature_that_is_not_read_keeps_the_drive_off(reads: Any) -> None:
    supervised = LimitSupervision(_Drive(), Limits(temperature_degC=80.0), reads)  # type: ignore[arg-type]
    with pytest.raises(CapabilityMissing, match="no thermometer reads the winding"):
        supervised.begin()


def test_a_temperature_beyond_its_limit_stops_the_motor() -> None:
    drive, readings = _Drive(), [60.0, 60.0, 90.0]
    supervised = LimitSupervision(drive, Limits(temperature_degC=80.0), lambda: readings.pop(0))  # type: ignore[arg-type]
    drive.supervision = supervised
    supervised.begin()
    supervised.check()
    drive.clock.now_s = lambda: 1.0
    with pytest.raises(LimitTrip, match="temperature is 90 degC"):
        supervised.check()
    assert len(drive.stops) == 1
