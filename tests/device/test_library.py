"""The C library's pure functions against those of the host, on generated input."""

from __future__ import annotations

import ctypes
import zlib
from pathlib import Path

import numpy as np
from hypothesis import given, settings, strategies as st

from benchtool.protocol.canopen.emcy import error_register
from benchtool.protocol.cia402 import State, statusword, transition
from benchtool.protocol.serial import FrameSplitter, encode_frame
from tests.device.c_drive import Library, make

STATES: list[State] = [
    state for state in State if state is not State.UNKNOWN
]  # in the order of enum bt_state
u16 = ctypes.c_uint16
_CAUSES = ("too_long", "bad_stuffing", "too_short", "bad_crc")
_LONGEST = 128


def _transition(library: Library, state: State, word: int, before: int) -> State:
    arguments = STATES.index(state), u16(word), u16(before)
    after: int = library.call("bt_cia402_transition", *arguments, result=ctypes.c_int)
    return STATES[after]


def test_every_controlword_in_every_state_after_every_edge(library: Library) -> None:
    """All of the low byte, which has every bit that matters, against both levels of bit 7 before."""
    for state in STATES:
        for word in range(256):
            for before in (0x0000, 0x0080, 0x000F, 0x008F, 0xFF7F, 0xFFFF):
                assert _transition(library, state, word, before) is transition(state, word, before)


def test_no_other_bit_matters(library: Library) -> None:
    for word, before in np.random.default_rng(1).integers(0, 1 << 16, (2000, 2)).tolist():
        for state in STATES:
            assert _transition(library, state, word, before) is transition(state, word, before)


def test_an_invalid_state_is_ignored(library: Library) -> None:
    for state in (8, 255):
        assert library.call("bt_cia402_transition", state, u16(6), u16(0), result=ctypes.c_int) == state


def test_statuswords_tell_the_states(library: Library) -> None:
    for number, state in enumerate(STATES):
        assert library.call("bt_cia402_statusword", number, u16(0x0200), result=u16) == statusword(state)
        on = library.call("bt_cia402_power_stage_on", number, result=ctypes.c_bool)
        assert on is state.power_stage_on


def test_the_error_register_of_every_code(library: Library) -> None:
    for code in range(0x10000):
        assert library.call("bt_error_register", u16(code), result=ctypes.c_uint8) == error_register(code)


@given(st.binary(max_size=600), st.integers(0, 2**32 - 1))
def test_crc(library: Library, data: bytes, begun: int) -> None:
    n = ctypes.c_size_t(len(data))
    assert library.call("bt_crc", ctypes.c_uint32(begun), data, n) == zlib.crc32(data, begun)


payloads = st.binary(min_size=1, max_size=700) | st.lists(
    st.sampled_from([b"\0", b"\1" * 253, b"\1" * 254, b"\xff"]), min_size=1, max_size=6
).map(b"".join)


@given(payloads)
def test_frames_have_the_same_bytes(library: Library, payload: bytes) -> None:
    frame = ctypes.create_string_buffer(4096)
    sizes = ctypes.c_size_t(len(payload)), frame, ctypes.c_size_t(4096)
    n = library.call("shared_frame", payload, *sizes, result=ctypes.c_size_t)
    assert frame.raw[:n] == encode_frame(payload)


@st.composite
def lines(draw: st.DrawFn) -> bytes:
    """Frames of any length, whole and damaged, and noise between them."""
    pieces = []
    for _ in range(draw(st.integers(1, 6))):
        piece = draw(st.one_of(st.binary(max_size=12), payloads.map(encode_frame)))
        if piece and draw(st.booleans()):
            at = draw(st.integers(0, len(piece) - 1))
            damaged = bytes([piece[at] ^ 1 << draw(st.integers(0, 7))]) if draw(st.booleans()) else b""
            piece = piece[:at] + damaged + piece[at + 1 :]
        pieces.append(piece)
    return b"".join(pieces)


@settings(max_examples=500)
@given(lines(), st.sampled_from([_LONGEST, 200, 256]))
def test_a_line_gives_the_same_payloads_and_the_same_counts(
    library: Library, line: bytes, longest: int
) -> None:
    splitter = FrameSplitter(longest)
    expected = splitter.feed(line)
    library.call("shared_receiver", ctypes.c_size_t(longest), result=None)
    payload = ctypes.create_string_buffer(512)
    found = []
    for byte in line:
        n = library.call("shared_take", ctypes.c_uint8(byte), payload, result=ctypes.c_size_t)
        if n:
            found.append(payload.raw[:n])
    counts = (ctypes.c_uint32 * 4)()
    library.call("shared_dropped", counts, result=None)
    assert found == expected
    assert tuple(counts) == tuple(getattr(splitter, cause) for cause in _CAUSES)


def test_make_check(build: Path) -> None:
    """The tests in C, with every compiler there is, sanitizers and a second of the fuzzer; the example is
    made already."""
    printed = make(build, "check-serial", SECONDS_OF_CHECK="1")
    assert printed.count("all content") >= 2
