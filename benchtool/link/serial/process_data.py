"""Process data over a serial line: batches of records, and a setpoint message that needs no setting up."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchtool.link.interface import BatchLink
from benchtool.link.process_data import DriveAccess, Source, encoded
from benchtool.link.serial.batch_source import BatchSource
from benchtool.protocol.dictionary import Dictionary, Variable


class BatchProcessData:
    """The `ProcessData` of a link that carries batches."""

    def __init__(self, link: BatchLink) -> None:
        self._link = link

    def fitting(self, dictionary: Dictionary, channels: Sequence[str]) -> tuple[str, ...]:
        """See `ProcessData.fitting`."""
        return tuple(name for name in channels if name in dictionary)

    def source(
        self, drive: DriveAccess, channels: Sequence[str], rate_Hz: float, after: Source[Any] | None = None
    ) -> BatchSource:
        """See `ProcessData.source`; a stream leaves nothing on the drive that a later one has to know."""
        return BatchSource(drive, self._link, channels, rate_Hz)

    def setpoints(
        self, drive: DriveAccess, torque: Variable | None, speed: Variable | None
    ) -> SerialSetpoints:
        """See `ProcessData.setpoints`."""
        return SerialSetpoints(self._link, torque, speed)


class SerialSetpoints:
    """A `SetpointMessage` that the drive takes in any case."""

    def __init__(self, link: BatchLink, torque: Variable | None, speed: Variable | None) -> None:
        self._link = link
        self._torque, self._speed = torque, speed

    def encode(self, torque_Nm: float, omega_m_rad_s: float) -> bytes:
        """See `SetpointMessage.encode`."""
        return encoded(self._torque, torque_Nm) + encoded(self._speed, omega_m_rad_s)

    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        """See `SetpointMessage.send`."""
        # For its check of limits only: the message has SI units whatever the dictionary has.
        self.encode(torque_Nm, omega_m_rad_s)
        self._link.send_setpoint(torque_Nm, omega_m_rad_s)

    def close(self) -> None:
        """Nothing was set up."""
