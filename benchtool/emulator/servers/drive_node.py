"""The emulated drive as several wires share it: one firmware, one time, one NMT state (CiA 301, 7.3.2)."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Protocol

from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.firmware.objects import Refused
from benchtool.emulator.servers.disturbance import Disturbances
from benchtool.emulator.servers.parties import Party
from benchtool.emulator.servers.pdo import ProcessData
from benchtool.emulator.servers.receiver import Receiver
from benchtool.emulator.servers.schedule import Schedule
from benchtool.errors import LinkClosed
from benchtool.protocol.canopen import Emergency, NmtCommand, NmtState
from benchtool.ticks import wrap_tick

OnGone = Callable[[OSError], None]

NEVER = 1 << 62


class Server(Protocol):
    """One wire of a drive.

    The node calls all but `receiver` with its lock held. A lost wire must not raise: its receiver reports it.
    """

    receiver: Receiver

    def boot(self) -> None:
        """The drive was powered up or its communication reset: announce it and discard the host's
        settings."""

    def confirm(self, state: NmtState) -> None:
        """The host has commanded a state."""

    def heartbeat(self, state: NmtState) -> None:
        """Send a heartbeat: its period is over."""

    def emergency(self, emergency: Emergency) -> None:
        """Report an error."""

    def process_data(self, can_id: int, data: bytes) -> None:
        """Send a PDO."""

    def next_tick(self, tick: int) -> int:
        """Return the first tick after `tick` in which there is something else to be sent, or `NEVER`."""

    def transmit(self, tick: int) -> None:
        """Send that, and handle what arrives late."""

    def release(self) -> None:
        """Give back what it holds of the drive: its wire is gone."""


class DriveNode:
    """A drive in its time, and the wires to it.

    Args:
        node_id: 1 to 127.
        firmware: makes the firmware, given where its emergencies go.
        seed: of disturbances.

    Attributes:
        lock: guards the drive; a server holds it while it handles a received frame.
        nmt_state: of all wires.
        stream_taken: whether a server has configured the stream at the control rate, of which there is one.
        disturbances: of all its wires.
        parties: other nodes on its CAN bus.
        schedule: actions at its ticks, which are called with the lock held.
    """

    def __init__(
        self, node_id: int, firmware: Callable[[Callable[[Emergency], None]], Firmware], seed: int = 0
    ) -> None:
        self.node_id = node_id
        self.lock = threading.Lock()
        self.nmt_state = NmtState.BOOT_UP
        self.stream_taken = False
        self.disturbances = Disturbances(seed)
        self.parties: list[Party] = []
        self.schedule = Schedule()
        self._servers: list[tuple[Server, OnGone]] = []
        self.firmware = firmware(self._report)
        self._pdos = ProcessData(
            self.firmware.objects, node_id, self.firmware.period_s, self._send_process_data, self.feed_link
        )
        self._boot()

    @property
    def tick(self) -> int:
        """The drive's tick, counted on past 2**32."""
        return self.firmware.core.tick

    @property
    def on_can(self) -> bool:
        """Whether one of its wires is a CAN bus."""
        return any(getattr(server, "is_can", False) for server, _ in self._servers)

    @property
    def now_s(self) -> float:
        """Drive time."""
        return self.firmware.now_s

    def tick_at(self, at_s: float) -> int:
        """Return the first tick at a drive time or after it, later than now; `NEVER` of infinity."""
        if at_s == float("inf"):
            return NEVER
        return max(
            self.tick + 1, self.firmware.core.first_tick + math.ceil(at_s / self.firmware.period_s - 1e-6)
        )

    def is_under_way(self) -> bool:
        """Return whether frames are late on one of its wires."""
        return any(getattr(server, "is_under_way", bool)() for server, _ in self._servers)

    def add(self, server: Server, on_gone: OnGone = lambda _: None) -> None:
        """Put a wire to the drive into service.

        Args:
            server: owned from now on.
            on_gone: called with the reason, in the thread that advances time, if the wire is lost. The drive
            runs on.
        """
        with self.lock:
            self._servers.append((server, on_gone))
            if self.firmware.now_s > 0.0:
                server.heartbeat(self.nmt_state)
            else:
                server.boot()
        server.receiver.start()

    def advance_to(self, now_s: float) -> None:
        """Run the drive up to `now_s` of the clock it follows, sending what falls due on the way.

        Raises:
            LinkClosed: a receive thread has failed.
        """
        self._raise_failure()
        self._let_go()
        with self.lock:
            end = self.firmware.core.first_tick + int(now_s / self.firmware.period_s + 1e-6)
            self.schedule.run(self.tick)
            while (tick := self.tick) < end:
                every = self._heartbeat_ticks()
                beat = (tick // every + 1) * every if every else end
                operational = self.nmt_state is NmtState.OPERATIONAL
                due = [server.next_tick(tick) for server, _ in self._servers]
                due.append(self.schedule.next_tick)
                stop = min(end, beat, self._pdos.next_tick(tick) if operational else end, *due)
                self.firmware.advance_to(stop)
                self.schedule.run(stop)
                if self.firmware.hung:
                    continue
                if operational and self.nmt_state is NmtState.OPERATIONAL:
                    self._pdos.transmit(stop)
                for server, _ in self._servers:
                    server.transmit(stop)
                    if every and beat == stop:
                        server.heartbeat(self.nmt_state)

    def close(self) -> None:
        """Power off: the threads end, the wires are given back.

        Raises:
            LinkClosed: a receive thread had failed.
        """
        for server, _ in self._servers:
            server.receiver.stop()
        self._raise_failure()

    # ---- what a server's receive thread calls, with the lock held ------------------------------------------

    def command(self, command: int) -> None:
        """Take a command of network management; an unknown number is ignored."""
        match command:
            case NmtCommand.START:
                self.nmt_state = NmtState.OPERATIONAL
            case NmtCommand.STOP:
                self.nmt_state = NmtState.STOPPED
                self.firmware.stop()
            case NmtCommand.ENTER_PRE_OPERATIONAL:
                self.nmt_state = NmtState.PRE_OPERATIONAL
            case NmtCommand.RESET_NODE:
                self.restart()
                return
            case NmtCommand.RESET_COMMUNICATION:
                self._boot()
                return
            case _:
                return
        for server, _ in self._servers:
            server.confirm(self.nmt_state)

    def restart(self) -> None:
        """Start afresh, as after NMT reset node or a dip of the supply."""
        self.firmware.reset()
        self._boot()

    def on_host_heartbeat(self, node: int) -> None:
        """A heartbeat was heard; that of the host feeds the link supervision."""
        if node == self.firmware.supervision.host_node_id:
            self.feed_link()

    def on_process_data(self, can_id: int, data: bytes) -> None:
        """Take an RPDO, whichever it is."""
        if self.nmt_state is NmtState.OPERATIONAL:
            self._pdos.receive(can_id, data)

    def on_setpoint(self, torque_command: bytes, omega_m_command: bytes) -> bool:
        """Take both setpoints as their objects have them, or neither; only then they feed the supervision."""
        objects = self.firmware.objects
        entries = objects.table.by_name["torque_command"], objects.table.by_name["omega_m_command"]
        try:
            objects.write_all(list(zip(entries, (torque_command, omega_m_command), strict=True)))
        except Refused:
            return False
        self.feed_link()
        return True

    def count(self, name: str, more: int = 1) -> None:
        """Add to a counter of the dictionary."""
        objects = self.firmware.objects
        objects[name] = wrap_tick(int(objects[name]) + more)

    def feed_link(self) -> None:
        self.firmware.feed_link()

    # ---- notifications to all servers -------------------------------------------------------------------

    def _boot(self) -> None:
        self._pdos.reset()
        for server, _ in self._servers:
            server.boot()
        self.nmt_state = NmtState.PRE_OPERATIONAL

    def _report(self, emergency: Emergency) -> None:
        if self.nmt_state is not NmtState.STOPPED:
            for server, _ in self._servers:
                server.emergency(emergency)

    def _send_process_data(self, can_id: int, data: bytes) -> None:
        for server, _ in self._servers:
            server.process_data(can_id, data)

    def _heartbeat_ticks(self) -> int:
        return round(float(self.firmware.objects["producer_heartbeat"]) * 1e-3 / self.firmware.period_s)

    # ---- wires that end ------------------------------------------------------------------------------------

    def _let_go(self) -> None:
        """Remove the servers whose wires are gone, and call `on_gone`."""
        with self.lock:
            gone = [each for each in self._servers if each[0].receiver.gone is not None]
            self._servers = [each for each in self._servers if each not in gone]
            for server, _ in gone:
                server.release()
        for server, on_gone in gone:
            server.receiver.stop()
            assert server.receiver.gone is not None
            on_gone(server.receiver.gone)

    def _raise_failure(self) -> None:
        for server, _ in self._servers:
            if (failure := server.receiver.failure) is not None:
                raise LinkClosed(
                    f"the emulated drive stopped receiving: {failure!r}; this is a defect of benchtool"
                ) from failure
