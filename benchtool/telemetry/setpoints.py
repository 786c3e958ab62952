"""Setpoints as process data: one message for torque and speed, which feeds the drive's link supervision."""

from __future__ import annotations

from typing import Protocol

from benchtool.errors import BenchError, ValueRefused
from benchtool.link import BatchLink, FrameLink
from benchtool.protocol.canopen.nmt import NmtCommand
from benchtool.protocol.canopen.pdo import MAX_BITS, rpdo
from benchtool.protocol.dictionary.variable import Variable
from benchtool.telemetry.node import Node
from benchtool.telemetry.pdo_restoring import FoundPdo

TORQUE, SPEED = "torque_command", "omega_m_command"


class Setpoints:
    """Sets the drive up for setpoints of torque and speed; `send` then takes one message and no answer.

    The drive takes them in the NMT state operational, within the limits of its dictionary.

    Args:
        node: connected drive.
        torque, speed: its objects in Nm and rad/s, of which one may be left out; those of benchtool's
            dictionary without either.

    Raises:
        ValueRefused: the drive or the link has no such setpoints.
        SdoAbort, NoAnswer, WriteNotVerified: it cannot be set up.
    """

    def __init__(self, node: Node, torque: Variable | None = None, speed: Variable | None = None) -> None:
        if torque is None and speed is None:
            torque, speed = node.dictionary[TORQUE], node.dictionary[SPEED]
        link = node.link
        self._wire: _Wire
        if isinstance(link, BatchLink):
            self._wire = _Messages(link, torque, speed)
        elif isinstance(link, FrameLink):
            self._wire = _ProcessData(node, link, torque, speed)
        else:
            raise ValueRefused("this link carries no setpoints: use another link")
        link.nmt(NmtCommand.START)

    def check(self, *, torque_Nm: float = 0.0, omega_m_rad_s: float = 0.0) -> None:
        """Find out whether `send` would take these, without sending them.

        Raises:
            ValueRefused: a value is outside its limits.
        """
        self._wire.encode(torque_Nm, omega_m_rad_s)

    def send(self, *, torque_Nm: float = 0.0, omega_m_rad_s: float = 0.0) -> None:
        """Send both setpoints; the drive heeds the one of its mode.

        Raises:
            ValueRefused: a value is outside its limits; nothing was sent.
        """
        self._wire.send(torque_Nm, omega_m_rad_s)

    def close(self) -> None:
        """Have the drive take none any more, and put back what was set up.

        Raises:
            BenchError: the drive does not answer or refuses; the notes say how it is left.
        """
        self._wire.close()


class _Wire(Protocol):
    def encode(self, torque_Nm: float, omega_m_rad_s: float) -> bytes: ...
    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None: ...
    def close(self) -> None: ...


class _ProcessData:
    """RPDO1 over CAN."""

    def __init__(self, node: Node, link: FrameLink, torque: Variable | None, speed: Variable | None) -> None:
        self._node = node
        self._link = link
        self._torque, self._speed = torque, speed
        mapped = [each for each in (torque, speed) if each is not None]
        _require_mappable(*mapped)
        self._pdo = rpdo(link.node_id, [each.mapping for each in mapped])
        self._found = FoundPdo.of(node, self._pdo)
        try:
            for label, value in self._pdo.set_up():
                node.write(label, value)
        except BaseException as failure:
            try:
                self.close()
            except BenchError as also:
                failure.add_note(str(also))
            raise

    def encode(self, torque_Nm: float, omega_m_rad_s: float) -> bytes:
        return _encoded(self._torque, torque_Nm) + _encoded(self._speed, omega_m_rad_s)

    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        self._link.send_pdo(self._pdo.can_id, self.encode(torque_Nm, omega_m_rad_s))

    def close(self) -> None:
        self._found.put_back(self._node)


def _encoded(variable: Variable | None, value: float) -> bytes:
    return b"" if variable is None else variable.encode(value)


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


class _Messages:
    """The setpoint message of a serial line, which needs no setting up."""

    def __init__(self, link: BatchLink, torque: Variable | None, speed: Variable | None) -> None:
        self._link = link
        self._torque, self._speed = torque, speed

    def encode(self, torque_Nm: float, omega_m_rad_s: float) -> bytes:
        return _encoded(self._torque, torque_Nm) + _encoded(self._speed, omega_m_rad_s)

    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        # For its check of limits only: the message has SI units whatever the dictionary has.
        self.encode(torque_Nm, omega_m_rad_s)
        self._link.send_setpoint(torque_Nm, omega_m_rad_s)

    def close(self) -> None:
        """Nothing was set up."""
