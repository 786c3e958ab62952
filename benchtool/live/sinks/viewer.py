"""Viewers, native or in a browser, as processes that listen on loopback."""

from __future__ import annotations

import contextlib
import ipaddress
import os
import re
import socket
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Final, Self

import rerun as rr

from benchtool.errors import EnvironmentFailure, UsageError
from benchtool.live.sinks.page import Page
from benchtool.live.sinks.relay import Relay

LOOPBACK: Final = "127.0.0.1"
_STARTING_S = 20.0
_ENDING_S = 2.0
_CLOSING_S = 3.0
_LOOKING_S = 1.0
_ANSWERING_S = 0.2
_POLL_S = 0.02
_ESCAPES = re.compile(r"\x1b\[[0-9;]*m")
_LISTENING = re.compile(r"Listening for gRPC connections on \S+:(\d+)")
_HOSTING = re.compile(r"Hosting a web-viewer at http://(?:\[[^]]+\]|[^:/\s]+):(\d+)")
_QUIET: Final = {
    "CI": "true",  # what the viewer takes as a reason to collect no usage data
    "RUST_LOG": "info",  # the ports are read from its log
    "NO_COLOR": "1",
}


def viewer_program() -> Path:
    """Return the viewer that comes with the SDK's wheel.

    Raises:
        EnvironmentFailure: the wheel holds none.
    """
    spec = find_spec("rerun_cli")
    folder = Path(spec.origin).parent if spec is not None and spec.origin else Path()
    program = folder / ("rerun.exe" if sys.platform == "win32" else "rerun")
    if spec is None or not program.is_file():
        raise EnvironmentFailure(
            "the Rerun viewer is missing: the wheel of rerun-sdk brings it; install rerun-sdk again, or "
            "write a recording (.rrd) and open it elsewhere"
        )
    return program


class Viewer:
    """A running viewer: `native` outlives this process, `web` ends with `close`.

    Args:
        web: serve the web viewer instead of opening the native one.
        bind: address that its servers listen on.
        port, web_port: of its data and of the page; 0 picks free ones.

    Raises:
        UsageError: `bind` is no address.
        EnvironmentFailure: there is no viewer, no display, or the port is in use.
    """

    def __init__(self, *, web: bool, bind: str = LOOPBACK, port: int = 0, web_port: int = 0) -> None:
        self.web = web
        self._bind = _address(bind)
        if not web and sys.platform == "linux" and not _display():
            raise EnvironmentFailure(
                "the native viewer needs a display and neither DISPLAY nor WAYLAND_DISPLAY names one: serve "
                "the view to a browser (web) or write it to a file (.rrd)"
            )
        program = viewer_program()
        self._look_s = 0.0
        self._lost = self._replaced = False
        self._relay: Relay | None = None
        # Not Rerun's default port, 9876, at which the viewer of another program may listen.
        ports = ["--port", str(port or _free_port(self._bind))]
        mode = (
            ["--serve-web", "--web-viewer-port", "0", "--server-memory-limit", "512MiB"]
            if web
            else ["--memory-limit", "50%", "--hide-welcome-screen", "--expect-data-soon"]
        )
        self._log = tempfile.TemporaryFile("a+b")  # noqa: SIM115 # closed by close; appended to, wherever read
        try:
            self.process = subprocess.Popen(
                [program, "--bind", self._bind, *ports, *mode],
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=subprocess.STDOUT,
                env=viewer_environment(),
                start_new_session=True,  # Ctrl-C is for the measurement
            )
        except OSError as reason:
            self._log.close()
            raise EnvironmentFailure(
                f"{self.name} cannot be started: {reason}; install rerun-sdk again, or write a file (.rrd)"
            ) from None
        try:
            self.port = self._announced(_LISTENING, "gRPC", port)
            self._page = self._serve(web_port) if web else None
        except BaseException:
            self.end()
            self._log.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def name(self) -> str:
        return "the web viewer" if self.web else "the viewer"

    @property
    def closing_timeout_s(self) -> float:
        """Time for a working viewer to take what is queued."""
        return _CLOSING_S

    @property
    def host(self) -> str:
        """By which this machine reaches the viewer's servers."""
        host = LOOPBACK if self._bind in ("0.0.0.0", "::") else self._bind
        return f"[{host}]" if ":" in host else host

    @property
    def page(self) -> str:
        """Address of the web viewer's page; empty for the native viewer."""
        return "" if self._page is None else self._page.url

    def connect(self, stream: rr.RecordingStream) -> None:
        """Have a recording go there.

        Raises:
            EnvironmentFailure: the viewer has been closed.
        """
        if not self.alive():  # else the SDK would look for it for five seconds
            raise EnvironmentFailure(f"{self.name} has been closed: start another one")
        self._close_relay()
        self._relay = Relay(self.host.strip("[]"), self.port)
        stream.connect_grpc(f"rerun+http://{LOOPBACK}:{self._relay.port}/proxy")

    @property
    def batch_timeout_s(self) -> float:
        """Unlimited: the end of the connection ends the wait."""
        return 1e6

    @property
    def replaceable(self) -> bool:
        """Whether another viewer may take its place at the same port."""
        return True

    def closing_note(self) -> str:
        """Return the command that starts another viewer where this one was."""
        return f"'rerun --bind {self._bind} --port {self.port}' shows the rest"

    def alive(self) -> bool:
        """Return whether the process runs, or another listens in its place.

        The latter is checked once a second, and so is the former once the connection was lost: a process that
        is just ending seems to run, and its port to listen.
        """
        if not self._lost and self.process.poll() is None:
            return True
        if time.monotonic() >= self._look_s:
            self._look_s = time.monotonic() + _LOOKING_S
            self._replaced = self._answers()
        return self._replaced

    def lost(self) -> None:
        """Look for it, or for another in its place, in a second."""
        self._lost, self._replaced = True, False
        self._look_s = time.monotonic() + _LOOKING_S

    def give_up(self) -> None:
        """Cut the way to it, if there is one."""
        if self._relay is not None:
            self._relay.cut()

    def close(self) -> None:
        """End the web viewer; leave the native viewer open."""
        self._close_relay()
        if self._page is not None:
            self._page.close()
            self.end()
        self._log.close()

    def end(self) -> None:
        """Terminate the process; kill it if it does not end."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(_ENDING_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
        self.process.wait()

    def _close_relay(self) -> None:
        if self._relay is not None:
            self._relay.close()

    def _answers(self) -> bool:
        """Return whether a viewer listens at the address."""
        try:
            with socket.create_connection((self.host.strip("[]"), self.port), _ANSWERING_S):
                return True
        except OSError:
            return False

    def _serve(self, port: int) -> Page:
        behind = self._announced(_HOSTING, "web", 0)
        return Page(self._bind, port, self.host, behind, self.port)

    def _announced(self, pattern: re.Pattern[str], what: str, port: int) -> int:
        """Return the port that the viewer's log names."""
        deadline_s = time.monotonic() + _STARTING_S
        while time.monotonic() < deadline_s:
            ended = self.process.poll() is not None
            said = self._said()
            if found := pattern.search(said):
                return int(found[1])
            if ended:
                break
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(_POLL_S)
        reason = _reason(said)
        wanted = f" on port {port}" if port else ""
        raise EnvironmentFailure(
            f"{self.name} did not start its {what} server{wanted}: {reason}; choose another port, or write a "
            f"file (.rrd) instead"
        )

    def _said(self) -> str:
        self._log.seek(0)
        return _ESCAPES.sub("", self._log.read().decode(errors="replace"))


def viewer_environment() -> dict[str, str]:
    """Return the environment of a viewer, which has it collect no usage data."""
    return {**os.environ, **_QUIET}


def _address(bind: str) -> str:
    try:
        return str(ipaddress.ip_address(bind))
    except ValueError:
        raise UsageError(
            f"'{bind}' is no address to listen on: {LOOPBACK} is this machine only, 0.0.0.0 everybody"
        ) from None


def _free_port(bind: str) -> int:
    with socket.socket(socket.AF_INET6 if ":" in bind else socket.AF_INET) as taken:
        try:
            taken.bind((bind, 0))
        except OSError as reason:
            raise EnvironmentFailure(
                f"cannot listen on {bind}: {reason.strerror}; choose an address of this machine"
            ) from None
        port: int = taken.getsockname()[1]
        return port


def _display() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _reason(log: str) -> str:
    """Return the most informative line of a viewer's log."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    telling = [line for line in lines if re.search(r"error|in use|fail|panic", line, re.IGNORECASE)]
    return (telling or lines or ["it said nothing"])[-1][:200]
