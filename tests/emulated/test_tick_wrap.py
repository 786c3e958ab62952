"""A drive whose tick reaches 2**32, which at 10 kHz is after 119 hours."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import pairwise

import can
import numpy as np
import pytest

from benchtool.bench.session import Session, open_session
from benchtool.drive.capture import Capture, CaptureRequest
from benchtool.errors import DriveFault
from benchtool.protocol.modes import Mode
from benchtool.telemetry import TelemetryStream
from benchtool.ticks import TICKS

from .test_telemetry import Kept

both_links = pytest.mark.parametrize("url", ["emulated", "emulated?wire=serial"], ids=["can", "serial"])
Opener = Callable[[str, int], Session]


@pytest.fixture
def powered_up() -> Iterator[Opener]:
    """Opens sessions with a drive that is powered up so many ticks before the wrap."""
    with ExitStack() as stack:
        yield lambda url, before: stack.enter_context(open_session("zhu2011", url, first_tick=TICKS - before))


@both_links
@pytest.mark.parametrize("rate_Hz", [1000.0, 125.0])  # 2**32 is a multiple of neither 10 nor 80 ticks
def test_a_stream_goes_through_the_wrap_without_a_gap(powered_up: Opener, url: str, rate_Hz: float) -> None:
    session, kept = powered_up(url, 3003), Kept()
    drive = session.drive
    drive.connect()
    with TelemetryStream(drive, [kept.sink], ("torque", "omega_m"), rate_Hz) as stream:
        drive.wait(0.6)
    report = stream.report()
    stride = round(1e4 / rate_Hz)
    assert set(np.diff(kept.ticks)) == {stride}
    assert kept.ticks[0] < TICKS < kept.ticks[-1]
    assert report.counters.off_grid == report.counters.missing == 0
    assert report.gaps == ()
    assert report.expected == len(kept.ticks)
    assert report.clock is not None
    assert abs(report.clock.drift_ppm) < 5000.0, "batches come a little late"
    now = drive.tick_now()
    assert now is not None
    assert 0 <= now - kept.ticks[-1] <= 2 * stride


@both_links
def test_a_stream_begun_after_the_wrap_is_in_the_time_of_the_session(powered_up: Opener, url: str) -> None:
    session, kept = powered_up(url, 300), Kept()
    drive = session.drive
    drive.connect()
    drive.wait(0.1)
    with TelemetryStream(drive, [kept.sink], ("torque",), 100.0):
        drive.wait(0.3)
    now = drive.tick_now()
    assert now is not None
    assert now - 300 < kept.ticks[-1] <= now
    assert kept.ticks[0] > TICKS
    assert set(np.diff(kept.ticks)) == {100}


@both_links
@pytest.mark.parametrize("before", [1500, 2500])  # the wrap before, and behind the trigger
def test_a_capture_around_the_wrap_tells_its_ticks(powered_up: Opener, url: str, before: int) -> None:
    session = powered_up(url, before)
    drive = session.drive
    drive.connect()
    drive.wait(0.05)
    request = CaptureRequest(("omega_m",), rows=400, stride=5, pretrigger_rows=200, trigger="setpoint")
    capture = Capture(drive, request)
    drive.wait(0.12)
    drive.write("omega_m_command", 5.0)
    capture.wait()
    block = capture.read()
    assert block.first_tick <= TICKS <= block.ticks()[-1]
    triggered = int(drive.number("capture_trigger_tick"))
    assert 0 <= (triggered - int(block.ticks()[200])) % TICKS < 5 or (
        0 <= (int(block.ticks()[200]) - triggered) % TICKS < 5
    )
    now = drive.tick_now()
    assert now is not None
    assert now - 5000 < block.ticks()[-1] <= now


@both_links
def test_a_stimulus_and_supervision_go_through_the_wrap(powered_up: Opener, url: str) -> None:
    session = powered_up(url, 2000)
    drive = session.drive
    drive.connect()
    with drive.enabled(Mode.VELOCITY):
        for name, value in (("stimulus_quantity", "speed"), ("stimulus_shape", "step")):
            drive.write(name, value)
        for name, number in (("stimulus_amplitude", 10.0), ("stimulus_ticks", 4000)):
            drive.write(name, number)
        drive.write("stimulus_control", "start")
        drive.wait(0.39)
        assert drive.read("stimulus_state") == "running"
        drive.wait(0.05)
        assert drive.read("stimulus_state") == "done"
        assert TICKS - 2000 < drive.number("stimulus_start_tick") < TICKS
        assert drive.number("tick") < 5000
        drive.stop_heartbeat()
        with pytest.raises(DriveFault, match="0x8130"):
            drive.wait(0.6)


def test_frames_and_heartbeats_keep_their_period(powered_up: Opener) -> None:
    """Over CAN, as another master sees them."""
    channel = "wrap"
    with can.Bus(interface="virtual", channel=channel) as bus:
        session = powered_up(f"emulated?channel={channel}", 2003)
        drive, kept = session.drive, Kept()
        drive.connect()
        with TelemetryStream(drive, [kept.sink], ("torque",), 500.0):
            drive.wait(0.4)
        seen: dict[int, list[float]] = {}
        ticks = []
        while (frame := bus.recv(0)) is not None:
            seen.setdefault(frame.arbitration_id, []).append(frame.timestamp)
            if frame.arbitration_id == 0x181:
                ticks.append(int.from_bytes(frame.data[:4], "little"))
    assert max(ticks) > TICKS - 100
    assert min(ticks) < 100
    assert {(later - earlier) % TICKS for earlier, later in pairwise(ticks)} == {20}
    assert np.diff(seen[0x701][1:]) == pytest.approx(0.1)


@both_links
def test_events_are_placed_in_the_time_of_the_session(powered_up: Opener, url: str) -> None:
    session = powered_up(url, 1000)
    drive = session.drive
    drive.connect()
    drive.wait(70.0)  # long enough for its tick to be read once more
    drive.poll()
    now = drive.tick_now()
    assert now == TICKS - 1000 + round(session.clock.now_s() * 1e4)
