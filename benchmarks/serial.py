"""What a full-rate stream over a serial line costs: `python -m benchmarks.serial [--json] [--seconds N]`.

16 channels of float32 at 10 kHz, 650 kB/s, come in real time from a process of their own over a
pseudo-terminal, in messages of up to 1400 bytes as a microcontroller would send them. Measured are the
records that were lost and the processor time of this process, all threads, as a share of one core, for

    recording   port, link, decoder, fan-out and the Arrow stream of a bundle on disk
    baseline    the same bytes read from the port and thrown away

The drive's end keeps what the terminal does not take for a tenth of a second, and drops what comes then: a
machine that is busy with something else for longer shows as records dropped by the drive. Converting the
bundle to Parquet afterwards is timed by itself.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.figures import print_figures
from benchmarks.recording import CHANNELS, RATE_HZ
from benchtool.clock import RealClock
from benchtool.drive import RemoteDrive
from benchtool.link.port import PyserialPort
from benchtool.link.serial.link import SerialLink
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.serial import Stream, encode_frame, encode_message
from benchtool.recording import BundleWriter, Manifest
from benchtool.shipped import shipped
from benchtool.telemetry import record_stream

MAX_REPLY_BYTES = 1400
GOAL_PERCENT = 15.0
_BASELINE_S = 10.0
_STEP_S = 0.25
_SECONDS = 60.0


@contextmanager
def drive_end(max_reply: int) -> Iterator[str]:
    """A streaming drive in a process of its own; yields the name of its terminal."""
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.serial_drive", str(max_reply)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        yield process.stdout.readline().strip()
    finally:
        process.stdin.close()
        process.stdout.close()
        process.wait()


def record(terminal: str, seconds: float, folder: Path) -> dict[str, float]:
    """Return the shares and losses of a recording."""
    dictionary = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
    clock = RealClock()
    manifest = Manifest(what="benchmark", when="2000-01-01T00:00:00+00:00")
    with (
        SerialLink(PyserialPort(terminal), 1, clock) as link,
        BundleWriter(folder, manifest) as bundle,
        RemoteDrive(link, dictionary, "drive.eds", clock) as drive,
    ):
        with record_stream(drive, bundle, CHANNELS, RATE_HZ) as stream:
            wall_s, processor_s = time.perf_counter(), time.process_time()
            while time.perf_counter() - wall_s < seconds:
                clock.wait(_STEP_S)
                stream.check()
            wall_s, processor_s = time.perf_counter() - wall_s, time.process_time() - processor_s
        report = stream.report()
        counters = link.counters
        start_s = time.process_time()
        bundle.finish()
        converting_s = time.process_time() - start_s
    if report.expected is None or report.drive_dropped is None:
        raise SystemExit("the drive's end of the benchmark does not tell what it sent")
    return {
        "percent_of_a_core": round(100.0 * processor_s / wall_s, 2),
        "records_expected": report.expected,
        "records_received": report.counters.received,
        "records_lost": report.expected - report.counters.received,
        "records_dropped_by_the_drive": report.drive_dropped,
        "gaps": len(report.gaps),
        "frames_dropped": counters.frames_dropped,
        "host_queue_drops": report.frames_dropped,
        "jitter_max_ms": round(1e3 * report.jitter_max_s, 2),
        "converting_percent_of_a_core": round(100.0 * converting_s / wall_s, 2),
    }


def read_only(terminal: str, seconds: float) -> dict[str, float]:
    """Return the share of reading the same bytes without processing."""
    rows = (MAX_REPLY_BYTES - 14) // (4 * len(CHANNELS))
    port = PyserialPort(terminal)
    try:
        mappings = tuple(range(len(CHANNELS)))
        port.write(encode_frame(encode_message(Stream(1, 1, rows, mappings=mappings))))
        taken = 0
        wall_s, processor_s = time.perf_counter(), time.process_time()
        while time.perf_counter() - wall_s < seconds:
            taken += len(port.read())
        wall_s, processor_s = time.perf_counter() - wall_s, time.process_time() - processor_s
    finally:
        port.close()
    return {
        "baseline_percent_of_a_core": round(100.0 * processor_s / wall_s, 2),
        "kilobytes_per_s": round(taken / wall_s / 1e3, 1),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--seconds", type=float, default=_SECONDS, help="length of the recording")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        with drive_end(MAX_REPLY_BYTES) as terminal:
            recorded = record(terminal, arguments.seconds, Path(folder) / "bundle")
        with drive_end(MAX_REPLY_BYTES) as terminal:
            baseline = read_only(terminal, min(_BASELINE_S, arguments.seconds))
    ratio = recorded["percent_of_a_core"] / baseline["baseline_percent_of_a_core"]
    result = {
        **recorded,
        **baseline,
        "cost_over_baseline": round(ratio, 2),
        "goal_percent_of_a_core": GOAL_PERCENT,
        "channels": len(CHANNELS),
        "rate_Hz": RATE_HZ,
        "seconds": arguments.seconds,
    }
    print_figures(result, as_json=arguments.json)


if __name__ == "__main__":
    main()
