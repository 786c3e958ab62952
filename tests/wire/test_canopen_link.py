"""The host's CANopen link: against the SDO server, and against an adapter with scripted faults."""

from __future__ import annotations

import binascii
import random
import threading

import can
import pytest

from benchtool.clock import RealClock
from benchtool.errors import LinkError, NoAnswer, SdoAbort
from benchtool.link import Link
from benchtool.link.canopen.link import CanopenLink
from benchtool.protocol.canopen.abort import Abort
from tests.wire.endpoints import NODE, LossyBus, ScriptedBus, Served, Step, script, sdo

VALUE = "43 00 20 01 78 56 34 12"


# ---- transfers against the server --------------------------------------------------------------------------


@pytest.mark.parametrize("block", [False, True])
@pytest.mark.parametrize("size", [0, 1, 4, 5, 6, 7, 8, 14, 888, 889, 890, 1778, 1779, 5000])
def test_every_size_is_written_and_read(served: Served, link: Link, size: int, block: bool) -> None:
    data = random.Random(size).randbytes(size)
    link.download(0x2042, 3, data, block=block)
    assert served.writes == [(0x2042, 3, data)]
    assert link.upload(0x2042, 3, block=block) == data
    served.bus.settle()
    assert served.sdo.malformed == 0
    assert link.counters.retries == link.counters.sdo_aborts == 0


@pytest.mark.parametrize("block", [False, True])
def test_a_refusal_names_node_object_code_and_remedy(link: Link, block: bool) -> None:
    with pytest.raises(
        SdoAbort, match=r"node 5 refused reading 0x3000:2: 0x06020000 object does not exist: "
    ):
        link.upload(0x3000, 2, block=block)
    with pytest.raises(SdoAbort, match=r"node 5 refused writing 0x1000:0: 0x06010002 ") as refused:
        link.download(0x1000, 0, bytes(20), block=block)
    assert refused.value.code == Abort.READ_ONLY
    assert link.counters.sdo_aborts == 2


def test_threads_that_share_a_link_get_their_own_answers(served: Served, link: Link) -> None:
    served.objects |= {(0x2000, sub): bytes([sub]) * (sub + 1) for sub in range(40)}
    wrong: list[tuple[int, bytes]] = []

    def read(first: int) -> None:
        for k in range(200):
            sub = (first + 3 * k) % 40
            value = link.upload(0x2000, sub, block=k % 5 == 0)
            if value != bytes([sub]) * (sub + 1):
                wrong.append((sub, value))

    threads = [threading.Thread(target=read, args=(first,)) for first in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    assert link.counters.retries == 0


# ---- what a request does when the answer fails -------------------------------------------------------------


def test_a_read_is_asked_twice_and_then_given_up(scripted: ScriptedBus, impatient: CanopenLink) -> None:
    with pytest.raises(
        NoAnswer,
        match=r"^node 5 did not answer within 0.02 s when reading 0x6041:0, asked twice; check [^\n]*$",
    ):
        impatient.upload(0x6041, 0)
    abort = "80 41 60 00 00 00 04 05"
    assert scripted.requests == ["40 41 60 00 00 00 00 00", abort] * 2
    assert impatient.counters.retries == 1


def test_the_second_answer_counts(scripted: ScriptedBus, timing_out: CanopenLink) -> None:
    scripted.answer = script([], [], [sdo(VALUE)])
    assert timing_out.upload(0x2000, 1) == bytes.fromhex("78563412")
    assert timing_out.counters.retries == 1


@pytest.mark.parametrize(
    ("data", "block", "first"),
    [
        (b"\x01\x02", False, "2B 00 20 01 01 02 00 00"),
        (bytes(9), False, "21 00 20 01 09 00 00 00"),
        (bytes(9), True, "C6 00 20 01 09 00 00 00"),
    ],
)
def test_a_write_is_sent_once(
    scripted: ScriptedBus, impatient: CanopenLink, data: bytes, block: bool, first: str
) -> None:
    with pytest.raises(NoAnswer, match="when writing 0x2000:1, asked once"):
        impatient.download(0x2000, 1, data, block=block)
    assert scripted.requests == [first, "80 00 20 01 00 00 04 05"]
    assert impatient.counters.retries == 0


def test_a_write_given_up_half_way_sends_nothing_more(scripted: ScriptedBus, timing_out: CanopenLink) -> None:
    scripted.answer = script([sdo("60 00 20 01 00 00 00 00")])
    with pytest.raises(NoAnswer):
        timing_out.download(0x2000, 1, bytes(20))
    assert [request[:2] for request in scripted.requests] == ["21", "00", "80"]


def test_an_answer_to_an_earlier_request_is_passed_over(scripted: ScriptedBus, host: CanopenLink) -> None:
    late = [sdo("60 41 60 00 00 00 00 00"), sdo("80 41 60 00 00 00 00 08"), sdo("43 41 60 00 01 00 00 00")]
    scripted.answer = script([*late, sdo(VALUE)], [*late, sdo("60 00 20 01 00 00 00 00")])
    assert host.upload(0x2000, 1) == bytes.fromhex("78563412")
    host.download(0x2000, 1, b"\x01")
    assert len(scripted.sent) == 2


def test_an_abort_without_an_object_is_taken(scripted: ScriptedBus, host: CanopenLink) -> None:
    scripted.answer = script([sdo("80 00 00 00 00 00 02 06")])
    with pytest.raises(SdoAbort):
        host.upload(0x2000, 1)


def test_an_answer_out_of_protocol_is_a_link_error(scripted: ScriptedBus, host: CanopenLink) -> None:
    scripted.answer = lambda _: [sdo("43 00 20 01 78 56 34 12")]
    with pytest.raises(LinkError, match="node 5 answered out of protocol when writing 0x2000:1"):
        host.download(0x2000, 1, b"\x01")
    assert [request[:2] for request in scripted.requests] == ["2F", "80"]


@pytest.mark.parametrize("announced", [10, 5])
def test_more_or_fewer_bytes_than_announced_are_a_link_error(
    scripted: ScriptedBus, host: CanopenLink, announced: int
) -> None:
    other: list[list[Step]] = [
        [sdo(f"41 00 20 01 {announced:02X} 00 00 00")],
        [sdo("03 30 31 32 33 34 35 00")],
    ]
    scripted.answer = script(*other, *other)
    with pytest.raises(LinkError, match=f"6 bytes came, {announced} were announced"):
        host.upload(0x2000, 1)


# ---- block transfer when segments are lost, damaged or stopped ---------------------------------------------

TWENTY = bytes(range(20))
CRC = binascii.crc_hqx(TWENTY, 0)
BEGUN: list[Step] = [sdo("C6 00 20 01 14 00 00 00")]
FIRST, SECOND, THIRD = "01 00 01 02 03 04 05 06", "02 07 08 09 0A 0B 0C 0D", "83 0E 0F 10 11 12 13 00"


def end(crc: int) -> list[Step]:
    return [sdo(f"C5 {crc.to_bytes(2, 'little').hex()} 00 00 00 00 00")]


@pytest.mark.parametrize(
    ("length", "taken"), [(1, "27"), (2, "27 02"), (4, "27 02 AA BB"), (None, "27 02 AA BB")]
)
@pytest.mark.parametrize("command", ["42", "4A", "4E"])
def test_an_expedited_answer_without_size_has_the_length_of_its_object(
    scripted: ScriptedBus, host: CanopenLink, command: str, length: int | None, taken: str
) -> None:
    scripted.answer = script([sdo(f"{command} 41 60 00 27 02 AA BB")])
    assert host.upload(0x6041, 0, length=length) == bytes.fromhex(taken)


@pytest.mark.parametrize("length", [None, 1, 2, 4])
def test_a_length_changes_no_answer_that_tells_its_own(
    scripted: ScriptedBus, host: CanopenLink, length: int | None
) -> None:
    scripted.answer = script([sdo("47 41 60 00 27 02 AA 00")])
    assert host.upload(0x6041, 0, length=length) == bytes.fromhex("27 02 AA")


def test_a_segmented_answer_without_size_ends_with_its_last_segment(
    scripted: ScriptedBus, host: CanopenLink
) -> None:
    initiated = sdo("40 08 10 00 00 00 00 00")
    segments = sdo("00 30 31 32 33 34 35 36"), sdo("19 37 38 39 00 00 00 00")
    scripted.answer = script([initiated], [segments[0]], [segments[1]])
    assert host.upload(0x1008, 0, length=2) == b"0123456789"


def test_a_lost_segment_is_asked_for_again(scripted: ScriptedBus, host: CanopenLink) -> None:
    again: list[Step] = [sdo("01" + SECOND[2:]), sdo("82" + THIRD[2:])]
    scripted.answer = script(BEGUN, [sdo(FIRST), sdo(THIRD)], again, end(CRC))
    assert host.upload(0x2000, 1, block=True) == TWENTY
    assert [request[:8] for request in scripted.requests[2:4]] == ["A2 01 7F", "A2 02 7F"]


def test_a_lost_last_segment_is_asked_for_after_the_timeout(
    scripted: ScriptedBus, timing_out: CanopenLink
) -> None:
    scripted.answer = script(BEGUN, [sdo(FIRST), sdo(SECOND)], [sdo("81" + THIRD[2:])], end(CRC))
    assert timing_out.upload(0x2000, 1, block=True) == TWENTY
    assert timing_out.counters.retries == 0


def test_a_wrong_crc_is_read_again_and_then_an_error(scripted: ScriptedBus, host: CanopenLink) -> None:
    whole: list[Step] = [sdo(FIRST), sdo(SECOND), sdo(THIRD)]
    bad: list[list[Step]] = [BEGUN, whole, end(CRC ^ 1), []]
    scripted.answer = script(*bad, BEGUN, whole, end(CRC))
    assert host.upload(0x2000, 1, block=True) == TWENTY
    assert host.counters.retries == 1
    scripted.answer = script(*bad, *bad)
    with pytest.raises(LinkError, match="the CRC of 20 bytes is wrong"):
        host.upload(0x2000, 1, block=True)
    assert scripted.requests[-1] == "80 00 20 01 04 00 04 05"


@pytest.mark.parametrize("announced", [19, 21])
def test_a_block_of_another_length_than_announced_is_a_link_error(
    scripted: ScriptedBus, host: CanopenLink, announced: int
) -> None:
    begun: list[Step] = [sdo(f"C6 00 20 01 {announced:02X} 00 00 00")]
    other: list[list[Step]] = [begun, [sdo(FIRST), sdo(SECOND), sdo(THIRD)], end(CRC), []]
    scripted.answer = script(*other, *other)
    with pytest.raises(LinkError, match="20 bytes came, others were announced"):
        host.upload(0x2000, 1, block=True)
    assert scripted.requests[-1].startswith("80 00 20 01")


def test_segments_that_never_get_through_end_the_transfer(scripted: ScriptedBus, host: CanopenLink) -> None:
    scripted.answer = lambda sent: (
        BEGUN if sent.data[0] == 0xA4 else [sdo(THIRD)] if sent.data[0] != 0x80 else []
    )
    with pytest.raises(LinkError, match="the segments do not get through"):
        host.upload(0x2000, 1, block=True)
    scripted.answer = lambda sent: [
        sdo("A4 00 20 01 7F 00 00 00" if sent.data[0] == 0xC6 else "A2 00 7F" + " 00" * 5)
    ]
    with pytest.raises(LinkError, match="the segments do not get through"):
        host.download(0x2000, 1, bytes(5), block=True)


def test_a_block_write_repeats_lost_segments_only(scripted: ScriptedBus, host: CanopenLink) -> None:
    scripted.answer = script(
        [sdo("A4 00 20 01 7F 00 00 00")],
        [],
        [],
        [sdo("A2 01 7F 00 00 00 00 00")],
        [],
        [sdo("A2 02 7F 00 00 00 00 00")],
        [sdo("A1 00 00 00 00 00 00 00")],
    )
    host.download(0x2000, 1, TWENTY, block=True)
    crc = CRC.to_bytes(2, "little").hex(" ").upper()
    assert scripted.requests[1:] == [
        *(FIRST, SECOND, THIRD),
        *("01" + SECOND[2:], "82" + THIRD[2:]),
        f"C5 {crc} 00 00 00 00 00",
    ]


@pytest.mark.parametrize("after", [1, 2, 3])
def test_an_upload_that_the_server_stops_leaves_the_link_usable(
    scripted: ScriptedBus, host: CanopenLink, after: int
) -> None:
    stop: list[Step] = [sdo("80 00 20 01 24 00 00 08")]
    steps: list[list[Step]] = [BEGUN, [sdo(FIRST), sdo(SECOND), sdo(THIRD)], end(CRC)]
    scripted.answer = script(*steps[: after - 1], stop, [sdo(VALUE)])
    with pytest.raises(SdoAbort) as stopped:
        host.upload(0x2000, 1, block=True)
    assert stopped.value.code == Abort.NO_DATA
    assert host.upload(0x2000, 1) == bytes.fromhex("78563412")


def test_lost_segments_of_a_real_transfer_are_made_up_for(served: Served, channel: str) -> None:
    served.objects[0x2042, 0] = random.Random(1).randbytes(4000)
    bus = LossyBus(channel)
    lost = [127, 1, 64]

    def loses(each: can.Message) -> bool:
        return bool(lost) and each.data[0] == lost[0] and lost.pop(0) > 0

    bus.loses = loses
    with CanopenLink(bus, NODE, RealClock()) as link:
        assert link.upload(0x2042, 0, block=True) == served.objects[0x2042, 0]
        assert link.counters.retries == 0
    assert lost == []


@pytest.mark.parametrize("deaf_from", [0, 1, 50, 127, 200])
def test_an_upload_that_the_host_gives_up_leaves_both_ends_usable(
    served: Served, channel: str, deaf_from: int
) -> None:
    served.objects |= {(0x2000, 1): b"\x07", (0x2042, 0): random.Random(2).randbytes(4000)}
    bus = LossyBus(channel)
    heard = 0

    def deaf(_: can.Message) -> bool:
        nonlocal heard
        heard += 1
        return heard > deaf_from

    with CanopenLink(bus, NODE, RealClock(), sdo_timeout_s=0.1) as link:
        bus.loses = deaf
        with pytest.raises(NoAnswer):
            link.upload(0x2042, 0, block=True)
        bus.loses = lambda _: False
        assert link.upload(0x2000, 1) == b"\x07"
        assert link.upload(0x2042, 0, block=True) == served.objects[0x2042, 0]
