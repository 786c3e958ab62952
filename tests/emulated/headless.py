"""Rerun's viewer without a window, which is asked for pictures and for what went wrong in its panels."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rerun.experimental import ViewerClient

from benchtool.live.sinks.viewer import viewer_environment, viewer_program

POSSIBLE = sys.platform == "linux" and any(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))
"""Whether there is lavapipe, which draws without a graphics card (Debian: mesa-vulkan-drivers)."""

_LISTENING = re.compile(r"Listening for gRPC connections on \S+:(\d+)")
_LOADING_S = 60.0
_POLL_S = 0.1
_SAME = 10  # pictures in a row


@contextmanager
def viewer(recording: Path, folder: Path, size: str = "1600x1000") -> Iterator[ViewerClient]:
    """A viewer that has loaded a recording, ended on the way out; its log goes into `folder`."""
    log = folder / "viewer.log"
    with (
        log.open("wb") as said,
        subprocess.Popen(
            [viewer_program(), "--bind", "127.0.0.1", "--port", "auto", "--headless",
             "--window-size", size, recording],
            env=viewer_environment(),
            stdout=said,
            stderr=subprocess.STDOUT,
        ) as process,
    ):  # fmt: skip
        try:
            port = _announced(process, log)
            client = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            _loaded(process, client)
            yield client
        finally:
            process.terminate()


def _announced(process: subprocess.Popen[bytes], log: Path) -> int:
    deadline_s = time.monotonic() + _LOADING_S
    while (found := _LISTENING.search(log.read_text(encoding="utf-8", errors="replace"))) is None:
        assert process.poll() is None, log.read_text(encoding="utf-8", errors="replace")
        assert time.monotonic() < deadline_s, "the viewer does not listen"
        _pause(process)
    return int(found[1])


def _loaded(process: subprocess.Popen[bytes], client: ViewerClient) -> None:
    """Wait until nothing is loading and the picture stays the same."""
    deadline_s = time.monotonic() + _LOADING_S
    pictures: list[bytes] = []
    while len(pictures) < _SAME or len(set(pictures[-_SAME:])) > 1:
        assert time.monotonic() < deadline_s, f"the viewer is still loading: {client.get_state()}"
        state = client.get_state()
        if state.recordings and state.views and not state.loading:
            pictures.append(client.take_screenshot())
        _pause(process)


def _pause(process: subprocess.Popen[bytes]) -> None:
    try:
        process.wait(_POLL_S)
    except subprocess.TimeoutExpired:
        return
