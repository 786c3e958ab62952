"""How fast telemetry is decoded and recorded: `python -m benchmarks.recording [--json]`.

Measured, against real time, is a full-rate stream of 16 channels of float32 at 10 kHz: batches with header
and CRC-32 as bytes, decoded into Blocks, through the fan-out and its threads, into the Arrow stream of a
bundle on disk. The baseline, measured in the same run, is the unavoidable part: the CRC and a view of the
bytes.
The second figure is the slow stream: PDOs per second through the decoder, against a loop that only tells
their identifiers apart. Processor time of all threads counts, so that a neighbour on the machine does not.
"""

from __future__ import annotations

import argparse
import statistics
import struct
import tempfile
import time
import zlib
from pathlib import Path

import numpy as np

from benchmarks.figures import print_figures
from benchtool.protocol.capture_data import CaptureHeader, decode_capture, encode_capture
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.telemetry import RecordDecoder, stream_layout
from benchtool.recording import BundleWriter, Manifest
from benchtool.shipped import shipped
from benchtool.telemetry import FanOut, Sink

RATE_HZ = 10_000
CHANNELS = (
    "i_a", "i_b", "i_c", "i_d", "i_q", "u_alpha", "u_beta", "u_dc", "theta_m", "omega_m", "torque",
    "torque_reference", "psi_s", "psi_s_reference", "psi_alpha", "psi_beta",
)  # fmt: skip
ROWS = 1000
BATCHES = 300
RECORDS = 20_000
RUNS = 7
GOAL = 50.0  # times real time

_DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)


def batches() -> list[bytes]:
    """30 s of a stream, as bytes."""
    random = np.random.default_rng(1)
    return [
        encode_capture(
            CaptureHeader(len(CHANNELS), 1, 100_000, ROWS, number * ROWS, number * ROWS, 1),
            random.standard_normal((ROWS, len(CHANNELS)), dtype=np.float32).tobytes(),
        )
        for number in range(BATCHES)
    ]


def record_s(data: list[bytes], folder: Path) -> tuple[float, float]:
    """Return the processor and wall time of decoding and recording."""
    channels = [_DICTIONARY[name] for name in CHANNELS]
    with BundleWriter(folder, Manifest(what="benchmark", when="2000-01-01T00:00:00+00:00")) as bundle:
        wall, processor = time.perf_counter(), time.process_time()
        fan_out = FanOut([Sink("recorder", lambda block: bundle.append("stream", block), lossless=True)])
        for batch in data:
            fan_out.put(decode_capture(batch, channels, sequence=1))
        fan_out.close()
        spent = time.process_time() - processor, time.perf_counter() - wall
        fan_out.check()
        return spent


def baseline_s(data: list[bytes]) -> float:
    """Return the processor time of CRC and view alone."""
    start = time.process_time()
    for batch in data:
        zlib.crc32(batch)
        np.frombuffer(batch, dtype="<f4")
    return time.process_time() - start


def pdos() -> tuple[RecordDecoder, list[tuple[int, bytes]]]:
    """Return a decoder and the PDOs of many records of the default channels."""
    layout = stream_layout(_DICTIONARY, 1, CHANNELS[:9], 1000.0, 1e-4)
    frames = []
    for number in range(RECORDS):
        stamp, value = struct.pack("<II", number * layout.stride, number), struct.pack("<f", 1.5)
        words = [stamp[:4], stamp[4:], *[value] * 9, stamp[4:]]
        frames += [(pdo.can_id, words[2 * n] + words[2 * n + 1]) for n, pdo in enumerate(layout.pdos)]
    return RecordDecoder(layout), frames


def decode_s() -> tuple[float, float, int]:
    """Return the processor time of the decoder, of the bare loop, and how many PDOs."""
    decoder, frames = pdos()
    start = time.process_time()
    for can_id, data in frames:
        decoder.feed(can_id, data, 0.0)
        if decoder.rows >= 200:
            decoder.pop_block()
    decoded = time.process_time() - start
    if decoder.counters.received != RECORDS:
        raise SystemExit(
            f"{decoder.counters.received} of {RECORDS} records: the benchmark is of whole streams"
        )
    places = {pdo.can_id: place for place, pdo in enumerate(decoder.layout.pdos)}
    start = time.process_time()
    for can_id, _ in frames:
        places.get(can_id)
    return decoded, time.process_time() - start, len(frames)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    as_json = parser.parse_args().json

    data = batches()
    streamed_s = BATCHES * ROWS / RATE_HZ
    with tempfile.TemporaryDirectory() as folder:
        runs = [record_s(data, Path(folder) / str(run)) for run in range(RUNS)]
    baseline = min(baseline_s(data) for _ in range(RUNS))
    decoding = min(decode_s() for _ in range(RUNS))
    factors = sorted(streamed_s / processor for processor, _ in runs)
    result = {
        "x_real_time_best": round(factors[-1], 1),
        "x_real_time_median": round(statistics.median(factors), 1),
        "x_real_time_worst": round(factors[0], 1),
        "x_real_time_wall_median": round(streamed_s / statistics.median(wall for _, wall in runs), 1),
        "goal_x_real_time": GOAL,
        "megabytes_per_s_best": round(sum(map(len, data)) / streamed_s * factors[-1] / 1e6, 1),
        "baseline_crc_and_view_x_real_time": round(streamed_s / baseline, 1),
        "cost_over_baseline": round(streamed_s / factors[-1] / baseline, 1),
        "pdos_per_s": round(decoding[2] / decoding[0]),
        "pdo_cost_over_bare_loop": round(decoding[0] / decoding[1], 1),
        "rows_per_batch": ROWS,
        "channels": len(CHANNELS),
        "runs": RUNS,
    }
    print_figures(result, as_json=as_json)


if __name__ == "__main__":
    main()
