"""Frames of SDO, against the examples and tables of CiA 301 written out by hand."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from benchtool.protocol.canopen import cob_id, sdo


@given(st.binary(min_size=1, max_size=4))
def test_an_expedited_transfer_brings_back_its_bytes(data: bytes) -> None:
    command = sdo.expedited(sdo.Request.DOWNLOAD, len(data))
    frame = sdo.INITIATE.pack(command, 0x6040, 0, int.from_bytes(data, "little"))
    assert len(frame) == sdo.FRAME_SIZE
    assert frame[1:4] == bytes([0x40, 0x60, 0x00])
    assert sdo.key(frame) == (0x6040, 0)
    assert sdo.expedited_data(frame) == data


def test_without_size_all_four_bytes_count() -> None:
    assert sdo.expedited_data(bytes.fromhex("4241600012345678")) == bytes.fromhex("12345678")


@pytest.mark.parametrize(("size", "command"), [(1, 0x2F), (2, 0x2B), (3, 0x27), (4, 0x23)])
def test_commands_of_expedited_downloads(size: int, command: int) -> None:
    assert sdo.expedited(sdo.Request.DOWNLOAD, size) == command


@given(st.binary(max_size=7), st.sampled_from([0, sdo.TOGGLE]), st.booleans())
def test_a_segment_brings_back_its_bytes(data: bytes, toggle: int, last: bool) -> None:
    frame = sdo.segment(sdo.Request.DOWNLOAD_SEGMENT, toggle, data, last=last)
    assert len(frame) == sdo.FRAME_SIZE
    assert sdo.segment_data(frame) == data
    assert bool(frame[0] & 0x01) is last
    assert frame[0] & 0x10 == toggle


@given(st.integers(0, 7), st.integers(0, 0xFFFF))
def test_the_end_of_a_block_tells_what_does_not_count(unused: int, crc: int) -> None:
    frame = sdo.block_end(sdo.Request.BLOCK_DOWNLOAD, unused, crc)
    assert (frame[0], frame[1:3], frame[3:]) == (
        0xC1 | unused << 2,
        crc.to_bytes(2, "little"),
        bytes(5),
    )
    assert sdo.block_unused(frame[0]) == unused


def test_requests_that_name_an_object() -> None:
    """By the tables of 7.2.4.3: 1 and 2, 5 with subcommand 0, 6 with subcommand 0."""
    named = {command for command in range(256) if sdo.initiates(command)}
    by_hand = {*range(0x20, 0x60), *range(0xA0, 0xC0, 4), *range(0xC0, 0xE0, 2)}
    assert named == by_hand


def test_identifiers_of_node_1() -> None:
    """The predefined connection set, CiA 301, table 38."""
    assert [
        each + 1 for each in (cob_id.EMCY, cob_id.SDO_RESPONSE, cob_id.SDO_REQUEST, cob_id.HEARTBEAT)
    ] == [*(0x081, 0x581, 0x601, 0x701)]
    assert [each + 1 for each in (*cob_id.TPDO[:4], *cob_id.RPDO)] == [
        *(0x181, 0x281, 0x381, 0x481, 0x201, 0x301)
    ]
    assert (cob_id.FIRST_OF_PDO, cob_id.LAST_OF_PDO) == (0x181, 0x57F)
