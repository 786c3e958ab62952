"""Setpoints as process data: one frame for torque and speed, which feeds the drive's link supervision."""

from __future__ import annotations

from benchtool.errors import ValueRefused
from benchtool.protocol.nmt import NmtCommand
from benchtool.protocol.pdo import rpdo
from benchtool.telemetry.node import Node

TORQUE, SPEED = "torque_command", "omega_m_command"


class Setpoints:
    """Sets RPDO1 up for torque and speed; `send` then takes one frame and no answer.

    The drive takes them in the NMT state operational, within the limits of its dictionary.

    Raises:
        ValueRefused: the drive has no such setpoints.
        SdoAbort, NoAnswer, WriteNotVerified: it cannot be set up.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._torque, self._speed = node.dictionary[TORQUE], node.dictionary[SPEED]
        self._pdo = rpdo(node.link.node_id, [self._torque.mapping, self._speed.mapping])
        for label, value in self._pdo.set_up():
            node.write(label, value)
        node.link.nmt(NmtCommand.START)

    def send(self, *, torque_Nm: float = 0.0, omega_m_rad_s: float = 0.0) -> None:
        """Send both setpoints; the drive heeds the one of its mode.

        Raises:
            ValueRefused: a value is outside its limits; nothing was sent.
        """
        data = self._torque.encode(torque_Nm) + self._speed.encode(omega_m_rad_s)
        if len(data) != 8:
            raise ValueRefused(
                f"'{TORQUE}' and '{SPEED}' have {len(data)} bytes together, 8 are expected: use another EDS"
            )
        self._node.link.send_pdo(self._pdo.can_id, data)

    def close(self) -> None:
        """Take the PDO out of use."""
        self._node.write(*self._pdo.switch_off)
