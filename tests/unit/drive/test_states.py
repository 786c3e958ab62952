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
NO_STATE = 0x0002  # switched on, but not ready: no state of the standard


@pytest.mark.parametrize("state", list(State))
def test_only_a_known_state_without_power_counts_as_disabled(state: State) -> None:
    drive: Any = SimpleNamespace(state=lambda: state)
    if state in OFF:
        require_disabled(drive, "R_s can be set")
    else:
        with pytest.raises(ValueRefused, match=f"'{state.value}', R_s can be set .* nothing was sent"):
            require_disabled(drive, "R_s can be set")


def test_a_drive_whose_state_cannot_be_told_is_not_taken_for_disabled() -> None:
    sent: list[NmtCommand] = []
    link: Any = SimpleNamespace(
        upload=lambda index, sub: NO_STATE.to_bytes(2, "little"),
        download=lambda index, sub, data: None,
        nmt=sent.append,
    )
    variable = SimpleNamespace(
        index=0x6040,
        sub=0,
        decode=lambda data: int.from_bytes(data, "little"),
        encode=lambda word: word.to_bytes(2, "little"),
    )
    dictionary: Any = {"statusword": variable, "controlword": variable}
    assert state_of(NO_STATE) is State.UNKNOWN
    with pytest.raises(StateError, match="did not confirm"):
        Cia402Node(link, dictionary, "drive.eds", VirtualClock()).disable()
    assert sent == [NmtCommand.STOP]
