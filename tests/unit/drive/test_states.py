"""What counts as disabled: nothing but a state that is known, and known to be off."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from benchtool.clock import VirtualClock
from benchtool.drive.parameters import require_disabled
from benchtool.drive.states import Cia402Node
from benchtool.errors import StateError, ValueRefused
from benchtool.protocol.cia402 import State, state_of
from benchtool.protocol.nmt import NmtCommand

OFF = {
    State.NOT_READY_TO_SWITCH_ON,
    State.SWITCH_ON_DISABLED,
    State.READY_TO_SWITCH_ON,
    State.SWITCHED_ON,
    State.FAULT,
}
OPERATION_ENABLED, SWITCH_ON_DISABLED = 0x0027, 0x0040
NO_STATE = 0x0002  # switched on, but not ready: no state of the standard


@pytest.mark.parametrize("state", list(State))
def test_only_a_known_state_without_power_counts_as_disabled(state: State) -> None:
    drive: Any = SimpleNamespace(state=lambda: state)
    if state in OFF:
        require_disabled(drive, "R_s can be set")
    else:
        with pytest.raises(ValueRefused, match=f"'{state.value}', R_s can be set .* nothing was sent"):
            require_disabled(drive, "R_s can be set")


class Walked:
    """A drive that tells `words`, the last one for ever, one every millisecond."""

    def __init__(self, *words: int) -> None:
        self.sent: list[NmtCommand] = []
        self._words = list(words)
        link: Any = SimpleNamespace(upload=self._upload, download=lambda *_: None, nmt=self.sent.append)
        variable = SimpleNamespace(
            index=0x6040,
            sub=0,
            decode=lambda data: int.from_bytes(data, "little"),
            encode=lambda word: word.to_bytes(2, "little"),
        )
        dictionary: Any = {"statusword": variable, "controlword": variable}
        self.clock = VirtualClock()
        self.node = Cia402Node(link, dictionary, "drive.eds", self.clock)

    def _upload(self, index: int, sub: int) -> bytes:
        return (self._words.pop(0) if len(self._words) > 1 else self._words[0]).to_bytes(2, "little")


def test_a_drive_whose_state_cannot_be_told_is_not_taken_for_disabled() -> None:
    assert state_of(NO_STATE) is State.UNKNOWN
    drive = Walked(NO_STATE)
    with pytest.raises(StateError, match="did not confirm"):
        drive.node.disable()
    assert drive.sent == [NmtCommand.STOP]


def test_a_drive_that_takes_its_time_is_waited_for_and_not_for_ever() -> None:
    patient = Walked(*[OPERATION_ENABLED] * 300, SWITCH_ON_DISABLED)
    patient.node.disable()
    assert patient.sent == []
    stuck = Walked(OPERATION_ENABLED)
    with pytest.raises(StateError, match="stays in 'operation enabled'"):
        stuck.node.disable()
    assert stuck.clock.now_s() == pytest.approx(1.0, abs=0.1)
