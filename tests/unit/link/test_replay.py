"""A recorded wire as a link: transfers of every kind, times, and files that are damaged."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchtool.bench.wires import registry
from benchtool.clock import VirtualClock
from benchtool.errors import LinkClosed, LinkError, NoAnswer, SdoAbort, UsageError
from benchtool.link import Frame
from benchtool.link.replay import FRAMES, ReplayLink
from benchtool.protocol.canopen.nmt import NmtCommand, NmtState

NODE = 1
LOG = """\
(100.000000) can0 601#4018100100000000 T
(100.001000) can0 581#431810017C0B0000 R
(100.002000) can0 601#2340200100000000 T
(100.002500) can0 581#6040200100000000 R
(100.003000) can0 601#4008100000000000 T
(100.003100) can0 581#410810000A000000 R
(100.003200) can0 601#6000000000000000 T
(100.003300) can0 581#0062656E63687420 R
(100.003400) can0 601#7000000000000000 T
(100.003500) can0 581#196F6F6C00000000 R
(100.004000) can0 601#4055550000000000 T
(100.004100) can0 581#8055550000000206 R
(100.100000) can0 701#05 R
(100.200000) can0 181#0102030405060708 R
(100.200000) can0 001#00 R
(100.300000) can0 081#1023020000000000 R
(100.400000) can0 601#A442200000000000 T
(100.400100) can0 581#C642200009000000 R
(100.400200) can0 601#A300000000000000 T
(100.400300) can0 581#0101020304050607 R
(100.400400) can0 581#8208090000000000 R
(100.400500) can0 601#A202 T
(100.400600) can0 581#D500000000000000 R
(100.500000) can0 601#4041600000000000 T
(100.500100) can0 581#4B41600027000000 R
(100.600000) can0 601#2108200002000000 T
(100.600100) can0 581#6008200000000000 R
(100.600200) can0 601#0B414200000000 T
(100.700000) can0 601#2108200002000000 T
(100.700100) can0 581#6008200000000000 R
(100.700200) can0 601#0B41420000000000 T
(100.700300) can0 581#2000000000000000 R
(101.000000) can0 701#7F R
(101.000000) can0 181#05
"""


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


UNSIZED = """\
(100.000000) can0 601#4041600000000000 T
(100.000100) can0 581#4241600027020000 R
"""


def replay(folder: Path, clock: VirtualClock, log: str = LOG) -> ReplayLink:
    path = folder / FRAMES
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(log, encoding="ascii")
    return ReplayLink(folder, NODE, clock)


def test_reads_are_answered_as_then_and_at_that_time(tmp_path: Path, clock: VirtualClock) -> None:
    link = replay(tmp_path, clock)
    assert link.upload(0x1018, 1) == bytes.fromhex("7C0B0000")
    assert clock.now_s() == pytest.approx(0.001)
    assert link.upload(0x1008, 0) == b"bencht ool", "segmented"
    assert link.upload(0x2042, 0, block=True) == bytes(range(1, 10)), "by blocks"
    assert clock.now_s() == pytest.approx(0.4006)
    assert link.upload(0x6041, 0) == bytes.fromhex("2700"), "two bytes"
    assert link.upload(0x1018, 1) == bytes.fromhex("7C0B0000"), "again, without going back"
    with pytest.raises(SdoAbort) as refused:
        link.upload(0x5555, 0)
    assert refused.value.code == 0x06020000


def test_what_was_not_read_or_written_is_refused(tmp_path: Path, clock: VirtualClock) -> None:
    link = replay(tmp_path, clock)
    with pytest.raises(NoAnswer, match="no answer of node 1 for 0x2000:2"):
        link.upload(0x2000, 2)
    with pytest.raises(LinkError, match="no write of 01 00 00 00 to 0x2040:1"):
        link.download(0x2040, 1, bytes.fromhex("01000000"))
    with pytest.raises(LinkError, match="takes no setpoints"):
        link.send_pdo(0x201, bytes(8))


def test_what_was_written_is_confirmed_and_reads_back(tmp_path: Path, clock: VirtualClock) -> None:
    link = replay(tmp_path, clock)
    link.download(0x2040, 1, bytes(4))
    assert link.upload(0x2040, 1) == bytes(4)
    link.download(0x2040, 1, bytes(4))
    link.download(0x2008, 0, b"AB")
    assert clock.now_s() == pytest.approx(0.7003), "the one that was confirmed"


def test_frames_come_at_their_time(tmp_path: Path, clock: VirtualClock) -> None:
    link = replay(tmp_path, clock)
    seen: list[Frame] = []
    link.subscribe([0x181], seen.append)
    link.nmt(NmtCommand.START)
    link.send_heartbeat()
    clock.wait(0.15)
    assert link.heartbeat_state() is NmtState.OPERATIONAL
    assert seen == []
    clock.wait(0.1)
    assert [(frame.can_id, frame.data.hex()) for frame in seen] == [(0x181, "0102030405060708")]
    assert seen[0].arrival_s == pytest.approx(0.2)
    assert link.emergencies() == ()
    clock.wait(0.1)
    assert [alarm.emergency.code for alarm in link.emergencies()] == [0x2310]
    link.unsubscribe([0x181])
    assert link.wait_heartbeat(2.0) is NmtState.PRE_OPERATIONAL
    assert len(seen) == 1
    with pytest.raises(NoAnswer):
        link.wait_heartbeat(0.2)
    clock.wait(1.0)
    with pytest.raises(LinkClosed, match=r"ends after 1\.00 s"):
        link.heartbeat_state()
    link.close()
    with pytest.raises(LinkClosed, match="is closed"):
        link.upload(0x1018, 1)


def test_a_line_that_is_half_written_is_left_out(tmp_path: Path, clock: VirtualClock) -> None:
    link = replay(tmp_path, clock, LOG + "(101.500000) can0 181#0A0B")
    clock.wait(1.4)
    link.heartbeat_state()
    clock.wait(0.2)
    with pytest.raises(LinkClosed):
        link.heartbeat_state()


@pytest.mark.parametrize("log", ["", "not a log\n", "(1.0) can0 181#XY R\n", "(1.0) can0 181#01 R"])
def test_a_file_that_is_no_log_is_one_line(tmp_path: Path, clock: VirtualClock, log: str) -> None:
    with pytest.raises(LinkError, match="cannot replay") as refused:
        replay(tmp_path, clock, log)
    assert "\n" not in str(refused.value)


def test_a_folder_without_frames_says_what_is_needed(tmp_path: Path, clock: VirtualClock) -> None:
    with pytest.raises(LinkError, match="recorded with --frames is expected"):
        ReplayLink(tmp_path, NODE, clock)


def test_addresses_of_replays() -> None:
    address = registry.parse("replay:C:/runs/a b?node=7")
    assert (address.scheme, address.place, address.node_id(1)) == ("replay", ("C:/runs/a b",), 7)
    with pytest.raises(UsageError, match="unknown option 'bitrate'"):
        registry.parse("replay:a?bitrate=5")


def test_an_answer_without_size_has_the_length_of_its_object(tmp_path: Path, clock: VirtualClock) -> None:
    link = replay(tmp_path, clock, UNSIZED)
    assert link.upload(0x6041, 0, length=2) == bytes.fromhex("2702")
    link = replay(tmp_path, clock, UNSIZED)
    assert link.upload(0x6041, 0) == bytes.fromhex("27020000")
