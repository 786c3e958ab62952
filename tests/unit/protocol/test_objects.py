"""The table of objects and the hash that names its version."""

from __future__ import annotations

import copy
import tomllib
from typing import Any

import pytest

from benchtool.protocol.dictionary.objects import DataType, ObjectTable, table_from_toml
from benchtool.shipped import shipped

DOCUMENT = tomllib.loads((shipped("firmware_protocol") / "objects.toml").read_text(encoding="utf-8"))


def changed(index: int, sub: int | None, /, **keys: Any) -> ObjectTable:
    """The table with keys of one object, or of one of its entries, replaced."""
    document = copy.deepcopy(DOCUMENT)
    row = next(item for item in document["object"] if item["index"] == index)
    if sub is not None:
        row = next(entry for entry in row["entry"] if entry["sub"] == sub)
    row.update(keys)
    return table_from_toml(document)


@pytest.mark.parametrize(
    "keys",
    [
        {"name": "R_phase"},
        {"sub": 40},
        {"type": "u32"},
        {"unit": "mohm"},
        {"factor": 0.5},
        {"role": "status"},
        {"access": "ro"},
        {"min": 0.01},
        {"max": 99.0},
        {"default": 0.2},
        {"values": {"low": 0}},
        {"enabled_write": False},
    ],
    ids=lambda keys: next(iter(keys)),
)
def test_hash_changes_with_everything_a_host_must_agree_on(keys: dict[str, Any]) -> None:
    assert changed(0x2000, 2, **keys).hash != table_from_toml(DOCUMENT).hash


def test_hash_changes_with_an_index() -> None:
    assert changed(0x606C, None, index=0x606D).hash != table_from_toml(DOCUMENT).hash


def test_hash_does_not_change_with_descriptions_or_with_its_own_default() -> None:
    expected = table_from_toml(DOCUMENT).hash
    assert changed(0x2000, 2, description="something else").hash == expected
    assert changed(0x2000, None, description="something else").hash == expected
    assert changed(0x2060, None, default=1234).hash == expected


def test_hash_does_not_change_with_the_order_of_the_file() -> None:
    document = {**DOCUMENT, "object": list(reversed(DOCUMENT["object"]))}
    assert table_from_toml(document).hash == table_from_toml(DOCUMENT).hash


def test_names_are_unique() -> None:
    with pytest.raises(ValueError, match=r"repeated: L_d"):
        changed(0x2000, 2, name="L_d")


def test_counts_of_records_and_arrays() -> None:
    table = table_from_toml(DOCUMENT)
    assert table.by_name["motor_count"].default == 8
    assert [entry.name for entry in table if entry.index == 0x1016] == [
        "consumer_heartbeat_count",
        "host_heartbeat",
    ]
    channels = [entry for entry in table if entry.index == 0x2041]
    assert [entry.sub for entry in channels] == list(range(17))
    assert channels[16].name == "capture_channel_16"


def test_signals_are_four_bytes_wide_and_mappable() -> None:
    signals = [entry for entry in table_from_toml(DOCUMENT) if entry.role == "signal"]
    assert {entry.type for entry in signals} == {DataType.U32, DataType.F32}
    assert all(entry.mappable for entry in signals)
    assert table_from_toml(DOCUMENT).by_name["torque"].mapping == 0x20300C20


def test_defaults_are_within_their_limits() -> None:
    for entry in table_from_toml(DOCUMENT):
        if isinstance(entry.default, int | float):
            assert entry.minimum is None or entry.default >= entry.minimum, entry.name
            assert entry.maximum is None or entry.default <= entry.maximum, entry.name
            assert entry.values is None or entry.default in entry.values.values(), entry.name


@pytest.mark.parametrize("type_", list(DataType))
def test_bits_are_those_of_the_numpy_type(type_: DataType) -> None:
    digits = "".join(character for character in type_ if character.isdigit())
    assert type_.bits == int(digits or 0)
