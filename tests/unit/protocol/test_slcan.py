"""Lines of a serial CAN adapter: parsing, and robustness against noise."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from benchtool.protocol.slcan import (
    MAX_LINE,
    AdapterLines,
    Answer,
    Cause,
    Lines,
    SlcanCommand,
    SlcanFrame,
    format_frame,
    parse_answer,
    parse_command,
    parse_frame,
)

GOOD = [
    (b"t1230", SlcanFrame(0x123, b"", 0)),
    (b"t4563112233", SlcanFrame(0x456, b"\x11\x22\x33", 3)),
    (b"t7FF8FFFFFFFFFFFFFFFF", SlcanFrame(0x7FF, b"\xff" * 8, 8)),
    (b"T12ABCDEF2AA55", SlcanFrame(0x12ABCDEF, b"\xaa\x55", 2, extended=True)),
    (b"T1FFFFFFF0", SlcanFrame(0x1FFFFFFF, b"", 0, extended=True)),
    (b"r1230", SlcanFrame(0x123, b"", 0, remote=True)),
    (b"r0018", SlcanFrame(0x001, b"", 8, remote=True)),
    (b"R000001234", SlcanFrame(0x123, b"", 4, extended=True, remote=True)),
    (b"t1231AB0000", SlcanFrame(0x123, b"\xab", 1, time_ms=0)),
    (b"t1230EA5F", SlcanFrame(0x123, b"", 0, time_ms=59_999)),
    (b"T0000012322211003A", SlcanFrame(0x123, b"\x22\x11", 2, extended=True, time_ms=58)),
    (b"r1238ea5f", SlcanFrame(0x123, b"", 8, remote=True, time_ms=59_999)),
]

BAD = [
    (b"t", Cause.LENGTH),
    (b"t12", Cause.LENGTH),
    (b"t123", Cause.LENGTH),
    (b"t1231", Cause.LENGTH),
    (b"t1231A", Cause.LENGTH),
    (b"t1231AABB", Cause.LENGTH),
    (b"t1231AABBCCDD", Cause.LENGTH),
    (b"T1234567", Cause.LENGTH),
    (b"T12345678", Cause.LENGTH),
    (b"T123456782AA", Cause.LENGTH),
    (b"r1231AA", Cause.LENGTH),
    (b"t1239" + b"00" * 9, Cause.DLC),
    (b"t123A" + b"00" * 10, Cause.DLC),
    (b"t8000", Cause.IDENTIFIER),
    (b"tFFF0", Cause.IDENTIFIER),
    (b"T200000000", Cause.IDENTIFIER),
    (b"TFFFFFFFF0", Cause.IDENTIFIER),
    (b"t1230EA60", Cause.TIME_STAMP),
    (b"t1230FFFF", Cause.TIME_STAMP),
    (b"t12g0", Cause.DIGIT),
    (b"t 123", Cause.DIGIT),
    (b"t+1230", Cause.DIGIT),
    (b"t1_30", Cause.DIGIT),
    (b"t1232 AABB", Cause.DIGIT),
    (b"t1231\xc3\xa9", Cause.DIGIT),
    (b"t123\xb2AABB", Cause.DIGIT),
    (b"tt1230", Cause.DIGIT),
    (b"\xf41230", Cause.LETTER),
    (b"1230", Cause.LETTER),
    (b"x1230", Cause.LETTER),
    (b" t1230", Cause.LETTER),
    (b"d1239" + b"00" * 12, Cause.UNSUPPORTED),
    (b"D000001230", Cause.UNSUPPORTED),
    (b"b1230", Cause.UNSUPPORTED),
    (b"B000001230", Cause.UNSUPPORTED),
]


@st.composite
def frames(draw: st.DrawFn, stamped: bool | None = None) -> SlcanFrame:
    extended, remote = draw(st.booleans()), draw(st.booleans())
    data = draw(st.binary(max_size=8))
    with_time = draw(st.booleans()) if stamped is None else stamped
    return SlcanFrame(
        draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF)),
        b"" if remote else data,
        len(data),
        extended,
        remote,
        draw(st.integers(0, 59_999)) if with_time else None,
    )


NOISE = st.one_of(
    st.binary(max_size=40),
    st.text("tTrRdDbBzZVNFOC0123456789abcdefABCDEF\a\n ", max_size=40).map(str.encode),
    st.integers(MAX_LINE - 3, 3 * MAX_LINE).map(lambda size: b"0" * size),
)


def cut(data: bytes, places: list[int]) -> list[bytes]:
    edges = [0, *sorted(place % (len(data) + 1) for place in places), len(data)]
    return [data[start:end] for start, end in pairwise(edges)]


class TestFrames:
    @pytest.mark.parametrize(("line", "frame"), GOOD)
    def test_a_line_is_read(self, line: bytes, frame: SlcanFrame) -> None:
        assert parse_frame(line) == frame

    @pytest.mark.parametrize(("line", "frame"), GOOD)
    def test_a_frame_is_written(self, line: bytes, frame: SlcanFrame) -> None:
        assert format_frame(frame).upper() == line.upper() + b"\r"
        assert format_frame(frame)[:1] == line[:1]

    @pytest.mark.parametrize(("line", "cause"), BAD)
    def test_a_damaged_line_is_none_and_says_why(self, line: bytes, cause: Cause) -> None:
        assert parse_frame(line) is cause

    @given(frames(), st.booleans())
    def test_what_is_written_is_read(self, frame: SlcanFrame, lower: bool) -> None:
        line = format_frame(frame)[:-1]
        assert parse_frame(line[:1] + line[1:].lower() if lower else line) == frame

    @given(frames(), st.integers(0, 40), st.integers(0, 255))
    def test_a_character_too_few_or_too_many_is_never_a_frame(
        self, frame: SlcanFrame, place: int, byte: int
    ) -> None:
        line = format_frame(frame)[:-1]
        place %= len(line)
        # Before the letter another letter may stand; what follows it is then no digit.
        assert isinstance(parse_frame(line[:place] + line[place + 1 :]), Cause)
        assert isinstance(parse_frame(line[:place] + bytes([byte]) + line[place:]), Cause)

    @given(st.binary(max_size=200))
    def test_nothing_raises(self, line: bytes) -> None:
        for parse in (parse_frame, parse_answer, parse_command):
            parse(line)

    @pytest.mark.parametrize(
        "frame",
        [
            SlcanFrame(0x800, b"", 0),
            SlcanFrame(-1, b"", 0),
            SlcanFrame(0x20000000, b"", 0, extended=True),
            SlcanFrame(1, bytes(9), 9),
            SlcanFrame(1, b"\x01", 2),
            SlcanFrame(1, b"\x01", 1, remote=True),
            SlcanFrame(1, b"", 9, remote=True),
            SlcanFrame(1, b"", 0, time_ms=60_000),
        ],
    )
    def test_what_no_line_can_say_is_refused(self, frame: SlcanFrame) -> None:
        with pytest.raises(ValueError, match=r"beyond|cannot be"):
            format_frame(frame)


class TestCommandsAndAnswers:
    @pytest.mark.parametrize(
        ("line", "answer"),
        [
            (b"", Answer("ok")),
            (b"\a", Answer("refused")),
            (b"z", Answer("sent")),
            (b"Z", Answer("sent")),
            (b"V1013", Answer("version", "1013")),
            (b"VL2K0 a1b2c3d github.com/x.git", Answer("version", "L2K0 a1b2c3d github.com/x.git")),
            (b"NA123", Answer("serial_number", "A123")),
            (b"F09", Answer("flags", "09")),
            (b"F0", Cause.LENGTH),
            (b"V", Cause.LENGTH),
            (b"V10\xff3", Cause.LENGTH),
            (b"x", Cause.LETTER),
        ],
    )
    def test_an_answer_is_read(self, line: bytes, answer: Answer | Cause) -> None:
        assert parse_answer(line) == answer

    @pytest.mark.parametrize(
        "line", ["O", "L", "C", "F", "V", "N", "S0", "S8", "s031C", "Z0", "Z1", "M0000FFFF"]
    )
    def test_a_command_is_read(self, line: str) -> None:
        assert parse_command(line.encode()) == SlcanCommand(line[0], line[1:])

    @pytest.mark.parametrize(
        ("line", "cause"),
        [
            (b"", Cause.LETTER),
            (b"S9", Cause.LETTER),
            (b"S", Cause.LETTER),
            (b"S66", Cause.LETTER),
            (b"O1", Cause.LETTER),
            (b"s031", Cause.LETTER),
            (b"M123", Cause.LETTER),
            (b"t12", Cause.LENGTH),
            (b"t1230EA5F", Cause.LENGTH),
        ],
    )
    def test_another_line_is_no_command(self, line: bytes, cause: Cause) -> None:
        assert parse_command(line) is cause

    def test_a_frame_is_a_command_as_well(self) -> None:
        assert parse_command(b"t1232ABCD") == SlcanFrame(0x123, b"\xab\xcd", 2)


class TestStream:
    def test_frames_and_answers_come_in_their_order_and_malformed_lines_are_counted(self) -> None:
        lines = AdapterLines()
        data = b"\rt1230\rt12\rz\rt8000\r\ad1230\rV1013\r\n\nt1240\r" + b"0" * 500 + b"\rt1250\rt12"
        found, answers = lines.feed(data)
        assert [frame.can_id for frame in found] == [0x123, 0x124, 0x125]
        assert [answer.kind for answer in answers] == ["ok", "sent", "refused", "version"]
        assert lines.malformed == {
            Cause.LENGTH: 1,
            Cause.IDENTIFIER: 1,
            Cause.UNSUPPORTED: 1,
            Cause.TOO_LONG: 1,
        }
        assert lines.feed(b"60\r")[0] == [SlcanFrame(0x126, b"", 0)]

    def test_a_bell_ends_a_damaged_line_and_is_heard(self) -> None:
        lines = AdapterLines()
        assert lines.feed(b"t1231A\at1230\r") == ([SlcanFrame(0x123, b"", 0)], [Answer("refused")])
        assert sum(lines.malformed.values()) == 1

    @given(
        st.lists(st.one_of(frames().map(format_frame), NOISE)).map(b"".join), st.lists(st.integers(0, 9999))
    )
    def test_how_the_bytes_are_cut_makes_no_difference(self, data: bytes, places: list[int]) -> None:
        whole, pieces = AdapterLines(), AdapterLines()
        expected = whole.feed(data)
        found: list[SlcanFrame] = []
        answers: list[Answer] = []
        for piece in cut(data, places):
            more = pieces.feed(piece)
            found += more[0]
            answers += more[1]
        assert (found, answers) == expected
        assert pieces.malformed == whole.malformed

    @given(st.lists(st.one_of(st.tuples(st.just(True), frames()), st.tuples(st.just(False), NOISE))))
    def test_frames_between_lines_of_noise_arrive(self, parts: list[tuple[bool, SlcanFrame | bytes]]) -> None:
        lines, data, sent = AdapterLines(), b"", []
        for _, part in parts:
            if isinstance(part, SlcanFrame):
                sent.append(part)
                data += format_frame(part)
            else:
                data += b"#" + part.replace(b"\r", b"").replace(b"\a", b"") + b"\r"
        found, _ = lines.feed(data)
        assert found == sent
        assert sum(lines.malformed.values()) == len(parts) - len(sent)

    @given(st.lists(st.tuples(st.binary(max_size=400), st.booleans()), max_size=20))
    def test_lines_are_those_of_the_bytes_but_for_those_that_are_too_long(
        self, parts: list[tuple[bytes, bool]]
    ) -> None:
        data = b"".join(part + (b"\r" if ends else b"") for part, ends in parts)
        *complete, tail = data.split(b"\r")
        lines = Lines()
        found = [line for part, ends in parts for line in lines.split(part + (b"\r" if ends else b""))]
        assert Counter(found) == Counter(line for line in complete if len(line) <= MAX_LINE)
        assert lines.too_long == sum(len(line) > MAX_LINE for line in [*complete, tail])

    def test_a_line_without_end_takes_no_memory(self) -> None:
        lines = AdapterLines()
        for _ in range(100):
            assert lines.feed(bytes(10_000)) == ([], [])
        assert lines.malformed == {Cause.TOO_LONG: 1}
        assert len(lines._lines._tail) <= MAX_LINE
        assert lines.feed(b"\rt1230\r") == ([SlcanFrame(0x123, b"", 0)], [])
