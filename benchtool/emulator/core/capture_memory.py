"""On-drive capture: rows of up to 16 signals at the control rate, around a trigger.

While armed, rows go into a ring. The trigger is looked for in every tick, also between two rows; from then on
the capture goes on until it has `rows` rows, of which at most `pretrigger` are from before the trigger. A
trigger that comes before so many rows are there is taken all the same, and more rows follow it.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit
from benchtool.emulator.memory import Record, record_type, word_offset, words
from benchtool.errors import ValueRefused
from benchtool.protocol import MOST_VALUES
from benchtool.ticks import wrap_tick

MAX_ROWS = 200_000
MAX_CHANNELS = 16
MAX_VALUES = MOST_VALUES


class CaptureState(IntEnum):
    """Object `capture_state`."""

    IDLE = 0
    ARMED = 1
    TRIGGERED = 2
    COMPLETE = 3
    ABORTED = 4


class Trigger(IntEnum):
    """Object `capture_trigger`."""

    IMMEDIATE = 0
    SETPOINT = 1
    RISING = 2
    FALLING = 3
    FAULT = 4
    STIMULUS = 5


_ARMED, _TRIGGERED, _COMPLETE = (
    int(CaptureState.ARMED),
    int(CaptureState.TRIGGERED),
    int(CaptureState.COMPLETE),
)
_IMMEDIATE, _SETPOINT, _RISING = int(Trigger.IMMEDIATE), int(Trigger.SETPOINT), int(Trigger.RISING)
_FALLING, _FAULT = int(Trigger.FALLING), int(Trigger.FAULT)

# `written` counts rows since arming, `row` is where the next one goes; `first` and `end` say which are kept;
# `last_*` are of the tick before.
CAPTURE = record_type(
    [
        ("state", "u4"),
        ("trigger", "u4"),
        ("stride", "u4"),
        ("pretrigger", "u4"),
        ("until_row", "u4"),
        ("armed_tick", "u4"),
        ("trigger_tick", "u4"),
        ("written", "i8"),
        ("row", "i8"),
        ("first", "i8"),
        ("end", "i8"),
        ("trigger_word", "u4"),
        ("trigger_is_float", "u4"),
        ("compared", "u4"),
        ("trigger_level", "f8"),
        ("last_value", "f8"),
        ("last_torque_command", "f8"),
        ("last_omega_command", "f8"),
    ]
)


@njit
def capture_row(
    capture: Any,
    drive: Any,
    drive_words: NDArray[np.uint32],
    drive_floats: NDArray[np.float32],
    channels: NDArray[np.uint32],
    rows: NDArray[np.uint32],
    tripped: bool,
    began: bool,
) -> None:
    """Look for the trigger and take a row if one is due, when all signals of the tick are fresh.

    `tripped` and `began` say whether a trip was raised and a stimulus began in this tick.
    """
    if capture.state != _ARMED and capture.state != _TRIGGERED:
        return
    if capture.state == _ARMED:
        if capture.written == 0 and capture.compared == 0:
            capture.armed_tick = drive.tick
        if _triggers(capture, drive, drive_words, drive_floats, tripped, began):
            capture.state = _TRIGGERED
            capture.trigger_tick = drive.tick
            capture.first = max(0, capture.written - capture.pretrigger)
            capture.end = capture.first + rows.shape[0]
    if capture.until_row > 0:
        capture.until_row -= 1
        return
    capture.until_row = capture.stride - 1
    for column in range(channels.size):
        rows[capture.row, column] = drive_words[channels[column]]
    capture.row = capture.row + 1 if capture.row + 1 < rows.shape[0] else 0
    capture.written += 1
    if capture.state == _TRIGGERED and capture.written >= capture.end:
        capture.state = _COMPLETE


@njit
def _triggers(
    capture: Any,
    drive: Any,
    drive_words: NDArray[np.uint32],
    drive_floats: NDArray[np.float32],
    tripped: bool,
    began: bool,
) -> bool:
    value = float(drive_words[capture.trigger_word])
    if capture.trigger_is_float == 1:
        value = float(drive_floats[capture.trigger_word])
    torque_command, omega_command = float(drive.torque_command), float(drive.omega_m_command)
    level = capture.trigger_level
    if capture.trigger == _IMMEDIATE:
        hit = True
    elif capture.trigger == _SETPOINT:
        changed = torque_command != capture.last_torque_command or omega_command != capture.last_omega_command
        hit = changed
    elif capture.trigger == _RISING:
        hit = capture.compared == 1 and capture.last_value < level and value >= level
    elif capture.trigger == _FALLING:
        hit = capture.compared == 1 and capture.last_value > level and value <= level
    elif capture.trigger == _FAULT:
        hit = tripped
    else:
        hit = began
    capture.compared = 1
    capture.last_value = value
    capture.last_torque_command = torque_command
    capture.last_omega_command = omega_command
    return hit


class CaptureRecorder:
    """The capture unit of one drive; the kernel fills it while the core runs."""

    def __init__(self, memory: Record) -> None:
        self._memory = memory
        self.record: Record = np.zeros(1, CAPTURE)
        self.words = words(memory)
        self.floats = memory.view(np.float32)
        self.channels = np.zeros(0, np.uint32)
        self.buffer = np.zeros((1, 0), np.uint32)

    def arm(
        self,
        *,
        names: Sequence[str],
        rows: int,
        stride: int = 1,
        pretrigger: int = 0,
        trigger: int = Trigger.IMMEDIATE,
        trigger_name: str = "torque",
        trigger_level: float = 0.0,
    ) -> None:
        """Discard earlier rows and wait for a trigger.

        `trigger_level` is in the unit of `trigger_name`, and counts for the rising and falling trigger.

        Raises:
            ValueRefused: a name is no four-byte field of the memory, or a number is out of its limits.
        """
        self._refuse(names, rows, stride, pretrigger, trigger, trigger_name)
        self.channels = np.array([word_offset(self._memory, name) for name in names], np.uint32)
        if self.buffer.shape != (rows, len(names)):  # new pages cost a hundredth of the run
            self.buffer = np.zeros((rows, len(names)), np.uint32)
        self.record[:] = 0
        capture = self.record[0]
        capture.state = CaptureState.ARMED
        capture.trigger = trigger
        capture.stride = stride
        capture.pretrigger = pretrigger
        capture.trigger_word = word_offset(self._memory, trigger_name)
        capture.trigger_is_float = self._memory.dtype[trigger_name].kind == "f"
        capture.trigger_level = trigger_level
        capture.last_torque_command = self._memory[0].torque_command
        capture.last_omega_command = self._memory[0].omega_m_command

    def abort(self) -> None:
        """Drop the rows."""
        self.record[0].state = CaptureState.ABORTED

    @property
    def state(self) -> CaptureState:
        return CaptureState(int(self.record[0].state))

    @property
    def trigger_tick(self) -> int:
        """Tick in which the trigger came; 0 before."""
        return int(self.record[0].trigger_tick)

    @property
    def first_tick(self) -> int:
        """Tick of the first kept row."""
        capture = self.record[0]
        return wrap_tick(int(capture.armed_tick) + int(capture.first) * int(capture.stride))

    @property
    def rows_done(self) -> int:
        """Rows that would be kept so far: while armed those of the pretrigger."""
        capture = self.record[0]
        written = int(capture.written)
        if self.state is CaptureState.ARMED:
            return min(written, int(capture.pretrigger))
        return written - int(capture.first)

    def rows(self) -> NDArray[np.uint32]:
        """Return rows of a complete capture in order of time, shape (rows, channels), as raw 32-bit words.

        Raises:
            ValueRefused: the capture is not complete.
        """
        if self.state is not CaptureState.COMPLETE:
            raise ValueRefused(f"capture is {self.state.name.lower()}, only a complete one can be read: wait")
        return np.roll(self.buffer, -(int(self.record[0].first) % len(self.buffer)), axis=0)

    def _refuse(
        self,
        names: Sequence[str],
        rows: int,
        stride: int,
        pretrigger: int,
        trigger: int,
        trigger_name: str,
    ) -> None:
        for name in [*names, trigger_name]:
            if name not in (self._memory.dtype.names or ()) or self._memory.dtype[name].itemsize != 4:
                raise ValueRefused(
                    f"'{name}' cannot be captured, a signal of four bytes is needed: choose one"
                )
        if not 1 <= len(names) <= MAX_CHANNELS:
            raise ValueRefused(f"{len(names)} channels to capture, 1 to {MAX_CHANNELS} can be: choose fewer")
        if not 1 <= rows <= MAX_ROWS or rows * len(names) > MAX_VALUES:
            raise ValueRefused(
                f"{rows} rows of {len(names)} channels, at most {MAX_ROWS} rows and {MAX_VALUES} values fit: "
                f"capture fewer or use a stride"
            )
        if not 0 <= pretrigger < rows:
            raise ValueRefused(f"pretrigger of {pretrigger} rows in {rows}: keep it below the number of rows")
        if stride < 1:
            raise ValueRefused(f"stride of {stride}, 1 or more is needed: correct it")
        if trigger not in tuple(Trigger):
            raise ValueRefused(f"no trigger {trigger}: it is one of {', '.join(map(str, map(int, Trigger)))}")
