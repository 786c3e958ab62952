"""An observer of a drive gets every state and emergency, at the drive's tick."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, strategies as st

from benchtool.clock import VirtualClock
from benchtool.drive.states import Cia402Node
from benchtool.errors import DriveFault
from benchtool.link import ReceivedEmergency
from benchtool.link.clock_anchor import TickAnchor
from benchtool.protocol.canopen.emcy import Emergency
from benchtool.protocol.cia402 import State
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.roles import Role
from benchtool.protocol.dictionary.variable import Variable

_OVERCURRENT, _HEARTBEAT, _NONE = Emergency(0x2310, 0x03), Emergency(0x8130, 0x11), Emergency(0, 0)


class Listener:
    """Keeps its notifications."""

    def __init__(self) -> None:
        self.told: list[tuple[object, int | None]] = []

    def state(self, state: State, tick: int | None) -> None:
        self.told.append((state, tick))

    def emergency(self, emergency: Emergency, tick: int | None) -> None:
        self.told.append((emergency, tick))


def node(*alarms: ReceivedEmergency) -> Cia402Node:
    """A node with a statusword of 'fault', and these alarms."""
    link: Any = SimpleNamespace(emergencies=lambda: alarms, upload=lambda index, sub, length: b"\x08\x00")
    variable = Variable(0x6041, 0, "statusword", DataType.U16)
    dictionary: Any = {Role.STATUSWORD: variable}
    return Cia402Node(link, dictionary, "drive.eds", VirtualClock())


def test_all_emergencies_are_told_though_the_first_error_is_raised() -> None:
    drive, listener = (
        node(
            ReceivedEmergency(_NONE, 1.0),
            ReceivedEmergency(_OVERCURRENT, 2.0),
            ReceivedEmergency(_HEARTBEAT, 2.5),
        ),
        Listener(),
    )
    drive._anchor = TickAnchor(1000, 1.5, 1e-3)
    with drive.observed(listener), pytest.raises(DriveFault, match="0x2310"):
        drive.raise_emergencies()
    assert listener.told == [(_NONE, 500), (_OVERCURRENT, 1500), (_HEARTBEAT, 2000)]


def test_an_observer_gets_every_state_until_it_is_removed() -> None:
    drive, listener = node(), Listener()
    with drive.observed(listener):
        assert drive.state() is State.FAULT
    assert drive.state() is State.FAULT
    assert listener.told == [(State.FAULT, None)]  # the drive has told no tick yet


@given(tick=st.integers(0, 1 << 32), at_s=st.floats(0.0, 1e5), ahead=st.integers(-100_000, 10_000_000))
def test_a_tick_is_told_by_the_time_that_has_passed(tick: int, at_s: float, ahead: int) -> None:
    mark = TickAnchor(tick, at_s, 1e-4)
    assert mark.tick_at(at_s + ahead * 1e-4) == tick + ahead
    assert mark.tick_at(at_s + (ahead + 0.5) * 1e-4) == tick + ahead


def test_an_observer_that_fails_keeps_no_drive_from_telling_its_state() -> None:
    class Broken(Listener):
        def state(self, state: State, tick: int | None) -> None:
            raise ZeroDivisionError

    drive, listener = node(), Listener()
    with drive.observed(Broken()), drive.observed(listener):
        assert drive.state() is State.FAULT
    assert listener.told == [(State.FAULT, None)]
