"""What the live view costs: `python -m benchmarks.live [--json] [--seconds N]`.

A stream of 16 channels at 10 kHz, in blocks of a fifth of a second and in real time, through a sink that may
drop into a view: written to an .rrd for N seconds, and for an eighth of that each to a viewer that takes it,
to one that is stopped, to one that is killed, and to one that is killed and started again. Processor time is
that of all threads of this process, those of Rerun among them; memory is resident, at the end over that after
a tenth of the time. The baseline, in the same run, is how many of the same rows go one by one through `log`
in a second of processor time; then the same with an entity for each channel.
"""

from __future__ import annotations

import argparse
import os
import signal
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np
import rerun as rr

from benchmarks.figures import print_figures
from benchtool.block import Block, Channel
from benchtool.clock import RealClock
from benchtool.live import Destination, FileDestination, LiveView, Setup, Viewer
from benchtool.live.messages import TimeAxis, block_columns, scalars
from benchtool.telemetry import Sink

RATE_HZ = 10_000
ROWS = 2000
GOAL_PERCENT = 20.0
_UNITS = ("A",) * 5 + ("V",) * 3 + ("rad", "rad/s", "Nm", "Nm", "Wb", "Wb", "Wb", "Wb")
_NAMES = (
    "i_a", "i_b", "i_c", "i_d", "i_q", "u_alpha", "u_beta", "u_dc", "theta_m", "omega_m", "torque",
    "torque_reference", "psi_s", "psi_s_reference", "psi_alpha", "psi_beta",
)  # fmt: skip


def block() -> Block:
    """Return a fifth of a second: a current of 10 Hz and noise everywhere, which nothing compresses."""
    random = np.random.default_rng(1)
    data = random.standard_normal((ROWS, len(_NAMES)))
    data[:, 0] += 10.0 * np.sin(2.0 * np.pi * 10.0 * np.arange(ROWS) / RATE_HZ)
    channels = tuple(Channel(name, unit) for name, unit in zip(_NAMES, _UNITS, strict=True))
    return Block(channels, 0, 1, 1.0 / RATE_HZ, data)


def resident_MB() -> float:
    """Return the memory of this process."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def stream_s(destination: Destination, seconds: float, happens: Callable[[], None]) -> dict[str, float]:
    """Send the stream in real time; `happens` is called after the first second."""
    clock, whole = RealClock(), block()
    view = LiveView(Setup("benchmark", psi_Wb=1.0), [destination])
    sink = Sink("live", view.add_block, lossless=False)
    view.count_drops(lambda: sink.rows_dropped)
    blocks = round(seconds * RATE_HZ / ROWS)
    longest_s = 0.0
    settled_MB = 0.0
    start_s, processor_s = clock.now_s(), time.process_time()
    for number in range(blocks):
        clock.wait(start_s + number * ROWS / RATE_HZ - clock.now_s())
        if number == RATE_HZ // ROWS:
            happens()
        if number == blocks // 10:
            settled_MB = resident_MB()
        before_s = clock.now_s()
        sink.put(replace(whole, first_tick=number * ROWS))
        longest_s = max(longest_s, clock.now_s() - before_s)
    processor_s = time.process_time() - processor_s
    spent_s = clock.now_s() - start_s
    grown_MB = resident_MB() - settled_MB
    sink.worker.close()
    view.close()
    sink.worker.check()
    return {
        "seconds": round(spent_s, 1),
        "percent_of_a_core": round(100.0 * processor_s / spent_s, 1),
        "memory_grown_MB": round(grown_MB, 1),
        "memory_MB": round(resident_MB(), 1),
        "rows": blocks * ROWS,
        "rows_not_shown": sink.rows_dropped + sum(view.rows_dropped.values()),
        "longest_put_ms": round(1e3 * longest_s, 2),
    }


def rows_per_s(send: Callable[[rr.RecordingStream, int], int], folder: Path) -> float:
    """Return the rows of 16 channels per second of processor time, over about a second."""
    stream = rr.RecordingStream("benchmark")
    stream.save(folder / "baseline.rrd")
    send(stream, 0)
    rows, number, start_s = 0, 1, time.process_time()
    while time.process_time() - start_s < 1.0:
        rows += send(stream, number)
        number += 1
    stream.flush()
    spent_s = time.process_time() - start_s
    stream.disconnect()
    return round(rows / spent_s)


def one_by_one(stream: rr.RecordingStream, number: int) -> int:
    """Send a hundred rows with `log`."""
    data = block().data[:100]
    for row, values in enumerate(data):
        stream.set_time("drive_tick", sequence=number * 100 + row)
        stream.log("/stream", rr.Scalars(values))
    return len(data)


def by_quantity(stream: rr.RecordingStream, number: int) -> int:
    """Send a block as the view does."""
    whole = replace(block(), first_tick=number * ROWS)
    for columns in block_columns(whole, TimeAxis(1e-4, 0, 0.0), "/stream"):
        columns.send(stream)
    return ROWS


def by_channel(stream: rr.RecordingStream, number: int) -> int:
    """Send a block with an entity for each channel."""
    whole, axis = replace(block(), first_tick=number * ROWS), TimeAxis(1e-4, 0, 0.0)
    for column, name in enumerate(whole.names):
        scalars(f"/stream/{name}", axis, whole.ticks(), whole.data[:, [column]]).send(stream)
    return ROWS


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--seconds", type=float, default=60.0, help="of the stream into a file")
    arguments = parser.parse_args()

    short_s = max(4.0, arguments.seconds / 8.0)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "live.rrd"
        result: dict[str, object] = {
            "file": stream_s(FileDestination(path, endless=True), arguments.seconds, lambda: None),
            "file_MB_per_minute": round(path.stat().st_size / 1e6 / (arguments.seconds / 60.0), 1),
        }
        with Viewer(web=True) as viewer:
            result["viewer"] = stream_s(viewer, short_s, lambda: None)
        with Viewer(web=True) as viewer:
            result["stopped_viewer"] = stream_s(
                viewer, short_s, lambda: viewer.process.send_signal(signal.SIGSTOP)
            )
        with Viewer(web=True) as viewer:
            result["killed_viewer"] = stream_s(viewer, short_s, viewer.process.kill)
        with Viewer(web=True) as viewer, ExitStack() as stack:

            def restart() -> None:
                viewer.end()
                stack.enter_context(Viewer(web=True, port=viewer.port))

            result["restarted_viewer"] = stream_s(viewer, short_s, restart)
        result |= {
            "baseline_rows_per_s_log": rows_per_s(one_by_one, Path(folder)),
            "rows_per_s_by_quantity": rows_per_s(by_quantity, Path(folder)),
            "rows_per_s_by_channel": rows_per_s(by_channel, Path(folder)),
        }
    result |= {
        "goal_percent_of_a_core": GOAL_PERCENT,
        "channels": len(_NAMES),
        "rate_Hz": RATE_HZ,
        "rerun": rr.__version__,
    }
    print_figures(result, as_json=arguments.json)


if __name__ == "__main__":
    main()
