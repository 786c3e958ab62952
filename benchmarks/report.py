"""How long a report takes: `python -m benchmarks.report [--json] [--seconds 600]`.

Two bundles, both synthetic: one as the demo leaves it (0.52 s of 12 channels at 10 kHz, and a transducer at
200 kHz) and a long one (600 s of 12 channels at 10 kHz). Measured is what `benchtool report` does, from
opening the bundle to the bytes of the page and, apart, of the PDF: reading, measuring again, drawing,
hashing, setting. The baseline, measured in the same run, is the unavoidable part: reading the bundle's data.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import print_figures
from benchtool.analysis import Measurement
from benchtool.analysis.measurement import measurements_to_json
from benchtool.block import Block, Channel
from benchtool.plan.model import Plan
from benchtool.profile import load_profile, profile_path
from benchtool.recording import Bundle, BundleWriter, Manifest
from benchtool.report.assembly.run import run_report
from benchtool.report.html import html_page
from benchtool.report.pdf.document import pdf_document
from benchtool.results.runs import recorded_runs

RATE_HZ, P, OMEGA_M_RAD_S = 10_000.0, 4, 15.71
SHORT_S = 0.52
OVERSAMPLING = 20
RUNS = 3
GOAL_S = 10.0


def capture(seconds: float) -> Block:
    """Return a machine in steady state: 12 channels with noise, one peak of one sample in the torque."""
    rows = round(seconds * RATE_HZ)
    random = np.random.default_rng(1)
    theta_m = OMEGA_M_RAD_S * np.arange(rows) / RATE_HZ
    theta_e = P * theta_m

    def noisy(values: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
        return np.asarray(values + scale * random.standard_normal(rows))

    torque = noisy(np.full(rows, 0.65), 0.008)
    torque[rows // 2] += 0.2
    columns = {
        Channel("i_a", "A"): noisy(0.643 * np.cos(theta_e), 0.01),
        Channel("i_b", "A"): noisy(0.643 * np.cos(theta_e - 2 * np.pi / 3), 0.01),
        Channel("i_c", "A"): noisy(0.643 * np.cos(theta_e + 2 * np.pi / 3), 0.01),
        Channel("torque", "Nm"): torque,
        Channel("torque_reference", "Nm"): np.full(rows, 0.65),
        Channel("psi_s", "Wb"): noisy(np.full(rows, 0.1686), 1e-3),
        Channel("psi_alpha", "Wb"): noisy(0.1686 * np.cos(theta_e), 1e-3),
        Channel("psi_beta", "Wb"): noisy(0.1686 * np.sin(theta_e), 1e-3),
        Channel("theta_m", "rad"): np.mod(theta_m, 2 * np.pi),
        Channel("omega_m", "rad/s"): noisy(np.full(rows, OMEGA_M_RAD_S), 0.01),
        Channel("switching_count", ""): np.arange(rows, dtype=np.float64),
        Channel("adc_saturated", ""): np.zeros(rows),
    }
    return Block(tuple(columns), 0, 1, 1.0 / RATE_HZ, np.column_stack(list(columns.values())))


def transducer(seconds: float) -> Block:
    """Return the shaft's torque, `OVERSAMPLING` times as fast."""
    rows = round(seconds * RATE_HZ * OVERSAMPLING)
    torque = 0.65 + 0.05 * np.random.default_rng(2).standard_normal(rows)
    return Block(
        (Channel("torque_transducer", "Nm"),), 0, 1, 1.0 / RATE_HZ / OVERSAMPLING, torque[:, np.newaxis]
    )


def write_bundle(folder: Path, seconds: float, *, with_transducer: bool) -> None:
    """A bundle of a plan, as a run leaves it."""
    profile = load_profile("zhu2011")
    plan = Plan.model_validate(
        {
            "title": f"{seconds:g} s of synthetic steady state",
            "profile": "zhu2011",
            "operating_point": {"omega_m_rad_s": OMEGA_M_RAD_S, "load_torque_Nm": 0.65},
            "record": {"duration_s": seconds, "channels": ("torque",)},
            "limits": {"torque_ripple_pp": {"max": 1.0}},
        }
    )
    manifest = Manifest(
        what=plan.title,
        when="2000-01-01T00:00:00+00:00",
        profile_name="zhu2011",
        profile_toml=profile_path("zhu2011").read_text(encoding="utf-8"),
        details={
            "case": "synthetic",
            "plan": plan.model_dump(mode="json"),
            "motor": profile.motor.model_dump(mode="json"),
        },
    )
    quality = measurements_to_json(
        [Measurement("capture_rows_missing", 0.0, "", "rows expected less received")]
    )
    with BundleWriter(folder, manifest) as bundle:
        bundle.append("capture", capture(seconds))
        if with_transducer:
            bundle.append("transducer", transducer(seconds))
        bundle.finish(certificate={"complete": True, "measurements": quality})


def measure(folder: Path) -> dict[str, float]:
    """Return the seconds of wall time: reading alone, the page, and the PDF on top of the same content."""
    start = time.perf_counter()
    bundle = Bundle.open(folder)
    for stream in bundle.streams:
        bundle.block(stream)
    read = time.perf_counter()
    report = run_report(folder, recorded_runs(folder))
    content = time.perf_counter()
    page = html_page(report)
    written = time.perf_counter()
    document = pdf_document(report)
    end = time.perf_counter()
    return {
        "read_s": read - start,
        "page_s": written - read,
        "with_pdf_s": end - read,
        "of_it_content_s": content - read,
        "page_megabytes": len(page) / 1e6,
        "pdf_megabytes": len(document) / 1e6,
    }


def best(folder: Path, runs: int) -> dict[str, float]:
    """Return the fastest of some runs, with its ratio to reading."""
    found = min((measure(folder) for _ in range(runs)), key=lambda each: each["with_pdf_s"])
    ratio = {"page_over_reading": found["page_s"] / found["read_s"]}
    return {name: round(value, 3) for name, value in (found | ratio).items()}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--seconds", type=float, default=600.0, help="length of the long recording")
    options = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        short, long = Path(folder) / "short", Path(folder) / "long"
        write_bundle(short, SHORT_S, with_transducer=True)
        write_bundle(long, options.seconds, with_transducer=False)
        measure(short)  # imports and fonts, once
        results = {"short": best(short, RUNS), "long": best(long, 2)}
    result = {
        **{f"{name}_{key}": value for name, found in results.items() for key, value in found.items()},
        "goal_s": GOAL_S,
        "long_recording_s": options.seconds,
        "peak_rss_megabytes": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3),
    }
    print_figures(result, as_json=options.json)


if __name__ == "__main__":
    main()
