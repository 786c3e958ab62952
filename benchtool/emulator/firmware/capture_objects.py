"""The capture objects in front of the core's capture memory."""

from __future__ import annotations

from benchtool.emulator.core.capture_memory import CaptureState
from benchtool.emulator.core.core import Core
from benchtool.emulator.firmware.objects import ObjectStore, Refused
from benchtool.protocol import CaptureHeader, encode_capture
from benchtool.protocol.canopen import Abort
from benchtool.protocol.dictionary import Entry, Number

_MAX_CHANNELS = 16
_MAX_VALUES = 1_000_000


class CaptureObjects:
    """Objects 0x2040 to 0x2042 of one drive."""

    def __init__(self, objects: ObjectStore, core: Core) -> None:
        self._objects = objects
        self._core = core
        self._sequence = 0
        self._stride = 1
        objects.check("capture_control", self._check_control)
        objects.on_write("capture_control", self._control)
        objects.compute("capture_state", lambda: int(core.capture.state))
        objects.compute("capture_rows_done", lambda: core.capture.rows_done)
        objects.compute("capture_trigger_tick", lambda: core.capture.trigger_tick)
        objects.compute("capture_sequence", lambda: self._sequence)
        objects.compute("capture_data", self._data)

    def abort(self) -> None:
        """Abort a capture that is under way; its rows are lost."""
        if self._core.capture.state in (CaptureState.ARMED, CaptureState.TRIGGERED):
            self._core.capture.abort()

    def _check_control(self, raw: Number) -> None:
        if raw == 1:
            self._channels()

    def _control(self, raw: Number) -> None:
        if raw == 0:
            self.abort()
            return
        self._sequence += 1
        self._stride = int(self._objects["capture_stride"])
        self._core.capture.arm(
            names=[entry.name for entry in self._channels()],
            rows=int(self._objects["capture_rows"]),
            stride=self._stride,
            pretrigger=int(self._objects["capture_pretrigger"]),
            trigger=int(self._objects["capture_trigger"]),
            trigger_name=self._trigger_name(),
            trigger_level=float(self._objects["capture_trigger_level"]),
        )

    def _channels(self) -> list[Entry]:
        channels: list[Entry] = []
        for position in range(1, _MAX_CHANNELS + 1):
            mapping = int(self._objects[f"capture_channel_{position}"])
            if mapping == 0:
                break
            channels.append(self._signal(mapping))
        rows = int(self._objects["capture_rows"])
        if not channels or rows * len(channels) > _MAX_VALUES or self._objects["capture_pretrigger"] >= rows:
            raise Refused(Abort.PARAMETER_INCOMPATIBLE)
        return channels

    def _signal(self, mapping: int) -> Entry:
        entry = self._objects.table.by_key.get((mapping >> 16, mapping >> 8 & 0xFF))
        if entry is None or entry.role != "signal" or entry.mapping != mapping:
            raise Refused(Abort.NOT_MAPPABLE)
        return entry

    def _trigger_name(self) -> str:
        return self._signal(int(self._objects["capture_trigger_signal"])).name

    def _data(self) -> bytes:
        capture = self._core.capture
        if capture.state is not CaptureState.COMPLETE:
            raise Refused(Abort.DEVICE_STATE)
        rows = capture.rows()
        header = CaptureHeader(
            n_channels=rows.shape[1],
            stride=self._stride,
            tick_period_ns=round(float(self._objects["control_period"]) * 1e9),
            rows=len(rows),
            first_tick=capture.first_tick,
            trigger_tick=capture.trigger_tick,
            sequence=self._sequence,
        )
        return encode_capture(header, rows.tobytes())
