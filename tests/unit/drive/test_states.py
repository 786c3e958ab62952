"""Only a known state with the power stage off counts as disabled."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from benchtool.clock import VirtualClock
from benchtool.drive.parameters.transaction import require_disabled
from benchtool.drive.states import Cia402Node
from benchtool.errors import LinkClosed, StateError, ValueRefused
from benchtool.protocol.canopen.nmt import NmtCommand
from benchtool.protocol.cia402 import State, state_of
from benchtool.protocol.dictionary import Dictionary
from benchtool.shipped import shipped

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
    """A drive that returns the statuswords `words`, then always the last, and holds written values."""

    def __init__(self, *words: int) -> None:
        self.sent: list[NmtCommand] = []
        self._words = list(words)
        self._held: dict[tuple[int, int], bytes] = {}
        link: Any = SimpleNamespace(upload=self._upload, download=self._download, nmt=self.sent.append)
        dictionary = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
        self.clock = VirtualClock()
        self.node = Cia402Node(link, dictionary, "drive.eds", self.clock)

    def _download(self, index: int, sub: int, data: bytes) -> None:
        self._held[index, sub] = data

    def _upload(self, index: int, sub: int, *, length: int | None = None) -> bytes:
        if (index, sub) in self._held:
            return self._held[index, sub]
        assert (index, sub, length) == (0x6041, 0, 2)
        return (self._words.pop(0) if len(self._words) > 1 else self._words[0]).to_bytes(2, "little")


def test_a_drive_whose_state_cannot_be_told_is_not_taken_for_disabled() -> None:
    assert state_of(NO_STATE) is State.UNKNOWN
    drive = Walked(NO_STATE)
    with pytest.raises(StateError, match="did not confirm"):
        drive.node.disable()
    assert drive.sent == [NmtCommand.STOP]


def test_a_link_that_has_gone_leaves_the_same_to_be_told() -> None:
    """Without it the operator would read "connect again" while the motor may be running."""
    drive = Walked(OPERATION_ENABLED)

    def gone(*_: object, **__: object) -> None:
        raise LinkClosed("the link is closed; connect again")

    vars(drive.node.link).update(upload=gone, nmt=gone)
    with pytest.raises(LinkClosed, match=r"closed; .*NMT stop could not be sent .* use the emergency stop"):
        drive.node.disable()


def test_a_drive_that_takes_its_time_is_waited_for_and_not_for_ever() -> None:
    patient = Walked(*[OPERATION_ENABLED] * 300, SWITCH_ON_DISABLED)
    patient.node.disable()
    assert patient.sent == []
    stuck = Walked(OPERATION_ENABLED)
    with pytest.raises(StateError, match="stays in 'operation enabled'"):
        stuck.node.disable()
    assert stuck.clock.now_s() == pytest.approx(1.0, abs=0.1)
