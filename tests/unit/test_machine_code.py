"""Machine code on disk does what the plain function does, and a damaged file is no harm."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.emulator.machine_code import Entry, _flat


class Inner(NamedTuple):
    gain: float
    part: None
    turns: int


class Outer(NamedTuple):
    inner: Inner
    on: bool
    pair: tuple[float, float]


RECORD = np.dtype([("number", "u4"), ("value", "f4")])


def weigh(n: int, outer: Outer, rows: Any, table: Any, records: Any, scale: float) -> float:
    """Write to each array, and return a number that each argument changes."""
    total = scale * n + outer.pair[0] - 2.0 * outer.pair[1]
    if outer.on and outer.inner.part is None:
        total += outer.inner.gain * outer.inner.turns
    for row in range(table.shape[0]):
        for column in range(table.shape[1]):
            total += (row + 1) * (column + 3) * table[row, column]
    for k in range(rows.size):
        total += (k + 1) * rows[k]
        rows[k] = total
    records[0].number += n
    records[0].value = scale
    return total


def entry(folder: Path, function: Callable[..., Any] = weigh) -> Any:
    return Entry(lambda: function, function.__name__, folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the machine code of `weigh`."""
    place = tmp_path_factory.mktemp("machine_code")
    compiled = entry(place)
    compiled(*arguments())
    assert compiled.compilations == 1
    return place


def arguments(
    n: int = 2, gain: float = 1.5, count: int = 3, on: bool = True, scale: float = 0.5
) -> tuple[Any, ...]:
    rows, table = np.arange(4.0), np.arange(6.0).reshape(2, 3)
    return n, Outer(Inner(gain, None, count), on, (scale, gain)), rows, table, np.zeros(1, RECORD), scale


@given(
    st.integers(0, 1000),
    st.floats(-1e6, 1e6),
    st.integers(-(2**40), 2**40),
    st.booleans(),
    st.floats(-1e3, 1e3),
)
def test_loaded_code_does_what_the_plain_function_does(
    loaded: Any, n: int, gain: float, count: int, on: bool, scale: float
) -> None:
    compiled_arguments, plain = arguments(n, gain, count, on, scale), arguments(n, gain, count, on, scale)
    plain = (*plain[:4], plain[4].view(np.recarray), plain[5])
    assert loaded(*compiled_arguments) == pytest.approx(weigh(*plain), rel=1e-12, abs=1e-9)
    for one, other in zip(compiled_arguments[2:4], plain[2:4], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-9)
    assert compiled_arguments[4][0]["number"] == n
    assert compiled_arguments[4][0]["value"] == np.float32(scale)


@pytest.fixture(scope="module")
def loaded(folder: Path) -> Any:
    found = entry(folder)
    assert found.cached
    assert not found.loaded
    found(*arguments())
    assert found.compilations == 0
    return found


def halved(x: float) -> float:
    return 0.5 * x


@pytest.mark.parametrize("damage", ["empty", "no header", "cut", "no object", "one bit"])
def test_a_damaged_file_is_compiled_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: str
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert entry(tmp_path, halved)(3.0) == 1.5
    (kept,) = tmp_path.rglob("*.o")
    whole = kept.read_bytes()
    header = whole.index(b"\n") + 1
    middle = (header + len(whole)) // 2
    content = {
        "empty": b"",
        "no header": whole[header:],
        "cut": whole[:-1],
        "no object": whole[:header] + bytes(len(whole) - header),
        "one bit": whole[:middle] + bytes([whole[middle] ^ 4]) + whole[middle + 1 :],
    }[damage]
    kept.write_bytes(content)
    again, after = entry(tmp_path, halved), entry(tmp_path, halved)
    assert (again(3.0), again.compilations) == (1.5, 1)
    assert (after(3.0), after.compilations) == (1.5, 0)


def test_what_compiled_code_cannot_take_is_refused() -> None:
    every_other = np.arange(6.0)[::2]
    kept = np.arange(3.0)
    kept.flags.writeable = False
    for wrong in (every_other, kept):
        with pytest.raises(TypeError, match="contiguous, aligned and writable"):
            _flat(wrong)
    with pytest.raises(TypeError, match="takes no str"):
        _flat(("a", 1.0))


def test_numbers_are_packed_in_the_order_of_the_fields() -> None:
    flat = _flat(arguments()[1])
    assert flat.letters == "dPqbdd"
    assert struct.unpack("dqqqdd", flat.packed) == (1.5, 0, 3, 1, 0.5, 1.5)
    assert math.isclose(_flat(0.25).argument, 0.25)  # type: ignore[arg-type]
