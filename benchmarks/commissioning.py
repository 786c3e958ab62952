"""Whether a commissioning finds the truth within what it states: `python -m benchmarks.commissioning`.

The motors that ship are commissioned on drives as they come out of their box, over the emulated CAN bus or
the serial line. Series `right` has the shipped motors with right nameplates; series `flaws` draws what real
set-ups show: a nameplate that is off, saliency, dead time, drop and resistance of the devices, gains and
offsets of the current sensors, 10 to 12 bits, noise, steps of the duties, an encoder at any angle, in either
direction, eccentric or counting from zero at power-up, cogging, harmonics of the EMF, friction. Series
`repeats` commissions each bench of `flaws` again and again, with other noise. Series `clean` has these flaws
with a right nameplate and an encoder the right way round, in which nothing is to be found wrong, `saturating`
the same of machines that saturate (`benchmarks.saturating`), and `wrong` one wrong set-up each
(`benchmarks.wrong_setups`), which is to be named.

What is stated beside the parameters is held against its uncertainty (`benchmarks.commissioned_numbers`).
Truth is what the sensors let be seen: a gain that all current sensors have in common scales R_s, L and J.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.commissioned_numbers import errors_beside, figures_beside, truth_beside
from benchmarks.figures import print_figures
from benchmarks.saturating import curve, saturate
from benchmarks.wrong_setups import CASES, FOUR_MOTORS, named
from benchtool.bench import Session, open_session
from benchtool.commission import (
    Known,
    commission,
    document,
    planned,
    planned_energy,
    stated_parameters,
    steps_for,
)
from benchtool.shipped import shipped

MOTORS: Final = tuple(
    sorted(path.parent.name for path in (shipped("profiles") / "motors").glob("*/profile.toml"))
)
TOLERANCES: Final[Mapping[str, float]] = {
    "R_s": 0.02, "L_d": 0.03, "L_q": 0.03, "psi_r": 0.01, "J": 0.05, "coulomb": 0.10, "friction": 0.15,
    "dead_time_voltage": 0.05,
}  # fmt: skip
"""Relative; those of the encoder are exact, and 1 degree electrical."""
_OFFSET_RAD: Final = math.radians(1.0)
_DATA_SHEET: Final = (0.75, 1.25)  # of a data sheet's resistance over that of a device
_NEAR: Final = 0.2
"""By how much the energy of a dry run may differ from what is spent."""
_SMALL_R_OHM, _SMALL_L_H = 0.05, 50e-6
_SMALL: Final = {"R_s": 0.05, "L_d": 0.06, "L_q": 0.06}
REPEATED: Final[Mapping[str, float]] = {"R_s": 0.5, "L_d": 1.0, "L_q": 1.0, "psi_r": 0.3, "J": 2.0}
"""Largest standard deviation of repeated commissionings that is wanted, in percent."""
_CURVE: Final = 0.05
SERIES: Final = ("right", "flaws", "clean", "repeats", "saturating", "wrong")
_LINKS: Final = ("emulated", "emulated?wire=serial")


@dataclass(frozen=True)
class Bench:
    """A profile with its truth, by the names of the estimates."""

    profile: dict[str, Any]
    truth: dict[str, float]


def clean(motor: str) -> Bench:
    """Return a shipped motor whose nameplate is right, on a drive that knows nothing of it."""
    profile = tomllib.loads(
        (shipped("profiles") / "motors" / motor / "profile.toml").read_text(encoding="utf-8")
    )
    profile["emulator"]["commissioned"] = False
    return Bench(profile, _truth(profile))


def flawed(motor: str, rng: np.random.Generator) -> Bench:
    """Return a shipped motor with every flaw drawn at random."""
    profile = clean(motor).profile
    stated, emulator = profile["motor"], profile["emulator"]
    true = emulator.setdefault("motor", {})
    T_s = profile["drive"].get("control_period_s", 1e-4)
    true |= {key: stated[key] for key in ("R_s_ohm", "L_d_H", "L_q_H", "psi_r_Wb", "J_kgm2")}
    true["L_q_H"] = max(stated["L_q_H"], stated["L_d_H"] * rng.uniform(1.0, 1.8))
    rated_Nm = stated["T_N_Nm"]
    true["coulomb_Nm"] = rated_Nm * rng.uniform(0.005, 0.05)
    true["friction_Nms"] = rated_Nm * rng.uniform(0.0, 0.05) / stated["omega_m_N_rad_s"]
    true["psi_5_Wb"], true["psi_7_Wb"] = (stated["psi_r_Wb"] * rng.uniform(0.0, 0.03, 2)).tolist()
    true["cogging_Nm"] = [rated_Nm * rng.uniform(0.0, 0.05)]
    true["cogging_order"] = [int(rng.choice((2, 6))) * stated["pole_pairs"]]
    true["cogging_phase_rad"] = [rng.uniform(-math.pi, math.pi)]
    true["power_up_angle_rad"] = rng.uniform(-math.pi, math.pi)
    inverter = emulator["inverter"]
    inverter["dead_time_s"] = rng.uniform(0.2e-6, min(3e-6, 0.03 * T_s))
    inverter["device_drop_V"] = rng.uniform(0.0, min(1.0, 0.04 * inverter["u_dc_V"]))
    inverter["on_resistance_ohm"] = rng.uniform(0.0005, 0.005)
    inverter["timer_Hz"] = 2.0 * rng.uniform(1000.0, 4000.0) / T_s
    sensors = emulator["sensors"]
    range_A = 3.0 * math.sqrt(2.0) * stated["I_N_A_rms"]
    bits = int(rng.integers(10, 13))
    sensors |= {"adc_bits": bits, "i_full_scale_A": range_A}
    sensors["current_noise_A_rms"] = rng.uniform(1.0, 2.0) * 2.0 * range_A / 2.0**bits
    common = rng.uniform(0.99, 1.01)
    for phase in "abc":
        sensors[f"i_{phase}"] = {
            "gain": common * rng.uniform(0.98, 1.02),
            "offset_A": range_A * rng.uniform(-0.02, 0.02),
        }
    sensors["encoder_offset_rad"] = rng.uniform(-math.pi, math.pi)
    sensors["encoder"] = {
        "reversed": bool(rng.integers(0, 2)),
        "relative": bool(rng.integers(0, 2)),
        "eccentricity_1_rad": math.radians(rng.uniform(0.0, 1.0)),
        "eccentricity_1_phase_rad": rng.uniform(-math.pi, math.pi),
    }
    for key in ("R_s_ohm", "L_d_H", "L_q_H", "J_kgm2"):
        stated[key] *= rng.uniform(0.7, 1.4)
    stated["psi_r_Wb"] *= rng.uniform(0.85, 1.2)
    profile["drive"]["on_resistance_ohm"] = inverter["on_resistance_ohm"] * rng.uniform(*_DATA_SHEET)
    return Bench(profile, _truth(profile))


def sound(motor: str, rng: np.random.Generator) -> Bench:
    """Return a shipped motor with flaws of the sensors and a right nameplate."""
    profile = flawed(motor, rng).profile
    true = profile["emulator"]["motor"]
    profile["motor"] |= {key: true[key] for key in ("R_s_ohm", "L_d_H", "L_q_H", "psi_r_Wb", "J_kgm2")}
    profile["emulator"]["sensors"]["encoder"]["reversed"] = False
    return Bench(profile, _truth(profile))


def saturating(motor: str, rng: np.random.Generator) -> Bench:
    """Return a shipped motor with flaws of the sensors, a right nameplate, and iron that saturates."""
    profile = sound(motor, rng).profile
    saturate(profile, rng)
    truth = _truth(profile)
    return Bench(profile, truth | curve(profile, profile["emulator"]["motor"]["L_d_H"] / truth["L_d"]))


def _truth(profile: Mapping[str, Any]) -> dict[str, float]:
    motor, emulator = profile["motor"], profile["emulator"]
    true = {**motor, **emulator.get("motor", {})}
    inverter, sensors = emulator["inverter"], emulator["sensors"]
    T_s = profile["drive"].get("control_period_s", 1e-4)
    gains = np.array([sensors.get(f"i_{phase}", {}).get("gain", 1.0) for phase in "abc"])
    seen = 3.0 / float(np.sum(1.0 / gains))
    encoder = sensors.get("encoder", {})
    offset = sensors.get("encoder_offset_rad", 0.0)
    if encoder.get("relative", False):
        at = true.get("power_up_angle_rad", 0.0)
        shown = encoder.get("eccentricity_1_rad", 0.0) * math.sin(
            at + offset + encoder.get("eccentricity_1_phase_rad", 0.0)
        )
        offset = -at - shown
    dead = inverter.get("dead_time_s", 0.0) / T_s * inverter["u_dc_V"]
    return {
        "R_s": (true["R_s_ohm"] + inverter.get("on_resistance_ohm", 0.0)) / seen,
        "L_d": true["L_d_H"] / seen,
        "L_q": true["L_q_H"] / seen,
        "psi_r": true["psi_r_Wb"],
        "pole_pairs": float(true["pole_pairs"]),
        "encoder_direction": -1.0 if encoder.get("reversed", False) else 1.0,
        "encoder_offset": offset,
        "J": true["J_kgm2"] * seen,
        "coulomb": true.get("coulomb_Nm", 0.0) * seen,
        "friction": true.get("friction_Nms", 0.0) * seen,
        "dead_time_voltage": dead + inverter.get("device_drop_V", 0.0),
    }


def errors(found: Mapping[str, Any], truth: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Return by name the error, relative to the tolerance and to the standard uncertainty, and that over the
    tolerance."""
    compared = {}
    p = truth["pole_pairs"]
    for name, true in truth.items():
        entry = found.get(name)
        if entry is None or entry["value"] is None:
            continue
        error = entry["value"] - true
        if name == "encoder_offset":
            error -= 2.0 * math.pi / p * round(error * p / (2.0 * math.pi))
        allowed = _allowed(name, truth)
        stated = (entry["uncertainty"] or {}).get("standard")
        compared[name] = {"of_tolerance": error / allowed if allowed else (0.0 if error == 0.0 else math.inf)}
        if stated:
            compared[name] |= {"z": error / stated, "u_of_tolerance": stated / allowed}
    return compared


def _allowed(name: str, truth: Mapping[str, float]) -> float:
    if name == "encoder_offset":
        return _OFFSET_RAD / truth["pole_pairs"]
    small = truth["R_s"] < _SMALL_R_OHM if name == "R_s" else truth.get(name, 0.0) < _SMALL_L_H
    relative = _SMALL[name] if name in _SMALL and small else TOLERANCES.get(name, 0.0)
    relative = _CURVE if "_at_" in name else relative
    return relative * abs(truth[name])


def toml(content: Mapping[str, Any], table: tuple[str, ...] = ()) -> Iterator[str]:
    """Yield the lines of a TOML document."""
    values = {key: value for key, value in content.items() if not isinstance(value, dict)}
    if values and table:
        yield f"[{'.'.join(table)}]"
    for key, value in values.items():
        yield f"{key} = {json.dumps(value)}"
    for key, value in content.items():
        if isinstance(value, dict):
            yield from toml(value, (*table, key))


def commissioned(
    bench: Bench,
    steps: Sequence[str],
    link: str,
    seed: int,
    meddle: Callable[[Session], None] = lambda _: None,
) -> dict[str, Any]:
    """Commission a bench; return the document, and `drive_s`, the time that it took the drive. With every
    step the drive is to store what is found.

    `meddle` does something to the bench once it is connected. With every step `dry_run_J` and `range_J` are
    what a dry run had said.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "profile.toml"
        path.write_text("\n".join(toml(bench.profile)) + "\n", encoding="utf-8")
        with open_session(str(path), link, seed=seed, instruments=False) as session:
            session.drive.connect()
            meddle(session)
            told = {} if steps else _dry_run(session)
            began_s = session.drive.clock.now_s()
            done = commission(session.drive, session.profile, steps_for(steps), keep=not steps)
            return {**document(done), "drive_s": session.drive.clock.now_s() - began_s, **told}


def _dry_run(session: Session) -> dict[str, Any]:
    stated = stated_parameters(session.drive, session.profile)
    known = Known.of(session.drive, session.profile, stated)
    energy = planned_energy(chain(*planned(steps_for(()), known).values()), known)
    return {"dry_run_J": energy.value_J, "range_J": [energy.least_J, energy.most_J]}


def figures(runs: Sequence[Mapping[str, Any]]) -> dict[str, object]:
    """Return how the errors are distributed, by name and over all."""
    found: dict[str, object] = {"runs": len(runs)}
    failed = [
        f"{each['motor']}: {name}: {step['reason']}"
        for each in runs
        for name, step in each["document"]["steps"].items()
        if step["verdict"] == "fail"
    ]
    found["failed"] = failed
    asked = [each for each in runs if each["document"]["not_saved"] != "it was not asked for"]
    found["saved"] = sum(each["document"]["saved"] for each in asked)
    found["not_saved"] = [
        f"{each['motor']}: {each['document']['not_saved']}" for each in asked if not each["document"]["saved"]
    ]
    found["findings"] = [
        f"{each['motor']}: {one['what']}" for each in runs for one in each["document"]["findings"]
    ]
    every: list[float] = []
    for name in dict.fromkeys(name for each in runs for name in each["errors"]):
        of = [each["errors"][name] for each in runs if name in each["errors"]]
        shares = np.abs([each["of_tolerance"] for each in of])
        line = f"told {len(of)}, within tolerance {100.0 * np.mean(shares <= 1.0):.0f} %, "
        line += f"largest {np.max(shares):.2f} of it"
        z = np.array([each["z"] for each in of if "z" in each])
        if len(z):
            every += z.tolist()
            median = float(np.median([each["u_of_tolerance"] for each in of if "z" in each]))
            line += (
                f"; z rms {math.sqrt(float(np.mean(z**2))):.2f}, within 2u "
                f"{100.0 * np.mean(np.abs(z) <= 2.0):.0f} %, largest {np.max(np.abs(z)):.1f}, "
                f"median u {median:.2f} of the tolerance"
            )
        found[name] = line
    z = np.array(every)
    if len(z):
        found["estimates"] = len(z)
        found["z_rms"] = round(math.sqrt(float(np.mean(z**2))), 3)
        found["within_2u_percent"] = round(100.0 * float(np.mean(np.abs(z) <= 2.0)), 2)
        found["largest_z"] = round(float(np.max(np.abs(z))), 2)
    whole = [each for each in runs if each["document"].get("saved")]
    if whole:
        found |= _energies(whole)
    found["longest_drive_s"] = round(max(each["document"]["drive_s"] for each in runs), 1) if runs else 0.0
    return found


def _energies(runs: Sequence[Mapping[str, Any]]) -> dict[str, object]:
    """Return how the energy of whole runs compares with what a dry run had said."""
    near, within = 0, 0
    ratios = []
    for each in runs:
        spent_J = sum(step["spent_J"] for step in each["document"]["steps"].values())
        least_J, most_J = each["document"]["range_J"]
        ratios.append(spent_J / each["document"]["dry_run_J"])
        near += abs(ratios[-1] - 1.0) <= _NEAR
        within += least_J <= spent_J <= most_J
    return {
        "spent_over_dry_run": [round(min(ratios), 3), round(max(ratios), 3)],
        "dry_run_within_20_percent": f"{near} of {len(runs)}",
        "spent_within_range": f"{within} of {len(runs)}",
    }


_DRAWN: Final = {"flaws": flawed, "repeats": flawed, "clean": sound, "saturating": saturating}


def spread(runs: Sequence[Mapping[str, Any]]) -> dict[str, object]:
    """Return the standard deviation of repeated commissionings of one bench, in percent; the largest of the
    motors."""
    found: dict[str, object] = {}
    for name in REPEATED:
        of_motors: dict[str, list[float]] = {}
        for each in runs:
            value = each["document"]["estimates"].get(name, {}).get("value")
            if value is not None:
                of_motors.setdefault(each["motor"], []).append(value)
        shares = {
            motor: 100.0 * float(np.std(values, ddof=1) / abs(np.mean(values)))
            for motor, values in of_motors.items()
            if len(values) > 1
        }
        if shares:
            worst = max(shares, key=lambda motor: shares[motor])
            found[f"spread_{name}_percent"] = round(shares[worst], 3)
            found[f"spread_{name}"] = f"largest {shares[worst]:.3f} % ({worst}), {REPEATED[name]:g} % wanted"
    return found


def of_motors(runs: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    """Return by motor the largest deviation of each estimate, in shares of its tolerance."""
    found: dict[str, dict[str, float]] = {}
    for each in runs:
        largest = found.setdefault(each["motor"], {})
        for name, error in each["errors"].items():
            largest[name] = max(largest.get(name, 0.0), round(abs(float(error["of_tolerance"])), 3))
    return found


def wrong_setups(motors: Sequence[str], seed: int, chosen: Sequence[str], *, tell: bool) -> dict[str, object]:
    """Commission each motor with each wrong set-up; return which were named."""
    missed, tried = [], 0
    for case in CASES:
        if chosen and case.name not in chosen:
            continue
        for k, motor in enumerate(motors):
            bench = sound(motor, np.random.default_rng([seed, MOTORS.index(motor), k]))
            case.profile(bench.profile)
            made = commissioned(bench, [case.step], _LINKS[k % len(_LINKS)], seed + k, case.bench)
            tried += 1
            seen = [f"{each['what']} [{each['cause']}]" for each in made["findings"]]
            seen += [step["reason"] for step in made["steps"].values() if step["verdict"] == "fail"]
            if not (well := named(case, made)):
                missed.append(f"{case.name}, {motor}: {'; '.join(seen) or 'nothing found'}")
            if tell:
                print(case.name, motor, "named" if well else "MISSED", seen[:2], flush=True)
    return {"wrong_setups": tried, "named": tried - len(missed), "missed": missed}


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--series", choices=SERIES, default="flaws", help="which to make")
    parser.add_argument("--motors", default="", help="names, separated by commas, or how many; all without")
    parser.add_argument("--draws", type=int, default=3, help="of each motor; of `repeats`, repetitions")
    parser.add_argument("--cases", default="", help="wrong set-ups, separated by commas; all without")
    parser.add_argument("--steps", default="", help="names, separated by commas; all without")
    parser.add_argument("--seed", type=int, default=1, help="of the draws")
    parser.add_argument("--each", action="store_true", help="print a line for each run, too")
    options = parser.parse_args()
    begin = time.perf_counter()
    chosen: Sequence[str] = FOUR_MOTORS if options.series == "wrong" else MOTORS
    if options.motors:
        chosen = chosen[: int(options.motors)] if options.motors.isdigit() else options.motors.split(",")
    if options.series == "wrong":
        cases = options.cases.split(",") if options.cases else []
        found = wrong_setups(chosen, options.seed, cases, tell=options.each)
    else:
        found = campaign(chosen, options)
    found["seconds"] = round(time.perf_counter() - begin, 1)
    print_figures(found, as_json=options.json)
    return 0


def campaign(motors: Sequence[str], options: argparse.Namespace) -> dict[str, object]:
    """Commission motors as often as is asked for; return the figures."""
    steps = options.steps.split(",") if options.steps else []
    runs: list[dict[str, Any]] = []
    for k in range(options.draws):
        for motor in motors:
            place = MOTORS.index(motor)
            rng = np.random.default_rng([options.seed, place, 0 if options.series == "repeats" else k])
            bench = clean(motor) if options.series == "right" else _DRAWN[options.series](motor, rng)
            link = _LINKS[(k + place) % len(_LINKS)]
            made = commissioned(bench, steps, link, seed=options.seed + k)
            found = made["estimates"]
            told = truth_beside(bench.profile, bench.truth, found)
            runs.append({"motor": motor, "document": made, "errors": errors(found, bench.truth)})
            runs[-1]["beside"] = errors_beside(found, told)
            if options.each:
                shares = {name: round(each["of_tolerance"], 2) for name, each in runs[-1]["errors"].items()}
                z = {name: round(each["z"], 1) for name, each in runs[-1]["errors"].items() if "z" in each}
                said = [each["what"] for each in made["findings"]]
                print(motor, f"{made['drive_s']:.1f} s", "of tolerance", shares, "z", z, said, flush=True)
    repeated = spread(runs) if options.series == "repeats" else {}
    drawn = {"series": options.series, "seed": options.seed}
    beside = figures_beside([each["beside"] for each in runs])
    return {**drawn, **figures(runs), **repeated, **beside, "motors": of_motors(runs)}


if __name__ == "__main__":
    raise SystemExit(main())
