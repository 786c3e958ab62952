"""The SDO server byte by byte, spoken to over plain python-can (CiA 301, 7.2.4.3)."""

from __future__ import annotations

import binascii

import pytest
from hypothesis import given, strategies as st

from benchtool.emulator.servers.sdo_server import SdoServer
from tests.wire.endpoints import Served, Wire

TEN = b"0123456789"
ABORT_BY_CLIENT = "80 00 20 01 00 00 00 08"
READ_1 = "40 00 20 01 00 00 00 00"
VALUE_1 = "43 00 20 01 78 56 34 12"


@pytest.fixture(autouse=True)
def _objects(served: Served) -> None:
    served.objects |= {(0x2000, 1): bytes.fromhex("78563412"), (0x2042, 0): TEN, (0x2043, 0): b""}


# ---- expedited ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "answer"),
    [
        (b"\x11", "4F 00 20 02 11 00 00 00"),
        (b"\x11\x22", "4B 00 20 02 11 22 00 00"),
        (b"\x11\x22\x33", "47 00 20 02 11 22 33 00"),
        (b"\x11\x22\x33\x44", "43 00 20 02 11 22 33 44"),
    ],
)
def test_expedited_upload(served: Served, wire: Wire, value: bytes, answer: str) -> None:
    served.objects[0x2000, 2] = value
    assert wire.ask("40 00 20 02 00 00 00 00") == [answer]


@pytest.mark.parametrize(
    ("request_", "value"),
    [
        ("2F 00 20 03 11 00 00 00", b"\x11"),
        ("2B 00 20 03 11 22 00 00", b"\x11\x22"),
        ("23 00 20 03 11 22 33 44", b"\x11\x22\x33\x44"),
        ("22 00 20 03 11 22 33 44", b"\x11\x22\x33\x44"),  # size not indicated
    ],
)
def test_expedited_download(served: Served, wire: Wire, request_: str, value: bytes) -> None:
    assert wire.ask(request_) == ["60 00 20 03 00 00 00 00"]
    assert served.writes == [(0x2000, 3, value)]


@pytest.mark.parametrize("n", [0x0, 0x4, 0xC])  # reserved without a size indicated (7.2.4.3.3)
@pytest.mark.parametrize(("length", "taken"), [(1, 1), (2, 2), (4, 4), (8, 4), (None, 4)])
def test_expedited_download_without_size(n: int, length: int | None, taken: int) -> None:
    answers: list[bytes] = []
    written: list[bytes] = []
    server = SdoServer(
        lambda *_: TEN, lambda index, sub, data: written.append(data), answers.append, lambda *_: length
    )
    server.on_request(bytes([0x22 | n]) + bytes.fromhex("00 20 03 11 22 33 44"))
    assert written == [bytes.fromhex("11223344")[:taken]]
    assert answers == [bytes.fromhex("60 00 20 03 00 00 00 00")]


def test_segmented_download_without_size(served: Served, wire: Wire) -> None:
    answers = wire.ask("20 00 20 03 00 00 00 00", "00 30 31 32 33 34 35 36", "19 37 38 39 00 00 00 00")
    assert answers == ["60 00 20 03 00 00 00 00", "20 00 00 00 00 00 00 00", "30 00 00 00 00 00 00 00"]
    assert served.writes == [(0x2000, 3, TEN)]


def test_refusals_carry_object_and_code(wire: Wire) -> None:
    assert wire.ask("40 34 12 05 00 00 00 00") == ["80 34 12 05 00 00 02 06"]
    assert wire.ask("A4 34 12 05 7F 00 00 00") == ["80 34 12 05 00 00 02 06"]
    assert wire.ask("23 00 10 00 01 00 00 00") == ["80 00 10 00 02 00 01 06"]


# ---- segmented ---------------------------------------------------------------------------------------------


def test_segmented_upload_alternates_the_toggle(wire: Wire) -> None:
    assert wire.ask("40 42 20 00 00 00 00 00") == ["41 42 20 00 0A 00 00 00"]
    assert wire.ask("60 00 00 00 00 00 00 00") == ["00 30 31 32 33 34 35 36"]
    assert wire.ask("70 00 00 00 00 00 00 00") == ["19 37 38 39 00 00 00 00"]
    assert wire.ask("60 00 00 00 00 00 00 00") == ["80 42 20 00 01 00 04 05"]


def test_a_toggle_that_does_not_alternate_aborts(wire: Wire) -> None:
    wire.ask("40 42 20 00 00 00 00 00", "60 00 00 00 00 00 00 00")
    assert wire.ask("60 00 00 00 00 00 00 00") == ["80 42 20 00 00 00 03 05"]


def test_an_empty_object_uploads_as_one_empty_segment(wire: Wire) -> None:
    assert wire.ask("40 43 20 00 00 00 00 00") == ["41 43 20 00 00 00 00 00"]
    assert wire.ask("60 00 00 00 00 00 00 00") == ["0F 00 00 00 00 00 00 00"]


def test_segmented_download_alternates_the_toggle(served: Served, wire: Wire) -> None:
    assert wire.ask("21 44 20 00 0A 00 00 00") == ["60 44 20 00 00 00 00 00"]
    assert wire.ask("00 30 31 32 33 34 35 36") == ["20 00 00 00 00 00 00 00"]
    assert served.writes == []
    assert wire.ask("19 37 38 39 00 00 00 00") == ["30 00 00 00 00 00 00 00"]
    assert served.writes == [(0x2044, 0, TEN)]


@pytest.mark.parametrize("announced", ["09", "0B"])
def test_segmented_download_of_another_length_than_announced_is_not_written(
    served: Served, wire: Wire, announced: str
) -> None:
    wire.ask(f"21 44 20 00 {announced} 00 00 00", "00 30 31 32 33 34 35 36")
    (answer,) = wire.ask("19 37 38 39 00 00 00 00")
    assert answer[:11] == "80 44 20 00"
    assert answer[18:] == "07 06"  # some code of "length of the data does not match"
    assert served.writes == []


# ---- block upload ------------------------------------------------------------------------------------------


def test_block_upload_with_crc(served: Served, wire: Wire) -> None:
    served.objects[0x2042, 0] = b"123456789"
    # CRC-16 of CiA 301 over this text is its published check value.
    assert binascii.crc_hqx(b"123456789", 0) == 0x31C3
    assert wire.ask("A4 42 20 00 7F 00 00 00") == ["C6 42 20 00 09 00 00 00"]
    assert wire.ask("A3 00 00 00 00 00 00 00") == ["01 31 32 33 34 35 36 37", "82 38 39 00 00 00 00 00"]
    assert wire.ask("A2 02 7F 00 00 00 00 00") == ["D5 C3 31 00 00 00 00 00"]
    assert wire.ask("A1 00 00 00 00 00 00 00") == []
    assert wire.ask(READ_1) == [VALUE_1]


def test_block_upload_without_crc_sends_zero(wire: Wire) -> None:
    wire.ask("A0 42 20 00 7F 00 00 00", "A3 00 00 00 00 00 00 00")
    assert wire.ask("A2 02 7F 00 00 00 00 00") == ["D1 00 00 00 00 00 00 00"]


def test_block_upload_of_nothing(wire: Wire) -> None:
    assert wire.ask("A4 43 20 00 7F 00 00 00") == ["C6 43 20 00 00 00 00 00"]
    assert wire.ask("A3 00 00 00 00 00 00 00") == ["81 00 00 00 00 00 00 00"]
    assert wire.ask("A2 01 7F 00 00 00 00 00") == ["DD 00 00 00 00 00 00 00"]


def test_block_upload_goes_on_after_the_last_segment_in_order(served: Served, wire: Wire) -> None:
    served.objects[0x2042, 0] = bytes(range(21))
    wire.ask("A4 42 20 00 7F 00 00 00")
    assert [answer[:2] for answer in wire.ask("A3 00 00 00 00 00 00 00")] == ["01", "02", "83"]
    assert wire.ask("A2 01 7F 00 00 00 00 00") == ["01 07 08 09 0A 0B 0C 0D", "82 0E 0F 10 11 12 13 14"]
    crc = binascii.crc_hqx(bytes(range(21)), 0).to_bytes(2, "little").hex(" ").upper()
    assert wire.ask("A2 02 7F 00 00 00 00 00") == [f"C1 {crc} 00 00 00 00 00"]


def test_block_upload_follows_a_change_of_the_block_size(served: Served, wire: Wire) -> None:
    served.objects[0x2042, 0] = bytes(range(28))
    wire.ask("A4 42 20 00 02 00 00 00")
    assert [answer[:2] for answer in wire.ask("A3 00 00 00 00 00 00 00")] == ["01", "02"]
    assert [answer[:2] for answer in wire.ask("A2 02 01 00 00 00 00 00")] == ["01"]
    assert [answer[:2] for answer in wire.ask("A2 01 7F 00 00 00 00 00")] == ["81"]


def test_the_protocol_switches_below_the_clients_threshold_only(wire: Wire) -> None:
    assert wire.ask("A4 42 20 00 7F 09 00 00") == ["C6 42 20 00 0A 00 00 00"]
    assert wire.ask("A4 42 20 00 7F 0A 00 00") == ["41 42 20 00 0A 00 00 00"]
    assert wire.ask("60 00 00 00 00 00 00 00") == ["00 30 31 32 33 34 35 36"]
    assert wire.ask("A4 00 20 01 7F 0A 00 00") == [VALUE_1]


@pytest.mark.parametrize("size", ["00", "80", "FF"])
def test_a_block_size_outside_1_to_127_aborts(wire: Wire, size: str) -> None:
    assert wire.ask(f"A4 42 20 00 {size} 00 00 00") == ["80 42 20 00 02 00 04 05"]
    wire.ask("A4 42 20 00 01 00 00 00", "A3 00 00 00 00 00 00 00")
    assert wire.ask(f"A2 01 {size} 00 00 00 00 00") == ["80 42 20 00 02 00 04 05"]


def test_acknowledging_more_than_was_sent_aborts(wire: Wire) -> None:
    wire.ask("A4 42 20 00 7F 00 00 00", "A3 00 00 00 00 00 00 00")
    assert wire.ask("A2 03 7F 00 00 00 00 00") == ["80 42 20 00 03 00 04 05"]


# ---- block download ----------------------------------------------------------------------------------------

CRC_TEN = binascii.crc_hqx(TEN, 0).to_bytes(2, "little").hex(" ").upper()


def test_block_download_with_crc(served: Served, wire: Wire) -> None:
    assert wire.ask("C6 44 20 00 0A 00 00 00") == ["A4 44 20 00 7F 00 00 00"]
    assert wire.ask("01 30 31 32 33 34 35 36") == []
    assert wire.ask("82 37 38 39 00 00 00 00") == ["A2 02 7F 00 00 00 00 00"]
    assert served.writes == []
    assert wire.ask(f"D1 {CRC_TEN} 00 00 00 00 00") == ["A1 00 00 00 00 00 00 00"]
    assert served.writes == [(0x2044, 0, TEN)]


def test_block_download_of_more_than_one_sub_block(served: Served, wire: Wire) -> None:
    wire.ask("C0 44 20 00 00 00 00 00")
    segments = [f"{number:02X} 00 00 00 00 00 00 00" for number in range(1, 128)]
    assert wire.ask(*segments) == ["A2 7F 7F 00 00 00 00 00"]
    assert wire.ask("81 11 00 00 00 00 00 00") == ["A2 01 7F 00 00 00 00 00"]
    assert wire.ask("D9 00 00 00 00 00 00 00") == ["A1 00 00 00 00 00 00 00"]
    assert served.writes == [(0x2044, 0, bytes(127 * 7) + b"\x11")]


def test_block_download_acknowledges_the_last_segment_in_order(served: Served, wire: Wire) -> None:
    wire.ask("C6 44 20 00 11 00 00 00")
    assert wire.ask("01 30 31 32 33 34 35 36", "83 61 62 63 00 00 00 00") == ["A2 01 7F 00 00 00 00 00"]
    assert wire.ask("01 37 38 39 30 31 32 33", "82 61 62 63 00 00 00 00") == ["A2 02 7F 00 00 00 00 00"]
    data = b"01234567890123abc"
    crc = binascii.crc_hqx(data, 0).to_bytes(2, "little").hex(" ")
    assert wire.ask(f"D1 {crc} 00 00 00 00 00") == ["A1 00 00 00 00 00 00 00"]
    assert served.writes == [(0x2044, 0, data)]


@pytest.mark.parametrize(
    ("begin", "end", "code"),
    [
        ("C6 44 20 00 0A 00 00 00", "D1 00 00 00 00 00 00 00", "04 00 04 05"),
        ("C6 44 20 00 0B 00 00 00", f"D1 {CRC_TEN} 00 00 00 00 00", "10 00 07 06"),
    ],
    ids=["crc", "length"],
)
def test_a_damaged_block_download_is_not_written(
    served: Served, wire: Wire, begin: str, end: str, code: str
) -> None:
    wire.ask(begin, "01 30 31 32 33 34 35 36", "82 37 38 39 00 00 00 00")
    assert wire.ask(end) == [f"80 44 20 00 {code}"]
    assert served.writes == []
    assert wire.ask(READ_1) == [VALUE_1]


def test_segments_beyond_the_announced_size_abort(served: Served, wire: Wire) -> None:
    wire.ask("C6 44 20 00 07 00 00 00", "01 30 31 32 33 34 35 36")
    assert wire.ask("02 37 38 39 00 00 00 00") == ["80 44 20 00 12 00 07 06"]
    assert served.writes == []


def test_segment_number_zero_aborts(wire: Wire) -> None:
    wire.ask("C6 44 20 00 0A 00 00 00")
    assert wire.ask("00 30 31 32 33 34 35 36") == ["80 44 20 00 03 00 04 05"]


def test_a_refused_write_aborts_at_the_end(served: Served, wire: Wire) -> None:
    wire.ask("C6 00 10 00 0A 00 00 00", "01 30 31 32 33 34 35 36", "82 37 38 39 00 00 00 00")
    assert wire.ask(f"D1 {CRC_TEN} 00 00 00 00 00") == ["80 00 10 00 02 00 01 06"]
    assert served.writes == []


# ---- out of step -------------------------------------------------------------------------------------------

STAGES = {
    "idle": (),
    "segmented upload": ("40 42 20 00 00 00 00 00",),
    "within segmented upload": ("40 42 20 00 00 00 00 00", "60 00 00 00 00 00 00 00"),
    "segmented download": ("21 44 20 00 0A 00 00 00",),
    "within segmented download": ("21 44 20 00 0A 00 00 00", "00 30 31 32 33 34 35 36"),
    "block upload begun": ("A4 42 20 00 7F 00 00 00",),
    "block upload sent": ("A4 42 20 00 7F 00 00 00", "A3 00 00 00 00 00 00 00"),
    "block upload ended": (
        "A4 42 20 00 7F 00 00 00",
        "A3 00 00 00 00 00 00 00",
        "A2 02 7F 00 00 00 00 00",
    ),
    "block download begun": ("C6 44 20 00 0A 00 00 00",),
    "within block download": ("C6 44 20 00 0A 00 00 00", "01 30 31 32 33 34 35 36"),
    "block download received": (
        "C6 44 20 00 0A 00 00 00",
        "01 30 31 32 33 34 35 36",
        "82 37 38 39 00 00 00 00",
    ),
}
REQUESTABLE = [stage for stage in STAGES if stage not in ("block download begun", "within block download")]


@pytest.mark.parametrize("stage", STAGES)
def test_the_clients_abort_ends_any_stage_without_an_answer(served: Served, wire: Wire, stage: str) -> None:
    wire.ask(*STAGES[stage])
    assert wire.ask(ABORT_BY_CLIENT) == []
    assert wire.ask(READ_1) == [VALUE_1]
    assert served.writes == []


@pytest.mark.parametrize("stage", REQUESTABLE)
def test_an_unknown_command_aborts_any_stage(served: Served, wire: Wire, stage: str) -> None:
    wire.ask(*STAGES[stage])
    (answer,) = wire.ask("E0 00 00 00 00 00 00 00")
    assert answer.startswith("80 ")
    assert answer.endswith(" 01 00 04 05")
    assert served.sdo.malformed == 1
    assert wire.ask(READ_1) == [VALUE_1]


@pytest.mark.parametrize("stage", REQUESTABLE)
def test_a_new_request_replaces_the_transfer_under_way(served: Served, wire: Wire, stage: str) -> None:
    wire.ask(*STAGES[stage])
    assert wire.ask(READ_1) == [VALUE_1]
    (answer,) = wire.ask("60 00 00 00 00 00 00 00")
    assert answer.endswith(" 01 00 04 05")
    assert served.writes == []


@pytest.mark.parametrize(
    ("stage", "intruder"),
    [
        ("idle", "00 00 00 00 00 00 00 00"),
        ("idle", "60 00 00 00 00 00 00 00"),
        ("idle", "A1 00 00 00 00 00 00 00"),
        ("idle", "A2 01 7F 00 00 00 00 00"),
        ("idle", "A3 00 00 00 00 00 00 00"),
        ("idle", "C1 00 00 00 00 00 00 00"),
        ("segmented upload", "00 30 31 32 33 34 35 36"),
        ("segmented download", "60 00 00 00 00 00 00 00"),
        ("block upload begun", "A2 01 7F 00 00 00 00 00"),
        ("block upload sent", "A3 00 00 00 00 00 00 00"),
        ("block upload sent", "A1 00 00 00 00 00 00 00"),
        ("block upload ended", "A2 00 7F 00 00 00 00 00"),
        ("block download received", "00 30 31 32 33 34 35 36"),
    ],
)
def test_a_frame_of_another_stage_aborts(served: Served, wire: Wire, stage: str, intruder: str) -> None:
    wire.ask(*STAGES[stage])
    (answer,) = wire.ask(intruder)
    assert answer.startswith("80 ")
    assert answer.endswith(" 01 00 04 05")
    assert served.sdo.malformed == 1
    assert served.writes == []


@pytest.mark.parametrize("length", range(8))
def test_a_frame_of_another_length_is_only_counted(served: Served, wire: Wire, length: int) -> None:
    wire.ask("40 42 20 00 00 00 00 00")
    assert wire.ask("60 " * length) == []
    assert served.sdo.malformed == 1
    assert wire.ask("60 00 00 00 00 00 00 00") == ["00 30 31 32 33 34 35 36"]


COMMANDS = [
    0x00,
    0x10,
    0x01,
    0x20,
    0x21,
    0x23,
    0x40,
    0x60,
    0x70,
    0x81,
    0xA0,
    0xA1,
    0xA2,
    0xA3,
    0xA4,
    0xC1,
    0xC6,
]
likely = st.builds(
    lambda command, rest: bytes([command]) + rest,
    st.sampled_from(COMMANDS),
    st.binary(min_size=7, max_size=7),
)


@given(st.lists(st.one_of(likely, st.binary(max_size=8)), max_size=40))
def test_no_sequence_of_frames_raises_or_stops_the_server(frames: list[bytes]) -> None:
    answers: list[bytes] = []
    written: list[bytes] = []
    server = SdoServer(lambda *_: TEN, lambda index, sub, data: written.append(data), answers.append)
    for each in frames:
        server.on_request(each)
    assert all(len(answer) == 8 for answer in answers)
    server.on_request(bytes.fromhex(ABORT_BY_CLIENT))
    answers.clear()
    for request in ("A4 42 20 00 7F 00 00 00", "A3 00 00 00 00 00 00 00", "A2 02 7F 00 00 00 00 00"):
        server.on_request(bytes.fromhex(request))
    assert [answer.hex() for answer in answers[1:3]] == ["0130313233343536", "8237383900000000"]
    assert answers[3] == b"\xd1" + binascii.crc_hqx(TEN, 0).to_bytes(2, "little") + bytes(5)
