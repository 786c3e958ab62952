"""The golden vectors: true to the page and to a second implementation, and the code true to them."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest
from cobs import cobs

from benchtool.protocol.serial import (
    VERSION,
    Event,
    FrameSplitter,
    MessageType,
    Reject,
    decode_reply,
    decode_request,
    encode_frame,
    encode_message,
)
from tests.unit.protocol.serial.reference import PAGE, VECTORS, crc32, frame, payload, sections, stuff

MESSAGES = {each["name"]: each for each in VECTORS["messages"]}


def named(part: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("vector", VECTORS[part], ids=lambda each: each["name"])


def test_crc() -> None:
    for vector in VECTORS["crc"]:
        assert crc32(bytes.fromhex(vector["data"])) == vector["crc"]
    assert VECTORS["version"] == VERSION


@named("cobs")
def test_stuffing(vector: dict[str, str]) -> None:
    plain, stuffed = bytes.fromhex(vector["plain"]), bytes.fromhex(vector["stuffed"])
    assert stuff(plain) == stuffed
    assert cobs.encode(plain) == stuffed
    assert cobs.decode(stuffed) == plain


@named("messages")
def test_message(vector: dict[str, Any]) -> None:
    """Bytes are what the page's table makes of the fields, and mean what the fields say."""
    data = bytes.fromhex(vector["payload"])
    assert data[0] == vector["type"]
    assert payload(vector["type"], vector["fields"]) == data
    assert frame(data).hex() == vector["frame"]
    assert encode_frame(data).hex() == vector["frame"]
    assert FrameSplitter().feed(bytes.fromhex(vector["frame"])) == [data]
    ours, theirs = (
        (decode_request, decode_reply) if vector["from"] == "host" else (decode_reply, decode_request)
    )
    message = ours(data)
    assert message is not None
    assert encode_message(message) == data
    assert theirs(data) is None
    for name, value in vector["fields"].items():
        found = field(message, name)
        assert (list(found) if isinstance(found, tuple) else found) == value, name


def field(message: Any, name: str) -> Any:
    """A field as the vectors have it."""
    if isinstance(message, Event) and name in ("error_code", "error_register", "vendor"):
        part = {"error_code": "code", "error_register": "register"}.get(name, name)
        found: Any = getattr(message.emergency, part)
    elif isinstance(message, Reject) and name == "request_type":
        found = message.type
    elif name == "name_length":
        found = len(message.device_name)
    elif name == "n" and not hasattr(message, "n"):
        found = len(message.mappings)
    else:
        found = getattr(message, name)
    return found.hex() if isinstance(found, bytes) else found


def test_every_type_has_a_vector_a_table_and_an_example() -> None:
    types = set(MessageType)
    assert {each["type"] for each in VECTORS["messages"]} == types
    assert set(sections()) == types
    heads = {int(kind, 16): name for kind, name in re.findall(r"^### 0x(..) (\w+)$", PAGE, re.MULTILINE)}
    assert heads == {each.value: each.name for each in MessageType}


def test_examples_of_the_page_are_the_vectors() -> None:
    examples = re.findall(r"^Example `(\w+)`: `([0-9a-f ]+)`$", PAGE, re.MULTILINE)
    assert len(examples) == PAGE.count("\nExample")
    for name, data in examples:
        assert bytes.fromhex(data).hex() == MESSAGES[name]["payload"], name
    assert {MESSAGES[name]["type"] for name, _ in examples} == set(MessageType)
    ((name, data),) = re.findall(r"^Frame of `(\w+)`: `([0-9a-f ]+)`$", PAGE, re.MULTILINE)
    assert bytes.fromhex(data).hex() == MESSAGES[name]["frame"]


@named("lines")
def test_line(vector: dict[str, Any]) -> None:
    splitter = FrameSplitter(vector["max_payload"])
    found = [each.hex() for each in splitter.feed(bytes.fromhex(vector["bytes"]))]
    assert found == vector["payloads"]
    causes = ("too_long", "bad_stuffing", "too_short", "bad_crc")
    assert {cause: getattr(splitter, cause) for cause in causes} == {cause: vector[cause] for cause in causes}
    assert splitter.dropped == sum(vector[cause] for cause in causes)
    assert splitter.frames == len(found)


def test_the_lines_show_every_cause_and_the_closing_run() -> None:
    for cause in ("too_long", "bad_stuffing", "too_short", "bad_crc"):
        assert any(each[cause] for each in VECTORS["lines"])
    (closed,) = (each for each in VECTORS["lines"] if each["name"] == "closed_by_an_empty_run")
    data = bytes.fromhex(closed["bytes"])
    assert (data[1], data.index(0, 1)) == (0xFF, 257)
    assert data[256] == 1


@named("requests_not_understood")
def test_request_that_cannot_be_taken(vector: dict[str, str]) -> None:
    answer = decode_request(bytes.fromhex(vector["payload"]))
    if vector["answer"]:
        assert isinstance(answer, Reject)
        assert encode_message(answer).hex() == vector["answer"]
    else:
        assert answer is None


@named("replies_dropped")
def test_reply_that_is_dropped(vector: dict[str, str]) -> None:
    assert decode_reply(bytes.fromhex(vector["payload"])) is None


def test_setpoints_are_taken_by_the_rule_of_the_page() -> None:
    for vector in VECTORS["setpoint_sequences"]:
        last = vector["last"]
        taken = last is None or 1 <= (vector["sequence"] - last) % 2**32 < 2**31
        assert taken == vector["taken"], vector


def test_scaled_values_follow_the_rule_of_the_page() -> None:
    for vector in VECTORS["scaled"]:
        steps = math.nan if vector["value"] is None else vector["value"] / vector["scale"]
        assert vector["raw"] == (round(steps) if abs(steps) <= 32767 else -32768)


def test_numbers_of_the_page() -> None:
    """What the page says a batch takes."""
    records, values = 20, 16
    data = 14 + records * values * 4
    assert 21 + records * values * 4 + (data + 4) // 254 == 1306 == len(frame(b"\x01" * data))
    assert "1306 bytes every 2 ms" in PAGE
