"""Whether a wrong parameter is named, and whether uncertainties hold: `python -m benchmarks.balances`.

The emulated drive plays the plan zhu2011/identify with the profile's parameters. In one series a single one
of nine parameters of the machine differs, by a random amount: counted is how often that one and no other is
named, and how often its difference is within 20 % of the true one. In the other everything differs at once,
with gains and offsets of the sensors and cogging: counted is how often +-2u holds the truth.

Truth is what the sensors' common gain lets be seen: voltages as the drive reads its dc link.
"""

from __future__ import annotations

import argparse
import math
import time
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from benchmarks.figures import print_figures
from benchtool.analysis import Instruments, Window
from benchtool.analysis.balances import (
    FLUX_BALANCE,
    MOTION_BALANCE,
    Deviation,
    FluxBalanceSettings,
    MotionBalanceSettings,
    contradictions,
    deviations,
)
from benchtool.block import Block
from benchtool.emulator.control.stimulus import Quantity, Shape, StimulusState
from benchtool.emulator.core import Core
from benchtool.emulator.machine.sensor_truth import CurrentTruth, SensorTruth
from benchtool.emulator.machine.truth import InverterTruth, MotorTruth
from benchtool.errors import AnalysisError
from benchtool.plan import Plan, load_plan
from benchtool.profile import Motor, Profile, load_profile
from benchtool.protocol import Mode
from benchtool.protocol.dictionary.objects import table_from_toml
from benchtool.shipped import shipped

CHANNELS: Final = {
    **dict.fromkeys(("i_a", "i_b", "i_c"), "A"),
    **dict.fromkeys(("u_alpha", "u_beta", "u_dc"), "V"),
    "theta_m": "rad",
}
BELIEVED: Final = {"R_s": "R_s_ohm", "L_d": "L_d_H", "L_q": "L_q_H", "psi_r": "psi_r_Wb", "J": "J_kgm2"}
NINE: Final = (*BELIEVED, "encoder_offset", "dead_time_voltage", "friction", "coulomb")
SENSORS: Final = ("adc_bits", "i_full_scale_A", "u_full_scale_V", "current_noise_A_rms", "encoder_lines")
LEAST_FRICTION: Final = {"friction_Nms": 1e-9, "coulomb_Nm": 1e-6}
U_DC: Final = 122.5
T_S: Final = 1e-4


@dataclass
class Bench:
    """A machine, its inverter and its sensors, as they differ from the profile."""

    motor: dict[str, float] = field(default_factory=lambda: dict(LEAST_FRICTION))
    dead_time_s: float = 1e-12
    sensors: dict[str, Any] = field(default_factory=dict)


def capture(profile: Profile, plan: Plan, bench: Bench, seed: int) -> Block:
    """Return what the drive captures of the plan."""
    document = (shipped("firmware_protocol") / "objects.toml").read_text(encoding="utf-8")
    assert profile.emulator is not None
    stated_sensors = profile.emulator.sensors
    sensors = {key: getattr(stated_sensors, key) for key in SENSORS}
    stated = {key: getattr(profile.motor, key) for key in ("pole_pairs", *BELIEVED.values())}
    core = Core(
        table_from_toml(tomllib.loads(document)),
        MotorTruth(**{**stated, **bench.motor}),
        InverterTruth(u_dc_V=U_DC, dead_time_s=bench.dead_time_s),
        SensorTruth(**{**sensors, **bench.sensors}),
        seed,
    )
    memory = {
        "pole_pairs": 4, "T_N": 9.55, "omega_m_N": 157.1, "encoder_lines": 2500, "u_s": 81.65,
        "T_k_ratio": 0.7, "K_p_speed": 0.1, "K_i_speed": 1.0, "torque_limit": 9.55, "omega_observer": 160.0,
        "i_trip": 12.0, "omega_m_trip": 220.0, "u_dc_min": 50.0, "u_dc_max": 400.0,
    }  # fmt: skip
    memory |= {name: getattr(profile.motor, key) for name, key in BELIEVED.items()}
    for name, value in memory.items():
        core.memory[name] = value
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.run(round(plan.operating_point.settle_s / T_S))
    rows = round(plan.record.duration_s / T_S)
    core.capture.arm(names=list(CHANNELS), rows=rows)
    before = round(plan.record.pretrigger_s / T_S)
    core.run(before)
    _play(core, plan)
    if core.run(rows - before) < rows - before:
        raise SystemExit(f"the drive tripped with {bench}: the excitation is too strong")
    data = core.capture.rows().view(np.float32).astype(np.float64)
    return Block.from_arrays(1.0 / T_S, CHANNELS, **dict(zip(CHANNELS, data.T, strict=True)))


def _play(core: Core, plan: Plan) -> None:
    assert plan.stimulus is not None
    core.stimulus.quantity, core.stimulus.kind = int(Quantity.SPEED), int(Shape.CHIRP_LINEAR)
    core.stimulus.amplitude = plan.stimulus.amplitude
    core.stimulus.ticks, core.stimulus.repetitions = plan.stimulus.ticks(T_S), 1
    core.stimulus.f_start = plan.stimulus.frequency_start_Hz
    core.stimulus.f_end = plan.stimulus.frequency_end_Hz
    core.stimulus.T_s = T_S
    core.stimulus.state = StimulusState.RUNNING


def estimates(block: Block, profile: Profile) -> tuple[Deviation, ...]:
    """Return every estimate of a capture beside its belief, with the sensors that the profile states."""
    motor = profile.motor
    window = Window.of(block, motor)
    measured = [
        *FLUX_BALANCE.measure(window, FluxBalanceSettings()).measurements,
        *MOTION_BALANCE.measure(window, MotionBalanceSettings()).measurements,
    ]
    found = Instruments(profile.bench, [block]).applied(measured)
    believed = {name: float(getattr(motor, key)) for name, key in BELIEVED.items()}
    return deviations(found, believed, motor, U_DC)


def one_wrong(name: str, motor: Motor, rng: np.random.Generator) -> tuple[Bench, float]:
    """Return a bench on which one parameter is not as believed, and by how much."""
    bench, sign = Bench(), rng.choice((-1.0, 1.0))
    if name in BELIEVED:
        share = sign * (rng.uniform(0.05, 0.2) if name == "psi_r" else rng.uniform(0.1, 0.5))
        believed = float(getattr(motor, BELIEVED[name]))
        bench.motor[BELIEVED[name]] = (1.0 + share) * believed
        return bench, share * believed
    match name:
        case "encoder_offset":
            size = sign * math.radians(rng.uniform(2.0, 15.0))
            bench.sensors["encoder_offset_rad"] = -size / motor.pole_pairs
        case "dead_time_voltage":
            bench.dead_time_s = rng.uniform(0.5e-6, 3e-6)
            size = bench.dead_time_s / T_S * U_DC
        case "friction":
            size = bench.motor["friction_Nms"] = (
                rng.uniform(0.01, 0.05) * motor.T_N_Nm / motor.omega_m_N_rad_s
            )
        case _:
            size = bench.motor["coulomb_Nm"] = rng.uniform(0.01, 0.05) * motor.T_N_Nm
    return bench, size


def all_wrong(motor: Motor, rng: np.random.Generator) -> tuple[Bench, dict[str, float]]:
    """Return a bench on which nothing is as believed, and the truth."""

    def scaled(spread: float) -> float:
        return math.exp(rng.uniform(-spread, spread))

    L_d = motor.L_d_H * scaled(0.25)
    truth = {
        "R_s": motor.R_s_ohm * scaled(0.4),
        "L_d": L_d,
        "L_q": L_d * rng.uniform(1.0, 1.6),
        "psi_r": motor.psi_r_Wb * scaled(0.08),
        "J": motor.J_kgm2 * scaled(0.4),
        "friction": rng.uniform(1e-4, 3e-3),
        "coulomb": rng.uniform(0.02, 0.2),
        "encoder_offset": rng.uniform(-0.1, 0.1),
    }
    dead_time_s = rng.uniform(0.5e-6, 3e-6)
    gains = 1.0 + rng.uniform(-0.02, 0.02, 3)
    gains /= np.mean(gains)
    bench = Bench(
        {key: truth[name] for name, key in BELIEVED.items()}
        | {"friction_Nms": truth["friction"], "coulomb_Nm": truth["coulomb"]}
        | {"cogging_Nm": rng.uniform(0.0, 0.1), "cogging_order": 24},
        dead_time_s,
        {
            "encoder_offset_rad": -truth["encoder_offset"] / motor.pole_pairs,
            **{
                f"i_{phase}": CurrentTruth(gain=gains[k], offset_A=rng.uniform(-0.02, 0.02))
                for k, phase in enumerate("abc")
            },
        },
    )
    truth["dead_time_voltage"] = dead_time_s / T_S * U_DC
    return bench, truth | {f"current_gain_{phase}": gains[k] - 1.0 for k, phase in enumerate("abc")}


def seen(truth: Mapping[str, float], block: Block) -> dict[str, float]:
    """Return the truth as a drive can see it that reads its dc link as it does."""
    gain = float(np.mean(block.column("u_dc"))) / U_DC
    scaled = {"R_s", "L_d", "L_q", "psi_r", "dead_time_voltage", "J", "friction", "coulomb"}
    return {name: value * (gain if name in scaled else 1.0) for name, value in truth.items()}


def naming(draws: int, seed: int) -> Iterator[tuple[str, bool, bool]]:
    """Yield the parameter that differs, whether it alone is named, and whether its size is right."""
    profile, plan = load_profile("zhu2011"), load_plan("zhu2011/identify")
    rng = np.random.default_rng(seed)
    for draw in range(draws):
        name = NINE[draw % len(NINE)]
        bench, size = one_wrong(name, profile.motor, rng)
        try:
            found = estimates(capture(profile, plan, bench, draw), profile)
        except AnalysisError:
            yield name, False, False
            continue
        named = [each.name for each in contradictions(found)]
        (own,) = (each for each in found if each.name == name)
        yield name, named == [name], own.told and abs(own.difference / size - 1.0) <= 0.2


def errors(draws: int, seed: int) -> Iterator[dict[str, float]]:
    """Yield by name the errors of a capture's estimates in standard uncertainties; what is not told is left
    out."""
    profile, plan = load_profile("zhu2011"), load_plan("zhu2011/identify")
    rng = np.random.default_rng(seed)
    for draw in range(draws):
        bench, truth = all_wrong(profile.motor, rng)
        block = capture(profile, plan, bench, draw)
        true = seen(truth, block)
        yield {
            each.name: (each.estimate.value - true[each.name]) / each.estimate.uncertainty.standard
            for each in estimates(block, profile)
            if each.told and each.estimate.uncertainty is not None
        }


def named_figures(told: Sequence[tuple[str, bool, bool]]) -> dict[str, object]:
    """Return how often a single wrong parameter was named alone, and its size right."""
    figures: dict[str, object] = {}
    for name in NINE:
        own = [(named, sized) for each, named, sized in told if each == name]
        counts = f"{sum(named for named, _ in own)} named, {sum(sized for _, sized in own)} within 20 %"
        figures[f"{name} wrong"] = f"{counts} of {len(own)}"
    share = sum(named for _, named, _ in told) / len(told)
    right = sum(named and sized for _, named, sized in told) / len(told)
    return figures | {"named": round(share, 4), "named_within_20_percent": round(right, 4)}


def error_figures(found: Sequence[Mapping[str, float]]) -> dict[str, object]:
    """Return by name how the errors are distributed, in standard uncertainties."""
    figures: dict[str, object] = {}
    for name in (*NINE, *(f"current_gain_{phase}" for phase in "abc")):
        z = np.array([each[name] for each in found if name in each])
        figures[f"z of {name}"] = f"told {len(z)}" + (
            f", rms {math.sqrt(float(np.mean(z**2))):.2f}, mean {np.mean(z):+.2f}, "
            f"within 2u {100.0 * np.mean(np.abs(z) <= 2.0):.1f} %, largest {np.max(np.abs(z)):.1f}"
            if len(z)
            else ""
        )
    z = np.array([value for each in found for value in each.values()])
    if len(z):
        figures["z_rms"] = round(math.sqrt(float(np.mean(z**2))), 3)
        figures["within_2u_percent"] = round(100.0 * float(np.mean(np.abs(z) <= 2.0)), 2)
    return figures


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--draws", type=int, default=207, help="machines of each series")
    parser.add_argument(
        "--series", choices=("naming", "errors", "both"), default="both", help="which to make"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the draws")
    options = parser.parse_args()
    begin = time.perf_counter()
    figures: dict[str, object] = {}
    if options.series != "errors":
        figures |= named_figures(list(naming(options.draws, options.seed)))
    if options.series != "naming":
        figures |= error_figures(list(errors(options.draws, options.seed)))
    figures["seconds"] = round(time.perf_counter() - begin, 1)
    print_figures(figures, as_json=options.json)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
