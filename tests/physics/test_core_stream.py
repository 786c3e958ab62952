"""The stream's ring: what is written, on which ticks, and what is lost without a reader."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.core.kernels import kernel_of
from benchtool.emulator.core.stream_ring import RING_ROWS
from benchtool.errors import ValueRefused
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import make_core


def _ticks(core: Core, rows: int = RING_ROWS) -> list[int]:
    return [int(tick) for tick in core.stream.read(rows).rows[:, 0]]


def test_rows_are_those_of_the_ticks_that_the_stride_divides() -> None:
    core = make_core()
    core.run(7)
    core.stream.start(["tick", "u_dc"], 5)
    assert core.stream.ticks_until(3) == 13
    core.run(13)
    assert (core.stream.ticks_until(3), core.stream.waiting) == (0, 3)
    core.run(4)
    assert core.stream.ticks_until(4) == 1
    lost, first_tick, rows = core.stream.read(2)
    assert (lost, first_tick, [int(tick) for tick in rows[:, 0]]) == (0, 10, [10, 15])
    assert rows[:, 1].view(np.float32) == pytest.approx(122.5, abs=0.3)
    core.run(1)
    assert core.stream.read(100)[1] == 20
    core.stream.stop()
    core.run(50)
    assert core.stream.waiting == 0


def test_nothing_is_written_before_the_start() -> None:
    core = make_core()
    core.run(100)
    assert core.stream.waiting == 0
    core.stream.start(["tick"], 1)
    core.stream.start(["tick"], 3)
    core.run(10)
    assert _ticks(core) == [102, 105, 108]


@given(
    st.lists(st.tuples(st.integers(1, 3 * RING_ROWS), st.integers(1, 2 * RING_ROWS)), max_size=6),
    st.integers(1, 3),
)
def test_every_row_is_taken_once_or_counted_as_lost(parts: list[tuple[int, int]], stride: int) -> None:
    core = make_core()
    core.stream.start(["tick"], stride)
    expected = stride
    for ticks, wanted in parts:
        core.run(ticks)
        lost, first_tick, rows = core.stream.read(wanted)
        assert lost == 0 or core.stream.waiting + len(rows) == RING_ROWS
        expected += lost * stride
        assert first_tick == expected
        assert rows[:, 0].tolist() == [expected + stride * row for row in range(len(rows))]
        expected += len(rows) * stride
    assert expected + core.stream.waiting * stride == (int(core.memory["tick"][0]) // stride + 1) * stride


def _streamed(kernel: Any, ticks: int) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    core = make_core(sensors={"current_noise_A_rms": 0.015}, seed=3)
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 20.0
    names = ["tick", "i_a", "torque", "switching_count"]
    core.capture.arm(names=names, rows=ticks)
    core.stream.start(names, 1)
    assert core.run_with(kernel, ticks) == ticks
    return core.stream.read(ticks).rows, core.capture.rows()


def test_compiled_and_plain_kernel_stream_the_same_bits_and_those_of_a_capture() -> None:
    compiled, captured = _streamed(kernel_of(make_core()._truth), 200)
    plain, _ = _streamed(run_ticks, 200)
    assert np.array_equal(compiled, captured)
    assert np.array_equal(compiled[:, [0, 3]], plain[:, [0, 3]])
    floats, plain_floats = compiled[:, 1:3].view(np.float32), plain[:, 1:3].view(np.float32)
    assert floats == pytest.approx(plain_floats, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize(
    ("names", "stride", "named"),
    [
        ([], 1, "0 channels"),
        (["tick"] * 17, 1, "17 channels"),
        (["law"], 1, "'law'"),
        (["nothing"], 1, "'nothing'"),
        (["tick"], 0, "stride"),
    ],
)
def test_refuses_what_cannot_be_streamed(names: list[str], stride: int, named: str) -> None:
    with pytest.raises(ValueRefused, match=named):
        make_core().stream.start(names, stride)
