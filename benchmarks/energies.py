"""Whether the energy accounts balance: `python -m benchmarks.energies [--json]`.

Emulated benches of random values, with every part that has an account: link with capacitor, ripple and brake
chopper, dead time, devices, saturation, phases that differ, iron loss, heat, dry friction, cogging, a
coupling with play, and a load machine that gives way. The drive accelerates, brakes into the link and is
switched off under current. Told is the largest imbalance of each balance, over all that was moved.
"""

from __future__ import annotations

import argparse
import time
import tomllib
from typing import Any, Final

import numpy as np

from benchmarks.figures import print_figures
from benchtool.emulator.core import Core
from benchtool.emulator.machine.heat import HeatTruth
from benchtool.emulator.machine.saturation import SaturationTruth
from benchtool.emulator.machine.sensor_truth import SensorTruth
from benchtool.emulator.machine.train_truth import LoadMachineTruth, LoadTruth, ShaftTruth, TrainTruth
from benchtool.emulator.machine.truth import InverterTruth, MotorTruth
from benchtool.errors import EmulationError
from benchtool.protocol.dictionary.objects import ObjectTable, table_from_toml
from benchtool.protocol.modes import Mode
from benchtool.shipped import shipped

BALANCES: Final = {
    "supply": ("link_resistance", "chopper", "capacitor", "dc"),
    "dc": ("copper", "iron", "inverter", "friction", "shaft", "magnetic", "kinetic"),
    "shaft": ("coupling", "twist", "load_kinetic", "load"),
}
T_S: Final = 1e-4
U_DC: Final = 122.5


def bench(table: ObjectTable, rng: np.random.Generator, seed: int) -> Core:
    """Return a bench of random values, whose drive is set up for the paper's machine."""

    def about(value: float) -> float:
        return value * float(np.exp(rng.uniform(-0.5, 0.5)))

    motor = MotorTruth(
        pole_pairs=4,
        R_s_ohm=about(0.123),
        L_d_H=about(9e-3),
        L_q_H=about(11e-3),
        psi_r_Wb=0.1685,
        J_kgm2=about(1.3e-3),
        friction_Nms=about(1e-3),
        coulomb_Nm=about(0.05),
        breakaway_Nm=about(0.1),
        stribeck_rad_s=about(3.0),
        psi_5_Wb=about(2e-3),
        psi_of_phase=(1.0, 1.01, 0.99),
        series_R_ohm=(0.0, about(0.02), 0.0),
        series_L_H=(0.0, about(2e-4), 0.0),
        cogging_Nm=about(0.05),
        cogging_order=24,
        R_fe_ohm=about(80.0),
        saturation=SaturationTruth(a_dd=about(3e4), a_qq=about(4e2), a_dq=about(2e2), S=5, T=1, U=1, V=1),
        heat=HeatTruth(
            C_winding_J_K=about(20.0),
            C_body_J_K=about(200.0),
            R_winding_body_K_W=about(1.0),
            R_body_ambient_K_W=about(3.0),
        ),
    )
    inverter = InverterTruth(
        u_dc_V=U_DC,
        dc_link_R_ohm=about(0.3),
        dc_link_C_F=about(5e-4),
        supply_ripple_V=about(1.0),
        supply_ripple_Hz=300.0,
        chopper_R_ohm=about(10.0),
        chopper_on_V=130.0,
        chopper_off_V=126.0,
        dead_time_s=about(2e-6),
        device_drop_V=about(1.0),
        on_resistance_ohm=about(0.02),
    )
    train = TrainTruth(
        shaft=ShaftTruth(
            J_load_kgm2=about(2e-3),
            coupling_Nm_rad=about(200.0),
            coupling_Nms=about(0.05),
            backlash_rad=about(5e-3),
            unbalance_kgm=about(2e-3),
        ),
        load=LoadTruth(linear_Nms=about(1e-3), quadratic_Nms2=about(1e-5)),
        load_machine=LoadMachineTruth(bandwidth_Hz=about(100.0), stiffness_Nms=about(0.5)),
    )
    core = Core(
        table, motor, inverter, SensorTruth(i_full_scale_A=40.0, u_full_scale_V=500.0), seed, 0, train
    )
    believed = {"pole_pairs": 4, "R_s": 0.123, "L_d": 9.5e-3, "L_q": 9.5e-3, "psi_r": 0.1685, "J": 3e-3}
    limits = {"i_trip": 40.0, "omega_m_trip": 400.0, "u_dc_min": 20.0, "u_dc_max": 400.0}
    control = {"encoder_lines": 2500, "u_s": 70.0, "T_k_ratio": 0.7, "K_p_speed": 0.2, "K_i_speed": 2.0}
    rating = {"T_N": 9.55, "omega_m_N": 157.1, "torque_limit": 9.55, "omega_observer": 160.0}
    for name, value in (believed | limits | control | rating).items():
        core.memory[name] = value
    core.command.mode = int(Mode.TORQUE)
    return core


def run(core: Core, rng: np.random.Generator) -> None:
    """Accelerate, brake and switch off under current, with other torques each time; loads come and go."""
    for _ in range(4):
        for torque in (rng.uniform(1.0, 5.0), -rng.uniform(1.0, 5.0)):
            core.command.trip, core.command.pwm_enabled = 0, 1
            core.memory["torque_command"] = torque
            core.load.torque_Nm = rng.uniform(-0.5, 0.5)
            core.run(1500)
        core.command.pwm_enabled = 0
        core.run(200)


def imbalances(core: Core) -> dict[str, float]:
    """Return what each balance leaves over, over all that was moved."""
    energy = core.energies.now_J()
    moved = sum(abs(value) for value in energy.values())
    return {
        drawn: abs(energy[drawn] - sum(energy[part] for part in parts)) / moved
        for drawn, parts in BALANCES.items()
    }


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--benches", type=int, default=20, help="random ones")
    parser.add_argument("--seed", type=int, default=1, help="of the draws")
    options = parser.parse_args()
    begin = time.perf_counter()
    document = (shipped("firmware_protocol") / "objects.toml").read_text(encoding="utf-8")
    table, rng = table_from_toml(tomllib.loads(document)), np.random.default_rng(options.seed)
    found: list[dict[str, float]] = []
    figures: dict[str, Any] = {"benches": options.benches, "ran_away": 0}
    moved: dict[str, float] = {}
    for seed in range(options.benches):
        core = bench(table, rng, seed)
        try:
            run(core, rng)
        except EmulationError:
            figures["ran_away"] += 1
            continue
        found.append(imbalances(core))
        for name, value in core.energies.now_J().items():
            moved[name] = max(moved.get(name, 0.0), abs(value))
    figures |= {f"largest_imbalance_{name}": max(each[name] for each in found) for name in BALANCES}
    figures |= {f"largest_{name}_J": round(value, 4) for name, value in moved.items()}
    figures["seconds"] = round(time.perf_counter() - begin, 1)
    print_figures(figures, as_json=options.json)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
