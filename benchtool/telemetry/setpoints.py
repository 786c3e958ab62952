"""Setpoints as process data: one message for torque and speed, which feeds the drive's link supervision."""

from __future__ import annotations

from benchtool.protocol.canopen import NmtCommand
from benchtool.protocol.dictionary import Variable
from benchtool.telemetry.streamed_drive import StreamedDrive

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

    def __init__(
        self, node: StreamedDrive, torque: Variable | None = None, speed: Variable | None = None
    ) -> None:
        if torque is None and speed is None:
            torque, speed = node.dictionary[TORQUE], node.dictionary[SPEED]
        self._message = node.link.process_data.setpoints(node, torque, speed)
        node.link.nmt(NmtCommand.START)

    def check(self, *, torque_Nm: float = 0.0, omega_m_rad_s: float = 0.0) -> None:
        """Check that `send` would accept these, without sending them.

        Raises:
            ValueRefused: a value is outside its limits.
        """
        self._message.encode(torque_Nm, omega_m_rad_s)

    def send(self, *, torque_Nm: float = 0.0, omega_m_rad_s: float = 0.0) -> None:
        """Send both setpoints; the drive uses the one of its mode.

        Raises:
            ValueRefused: a value is outside its limits; nothing was sent.
        """
        self._message.send(torque_Nm, omega_m_rad_s)

    def close(self) -> None:
        """Stop the drive from taking setpoints, and restore what was set up.

        Raises:
            BenchError: the drive does not answer or refuses; the notes say how it is left.
        """
        self._message.close()
