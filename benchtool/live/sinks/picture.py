"""A recording as a picture: Rerun's viewer without a window draws it and is asked for what it shows."""

from __future__ import annotations

import re
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Final

from rerun.experimental import ViewerClient

from benchtool.errors import EnvironmentFailure
from benchtool.live.sinks.viewer import LOOPBACK, viewer_environment, viewer_program

PICTURE_SIZE: Final = "1600x1000"
"""Width and height in pixels."""

_LISTENING = re.compile(r"Listening for gRPC connections on \S+:(\d+)")
_STARTING_S = 20.0
_LOADING_S = 60.0
_POLL_S = 0.1
_SAME = 10  # pictures in a row
_REMEDY = (
    "drawing without a display needs Vulkan, with a graphics card or in software (Debian: apt-get install "
    "mesa-vulkan-drivers); or open the recording elsewhere with 'rerun FILE.rrd'"
)


def take_picture(recording: Path, size: str = PICTURE_SIZE) -> bytes:
    """Return what the viewer shows of a recording (.rrd), as a PNG.

    Raises:
        EnvironmentFailure: there is no viewer, or it cannot draw here.
    """
    with headless_viewer(recording, size) as viewer:
        try:
            picture: bytes = viewer.take_screenshot()
        except (RuntimeError, OSError) as reason:
            raise _undrawn(str(reason)) from None
    return picture


@contextmanager
def headless_viewer(recording: Path, size: str = PICTURE_SIZE) -> Iterator[ViewerClient]:
    """A viewer without a window that has loaded a recording and drawn it; ended on the way out.

    Raises:
        EnvironmentFailure: there is no viewer, or it cannot draw here.
    """
    program = viewer_program()
    with (
        tempfile.TemporaryFile("a+b") as log,
        subprocess.Popen(
            [program, "--bind", LOOPBACK, "--port", "auto", "--headless", "--window-size", size, recording],
            env=viewer_environment(),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
        ) as process,
    ):
        try:
            yield _loaded(process, log)
        finally:
            process.terminate()


def _loaded(process: subprocess.Popen[bytes], log: IO[bytes]) -> ViewerClient:
    """Return the viewer, once nothing is loading and the picture stays the same."""

    def said() -> str:
        log.seek(0)
        return log.read().decode(errors="replace")

    def within(deadline_s: float) -> None:
        if process.poll() is not None or time.monotonic() > deadline_s:
            raise _undrawn(_last_line(said()) or "the viewer does not answer")
        try:
            process.wait(_POLL_S)
        except subprocess.TimeoutExpired:
            return

    deadline_s = time.monotonic() + _STARTING_S
    while (found := _LISTENING.search(said())) is None:
        within(deadline_s)
    deadline_s = time.monotonic() + _LOADING_S
    pictures: list[bytes] = []
    try:
        client = ViewerClient.connect(f"rerun+http://{LOOPBACK}:{found[1]}/proxy")
        while len(pictures) < _SAME or len(set(pictures[-_SAME:])) > 1:
            within(deadline_s)
            state = client.get_state()
            if state.recordings and state.views and not state.loading:
                pictures.append(client.take_screenshot())
    except (RuntimeError, OSError) as reason:
        raise _undrawn(str(reason)) from None
    return client


def _last_line(log: str) -> str:
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    telling = [line for line in lines if re.search(r"error|fail|panic|adapter", line, re.IGNORECASE)]
    return (telling or lines or [""])[-1][:200]


def _undrawn(reason: str) -> EnvironmentFailure:
    return EnvironmentFailure(f"the view cannot be drawn: {reason.splitlines()[0]}; {_REMEDY}")
