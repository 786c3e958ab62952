"""What the host's CANopen link receives besides answers, and what becomes of it when its adapter fails."""

from __future__ import annotations

from collections.abc import Callable

import can
import canopen
import pytest

from benchtool.clock import RealClock, VirtualClock
from benchtool.errors import LinkClosed, LinkError, NoAnswer
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.canopen.sdo_client import SdoClient
from benchtool.link.canopen.virtual import VirtualTimeBus
from benchtool.protocol.canopen.emcy import Emergency
from benchtool.protocol.canopen.nmt import NmtCommand, NmtState
from tests.wire.endpoints import NODE, ScriptedBus, Served, Step, frame, script, sdo

VALUE = "43 00 20 01 78 56 34 12"


# ---- the receive thread ------------------------------------------------------------------------------------


def test_reception_survives_what_a_driver_raises(scripted: ScriptedBus, host: CanopenLink) -> None:
    errors = [
        can.CanOperationError("noise"),
        ValueError("invalid literal"),
        IndexError("short"),
        OSError("again"),
    ]
    steps: list[Step] = [*errors * 20, frame(0x706, "05"), *errors * 20]
    for step in steps:
        scripted.arriving.put(step)
    scripted.answer = script([ValueError("noise"), sdo(VALUE)])
    assert host.upload(0x2000, 1) == bytes.fromhex("78563412")
    assert host.counters.receive_errors == 161


def test_malformed_frames_are_dropped_and_counted(scripted: ScriptedBus, host: CanopenLink) -> None:
    bad = [
        sdo("43 00 20 01"),
        frame(0x700 + NODE, "05 00"),
        frame(0x700 + NODE, "63"),
        frame(0x080 + NODE, "10 23"),
        frame(0x580 + NODE, VALUE, is_extended_id=True),
        frame(0x580 + NODE, "", is_remote_frame=True, dlc=8),
        can.Message(is_error_frame=True),
    ]
    scripted.answer = script([*bad, sdo(VALUE)])
    assert host.upload(0x2000, 1) == bytes.fromhex("78563412")
    assert host.counters.frames_received == len(bad) + 1
    assert host.counters.frames_dropped == len(bad)
    assert host.emergencies() == ()
    assert host.heartbeat_state() is None


def test_frames_of_other_nodes_are_none_of_its_business(scripted: ScriptedBus, host: CanopenLink) -> None:
    others = [frame(0x586, VALUE), frame(0x706, "05"), frame(0x086, "10 23 01 00 00 00 00 00")]
    scripted.answer = script([*others, sdo(VALUE)])
    assert host.upload(0x2000, 1) == bytes.fromhex("78563412")
    assert host.counters.frames_dropped == 0
    assert (host.heartbeat_state(), host.emergencies()) == (None, ())


def test_unrequested_answers_do_not_accumulate(served: Served, channel: str) -> None:
    served.objects[0x2000, 1] = b"\x07"
    bus = VirtualTimeBus(channel)
    with CanopenLink(bus, NODE, RealClock()) as link:
        for _ in range(1200):
            served.bus.send(sdo(VALUE))
        bus.settle()
        assert link.counters.overruns == 1200 - 1024
        assert link.upload(0x2000, 1) == b"\x07"


def test_a_vanished_adapter_is_told_to_every_caller(scripted: ScriptedBus, host: CanopenLink) -> None:
    scripted.broken = can.CanOperationError("device unplugged")
    calls: list[Callable[[], object]] = [
        lambda: host.upload(0x2000, 1),
        lambda: host.download(0x2000, 1, b"\x01"),
        lambda: host.nmt(NmtCommand.START),
        host.send_heartbeat,
        host.heartbeat_state,
        host.emergencies,
        lambda: host.wait_heartbeat(1.0),
    ]
    for call in calls:
        with pytest.raises(
            LinkClosed, match="the adapter of node 5 stopped working: device unplugged; check "
        ):
            call()


def test_an_end_of_reception_is_no_answer_to_a_second_one() -> None:
    client = SdoClient(canopen.Network(), NODE, 1.0)
    client.on_response(0x580 + NODE, bytes.fromhex(VALUE), 0.0)
    client.end_waiting()
    assert client.more_answers(0x2000, 1) == 1


def test_an_adapter_that_vanishes_during_a_request_is_told_instead_of_silence(
    scripted: ScriptedBus, host: CanopenLink
) -> None:
    scripted.broken = scripted.send_error = OSError("gone")
    with pytest.raises(LinkClosed, match="gone"):
        host.upload(0x2000, 1)


def test_a_bus_closed_under_the_link_is_a_closed_link(served: Served, channel: str) -> None:
    bus = VirtualTimeBus(channel)
    with CanopenLink(bus, NODE, RealClock()) as link:
        bus.shutdown()
        with pytest.raises(LinkClosed):
            link.upload(0x2000, 1)


def test_a_frame_that_cannot_be_sent_is_a_link_error(scripted: ScriptedBus, host: CanopenLink) -> None:
    scripted.send_error = can.CanOperationError("transmit buffer full")
    with pytest.raises(LinkError, match="sending to node 5 failed: transmit buffer full; check ") as failed:
        host.send_heartbeat()
    assert not isinstance(failed.value, LinkClosed)


def test_a_closed_link_says_so_and_closes_once(scripted: ScriptedBus) -> None:
    link = CanopenLink(scripted, NODE, RealClock())
    link.close()
    link.close()
    for call in (lambda: link.upload(0x2000, 1), link.send_heartbeat, link.emergencies):
        with pytest.raises(LinkClosed, match="the link to node 5 is closed"):
            call()
    assert link.counters.frames_received == 0


# ---- network management and emergencies --------------------------------------------------------------------


def test_commands_and_heartbeat_on_the_wire(scripted: ScriptedBus, host: CanopenLink) -> None:
    host.nmt(NmtCommand.START)
    host.nmt(NmtCommand.RESET_NODE)
    host.send_heartbeat()
    sent = [(each.arbitration_id, bytes(each.data), each.is_extended_id) for each in scripted.sent]
    assert sent == [(0, b"\x01\x05", False), (0, b"\x81\x05", False), (0x77F, b"\x05", False)]


def test_the_next_heartbeat_is_waited_for_in_the_clocks_time(channel: str) -> None:
    clock = VirtualClock()
    bus = VirtualTimeBus(channel)
    with CanopenLink(bus, NODE, clock) as link, VirtualTimeBus(channel) as drive:
        clock.register(bus.settle)
        assert link.heartbeat_state() is None
        beats = iter(["00", "7F", "05"])
        timer = clock.call_every(10.0, lambda: drive.send(frame(0x700 + NODE, next(beats))))
        assert link.wait_heartbeat(20.0) is NmtState.BOOT_UP
        assert link.wait_heartbeat(20.0) is NmtState.PRE_OPERATIONAL
        with pytest.raises(NoAnswer, match="no heartbeat of node 5 within 5 s; check "):
            link.wait_heartbeat(5.0)
        assert link.wait_heartbeat(20.0) is link.heartbeat_state() is NmtState.OPERATIONAL
        timer.cancel()
        assert link.counters.heartbeats_received == 3


def test_emergencies_are_handed_out_once_and_the_first_are_kept(channel: str) -> None:
    bus = VirtualTimeBus(channel)
    with CanopenLink(bus, NODE, RealClock()) as link, VirtualTimeBus(channel) as drive:
        for code in range(300):
            drive.send(frame(0x080 + NODE, Emergency(code, 1).encode().hex()))
        bus.settle()
        assert [alarm.emergency.code for alarm in link.emergencies()] == list(range(256))
        assert link.emergencies() == ()
        assert link.counters.emcy_received == 300
        assert link.counters.overruns == 300 - 256
