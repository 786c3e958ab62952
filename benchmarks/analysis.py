"""How fast a long capture is analysed, and in how much memory: `python -m benchmarks.analysis [--json]`.

Measured is every analysis of a steady state (`measure_all`: ripple, spectrum, distortion, groups,
orders, torque residual) of a synthetic capture of 12 channels at 10 kHz, 600 s long: a current with
harmonics, a torque with ripple and an encoder angle, all with noise, rounded to float32 as on the wire.
Every figure is from a process of its own, so that its peak memory is its own too. The baseline, in the same
run, is one Welch spectrum (scipy.signal.welch, 4096 samples a segment) of each of the 12 channels. Reading
the same capture back from a run bundle is measured apart.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from benchmarks.figures import print_figures
from benchtool.analysis.window import Window
from benchtool.block import Block, Channel
from benchtool.plan.analyses import Analyses
from benchtool.profile import load_profile
from benchtool.recording import Bundle, BundleWriter, Manifest
from benchtool.results.analyses import measure_all, planned

RATE_HZ = 10_000
SECONDS = 600
RUNS = 5
GOAL_S = 2.0
GOAL_MB = 1500.0
MOTOR = load_profile("zhu2011").motor
FREQUENCY_HZ = 10.013  # no whole number of samples a period
ENCODER_COUNTS = 10_000
BATCH = 1000
CHANNELS = {
    "i_a": "A", "i_b": "A", "i_c": "A", "i_d": "A", "i_q": "A", "u_alpha": "V", "u_beta": "V",
    "theta_m": "rad", "omega_m": "rad/s", "torque": "Nm", "psi_s": "Wb", "switching_count": "",
}  # fmt: skip
Figures = dict[str, float]


def capture(seconds: int) -> Block:
    """Return a synthetic capture, each channel contiguous."""
    random, rows = np.random.default_rng(1), seconds * RATE_HZ
    data = np.empty((rows, len(CHANNELS)), order="F")
    for start in range(0, rows, RATE_HZ):
        part = slice(start, start + RATE_HZ)
        number = np.arange(start, start + RATE_HZ)
        theta_e = 2 * np.pi * FREQUENCY_HZ / RATE_HZ * number
        for column, values in enumerate(_channels(number, theta_e).values()):
            noise = 0.003 * random.standard_normal(RATE_HZ)
            data[part, column] = (values + noise).astype(np.float32)
        step = 2 * np.pi / ENCODER_COUNTS
        turned = np.floor(np.mod(theta_e / MOTOR.pole_pairs, 2 * np.pi) / step) * step
        data[part, list(CHANNELS).index("theta_m")] = turned.astype(np.float32)
        data[part, list(CHANNELS).index("switching_count")] = 3 * number
    return Block(tuple(Channel(*each) for each in CHANNELS.items()), 0, 1, 1.0 / RATE_HZ, data)


def _channels(number: NDArray[np.int64], theta_e: NDArray[np.floating[Any]]) -> dict[str, Any]:
    phases = {
        f"i_{phase}": 0.64 * np.cos(theta_e - turn) + 0.006 * np.cos(5 * (theta_e - turn))
        for phase, turn in (("a", 0.0), ("b", 2 * np.pi / 3), ("c", 4 * np.pi / 3))
    }
    voltages = {"u_alpha": 20 * np.cos(theta_e), "u_beta": 20 * np.sin(theta_e)}
    torque = {"torque": 0.65 + 0.02 * np.cos(6 * theta_e), "psi_s": 0.17}
    known: dict[str, Any] = {**phases, **voltages, **torque, "i_q": 0.64, "omega_m": 15.7}
    return {name: known.get(name, 0.0) for name in CHANNELS}


def peak_MB() -> float:
    """Return the most memory that this process has held, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def analyse(seconds: int, folder: str) -> Figures:
    """Return the time of each of some analyses of a block in memory; the first is apart."""
    block = capture(seconds)
    before = peak_MB()
    processor = time.process_time()
    times = [_analyse_s(block) for _ in range(RUNS + 1)]
    processor = (time.process_time() - processor) / len(times)
    return {
        "processor_s": processor,
        "first_s": times[0],
        "best_s": min(times[1:]),
        "median_s": statistics.median(times[1:]),
        "worst_s": max(times[1:]),
        "block_and_imports_MB": before,
        "peak_rss_MB": peak_MB(),
    }


def welch(seconds: int, folder: str) -> Figures:
    """Return the best time of a Welch spectrum of every channel."""
    block = capture(seconds)
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        for name in block.names:
            signal.welch(block.column(name), block.sample_rate_Hz, nperseg=4096)
        times.append(time.perf_counter() - start)
    return {"best_s": min(times)}


def write(seconds: int, folder: str) -> Figures:
    """Record the capture as a finished bundle."""
    block = capture(seconds)
    with BundleWriter(Path(folder), Manifest(what="benchmark", when="2000-01-01T00:00:00+00:00")) as bundle:
        for start in range(0, len(block.data), BATCH):
            rows = block.data[start : start + BATCH]
            bundle.append("capture", Block(block.channels, start, 1, block.tick_s, rows))
        bundle.finish()
    return {}


def read(seconds: int, folder: str) -> Figures:
    """Return the time of reading the bundle, once, and of one analysis of what was read."""
    start = time.perf_counter()
    block = Bundle.open(Path(folder)).block("capture")
    read_s = time.perf_counter() - start
    if len(block.data) != seconds * RATE_HZ:
        raise SystemExit(f"{len(block.data)} rows of {seconds} s: the benchmark is of whole recordings")
    return {"read_s": read_s, "analysis_s": _analyse_s(block), "peak_rss_MB": peak_MB()}


def _analyse_s(block: Block) -> float:
    start = time.perf_counter()
    measure_all(tuple(planned(Analyses(), Window.of(block, MOTOR), None)))
    return time.perf_counter() - start


def apart(function: Callable[[int, str], Figures], seconds: int, folder: str = "") -> Figures:
    """Return what a function measures in a new process."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, (seconds, folder))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--seconds", type=int, default=SECONDS, help="length of the capture")
    options = parser.parse_args()

    analysed, baseline = apart(analyse, options.seconds), apart(welch, options.seconds)
    with tempfile.TemporaryDirectory() as folder:
        bundle = str(Path(folder) / "bundle")
        apart(write, options.seconds, bundle)
        reread = apart(read, options.seconds, bundle)
    result: dict[str, float | str] = {
        "analysis_s_best": round(analysed["best_s"], 2),
        "analysis_s_median": round(analysed["median_s"], 2),
        "analysis_s_worst": round(analysed["worst_s"], 2),
        "analysis_s_first": round(analysed["first_s"], 2),
        "analysis_processor_s_mean": round(analysed["processor_s"], 2),
        "goal_s": GOAL_S,
        "peak_rss_MB": round(analysed["peak_rss_MB"]),
        "peak_rss_MB_of_block_and_imports": round(analysed["block_and_imports_MB"]),
        "goal_MB": GOAL_MB,
        "baseline_welch_of_all_channels_s": round(baseline["best_s"], 2),
        "ratio_to_baseline": round(analysed["best_s"] / baseline["best_s"], 2),
        "bundle_read_s": round(reread["read_s"], 2),
        "bundle_analysis_s": round(reread["analysis_s"], 2),
        "bundle_peak_rss_MB": round(reread["peak_rss_MB"]),
        "seconds_of_capture": options.seconds,
        "rate_Hz": RATE_HZ,
        "channels": len(CHANNELS),
        "runs": RUNS,
    }
    print_figures(result, as_json=options.json)


if __name__ == "__main__":
    main()
