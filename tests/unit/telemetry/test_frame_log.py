"""The file of frames while it grows: when it is flushed, and what of it is acknowledged."""

from __future__ import annotations

import hashlib
from pathlib import Path

import can

from benchtool.recording.checkpoints import read_checkpoints
from benchtool.telemetry.frames import FrameLog

NAME = "data/frames.log"


def _frame(timestamp: float) -> can.Message:
    return can.Message(timestamp=timestamp, arbitration_id=0x181, data=b"\x01\x02", is_extended_id=False)


def test_the_file_is_flushed_and_acknowledged_five_times_a_second(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    log = FrameLog()
    log.append(_frame(0.0))
    log.start(tmp_path)
    for timestamp in (0.125, 0.2, 0.325, 0.39, 0.5, 0.6):
        log.append(_frame(timestamp))
    log.close()
    lines = (tmp_path / NAME).read_bytes().splitlines(keepends=True)
    assert [float(line.split(b")")[0][1:]) for line in lines] == [0.0, 0.125, 0.2, 0.325, 0.39, 0.5, 0.6]
    begun = [b"".join(lines[:count]) for count in (3, 6)]  # up to the frames of 0.2 s and 0.5 s
    states = read_checkpoints(tmp_path)[NAME]
    assert [(each.size_B, each.sha256) for each in states] == [
        (len(part), hashlib.sha256(part).hexdigest()) for part in begun
    ]


def test_frames_after_the_end_are_not_kept(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    log = FrameLog()
    log.start(tmp_path)
    log.append(_frame(1.0))
    log.close()
    log.append(_frame(2.0))
    log.close()
    assert len((tmp_path / NAME).read_bytes().splitlines()) == 1
