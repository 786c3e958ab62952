"""How fast the emulated drive is against real time: `python -m benchmarks.emulator [--json]`.

Measured is the closed loop at 0.1 of rated speed against 0.65 Nm: TPC at 10 kHz, the machine integrated
between switching edges, noisy 10-bit sensors, a capture of 12 channels under way. The baseline, in the same
run, is the same kernel on the same inputs as plain Python, which its sources are without the compiler. What
the parts of a bench cost is measured against the ideal one, turn by turn in this process.
Processor time of this one thread counts, so that a neighbour on the machine does not.
"""

from __future__ import annotations

import argparse
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable, Mapping
from typing import Any

from benchmarks.figures import print_figures
from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.sensor_truth import SensorTruth
from benchtool.emulator.machine.train_truth import NOTHING, TrainTruth
from benchtool.emulator.machine.truth import InverterTruth, MotorTruth
from benchtool.protocol.dictionary.objects import table_from_toml
from benchtool.protocol.modes import Mode
from benchtool.shipped import shipped

CHANNELS = [
    "tick", "i_a", "i_b", "i_c", "u_alpha", "u_beta", "theta_m", "omega_m", "torque", "torque_reference",
    "psi_s", "switching_count",
]  # fmt: skip
TICKS = 20_000
RUNS = 15
PARTS: dict[str, tuple[dict[str, float], dict[str, float]]] = {  # of the motor, of the inverter
    "coulomb": ({"coulomb_Nm": 0.02}, {}),
    "stribeck": ({"coulomb_Nm": 0.02, "breakaway_Nm": 0.03, "stribeck_rad_s": 5.0}, {}),
    "cogging": ({"cogging_Nm": 0.02, "cogging_order": 12}, {}),
    "dead_time": ({}, {"dead_time_s": 2e-6}),
    "devices": ({}, {"device_drop_V": 1.0, "on_resistance_ohm": 0.02}),
    "timer": ({}, {"timer_Hz": 100e6}),
    "harmonics": ({"psi_5_Wb": 4e-3, "psi_7_Wb": 2e-3}, {}),
    "dc_link": ({}, {"dc_link_R_ohm": 0.5, "dc_link_C_F": 1e-3}),
}
BASELINE_TICKS = 300
GOAL = 250.0  # times real time

_START = """
import time
from benchmarks.emulator import paper_machine
core = paper_machine()
start = time.perf_counter()
core.run(1)
print(time.perf_counter() - start)
"""


def paper_machine(
    motor: Mapping[str, Any] = {}, inverter: Mapping[str, Any] = {}, train: TrainTruth = NOTHING
) -> Core:
    """Return the paper's machine with its drive set up and switched on, and with these flaws."""
    document = (shipped("firmware_protocol") / "objects.toml").read_text(encoding="utf-8")
    core = Core(
        table_from_toml(tomllib.loads(document)),
        MotorTruth(
            pole_pairs=4,
            R_s_ohm=0.123,
            L_d_H=9.52e-3,
            L_q_H=9.52e-3,
            psi_r_Wb=0.1685,
            J_kgm2=13.1e-4,
            **motor,
        ),
        InverterTruth(u_dc_V=122.5, **inverter),
        SensorTruth(i_full_scale_A=15.0, u_full_scale_V=500.0, current_noise_A_rms=0.015),
        seed=1,
        train=train,
    )
    believed = {
        "pole_pairs": 4, "R_s": 0.123, "L_d": 9.52e-3, "L_q": 9.52e-3, "psi_r": 0.1685, "J": 13.1e-4,
        "T_N": 9.55, "omega_m_N": 157.1, "u_s": 81.65, "T_k_ratio": 0.7, "K_p_speed": 0.04, "K_i_speed": 0.4,
        "torque_limit": 9.55, "omega_observer": 160.0, "i_trip": 14.5, "omega_m_trip": 220.0,
        "u_dc_min": 50.0, "u_dc_max": 400.0, "omega_m_command": 15.71,
    }  # fmt: skip
    for name, value in believed.items():
        core.memory[name] = value
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.load.torque_Nm = 0.65
    return core


def capture(core: Core, ticks: int) -> None:
    """Log every tick of the next `ticks`."""
    core.capture.arm(names=CHANNELS, rows=ticks)


def cpu_s(core: Core, ticks: int, run: Callable[[int], int]) -> float:
    """Return the processor time of `ticks` logged ticks."""
    capture(core, ticks)
    start = time.thread_time()
    ran = run(ticks)
    elapsed = time.thread_time() - start
    if ran != ticks:
        raise SystemExit(
            f"the drive tripped after {ran} of {ticks} ticks: the benchmark is of normal running"
        )
    return elapsed


def speeds_with_parts() -> dict[str, float]:
    """Return speed with each part of `PARTS`, and with all of them, as a share of that of the ideal bench."""
    whole = [{key: value for part in PARTS.values() for key, value in part[k].items()} for k in (0, 1)]
    cores = {
        "ideal": paper_machine(),
        **{f"speed_with_{name}": paper_machine(*part) for name, part in PARTS.items()},
        "speed_with_all_parts": paper_machine(*whole),
    }
    best = dict.fromkeys(cores, math.inf)
    for _ in range(RUNS):
        for name, core in cores.items():
            best[name] = min(best[name], cpu_s(core, TICKS // 10, core.run))
    ideal = best.pop("ideal")
    return {name: round(ideal / each, 3) for name, each in best.items()}


def start_s(cache: str) -> float:
    """Return the time of the first tick in a new process that caches in the folder `cache`."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-c", _START]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    as_json = parser.parse_args().json

    with tempfile.TemporaryDirectory() as cache:
        cold_s, warm_s = start_s(cache), start_s(cache)

    core = paper_machine()
    core.run(TICKS)
    simulated_s = TICKS * core.control_period_s
    factors = sorted(simulated_s / cpu_s(core, TICKS, core.run) for _ in range(RUNS))

    plain = paper_machine()
    plain.run(TICKS)
    python_s = cpu_s(plain, BASELINE_TICKS, lambda ticks: plain.run_with(run_ticks, ticks))
    python_factor = BASELINE_TICKS * plain.control_period_s / python_s

    result = {
        "x_real_time_best": round(factors[-1], 1),
        "x_real_time_median": round(statistics.median(factors), 1),
        "x_real_time_worst": round(factors[0], 1),
        "ns_per_tick_best": round(1e9 * core.control_period_s / factors[-1], 1),
        "goal_x_real_time": GOAL,
        "baseline_plain_python_x_real_time": round(python_factor, 4),
        "speedup_over_plain_python": round(factors[-1] / python_factor),
        "first_tick_compiling_s": round(cold_s, 2),
        "first_tick_cached_s": round(warm_s, 2),
        "ticks_per_run": TICKS,
        "runs": RUNS,
        "channels_captured": len(CHANNELS),
        **speeds_with_parts(),
    }
    print_figures(result, as_json=as_json)


if __name__ == "__main__":
    main()
