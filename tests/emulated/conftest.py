"""Sessions with the emulated drive on a bus that a test can listen to."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass

import can
import pytest
from matplotlib.figure import Figure

from benchtool.bench.session import Session, open_session
from benchtool.report import html
from benchtool.report.figures import drawings
from benchtool.report.pdf import flow

_numbers = itertools.count()


@dataclass(frozen=True)
class Wire:
    """A plain python-can bus beside the host and the drive."""

    bus: can.BusABC
    session: Session

    def frames(self) -> list[tuple[int, bytes]]:
        """Return the frames on the wire since the last call, in order."""
        self.session.clock.wait(0.0)
        seen = []
        while (frame := self.bus.recv(0)) is not None:
            seen.append((frame.arbitration_id, bytes(frame.data)))
        return seen

    def send(self, can_id: int, *data: int) -> None:
        """Put a frame on the wire and let it be handled."""
        self.bus.send(can.Message(arbitration_id=can_id, data=bytes(data), is_extended_id=False))
        self.session.clock.wait(0.0)


Opener = Callable[..., Wire]

over_both_wires = pytest.mark.parametrize("link_options", ["", "&wire=serial"], ids=["can", "serial"])
"""For a test of what a host does to a drive, whatever carries it; the observer's bus is there in any case."""


@pytest.fixture
def open_wire() -> Iterator[Opener]:
    """Opens sessions that end with the test; the observer's bus is there before the drive boots."""
    with ExitStack() as stack:

        def opener(profile: str = "zhu2011", *, options: str = "", seed: int = 0) -> Wire:
            channel = f"test-{next(_numbers)}"
            bus = stack.enter_context(can.Bus(interface="virtual", channel=channel))
            url = f"emulated?channel={channel}{options}"
            return Wire(bus, stack.enter_context(open_session(profile, url, seed=seed)))

        yield opener


@pytest.fixture
def blank_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Has reports show blank pictures, for tests of their texts; drawing is most of a report's time. Of the
    figures that analyses declare not even axes are made."""
    monkeypatch.setattr(drawings, "draw", lambda *_: Figure())
    monkeypatch.setattr(html, "data_uri", lambda _: "data:,")
    monkeypatch.setattr(flow, "draw_figure", lambda *_: None)


@pytest.fixture
def link_options() -> str:
    """Options of the host's link, for tests that are not of both wires."""
    return ""


@pytest.fixture
def wire(open_wire: Opener, link_options: str) -> Wire:
    """One session with the paper's machine."""
    return open_wire(options=link_options)
