"""Setpoints as process data: one message for torque and speed, which feeds the drive's link supervision."""

from __future__ import annotations

from typing import Protocol

from benchtool.errors import ValueRefused
from benchtool.link import BatchLink, FrameLink
from benchtool.protocol.nmt import NmtCommand
from benchtool.protocol.pdo import rpdo
from benchtool.protocol.variable import Variable
from benchtool.telemetry.node import Node

TORQUE, SPEED = "torque_command", "omega_m_command"


class Setpoints:
    """Sets the drive up for setpoints of torque and speed; `send` then takes one message and no answer.

    The drive takes them in the NMT state operational, within the limits of its dictionary.

    Raises:
        ValueRefused: the drive or the link has no such setpoints.
        SdoAbort, NoAnswer, WriteNotVerified: it cannot be set up.
    """

    def __init__(self, node: Node) -> None:
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

    def send(self, *, torque_Nm: float = 0.0, omega_m_rad_s: float = 0.0) -> None:
        """Send both setpoints; the drive heeds the one of its mode.

        Raises:
            ValueRefused: a value is outside its limits; nothing was sent.
        """
        self._wire.send(torque_Nm, omega_m_rad_s)

    def close(self) -> None:
        """Have the drive take none any more, where the wire provides for that."""
        self._wire.close()


class _Wire(Protocol):
    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None: ...
    def close(self) -> None: ...


class _ProcessData:
    """RPDO1 over CAN."""

    def __init__(self, node: Node, link: FrameLink, torque: Variable, speed: Variable) -> None:
        self._node = node
        self._link = link
        self._torque, self._speed = torque, speed
        self._pdo = rpdo(link.node_id, [torque.mapping, speed.mapping])
        for label, value in self._pdo.set_up():
            node.write(label, value)

    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        data = self._torque.encode(torque_Nm) + self._speed.encode(omega_m_rad_s)
        if len(data) != 8:
            raise ValueRefused(
                f"'{TORQUE}' and '{SPEED}' have {len(data)} bytes together, 8 are expected: use another EDS"
            )
        self._link.send_pdo(self._pdo.can_id, data)

    def close(self) -> None:
        self._node.write(*self._pdo.switch_off)


class _Messages:
    """The setpoint message of a serial line, which needs no setting up."""

    def __init__(self, link: BatchLink, torque: Variable, speed: Variable) -> None:
        self._link = link
        self._torque, self._speed = torque, speed

    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        # Encoded for its check of limits only: the message has SI units whatever the dictionary has.
        self._torque.encode(torque_Nm)
        self._speed.encode(omega_m_rad_s)
        self._link.send_setpoint(torque_Nm, omega_m_rad_s)

    def close(self) -> None:
        """Nothing was set up."""
