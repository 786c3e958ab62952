"""A serial CAN adapter (slcan, LAWICEL) as a python-can bus that reads in bulk and tolerates noise."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress

import can

from benchtool.link.port import Port, open_port
from benchtool.protocol import BITRATES_BIT_S, AdapterLines, Answer, Cause, SlcanFrame, format_frame

DEFAULT_BAUDRATE = 115_200
_ANSWER_S = 0.5
_FIRST_ANSWER_S = 0.25
_BABBLE_S = 0.5
_READY_S = 3.0


class SlcanBus(can.BusABC):
    """An adapter behind a byte port, its channel open; `shutdown` closes both.

    Opening closes the channel first, whatever state an earlier user left it in. An adapter that answers has
    its channel open on return; one that does not opens it a moment later, and nothing says when. `recv` reads
    what the port holds, so that even `recv(0)` may last the 50 ms that a port waits. One thread receives; any
    may send.

    Args:
        port: owned from now on, also if opening fails.
        bitrate: of the CAN bus in bit/s, one of `BITRATES_BIT_S`; None leaves the adapter as it is set.
        listen_only: take no part on the bus, not even by acknowledging.
        acknowledged: the adapter answers commands. True requires it, for up to three seconds in which an
            adapter may still be starting; False expects nothing; None goes by whether it answers the first.
        identify: ask for version and serial number before the channel is opened.
        now_s: stamps frames with the moment at which they were read; the time of day, as python-can does.
        name: of the channel, in messages.

    Raises: can.CanInitializationError: an invalid bit rate, or an adapter that refuses, is gone, or does not
        answer although `acknowledged` is True.
    """

    def __init__(
        self,
        port: Port,
        bitrate: int | None = None,
        *,
        listen_only: bool = False,
        acknowledged: bool | None = None,
        identify: bool = False,
        now_s: Callable[[], float] = time.time,
        name: str = "slcan",
    ) -> None:
        self.channel_info = name
        self.version: str | None = None
        self.serial_number: str | None = None
        self.frames = 0
        self.refused = 0  # commands, after opening: frames that the adapter did not take
        self._port = port
        self._now_s = now_s
        self._listen_only = listen_only
        self._lines = AdapterLines()
        self._waiting: deque[can.Message] = deque()
        self._answers: deque[Answer] = deque()
        self._writing = threading.Lock()
        self._broken_off = False
        try:
            self._open(bitrate, acknowledged, identify)
        except OSError as reason:
            port.close()
            raise can.CanInitializationError(f"the adapter is gone: {reason}; check its cable") from reason
        except BaseException:
            port.close()
            raise
        super().__init__(name)

    @property
    def malformed(self) -> int:
        """Lines dropped since the channel was opened."""
        return sum(self._lines.malformed.values())

    @property
    def malformed_by_cause(self) -> dict[Cause, int]:
        """Those lines by cause."""
        return self._lines.malformed

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame; that the adapter refused it shows in `refused`, a moment later.

        Raises: can.CanOperationError: the adapter is gone or blocked, or slcan cannot represent this frame.
        """
        if self._listen_only:
            raise can.CanOperationError("the channel only listens; open it without listen_only to send")
        if msg.is_fd or msg.is_error_frame:
            raise can.CanOperationError("slcan has no FD and no error frames; send classical CAN frames")
        remote = msg.is_remote_frame
        frame = SlcanFrame(msg.arbitration_id, bytes(msg.data), msg.dlc, msg.is_extended_id, remote)
        try:
            self._write(format_frame(frame))
        except OSError as reason:
            raise can.CanOperationError(f"the adapter takes nothing: {reason}; check its cable") from reason
        except ValueError as reason:
            raise can.CanOperationError(str(reason)) from reason

    def shutdown(self) -> None:
        """Close channel and port; a second call does nothing."""
        if self._is_shutdown:
            return
        super().shutdown()
        with suppress(OSError):
            self._write(b"C\r")
        self._port.close()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._waiting:
            try:
                self._fill()
            except OSError as reason:
                raise can.CanOperationError(f"the adapter is gone: {reason}; check its cable") from reason
            self.refused += sum(answer.kind == "refused" for answer in self._answers)
            self._answers.clear()
        return (self._waiting.popleft() if self._waiting else None), False

    def _fill(self) -> bool:
        """Read received data; return whether there were any."""
        data = self._port.read()
        if not data:
            return False
        now_s = self._now_s()
        frames, answers = self._lines.feed(data)
        self.frames += len(frames)
        self._answers.extend(answers)
        self._waiting.extend(
            can.Message(
                timestamp=now_s,
                arbitration_id=frame.can_id,
                is_extended_id=frame.extended,
                is_remote_frame=frame.remote,
                channel=self.channel_info,
                dlc=frame.dlc,
                data=frame.data,
            )
            for frame in frames
        )
        return True

    def _write(self, line: bytes) -> None:
        with self._writing:
            # The rest of an interrupted line must not become part of this one.
            whole = b"\r" + line if self._broken_off else line
            self._broken_off = True
            self._port.write(whole)
            self._broken_off = False

    # ---- opening -----------------------------------------------------------------------------------------

    def _open(self, bitrate: int | None, acknowledged: bool | None, identify: bool) -> None:
        if bitrate is not None and bitrate not in BITRATES_BIT_S:
            known = ", ".join(map(str, BITRATES_BIT_S))
            raise can.CanInitializationError(
                f"a bit rate of {bitrate} bit/s is none that slcan has: choose one of {known}"
            )
        patience_s = 0.0 if acknowledged is False else _FIRST_ANSWER_S
        answers = self._close_channel(patience_s)
        deadline_s = time.monotonic() + _READY_S
        while acknowledged and not answers:
            if time.monotonic() > deadline_s:
                raise can.CanInitializationError(
                    f"the adapter answered no command within {_READY_S:g} s; "
                    f"check that it is an slcan adapter, and its baud rate"
                )
            answers = self._close_channel(patience_s)
        if identify:
            self.version = self._query("V", "version")
            self.serial_number = self._query("N", "serial_number")
        expected = answers if acknowledged is None else acknowledged
        if bitrate is not None:
            code = BITRATES_BIT_S.index(bitrate)
            self._command(
                f"S{code}", expected, f"the adapter refused {bitrate} bit/s: choose another bit rate"
            )
        self._command(
            "L" if self._listen_only else "O",
            expected,
            "the adapter refused to open its channel: name the bit rate, or plug it in again",
        )

    def _close_channel(self, patience_s: float) -> bool:
        """Close the channel and drop pending input; return whether the adapter answers commands."""
        # The first CRs end what an earlier user may have left unfinished, as the manual advises.
        self._write(b"\r\r\rC\r")
        start_s = time.monotonic()
        answers = False
        while True:
            quiet = not self._fill()
            answers = answers or any(answer.kind in ("ok", "refused") for answer in self._answers)
            spent_s = time.monotonic() - start_s
            if spent_s > _BABBLE_S or (quiet and (answers or spent_s > patience_s)):
                break
        self._waiting.clear()
        self._answers.clear()
        self._lines = AdapterLines()
        self.frames = 0
        return answers

    def _command(self, command: str, expected: bool, refusal: str) -> None:
        self._write(f"{command}\r".encode())
        answer = self._wait_for(("ok", "refused")) if expected else None
        if answer is not None and answer.kind == "refused":
            raise can.CanInitializationError(refusal)
        if expected and answer is None:
            raise can.CanInitializationError(
                f"the adapter did not answer the command {command} within {_ANSWER_S:g} s; plug it in again"
            )

    def _query(self, command: str, kind: str) -> str | None:
        self._write(f"{command}\r".encode())
        answer = self._wait_for((kind, "refused"))
        return None if answer is None or answer.kind == "refused" else answer.text

    def _wait_for(self, kinds: tuple[str, ...]) -> Answer | None:
        """Return the first answer of one of these kinds; those of other kinds are dropped."""
        deadline_s = time.monotonic() + _ANSWER_S
        while True:
            while self._answers:
                answer = self._answers.popleft()
                if answer.kind in kinds:
                    return answer
            if time.monotonic() > deadline_s:
                return None
            self._fill()


def open_slcan(
    channel: str,
    bitrate: int | None = None,
    *,
    baudrate: int = DEFAULT_BAUDRATE,
    listen_only: bool = False,
    acknowledged: bool | None = None,
    now_s: Callable[[], float] = time.time,
) -> SlcanBus:
    """Return the adapter at a port.

    Args:
        channel: a port as `open_port` takes it, `/dev/ttyACM0` or `socket://HOST:PORT`; with `@921600` after
            it, in place of `baudrate`, as python-can has it.
        baudrate: of the serial line in bit/s; adapters on USB ignore it.

    Raises:
        LinkError: the port cannot be opened.
        can.CanInitializationError: as `SlcanBus`.
    """
    url, at, tail = channel.rpartition("@")
    if at and tail.isdecimal():
        channel, baudrate = url, int(tail)
    return SlcanBus(
        open_port(channel, baudrate),
        bitrate,
        listen_only=listen_only,
        acknowledged=acknowledged,
        now_s=now_s,
        name=channel,
    )
