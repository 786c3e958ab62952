"""The stream over CAN: records in TPDOs, at a whole number of milliseconds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress

from benchtool.errors import BenchError
from benchtool.link.canopen.pdo_backup import PdoBackup, backup_if_used
from benchtool.link.interface import Frame, FrameLink
from benchtool.link.process_data import DriveAccess, Sent, control_period_s
from benchtool.protocol import RecordDecoder, stream_layout
from benchtool.protocol.canopen import INVALID, TPDO, TPDO_COMMUNICATION, NmtCommand, most_tpdos, tpdo
from benchtool.ticks import ticks_since


class PdoSource:
    """A `Source` of frames.

    Args:
        drive: connected.
        link: its link.
        channels: signals of four bytes, 13 at most.
        rate_Hz: records per second; a whole number of milliseconds apart.
        after: the source that this one goes on for, after the link was lost.

    TPDOs that were in use are restored; others stay disabled with this mapping.

    Raises:
        ValueRefused: the drive cannot stream this.
    """

    def __init__(
        self,
        drive: DriveAccess,
        link: FrameLink,
        channels: Sequence[str],
        rate_Hz: float,
        after: PdoSource | None = None,
    ) -> None:
        self._drive = drive
        self._link = link
        self.tick_s = control_period_s(drive)
        self._layout = stream_layout(drive.dictionary, link.node_id, channels, rate_Hz, self.tick_s)
        self.decoder = RecordDecoder(self._layout, drive.tick_now())
        self._sequence_before = 0
        self._found: tuple[PdoBackup, ...] | None = None if after is None else after._found

    @property
    def stride(self) -> int:
        return self._layout.stride

    def start(self, receive: Callable[[Frame], None]) -> None:
        """See `Source.start`."""
        drive = self._drive
        mapped = {pdo.number: pdo for pdo in self._layout.pdos}
        numbers = range(1, most_tpdos(self._link.node_id) + 1)
        all_pdos = [mapped.get(number) or tpdo(self._link.node_id, (), number) for number in numbers]
        if self._found is None:
            found = (backup_if_used(drive, pdo) for pdo in all_pdos)
            self._found = tuple(each for each in found if each is not None)
        try:
            self._set_up(receive)
        except BaseException:
            with suppress(BenchError):  # the failure that is under way is the one to report
                self._restore()
            raise

    def _set_up(self, receive: Callable[[Frame], None]) -> None:
        drive = self._drive
        for number in range(1, len(TPDO) + 1):
            self._switch_off(number)
        self._sequence_before = int(drive.number("stream_sequence"))
        self._link.subscribe((pdo.can_id for pdo in self._layout.pdos), receive)
        # The first PDO last: a record begins with it, so that none begins before all are in use.
        for pdo in reversed(self._layout.pdos):
            for label, value in pdo.set_up(self._layout.timer_ms * 1e-3):
                drive.write(label, value)
        self._link.nmt(NmtCommand.START)

    def stop(self) -> Sent:
        """See `Source.stop`."""
        for pdo in self._layout.pdos:
            self._drive.write(*pdo.switch_off)
        sent = Sent(ticks_since(int(self._drive.number("stream_sequence")), self._sequence_before))
        self._restore()
        return sent

    def detach(self) -> None:
        """See `Source.detach`."""
        self._link.unsubscribe(pdo.can_id for pdo in self._layout.pdos)

    def feed(self, item: Frame) -> bool:
        """See `Source.feed`."""
        return self.decoder.feed(*item)

    def _restore(self) -> None:
        for each in self._found or ():
            each.restore(self._drive)

    def _switch_off(self, number: int) -> None:
        label = f"0x{TPDO_COMMUNICATION + number - 1:04X}:1"
        if label in self._drive.dictionary:
            cob_id = int(self._drive.number(label))
            if not cob_id & INVALID:
                self._drive.write(label, cob_id | INVALID)
