"""The on-drive capture: armed over the link, recorded at the control rate, read as one domain."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from benchtool.block import Block
from benchtool.drive.capabilities import Capability
from benchtool.drive.remote import RemoteDrive
from benchtool.errors import CaptureError, ValueRefused
from benchtool.protocol import decode_capture
from benchtool.ticks import unwrap_tick

_POLL_S = 0.01
_SLACK_S = 1.0
MAX_CHANNELS: Final = 16
"""Channels of a capture: objects `capture_channel_1` and on."""


@dataclass(frozen=True)
class CaptureRequest:
    """What to capture: names of signals, rows in all, ticks per row, and rows from before the trigger.

    Raises:
        ValueRefused: no channel, or more than a capture has.
    """

    channels: tuple[str, ...]
    rows: int
    stride: int = 1
    pretrigger_rows: int = 0
    trigger: str = "immediate"
    trigger_signal: str | None = None
    trigger_level: float = 0.0

    def __post_init__(self) -> None:
        if not 0 < len(self.channels) <= MAX_CHANNELS:
            raise ValueRefused(
                f"{len(self.channels)} channels, 1 to {MAX_CHANNELS} are expected; nothing was sent: "
                f"choose some"
            )


class Capture:
    """One armed capture.

    Args:
        drive: connected drive.
        request: what to capture; it is armed on construction.

    Raises:
        CapabilityMissing: the drive has no capture.
        SdoAbort: the drive refuses the request.
    """

    def __init__(self, drive: RemoteDrive, request: CaptureRequest) -> None:
        drive.capabilities.require(Capability.CAPTURE, purpose="a capture")
        self._drive = drive
        self._channels = [drive.dictionary[name] for name in request.channels]
        mappings = [variable.mapping for variable in self._channels]
        for position, mapping in enumerate([*mappings, 0][:MAX_CHANNELS], start=1):
            drive.write(f"capture_channel_{position}", mapping)
        drive.write("capture_rows", request.rows)
        drive.write("capture_stride", request.stride)
        drive.write("capture_pretrigger", request.pretrigger_rows)
        drive.write("capture_trigger", request.trigger)
        if request.trigger_signal is not None:
            drive.write("capture_trigger_signal", drive.dictionary[request.trigger_signal].mapping)
            drive.write("capture_trigger_level", request.trigger_level)
        drive.write("capture_control", "arm")
        self._sequence = int(drive.number("capture_sequence"))
        self.duration_s = request.rows * request.stride * drive.number("control_period")

    def wait(self) -> None:
        """Return when the capture is complete.

        Raises:
            DriveFault: an emergency arrived meanwhile.
            CaptureError: it was aborted, or is not complete a second after it should be.
        """
        self._drive.wait(self.duration_s)
        waited_s = 0.0
        while (state := self._drive.read("capture_state")) != "complete":
            rows = self._drive.number("capture_rows_done")
            if state not in ("armed", "triggered"):
                raise CaptureError(
                    f"the capture is {state!r} after {rows:.0f} rows, 'complete' was expected: "
                    f"another master or a reset of the drive ended it; arm it again"
                )
            if waited_s > _SLACK_S:
                raise CaptureError(
                    f"the capture is still {state!r} with {rows:.0f} rows {_SLACK_S:g} s after its end: "
                    f"check its trigger"
                )
            self._drive.wait(_POLL_S)
            waited_s += _POLL_S

    def read(self) -> Block:
        """Return the captured rows, by block upload.

        Raises:
            CaptureError: the data are inconsistent or belong to another capture.
        """
        variable = self._drive.dictionary["capture_data"]
        data = self._drive.link.upload(variable.index, variable.sub, block=True)
        block = decode_capture(data, self._channels, self._sequence)
        return replace(block, first_tick=unwrap_tick(block.first_tick, self._drive.tick_now()))
