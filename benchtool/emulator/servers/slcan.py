"""A serial CAN adapter (slcan, LAWICEL) between an emulated drive and the client of a byte port."""

from __future__ import annotations

import threading
from collections import deque

import can

from benchtool.emulator.ports.client import HungUp, Traffic
from benchtool.emulator.servers.acceptance import ACCEPT_ALL, accepts
from benchtool.link import Port
from benchtool.protocol import (
    BITRATES_BIT_S,
    OK,
    REFUSED,
    Cause,
    Lines,
    SlcanCommand,
    SlcanFrame,
    TIME_MODULUS_ms,
    format_frame,
    parse_command,
)

VERSION = "1010"  # hardware 1.0, software 1.0
_LINES_AT_ONCE = 64
_ANSWERS = 64
_WRITING_S = 0.5

# Status flags of the command F.
_RECEIVE_FIFO_FULL = 0x01
_DATA_OVERRUN = 0x08


class SlcanAdapter(can.BusABC):
    """The drive's end of an adapter: `recv` has the host's frames, `send` gives the host the drive's.

    It behaves as the LAWICEL CANUSB manual says: a bit rate before the channel can be opened, settings only
    while it is closed, CR or BELL for each command, `z` and `Z` for each frame. The manual's commands that it
    has not are refused: P, A and X (polling), U, Q and W. A line of nothing is refused as well.

    Commands are handled in the thread that receives; a thread of its own writes. `send` never waits: frames
    that the host does not fetch in time are dropped, counted, and shown in the status flags as an overrun of
    the receive FIFO. The transmit FIFO cannot overrun, because the line holds the host back.

    A client that hangs up (`HungUp` from the port) takes the adapter's power with it: the channel closes and
    settings are as after power-up, so that the next client finds neither an open channel nor old frames. Any
    other failure of the port ends the adapter: `recv` raises, `send` drops and counts.

    Args:
        port: owned from now on.
        acknowledge: answer commands; False is an adapter that sends frames and nothing else.
        bitrate: in bit/s, set after power-up without a command; None waits for one, as the manual says.
        waiting: how many frames for the host may wait.
        serial_number: four characters, answer of N.
        name: of the adapter, in messages.
    """

    def __init__(
        self,
        port: Port,
        *,
        acknowledge: bool = True,
        bitrate: int | None = None,
        waiting: int = 1024,
        serial_number: str = "BT01",
        name: str = "slcan adapter",
    ) -> None:
        self.channel_info = name
        self.received = 0  # frames of the host
        self.sent = 0  # frames of the drive that the host fetched or will fetch
        self.dropped = 0  # frames of the drive that the host did not fetch
        self.malformed: dict[Cause, int] = {}
        self._port = port
        self._acknowledge = acknowledge
        self._default_bitrate = bitrate
        self._most = waiting
        self._serial_number = serial_number
        self._lines = Lines()
        self._received: deque[can.Message] = deque()
        self._outgoing: deque[bytes] = deque()
        self._changed = threading.Condition()
        self._failure: OSError | None = None
        self._stopping = self._writing = False
        self._is_open = self._listen_only = self._stamps = self._is_set_up = False
        self._bitrate: int | None = None
        self._acceptance = ACCEPT_ALL
        self._flags = 0
        self._power_up()
        super().__init__(name)
        self._writer = threading.Thread(target=self._write, name="slcan-adapter", daemon=True)
        self._writer.start()

    @property
    def is_open(self) -> bool:
        """Whether frames pass."""
        return self._is_open

    @property
    def bitrate(self) -> int | None:
        """In bit/s; None if it was not set, or by registers."""
        return self._bitrate

    @property
    def traffic(self) -> Traffic:
        """Frames to and from the host."""
        return Traffic(self.received, self.sent, self.dropped + sum(self.malformed.values()))

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Give the host a frame; while the channel is closed it is dropped, as on a bus without listeners.

        Raises:
            can.CanOperationError: no line can say this frame.
        """
        if msg.is_fd or msg.is_error_frame:
            raise can.CanOperationError("slcan has no FD and no error frames; send classical CAN frames")
        remote = msg.is_remote_frame
        time_ms = int(msg.timestamp * 1e3 + 1e-6) % TIME_MODULUS_ms if self._stamps else None
        frame = SlcanFrame(msg.arbitration_id, bytes(msg.data), msg.dlc, msg.is_extended_id, remote, time_ms)
        try:
            line = format_frame(frame)
        except ValueError as reason:
            raise can.CanOperationError(str(reason)) from reason
        with self._changed:
            if not self._is_open or not accepts(*self._acceptance, frame):
                return
            if self._failure is not None or len(self._outgoing) >= self._most:
                self.dropped += 1
                self._flags |= _RECEIVE_FIFO_FULL | _DATA_OVERRUN
                return
            self.sent += 1
            self._outgoing.append(line)
            self._changed.notify()

    def shutdown(self) -> None:
        """Power off, and give the port back; a second call does nothing."""
        if self._is_shutdown:
            return
        super().shutdown()
        with self._changed:
            self._stopping = True
            self._changed.notify()
        self._port.close()
        self._writer.join()

    # ---- from the host -----------------------------------------------------------------------------------

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._received:
            self._fill()
        return (self._received.popleft() if self._received else None), False

    def _fill(self) -> None:
        if self._failure is not None:
            raise can.CanOperationError(f"{self.channel_info} has lost its port: {self._failure}")
        try:
            data = self._port.read()
        except HungUp:
            with self._changed:  # what is being written is for the client who has gone
                self._outgoing.clear()
                self._changed.wait_for(lambda: not self._writing, _WRITING_S)
            self._power_up()
            return
        except OSError as reason:
            self._fail(reason)
            raise can.CanOperationError(f"{self.channel_info} has lost its port: {reason}") from reason
        too_long = self._lines.too_long
        for line in self._lines.split(data.replace(b"\n", b"")):  # some hosts add LF to CR
            self._answer(self._handle(parse_command(line), is_empty=not line))
        for _ in range(self._lines.too_long - too_long):
            self._answer(self._refuse(Cause.TOO_LONG))

    def _handle(self, asked: SlcanCommand | SlcanFrame | Cause, *, is_empty: bool) -> bytes:
        """Return what is answered."""
        if isinstance(asked, SlcanFrame):
            return self._transmit(asked)
        if isinstance(asked, SlcanCommand):
            return self._obey(asked)
        return REFUSED if is_empty else self._refuse(asked)

    def _refuse(self, cause: Cause) -> bytes:
        self.malformed[cause] = self.malformed.get(cause, 0) + 1
        return REFUSED

    def _transmit(self, frame: SlcanFrame) -> bytes:
        if not self._is_open or self._listen_only:
            return REFUSED
        self.received += 1
        self._received.append(
            can.Message(
                arbitration_id=frame.can_id,
                is_extended_id=frame.extended,
                is_remote_frame=frame.remote,
                channel=self.channel_info,
                dlc=frame.dlc,
                data=frame.data,
            )
        )
        return b"Z\r" if frame.extended else b"z\r"

    def _obey(self, command: SlcanCommand) -> bytes:
        letter, argument = command
        match letter:
            case "V":
                return f"V{VERSION}\r".encode()
            case "N":
                return f"N{self._serial_number}\r".encode()
        with self._changed:
            if self._is_open:
                return self._obey_open(letter)
            return self._obey_closed(letter, argument)

    def _obey_open(self, letter: str) -> bytes:
        match letter:
            case "C":
                self._is_open = False
                return OK
            case "F":
                flags, self._flags = self._flags, 0
                return f"F{flags:02X}\r".encode()
        return REFUSED

    def _obey_closed(self, letter: str, argument: str) -> bytes:
        match letter:
            case "S":
                self._bitrate, self._is_set_up = BITRATES_BIT_S[int(argument)], True
            case "s":
                self._bitrate, self._is_set_up = None, True
            case "Z":
                self._stamps = argument == "1"
            case "M" if self._is_set_up:
                self._acceptance = int(argument, 16), self._acceptance[1]
            case "m" if self._is_set_up:
                self._acceptance = self._acceptance[0], int(argument, 16)
            case "O" | "L" if self._is_set_up:
                self._is_open, self._listen_only = True, letter == "L"
                self._flags = 0
            case _:
                return REFUSED
        return OK

    def _power_up(self) -> None:
        with self._changed:
            self._is_open = self._listen_only = self._stamps = False
            self._bitrate = self._default_bitrate
            self._is_set_up = self._bitrate is not None
            self._acceptance = ACCEPT_ALL
            self._flags = 0
            self._outgoing.clear()
        self._received.clear()
        self._lines.clear()

    # ---- to the host -------------------------------------------------------------------------------------

    def _answer(self, line: bytes) -> None:
        if not self._acknowledge:
            return
        with self._changed:
            # Answers have room of their own: a host that only asks and never reads loses them, too.
            if len(self._outgoing) < self._most + _ANSWERS:
                self._outgoing.append(line)
                self._changed.notify()

    def _write(self) -> None:
        while True:
            with self._changed:
                while not self._outgoing and not self._stopping:
                    self._changed.wait()
                if self._stopping:
                    return
                count = min(len(self._outgoing), _LINES_AT_ONCE)
                lines = b"".join(self._outgoing.popleft() for _ in range(count))
                self._writing = True
            try:
                self._port.write(lines)
            except HungUp:
                pass  # lost with the client; the receiving thread learns of it as well
            except OSError as reason:
                self._fail(reason)
                return
            finally:
                with self._changed:
                    self._writing = False
                    self._changed.notify_all()

    def _fail(self, reason: OSError) -> None:
        with self._changed:
            if self._failure is None and not self._stopping:
                self._failure = reason
