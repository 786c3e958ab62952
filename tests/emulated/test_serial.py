"""The emulated drive over its serial line: the stream at the control rate, losses, and reconnection."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchtool.bench.session import Session, open_session
from benchtool.cli import app
from benchtool.drive import Capture, CaptureRequest
from benchtool.emulator.bench import EmulatedBench
from benchtool.errors import DictionaryMismatch, LinkClosed, LinkError, NoAnswer, StateError, ValueRefused
from benchtool.link.pipe import PipePort
from benchtool.link.serial.link import SerialLink
from benchtool.protocol.canopen.nmt import NmtCommand
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode
from benchtool.protocol.serial import Batch, BatchDecoder, MessageType
from benchtool.recording import Bundle
from benchtool.run.runner import run_plan
from benchtool.telemetry import Sink, TelemetryStream, certify_recording

from .test_runs import INFO, RunObserver, _plan
from .test_telemetry import Kept

SIXTEEN = (
    *("tick", "i_a", "i_b", "i_c", "i_d", "i_q", "torque", "torque_reference"),
    *("psi_s", "omega_m", "theta_m", "u_dc", "switching_count", "law_clipped", "adc_saturated", "psi_alpha"),
)
BATCH = 63  # records of sixteen words in the longest message


class Line:
    """What is between a host's link and the drive, which may lose or damage what the drive sends."""

    def __init__(self, port: PipePort) -> None:
        self._port = port
        self.batches = 0
        self.spoil: Callable[[int, bytes], bytes] = lambda _, data: data

    def read(self) -> bytes:
        return self.read_timed()[0]

    def read_timed(self) -> tuple[bytes, float]:
        data, arrival_s = self._port.read_timed()
        # One write is one frame; its type is the second stuffed byte.
        if len(data) > 2 and data[2] == MessageType.BATCH:
            self.batches += 1
            data = self.spoil(self.batches, data)
        return data, arrival_s

    def write(self, data: bytes) -> None:
        self._port.write(data)

    def close(self) -> None:
        self._port.close()

    def pull(self) -> None:
        """Take the cable out."""
        self._port.peer.close()


class Bench:
    """A session over a serial line whose cable a test can pull."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.lines: list[Line] = []
        self.benches: list[EmulatedBench] = []
        self.absent = 0
        host_port = EmulatedBench.host_port

        def lined(bench: EmulatedBench) -> Line:
            if self.absent:
                self.absent -= 1
                raise LinkError(
                    "cannot open /dev/ttyUSB0: no such file; check that the adapter is plugged in"
                )
            self.benches.append(bench)
            self.lines.append(Line(host_port(bench)))
            return self.lines[-1]

        self._host_port = host_port
        monkeypatch.setattr(EmulatedBench, "host_port", lined)

    def another(self) -> PipePort:
        """A second host's line to the same drive."""
        return self._host_port(self.benches[0])


@pytest.fixture
def hands(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch)


@pytest.fixture
def session(hands: Bench) -> Iterator[Session]:
    with open_session("zhu2011", "emulated?wire=serial") as opened:
        yield opened


# ---- the stream at the control rate ------------------------------------------------------------------------


def test_sixteen_channels_at_the_control_rate_are_those_of_a_capture(session: Session) -> None:
    drive = session.drive
    drive.connect()
    kept = Kept()
    with drive.enabled(Mode.VELOCITY):
        drive.write("omega_m_command", 20.0)
        with TelemetryStream(drive, [kept.sink], SIXTEEN, 10_000.0) as stream:
            capture = Capture(drive, CaptureRequest(SIXTEEN, rows=3000))
            capture.wait()
            drive.wait(0.7)
            stream.check()
        captured = capture.read()
    report = stream.report()
    assert report.expected == report.counters.received == len(kept.data) >= 10_000
    assert (report.gaps, report.drive_dropped) == ((), 0)
    assert np.diff(kept.ticks).tolist() == [1] * (len(kept.data) - 1)
    np.testing.assert_array_equal(kept.data[:, 0], kept.ticks)
    first = int(captured.data[0, 0]) - kept.ticks[0]
    np.testing.assert_array_equal(kept.data[first : first + 3000], captured.data)


def test_lost_and_damaged_batches_are_gaps_in_their_places(session: Session, hands: Bench) -> None:
    def spoil(number: int, data: bytes) -> bytes:
        if number in (10, 11, 40):
            return b""
        return data[:100] + bytes([data[100] ^ 0x55 or 1]) + data[101:] if number == 70 else data

    kept = Kept()
    hands.lines[0].spoil = spoil
    with TelemetryStream(session.drive, [kept.sink], SIXTEEN, 10_000.0) as stream:
        session.clock.wait(1.0)
    report = stream.report()
    assert [(gap.row, gap.missing_rows) for gap in report.gaps] == [
        (9 * BATCH, 2 * BATCH),
        (37 * BATCH, BATCH),
        (66 * BATCH, BATCH),
    ]
    assert report.expected == report.counters.received + 4 * BATCH == 10_000
    assert report.counters.lost == report.counters.missing == 4 * BATCH
    missing = sorted(set(range(kept.ticks[0], kept.ticks[0] + 10_000)) - set(kept.ticks))
    assert missing == [kept.ticks[0] + (n - 1) * BATCH + k for n in (10, 11, 40, 70) for k in range(BATCH)]
    np.testing.assert_array_equal(kept.data[:, 0], kept.ticks)
    certificate, _ = certify_recording(stream, {}, session.drive.link.counters)
    assert not certificate.complete
    assert certificate.value("telemetry_gap_max") == 2 * BATCH
    assert certificate.value("link_frames_dropped") == 1


def test_a_loss_at_the_end_is_known_from_the_drives_count(session: Session, hands: Bench) -> None:
    with TelemetryStream(session.drive, [Kept().sink], SIXTEEN, 10_000.0) as stream:
        session.clock.wait(0.5)
        hands.lines[0].spoil = lambda _, data: b""
        session.clock.wait(0.2)
    report = stream.report()
    assert report.expected == 7000
    assert report.counters.received == 5000 // BATCH * BATCH
    assert report.gaps == ()


@pytest.mark.parametrize("rate_Hz", [1.0, 50.0, 1000.0, 2500.0])
def test_every_rate_that_is_a_whole_number_of_ticks(session: Session, rate_Hz: float) -> None:
    kept = Kept()
    with TelemetryStream(session.drive, [kept.sink], ("tick", "torque"), rate_Hz) as stream:
        session.clock.wait(3.0)
    assert stream.report().expected == len(kept.data) == 3 * rate_Hz
    assert set(np.diff(kept.ticks)) == {round(10_000 / rate_Hz)}
    np.testing.assert_array_equal(kept.data[:, 0], kept.ticks)


def test_arrivals_bear_the_drives_time(session: Session) -> None:
    with TelemetryStream(session.drive, [Kept().sink], ("torque",), 100.0) as stream:
        session.clock.wait(1.0)
    report = stream.report()
    assert report.clock is not None
    assert abs(report.clock.drift_ppm) < 1e-3
    assert report.jitter_max_s < 1e-9


@pytest.mark.parametrize(
    ("channels", "rate_Hz", "complaint"),
    [
        (SIXTEEN, 3000.0, r"a record every 3\.33333 ticks, .* choose 3333\.33 Hz"),
        (SIXTEEN, 20_000.0, "choose 10000 Hz"),
        (SIXTEEN, -1.0, "choose one up to 10000 Hz"),
        ((*SIXTEEN, "psi_beta"), 100.0, "1 to 16 different signals are expected"),
        (("torque", "torque"), 100.0, "name each once"),
        (("statusword",), 100.0, "cannot be a channel of the stream"),
    ],
)
def test_what_cannot_be_streamed(
    session: Session, channels: tuple[str, ...], rate_Hz: float, complaint: str
) -> None:
    with (
        pytest.raises(ValueRefused, match=complaint),
        TelemetryStream(session.drive, [Kept().sink], channels, rate_Hz),
    ):
        pass


def test_the_stream_of_a_host_that_died_is_none_of_ours(session: Session) -> None:
    drive = session.drive
    assert isinstance(drive.link, SerialLink)
    drive.link.configure_stream([drive.dictionary["torque"].mapping], 1, 16)
    drive.link.nmt(NmtCommand.START)
    session.clock.wait(0.1)
    kept = Kept()
    with TelemetryStream(drive, [kept.sink], ("tick",), 1000.0) as stream:
        session.clock.wait(0.3)
    assert stream.report().counters.malformed == 0
    assert stream.report().expected == len(kept.data) == 300
    np.testing.assert_array_equal(kept.data[:, 0], kept.ticks)


def test_a_drive_that_loses_power_is_named(session: Session, hands: Bench) -> None:
    with (
        pytest.raises(NoAnswer, match=r"stream of node 1 stopped 1\.\d s ago, after 30 records"),
        TelemetryStream(session.drive, [Kept().sink], ("torque",)) as stream,
        session.drive.watched(stream.check),
    ):
        session.drive.wait(0.3)
        hands.benches[0].clock.unregister(hands.benches[0]._advance_to)
        session.drive.wait(5.0)


# ---- the same data on every wire ---------------------------------------------------------------------------


def _captured(folder: Path, url: str) -> bytes:
    with open_session("zhu2011", url, seed=3) as session:
        run_plan(lambda *_: nullcontext(session), _plan(), folder, INFO, RunObserver())
    (parquet,) = folder.rglob("capture.parquet")
    return parquet.read_bytes()


def test_a_plan_records_the_same_bytes_over_either_wire_and_twice(tmp_path: Path) -> None:
    first = _captured(tmp_path / "a", "emulated?wire=serial")
    assert _captured(tmp_path / "b", "emulated?wire=serial") == first
    assert _captured(tmp_path / "c", "emulated") == first


# ---- the cable --------------------------------------------------------------------------------------------


def test_a_pulled_cable_stops_the_motor_and_the_way_back_leaves_it_disabled(
    session: Session, hands: Bench
) -> None:
    drive = session.drive
    drive.connect()
    drive.enable(Mode.VELOCITY)
    drive.write("omega_m_command", 15.0)
    drive.wait(0.4)
    hands.lines[0].pull()
    with pytest.raises(LinkClosed, match="serial port of node 1 stopped working"):
        drive.wait(1.0)
    hands.absent = 4
    back = drive.reconnect(5.0)
    assert back.restarted is False
    assert back.identity.product_code == 0x2011
    assert not drive.state().power_stage_on
    assert drive.number("link_losses") == 1, "the drive's own supervision stopped the motor"
    assert drive.state() is State.FAULT
    drive.reset_fault()
    with drive.enabled(Mode.VELOCITY):
        drive.wait(0.7)
        assert drive.read("link_state") == "alive", "supervision is armed again"


def test_a_way_back_before_the_watchdog_disables_as_well(session: Session, hands: Bench) -> None:
    drive = session.drive
    drive.connect()
    drive.enable(Mode.VELOCITY)
    drive.wait(0.05)
    hands.lines[0].pull()
    assert drive.reconnect(1.0).restarted is False
    assert drive.state() is State.SWITCH_ON_DISABLED
    assert drive.number("link_losses") == 0


def test_no_way_back_is_an_error_in_due_time(session: Session, hands: Bench) -> None:
    drive = session.drive
    drive.connect()
    hands.lines[0].pull()
    hands.absent = 1000
    before_s = session.clock.now_s()
    with pytest.raises(LinkError, match="cannot open /dev/ttyUSB0"):
        drive.reconnect(2.0)
    assert session.clock.now_s() - before_s == pytest.approx(2.0, abs=0.3)


def test_another_drive_at_the_other_end_is_refused(
    session: Session, hands: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = session.drive
    drive.connect()
    hands.lines[0].pull()
    monkeypatch.setattr(type(drive.dictionary), "hash", 0x12345678)
    with pytest.raises(DictionaryMismatch):
        drive.reconnect(1.0)


# ---- a stream that goes on after its link was lost ------------------------------------------------------


def _lose_and_resume(session: Session, hands: Bench, stream: TelemetryStream, absent: int) -> None:
    hands.lines[-1].pull()
    hands.absent = absent
    with pytest.raises(LinkClosed):
        while True:
            session.clock.wait(0.05)
            stream.check()
    session.drive.reconnect(5.0)
    stream.resume()


@pytest.mark.parametrize("rate_Hz", [10_000.0, 100.0])
def test_a_stream_is_resumed_with_the_gap_in_its_place(
    session: Session, hands: Bench, rate_Hz: float
) -> None:
    kept = Kept()
    with TelemetryStream(session.drive, [kept.sink], ("tick", "torque"), rate_Hz) as stream:
        for absent in (3, 0):
            session.clock.wait(0.5)
            _lose_and_resume(session, hands, stream, absent)
        session.clock.wait(0.5)
        stream.check()
    report = stream.report()
    stride = round(10_000 / rate_Hz)
    steps = np.diff(kept.ticks) // stride
    (lost,) = np.nonzero(steps > 1)
    assert [(gap.row, gap.missing_rows) for gap in report.gaps] == [
        (int(row) + 1, int(steps[row]) - 1) for row in lost
    ]
    assert len(report.gaps) == 2
    np.testing.assert_array_equal(kept.data[:, 0], kept.ticks)
    assert (report.resumptions, report.expected) == (2, None)
    assert report.counters.received == len(kept.data) > 1.3 * rate_Hz
    certificate, _ = certify_recording(stream, {}, session.drive.link.counters)
    assert not certificate.complete
    assert certificate.value("telemetry_rows_missing") == sum(gap.missing_rows for gap in report.gaps)


def test_a_drive_that_was_only_read_goes_on_with_what_it_does(session: Session, hands: Bench) -> None:
    drive = session.drive
    other = SerialLink(hands.another(), 1, session.clock)
    with other, TelemetryStream(drive, [Kept().sink], ("tick",)) as stream:
        mode, word = drive.dictionary["mode_of_operation"], drive.dictionary["controlword"]
        other.download(mode.index, mode.sub, mode.encode(int(Mode.VELOCITY)))
        for command in (6, 7, 15):
            other.download(word.index, word.sub, word.encode(command))
        session.clock.wait(0.3)
        assert drive.state() is State.OPERATION_ENABLED
        _lose_and_resume(session, hands, stream, 0)
        assert drive.state() is State.OPERATION_ENABLED


def test_a_drive_that_restarted_meanwhile_ends_the_stream(
    session: Session, hands: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = Kept()
    feed = BatchDecoder.feed

    def restarted(decoder: BatchDecoder, batch: Batch, arrival_s: float) -> int:
        return feed(decoder, dataclasses.replace(batch, first_tick=batch.first_tick - 29_000), arrival_s)

    with (
        pytest.raises(StateError, match="node 1 restarted while its link was lost: tick "),
        TelemetryStream(session.drive, [kept.sink], ("torque",)) as stream,
    ):
        session.clock.wait(3.0)
        monkeypatch.setattr(BatchDecoder, "feed", restarted)
        _lose_and_resume(session, hands, stream, 0)
        session.clock.wait(0.3)
        stream.check()
    assert len(kept.data) <= 300


def test_a_recording_survives_a_pulled_cable(
    hands: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    check = TelemetryStream.check
    checks = 0

    def pulled(stream: TelemetryStream) -> None:
        nonlocal checks
        checks += 1
        if checks == 20:
            hands.lines[-1].pull()
            hands.absent = 2
        check(stream)

    monkeypatch.setattr(TelemetryStream, "check", pulled)
    options = ("record", "--duration", "4", "--rate", "1000", "--link", "emulated?wire=serial")
    result = CliRunner().invoke(app, (*options, "--reconnect", "5", "--out", "a"))
    assert result.exit_code == 0, result.output
    assert "stopped working: the other end hung up" in result.stderr
    bundle = Bundle.open(Path("a"))
    block = bundle.block("telemetry")
    (gap,) = block.gaps
    assert len(block.data) + gap.missing_rows == pytest.approx(4000, abs=30)
    assert bundle.complete
    assert bundle.certificate is not None
    assert not bundle.certificate["complete"]

    checks = 0
    result = CliRunner().invoke(app, (*options, "--out", "b"))
    assert result.exit_code == 3
    assert not Bundle.open(Path("b")).complete


# ---- the command line -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        (("record", "--duration", "1", "--link", "emulated?wire=serial", "--frames"), 2, "without --frames"),
        (
            ("info", "--link", "serial:/dev/nothing"),
            3,
            "cannot open /dev/nothing: No such file or directory;",
        ),
        (("info", "--link", "serial:socket://127.0.0.1:1"), 3, "check that the serial server runs"),
        (("info", "--link", "emulated?wire=serial&node=9"), 3, "node 9 is expected"),
    ],
)
def test_mistakes(
    arguments: tuple[str, ...], code: int, complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == code
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("benchtool: ")]
    assert complaint in line
    assert list(tmp_path.iterdir()) == []


def test_a_recording_at_the_control_rate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    options = ("--duration", "1", "--rate", "10000", "--channels", ",".join(SIXTEEN), "--out", "a")
    result = CliRunner().invoke(app, ("record", *options, "--link", "emulated?wire=serial"))
    assert result.exit_code == 0, result.output
    block = Bundle.open(Path("a")).block("telemetry")
    assert (block.data.shape, block.gaps, block.sample_rate_Hz) == ((10_000, 16), (), 10_000.0)
    np.testing.assert_array_equal(block.column("tick"), block.ticks())


def test_a_recorder_that_fails_leaves_the_drive_silent(session: Session) -> None:
    def full(block: object) -> None:
        raise ValueRefused("no room")

    sink = Sink("recorder", full, lossless=True)
    with (
        pytest.raises(ValueRefused, match="no room"),
        TelemetryStream(session.drive, [sink], SIXTEEN, 10_000.0),
    ):
        session.clock.wait(0.5)
    received = session.drive.link.counters.frames_received
    session.clock.wait(0.5)
    assert session.drive.link.counters.frames_received - received <= 12, "heartbeats only"
