"""Process data over CAN: records in TPDOs, setpoints in RPDO1."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchtool.errors import BenchError, ValueRefused
from benchtool.link.canopen.pdo_backup import PdoBackup
from benchtool.link.canopen.pdo_source import PdoSource
from benchtool.link.interface import FrameLink
from benchtool.link.process_data import DriveAccess, Source, encoded
from benchtool.protocol import most_channels
from benchtool.protocol.canopen import MAX_BITS, rpdo
from benchtool.protocol.dictionary import Dictionary, Role, Variable


class PdoProcessData:
    """The `ProcessData` of a link that carries frames."""

    def __init__(self, link: FrameLink) -> None:
        self._link = link

    def fitting(self, dictionary: Dictionary, channels: Sequence[str]) -> tuple[str, ...]:
        """See `ProcessData.fitting`; node ids above 63 have fewer TPDOs, and so fewer channels."""
        return tuple(name for name in channels if name in dictionary)[: most_channels(self._link.node_id)]

    def source(
        self, drive: DriveAccess, channels: Sequence[str], rate_Hz: float, after: Source[Any] | None = None
    ) -> PdoSource:
        """See `ProcessData.source`."""
        return PdoSource(
            drive, self._link, channels, rate_Hz, after if isinstance(after, PdoSource) else None
        )

    def setpoints(self, drive: DriveAccess, torque: Variable | None, speed: Variable | None) -> PdoSetpoints:
        """See `ProcessData.setpoints`."""
        return PdoSetpoints(drive, self._link, torque, speed)


class PdoSetpoints:
    """A `SetpointMessage` in RPDO1, whose parameters are restored at the end."""

    def __init__(
        self, drive: DriveAccess, link: FrameLink, torque: Variable | None, speed: Variable | None
    ) -> None:
        self._drive = drive
        self._link = link
        self._torque, self._speed = torque, speed
        mapped = [each for each in (torque, speed) if each is not None]
        _require_rpdo(drive.dictionary)
        _require_mappable(*mapped)
        self._pdo = rpdo(link.node_id, [each.mapping for each in mapped])
        self._found = PdoBackup.of(drive, self._pdo)
        try:
            for label, value in self._pdo.set_up():
                drive.write(label, value)
        except BaseException as failure:
            try:
                self.close()
            except BenchError as also:
                failure.add_note(str(also))
            raise

    def encode(self, torque_Nm: float, omega_m_rad_s: float) -> bytes:
        """See `SetpointMessage.encode`."""
        return encoded(self._torque, torque_Nm) + encoded(self._speed, omega_m_rad_s)

    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        """See `SetpointMessage.send`."""
        self._link.send_pdo(self._pdo.can_id, self.encode(torque_Nm, omega_m_rad_s))

    def close(self) -> None:
        """See `SetpointMessage.close`."""
        self._found.restore(self._drive)


def _require_rpdo(dictionary: Dictionary) -> None:
    for role in (Role.RPDO_COB_ID, Role.RPDO_MAPPING):
        if role.key not in dictionary:
            raise ValueRefused(
                f"setpoints at a rate take RPDO1, and {dictionary.source} has no {role.label}: give an EDS "
                f"that lists it; this drive takes no setpoints at a rate"
            )


def _require_mappable(*setpoints: Variable) -> None:
    for each in setpoints:
        if not (each.mappable and each.writable):
            raise ValueRefused(
                f"'{each.name}' ({each.label}) cannot be in an RPDO: its EDS says PDOMapping="
                f"{int(each.mappable)}, AccessType={each.access}; this drive takes no setpoints at a rate"
            )
    bits = sum(each.type.bits for each in setpoints)
    if bits > MAX_BITS:
        raise ValueRefused(
            f"{' and '.join(each.name for each in setpoints)} have {bits // 8} bytes together, an RPDO has "
            f"{MAX_BITS // 8}: this drive takes no setpoints at a rate"
        )
