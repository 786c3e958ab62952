"""Access, limits and state of every object are checked before memory changes."""

from __future__ import annotations

import struct
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.emulator.firmware.objects import ObjectStore, Refused
from benchtool.emulator.memory import new_memory
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.dictionary.objects import load_table
from benchtool.shipped import shipped

TABLE = load_table(shipped("firmware_protocol") / "objects.toml")


def _store(*, enabled: bool = False) -> ObjectStore:
    return ObjectStore(TABLE, new_memory(TABLE), lambda: enabled)


def _write(store: ObjectStore, name: str, data: bytes) -> Abort | None:
    entry = TABLE.by_name[name]
    try:
        store.write(entry.index, entry.sub, data)
    except Refused as refused:
        return refused.code
    return None


def _f32(value: float) -> bytes:
    return struct.pack("<f", value)


@pytest.mark.parametrize(
    ("name", "data", "code"),
    [
        ("R_s", _f32(0.2), None),
        ("R_s", _f32(100.0), None),
        ("L_d", _f32(1e-6), None),
        ("R_s", _f32(100.1), Abort.VALUE_HIGH),
        ("R_s", _f32(-0.1), Abort.VALUE_LOW),
        ("R_s", _f32(float("nan")), Abort.VALUE),
        ("R_s", _f32(float("inf")), Abort.VALUE),
        ("R_s", b"\x00\x00\x00", Abort.LENGTH_LOW),
        ("R_s", b"\x00" * 5, Abort.LENGTH_HIGH),
        ("mode_of_operation", b"\x07", Abort.VALUE),
        ("statusword", b"\x00\x00", Abort.READ_ONLY),
        ("device_name", b"x", Abort.READ_ONLY),
        ("capture_data", b"x", Abort.READ_ONLY),
    ],
)
def test_what_is_taken_and_what_is_refused(name: str, data: bytes, code: Abort | None) -> None:
    store = _store()
    entry = TABLE.by_name[name]
    before = None if entry.type.numpy is None else store.read(entry.index, entry.sub)
    assert _write(store, name, data) is code
    if before is not None:
        assert store.read(entry.index, entry.sub) == (data if code is None else before)


def test_unknown_index_and_sub_index_are_told_apart() -> None:
    with pytest.raises(Refused) as refused:
        _store().read(0x5555, 0)
    assert refused.value.code is Abort.NO_OBJECT
    with pytest.raises(Refused) as refused:
        _store().read(0x2000, 99)
    assert refused.value.code is Abort.NO_SUB_INDEX


def test_some_parameters_wait_until_the_power_stage_is_off() -> None:
    assert _write(_store(enabled=True), "pole_pairs", b"\x03") is Abort.DEVICE_STATE
    assert _write(_store(enabled=False), "pole_pairs", b"\x03") is None
    assert _write(_store(enabled=True), "torque_limit", _f32(0.5)) is None


def test_every_number_starts_at_its_default() -> None:
    store = _store()
    for entry in TABLE:
        if entry.type.numpy is not None:
            expected = np.asarray(entry.default, dtype=entry.type.numpy).tobytes()
            assert store.read(entry.index, entry.sub) == expected, entry.name


@given(st.integers(0, 0xFFFF), st.integers(0, 0xFF), st.binary(max_size=12))
def test_any_access_is_answered_by_a_value_or_an_abort(index: int, sub: int, data: bytes) -> None:
    store = _store()
    with suppress(Refused):
        store.write(index, sub, data)
    with suppress(Refused):
        store.read(index, sub)


@pytest.mark.parametrize("bad", [0, 1, 2])
def test_several_values_are_taken_together_or_not_at_all(bad: int) -> None:
    store = _store()
    names = ("torque_command", "omega_m_command", "R_s")
    values = [(TABLE.by_name[name], _f32(0.5)) for name in names]
    store.write_all(values)
    assert [store[name] for name in names] == [0.5, 0.5, 0.5]
    changed = [(entry, _f32(0.75)) for entry, _ in values]
    changed[bad] = (changed[bad][0], _f32(float("nan")))
    with pytest.raises(Refused):
        store.write_all(changed)
    assert [store[name] for name in names] == [0.5, 0.5, 0.5]
