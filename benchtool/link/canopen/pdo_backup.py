"""Backup of PDO parameters of a drive, restored after use."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

from benchtool.errors import BenchError, NoAnswer, SdoAbort
from benchtool.link.process_data import DriveAccess
from benchtool.protocol.canopen import INVALID, Pdo


@dataclass(frozen=True)
class PdoBackup:
    """Parameters of one PDO; `entries` are its mapping parameters from sub-index 1, the first `count` in
    use."""

    pdo: Pdo
    cob_id: int
    parameters: tuple[tuple[str, float], ...]
    count: int
    entries: tuple[int, ...]

    @classmethod
    def of(cls, drive: DriveAccess, pdo: Pdo) -> PdoBackup:
        """Read the parameters that `pdo.set_up` writes.

        Raises:
            ValueRefused: the drive has no such PDO.
            NoAnswer, SdoAbort: they cannot be read.
        """
        cob_id = int(drive.number(f"0x{pdo.communication:04X}:1"))
        labels = [f"0x{pdo.communication:04X}:2", *([f"0x{pdo.communication:04X}:5"] if pdo.transmit else [])]
        count = int(drive.number(f"0x{pdo.mapping:04X}:0"))
        subs = range(1, max(count, len(pdo.mappings)) + 1)
        entries = tuple(int(drive.number(f"0x{pdo.mapping:04X}:{sub}")) for sub in subs)
        return cls(pdo, cob_id, tuple((label, drive.number(label)) for label in labels), count, entries)

    def restore(self, drive: DriveAccess) -> None:
        """Restore the parameters; the PDO is enabled again only if it was, as the last write.

        Raises:
            BenchError: the drive refuses; the message states the resulting configuration.
        """
        try:
            for label, value in self._writes():
                drive.write(label, value)
            for sub, mapping in enumerate(self.entries[self.count :], start=self.count + 1):
                with suppress(SdoAbort):  # disabled first; not every drive accepts a zero
                    drive.write(f"0x{self.pdo.mapping:04X}:{sub}", mapping)
            drive.write(f"0x{self.pdo.mapping:04X}:0", self.count)
            drive.write(f"0x{self.pdo.communication:04X}:1", self.cob_id)
        except BenchError as failed:
            kind = "T" if self.pdo.transmit else "R"
            failed.add_note(
                f"{kind}PDO{self.pdo.number} is not as it was found: reset the drive's communication or "
                f"switch it off and on, which restores what it has stored"
            )
            raise

    def _writes(self) -> Iterator[tuple[str, float]]:
        yield f"0x{self.pdo.communication:04X}:1", INVALID | self.pdo.can_id
        yield f"0x{self.pdo.mapping:04X}:0", 0
        yield from self.parameters
        for sub, mapping in enumerate(self.entries[: self.count], start=1):
            yield f"0x{self.pdo.mapping:04X}:{sub}", mapping


def backup_if_used(drive: DriveAccess, pdo: Pdo) -> PdoBackup | None:
    """Return the backup of a PDO in use; None if it is not in use (one read), or cannot be read."""
    label = f"0x{pdo.communication:04X}:1"
    if label not in drive.dictionary or int(drive.number(label)) & INVALID:
        return None
    try:
        return PdoBackup.of(drive, pdo)
    except (NoAnswer, SdoAbort):
        return None
