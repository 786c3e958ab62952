"""The watchdog of the link: what feeds it, when it expires, and that the loss is latched."""

from __future__ import annotations

import math

from benchtool.emulator.firmware.supervision import LinkState, LinkSupervision

HOST_127_500_MS = 127 << 16 | 500


def _state(supervision: LinkSupervision) -> LinkState:
    return supervision.state


def _alive() -> LinkSupervision:
    supervision = LinkSupervision()
    supervision.configure(HOST_127_500_MS)
    supervision.feed(1.0)
    return supervision


def test_it_is_off_until_it_is_configured() -> None:
    supervision = LinkSupervision()
    supervision.feed(0.0)
    assert _state(supervision) is LinkState.OFF
    assert supervision.host_node_id == 0
    assert supervision.deadline_s() == math.inf
    assert supervision.may_enable


def test_the_power_stage_waits_for_the_first_heartbeat() -> None:
    supervision = LinkSupervision()
    supervision.configure(HOST_127_500_MS)
    assert (_state(supervision), supervision.host_node_id) == (LinkState.WAITING, 127)
    before = supervision.may_enable
    supervision.feed(1.0)
    assert (before, supervision.may_enable) == (False, True)
    assert supervision.deadline_s() == 1.5


def test_silence_is_a_loss_and_stays_one() -> None:
    supervision = _alive()
    assert not supervision.expire(1.499)
    assert supervision.expire(1.5)
    assert _state(supervision) is LinkState.LOST
    assert not supervision.expire(1.6), "a loss is reported once"
    supervision.feed(1.7)
    assert _state(supervision) is LinkState.LOST
    assert not supervision.may_enable
    assert supervision.losses == 1


def test_a_loss_is_forgotten_on_demand_only() -> None:
    supervision = _alive()
    supervision.expire(2.0)
    supervision.rearm()
    assert _state(supervision) is LinkState.WAITING
    supervision.feed(2.1)
    assert _state(supervision) is LinkState.ALIVE


def test_node_zero_or_timeout_zero_is_off() -> None:
    for value in (0, 127 << 16, 500):
        supervision = LinkSupervision()
        supervision.configure(value)
        assert _state(supervision) is LinkState.OFF
