"""What a first run on a computer takes to compile: `python -m benchmarks.compilation [--json] [NAME ...]`.

Each bench runs its first tick in a process of its own with an empty cache, where control and kernel are
compiled; `warm` is a second process, which loads them. Processor time counts, so that a neighbour on the
machine matters little; the ratios are to the ideal bench of the same run.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from typing import Any

from benchmarks.emulator import paper_machine
from benchmarks.figures import print_figures
from benchtool.emulator.core import Core
from benchtool.emulator.machine.heat import HeatTruth
from benchtool.emulator.machine.saturation import SaturationTruth
from benchtool.emulator.machine.train_truth import NOTHING, LoadMachineTruth, ShaftTruth, TrainTruth

_MACHINE: dict[str, dict[str, Any]] = {
    "ideal": {},
    "harmonics": {"psi_5_Wb": 4e-3, "psi_7_Wb": 2e-3},
    "saturation": {"saturation": SaturationTruth(a_dd=1e3, a_qq=1e2, a_dq=1e2)},
}
_EVERYTHING: dict[str, Any] = {
    **_MACHINE["harmonics"],
    **_MACHINE["saturation"],
    "psi_of_phase": (1.0, 1.01, 0.99),
    "series_R_ohm": (0.0, 0.01, 0.0),
    "R_fe_ohm": 500.0,
    "coulomb_Nm": 0.02,
    "breakaway_Nm": 0.03,
    "stribeck_rad_s": 5.0,
    "cogging_Nm": 0.02,
    "cogging_order": 12,
    "heat": HeatTruth(C_winding_J_K=20.0, C_body_J_K=500.0, R_winding_body_K_W=0.8, R_body_ambient_K_W=2.0),
}
_INVERTER: dict[str, Any] = {
    "dead_time_s": 2e-6,
    "device_drop_V": 1.0,
    "on_resistance_ohm": 0.02,
    "timer_Hz": 100e6,
    "dc_link_R_ohm": 0.5,
    "dc_link_C_F": 1e-3,
}
_TRAIN = TrainTruth(
    shaft=ShaftTruth(J_load_kgm2=1e-3, coupling_Nm_rad=1e3, coupling_Nms=0.01, backlash_rad=1e-3),
    load_machine=LoadMachineTruth(bandwidth_Hz=300.0, stiffness_Nms=1.0),
)
NAMES = (*_MACHINE, "drive_train", "everything")

_FIRST_TICK = """
import sys, time
from benchmarks.compilation import bench
core = bench(sys.argv[1])
start = time.process_time()
core.run(1)
print(time.process_time() - start)
"""


def bench(name: str) -> Core:
    """Return the paper's machine on the bench of this name."""
    if name == "everything":
        return paper_machine(_EVERYTHING, _INVERTER, _TRAIN)
    if name == "drive_train":
        return paper_machine(train=_TRAIN)
    return paper_machine(_MACHINE[name], train=NOTHING)


def first_tick_s(name: str, cache: str) -> float:
    """Return the processor time of the first tick in a new process that caches in the folder `cache`."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-c", _FIRST_TICK, name]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}; all by default")
    asked = parser.parse_args()
    unknown = set(asked.names) - set(NAMES)
    if unknown:
        parser.error(f"{', '.join(sorted(unknown))}: one of {', '.join(NAMES)} is needed")

    figures: dict[str, object] = {}
    cold_s: dict[str, float] = {}
    for name in asked.names or NAMES:
        with tempfile.TemporaryDirectory() as cache:
            cold_s[name], warm_s = first_tick_s(name, cache), first_tick_s(name, cache)
        figures[f"{name}_cpu_s"] = round(cold_s[name], 1)
        figures[f"{name}_warm_cpu_s"] = round(warm_s, 2)
        if "ideal" in cold_s:
            figures[f"{name}_over_ideal"] = round(cold_s[name] / cold_s["ideal"], 2)
    print_figures(figures, as_json=asked.json)


if __name__ == "__main__":
    main()
