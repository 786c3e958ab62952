"""The slow stream end to end: over frames, through threads, into a bundle, and back from one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import can
import numpy as np
import pytest

from benchtool.block import Block
from benchtool.emulator.bench import EmulatedBench
from benchtool.errors import NoAnswer, RecordingError, StateError, ValueRefused
from benchtool.link.canopen.virtual import VirtualTimeBus
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode
from benchtool.recording import Bundle, BundleWriter, Manifest
from benchtool.run.runner import run_plan
from benchtool.telemetry import Sink, TelemetryStream, certify_recording, record_stream

from .conftest import Opener, Wire, over_both_wires
from .test_runs import INFO, RunObserver, _plan

NODE = 1
CHANNELS = ("i_a", "torque", "omega_m", "switching_count")


class Kept:
    """A sink that keeps its blocks."""

    def __init__(self) -> None:
        self.blocks: list[Block] = []
        self.sink = Sink("kept", self.blocks.append, lossless=True)

    @property
    def data(self) -> np.ndarray:
        return np.concatenate([block.data for block in self.blocks])

    @property
    def ticks(self) -> list[int]:
        return [int(tick) for block in self.blocks for tick in block.ticks()]


class LossyBus(VirtualTimeBus):
    """A host's adapter that does not hear some of the frames."""

    loses: Callable[[can.Message], bool] = staticmethod(lambda _: False)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        received = super().recv(timeout)
        return None if received is not None and self.loses(received) else received


@pytest.fixture
def benches(monkeypatch: pytest.MonkeyPatch) -> list[EmulatedBench]:
    """The benches that are opened, in order, whose hosts have lossy adapters."""
    opened: list[EmulatedBench] = []

    def host_bus(bench: EmulatedBench) -> VirtualTimeBus:
        opened.append(bench)
        bus = LossyBus(bench.channel, clock=bench.clock)
        bench.clock.register(bus.settle)
        return bus

    monkeypatch.setattr(EmulatedBench, "host_bus", host_bus)
    return opened


def power_off(bench: EmulatedBench) -> None:
    bench.clock.unregister(bench._advance_to)
    bench._node.close()


@over_both_wires
def test_values_and_ticks_are_those_of_a_capture_at_the_control_rate(wire: Wire) -> None:
    from benchtool.drive import Capture, CaptureRequest

    drive = wire.session.drive
    drive.connect()
    kept = Kept()
    with drive.enabled(Mode.VELOCITY):
        drive.write("omega_m_command", 20.0)
        with TelemetryStream(drive, [kept.sink], CHANNELS, 200.0) as stream:
            capture = Capture(drive, CaptureRequest(("tick", *CHANNELS), rows=3000))
            capture.wait()
            drive.wait(0.1)
            stream.check()
        captured = capture.read()
    rows = {int(row[0]): row[1:] for row in captured.data}
    common = [(tick, row) for tick, row in zip(kept.ticks, kept.data, strict=True) if tick in rows]
    assert len(common) == 60
    for tick, row in common:
        assert row.tolist() == rows[tick].tolist()
    assert np.diff(kept.ticks).tolist() == [50] * (len(kept.ticks) - 1)


@over_both_wires
def test_a_later_stream_is_measured_against_what_the_drive_sent_of_it_alone(wire: Wire) -> None:
    for seconds, records in ((0.5, 50), (1.0, 100), (0.2, 20)):
        with TelemetryStream(wire.session.drive, [Kept().sink], CHANNELS) as stream:
            wire.session.clock.wait(seconds)
        assert stream.report().expected == stream.report().counters.received == records


@over_both_wires
def test_the_report_of_a_whole_stream(wire: Wire) -> None:
    drive = wire.session.drive
    kept = Kept()
    with TelemetryStream(drive, [kept.sink], CHANNELS) as stream:
        wire.session.clock.wait(1.0)
    report = stream.report()
    assert report.expected == report.counters.received == len(kept.data) == 100
    assert report.gaps == ()
    assert report.clock is not None
    assert abs(report.clock.drift_ppm) < 1e-3
    assert report.jitter_max_s < 1e-9
    wire.frames()
    wire.session.clock.wait(0.5)
    assert [can_id for can_id, _ in wire.frames() if 0x180 < can_id < 0x580] == [], (
        "the drive is silent again"
    )


def test_a_lost_frame_is_a_gap_in_its_place_and_nothing_else(
    benches: list[EmulatedBench], open_wire: Opener, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard = {0x281: 0, 0x181: 0}

    def loses(frame: can.Message) -> bool:
        if frame.arbitration_id in heard:
            heard[frame.arbitration_id] += 1
        return (frame.arbitration_id == 0x281 and heard[0x281] in (11, 12, 51)) or (
            frame.arbitration_id == 0x181 and heard[0x181] == 31
        )

    monkeypatch.setattr(LossyBus, "loses", staticmethod(loses))
    session = open_wire().session
    kept = Kept()
    with TelemetryStream(session.drive, [kept.sink], CHANNELS) as stream:
        session.clock.wait(1.0)
        stream.check()
    report = stream.report()
    first = kept.ticks[0]
    assert [(tick - first) // 100 for tick in kept.ticks] == [
        number for number in range(100) if number not in (10, 11, 30, 50)
    ]
    assert [(gap.row, gap.missing_rows) for gap in report.gaps] == [(10, 2), (28, 1), (47, 1)]
    assert (report.expected, report.counters.received, report.counters.lost) == (100, 96, 4)
    certificate, _ = certify_recording(stream, {}, session.drive.link.counters)
    assert not certificate.complete
    assert certificate.value("telemetry_gap_max") == 2


def test_a_loss_at_the_end_is_known_from_the_drives_count(
    benches: list[EmulatedBench], open_wire: Opener, monkeypatch: pytest.MonkeyPatch
) -> None:
    wire = open_wire()
    with TelemetryStream(wire.session.drive, [Kept().sink], CHANNELS) as stream:
        wire.session.clock.wait(0.5)
        monkeypatch.setattr(LossyBus, "loses", staticmethod(lambda frame: frame.arbitration_id == 0x181))
        wire.session.clock.wait(0.2)
    report = stream.report()
    assert (report.expected, report.counters.received) == (70, 50)


# ---- what goes wrong ---------------------------------------------------------------------------------------


@over_both_wires
def test_a_recorder_that_fails_ends_the_run_with_the_drive_disabled(wire: Wire) -> None:
    def full(block: Block) -> None:
        raise RecordingError("cannot write: no space left")

    drive = wire.session.drive
    drive.connect()
    with (
        pytest.raises(RecordingError, match="no space left"),
        TelemetryStream(drive, [Sink("recorder", full, lossless=True)], CHANNELS) as stream,
        drive.watched(stream.check),
        drive.enabled(Mode.VELOCITY),
    ):
        drive.wait(5.0)
    assert wire.session.clock.now_s() < 1.0
    assert drive.state() is State.SWITCH_ON_DISABLED


def test_a_recorder_that_fails_at_the_very_end_is_not_overlooked(wire: Wire) -> None:
    def full(block: Block) -> None:
        raise RecordingError("cannot write: no space left")

    sink = Sink("recorder", full, lossless=True)
    with pytest.raises(RecordingError, match="no space left"), TelemetryStream(wire.session.drive, [sink]):
        wire.session.clock.wait(0.1)


def test_a_recorder_that_stands_still_ends_the_run(benches: list[EmulatedBench], open_wire: Opener) -> None:
    wire = open_wire()
    go = threading.Event()

    def stand(block: Block) -> None:
        go.wait()

    drive = wire.session.drive
    sink = Sink("recorder", stand, lossless=True, size=1, room_s=0.01)
    try:
        with (
            pytest.raises(RecordingError, match="'recorder' is 1 blocks behind"),
            TelemetryStream(drive, [sink], CHANNELS, 1000.0) as stream,
        ):
            # A stalled disk stalls the barrier of virtual time as well; records are fed past it.
            benches[0].clock.unregister(sink.worker.settle)
            wire.session.clock.wait(2.0)
            go.set()
            stream.check()
    finally:
        go.set()


def test_a_drive_that_loses_power_is_named(benches: list[EmulatedBench], open_wire: Opener) -> None:
    session = open_wire().session
    kept = Kept()
    with (
        pytest.raises(NoAnswer, match=r"stream of node 1 stopped 1\.\d s ago, after 30 records"),
        TelemetryStream(session.drive, [kept.sink], CHANNELS) as stream,
        session.drive.watched(stream.check),
    ):
        session.drive.wait(0.3)
        power_off(benches[0])
        session.drive.wait(5.0)
    assert len(kept.data) == 30


@over_both_wires
@pytest.mark.parametrize(
    ("command", "state"), [(0x81, "pre-operational"), (0x80, "pre-operational"), (0x02, "stopped")]
)
def test_a_drive_that_another_master_takes_out_of_operational_is_named(
    wire: Wire, command: int, state: str
) -> None:
    drive = wire.session.drive
    with (
        pytest.raises(StateError, match=f"its heartbeat says {state}"),
        TelemetryStream(drive, [Kept().sink], CHANNELS) as stream,
        drive.watched(stream.check),
    ):
        drive.wait(0.3)
        wire.send(0x000, command, NODE)
        drive.wait(5.0)


@over_both_wires
def test_channels_that_cannot_be_leave_the_drive_as_it_was(wire: Wire) -> None:
    with (
        pytest.raises(ValueRefused, match="did you mean"),
        TelemetryStream(wire.session.drive, [Kept().sink], ("torqe",)),
    ):
        pass
    assert wire.session.drive.read("tpdo1_cob_id") == 0xC0000180 + NODE


def test_pdos_that_an_earlier_host_left_behind_are_switched_off(wire: Wire) -> None:
    drive = wire.session.drive
    drive.write("tpdo8_event_timer", 0.001)
    drive.write("tpdo8_mapping_1", 0x20300120)
    drive.write("tpdo8_mapping_count", 1)
    drive.write("tpdo8_cob_id", 0x4C0 + NODE)
    with TelemetryStream(drive, [Kept().sink], CHANNELS):
        wire.frames()
        wire.session.clock.wait(0.1)
        assert 0x4C1 not in dict(wire.frames())


def test_every_run_of_a_plan_has_the_stream_and_a_certificate(wire: Wire, tmp_path: Path) -> None:
    observer = RunObserver()
    run_plan(lambda *_: nullcontext(wire.session), _plan(), tmp_path / "run", INFO, observer)
    assert any("rows expected, 0 missing" in note for note in observer.notes)
    bundle = Bundle.open(tmp_path / "run")
    assert {"capture", "telemetry"} <= set(bundle.streams)
    telemetry = bundle.block("telemetry")
    assert telemetry.column("omega_m")[-1] == pytest.approx(31.42, abs=0.5)
    certificate = bundle.certificate
    assert certificate is not None
    assert certificate["complete"] is True
    assert certificate["measurements"]["capture_rows_expected"]["value"] == 1200
    assert certificate["measurements"]["telemetry_rows_received"]["value"] == len(telemetry.data)


def test_a_plan_whose_recording_fails_ends_with_the_drive_disabled(
    wire: Wire, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    append = BundleWriter.append

    def full(writer: BundleWriter, stream: str, block: Block) -> None:
        if stream == "telemetry" and block.first_tick > 2000:
            raise RecordingError("cannot write telemetry.arrows: no space left")
        append(writer, stream, block)

    monkeypatch.setattr(BundleWriter, "append", full)
    with pytest.raises(RecordingError, match="no space left"):
        run_plan(lambda *_: nullcontext(wire.session), _plan(), tmp_path / "run", INFO, RunObserver())
    assert wire.session.drive.state() is State.SWITCH_ON_DISABLED
    bundle = Bundle.open(tmp_path / "run")
    assert not bundle.complete
    assert bundle.manifest.details["failure"].startswith("RecordingError: cannot write telemetry.arrows")
    assert len(bundle.block("telemetry").data) == 20


def test_a_stream_goes_into_a_bundle_and_back(wire: Wire, tmp_path: Path) -> None:
    kept = Kept()
    with BundleWriter(tmp_path / "run", Manifest(what="test", when="2026-11-21T00:00:00+00:00")) as writer:
        with record_stream(wire.session.drive, writer, CHANNELS, others=[kept.sink]):
            wire.session.clock.wait(1.01)
        bundle = writer.finish()
    block = bundle.block("telemetry")
    np.testing.assert_array_equal(block.data, kept.data)
    assert block.ticks().tolist() == kept.ticks
    assert block.names == CHANNELS
