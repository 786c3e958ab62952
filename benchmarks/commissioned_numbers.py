"""Truth of the numbers that a commissioning states beside the parameters it is for.

Each is held against its uncertainty alone: gains, offsets, resistances of the phases, harmonics of the rotor
flux, the encoder's eccentricity, torques, and what the balances tell of the parameters again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

_BALANCED: Final = ("R_s", "L_d", "L_q", "psi_r", "dead_time_voltage")
_MOVED: Final = ("J", "friction", "coulomb")


def truth_beside(
    profile: Mapping[str, Any], truth: Mapping[str, float], found: Mapping[str, Any]
) -> dict[str, float]:
    """Return the truth of these numbers by name.

    Args:
        profile: of the bench, as TOML has it.
        truth: of the parameters.
        found: the estimates of the document, of which the encoder's offset tells what is left of its angle.
    """
    motor, emulator = profile["motor"], profile["emulator"]
    true, sensors = {**motor, **emulator.get("motor", {})}, emulator["sensors"]
    told = {"u_dc": emulator["inverter"]["u_dc_V"], "R_winding": true["R_s_ohm"], "load": 0.0}
    gains = [sensors.get(f"i_{phase}", {}).get("gain", 1.0) for phase in "abc"]
    seen = 3.0 / sum(1.0 / gain for gain in gains)
    told["R_winding"] /= seen
    for phase, gain in zip("abc", gains, strict=True):
        told[f"current_gain_{phase}"] = seen / gain
        told[f"current_offset_{phase}"] = sensors.get(f"i_{phase}", {}).get("offset_A", 0.0)
        told[f"R_{phase}"] = truth["R_s"]
    for order in (5, 7):
        told[f"psi_{order}_cos"], told[f"psi_{order}_sin"] = true.get(f"psi_{order}_Wb", 0.0), 0.0
    for n in (1, 2):
        if not sensors.get("encoder", {}).get(f"eccentricity_{n}_rad", 0.0):
            told[f"eccentricity_{n}_cos"] = told[f"eccentricity_{n}_sin"] = 0.0
    told["inertia_ratio"] = truth["J"] / motor["J_kgm2"]
    told |= {f"flux_balance_{name}": truth[name] for name in _BALANCED}
    told |= {f"motion_balance_{name}": truth[name] for name in _MOVED}
    told |= {f"balance_{name}": truth[name] for name in ("R_s", "psi_r")}
    cogging = zip(true.get("cogging_order", ()), true.get("cogging_Nm", ()), strict=True)
    told |= {f"cogging_{order}": torque_Nm * seen for order, torque_Nm in cogging}
    offset = found.get("encoder_offset", {}).get("value")
    if offset is not None:
        p = truth["pole_pairs"]
        ahead = p * (offset - truth["encoder_offset"])
        ahead -= 2.0 * math.pi * round(ahead / (2.0 * math.pi))
        told |= {"flux_balance_encoder_offset": ahead, "angle_difference": -ahead}
    return told


def errors_beside(found: Mapping[str, Any], told: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Return by name the error over the standard and over the expanded uncertainty, of numbers that state
    one."""
    compared = {}
    for name, true in told.items():
        entry = found.get(name)
        if entry is None or entry["value"] is None or not (u := entry["uncertainty"]) or not u["standard"]:
            continue
        error = entry["value"] - true
        compared[name] = (error / u["standard"], error / u["expanded"])
    return compared


def figures_beside(runs: Sequence[Mapping[str, tuple[float, float]]]) -> dict[str, str]:
    """Return how these errors are distributed, by name."""
    found = {}
    for name in dict.fromkeys(name for each in runs for name in each):
        z, share = np.array([each[name] for each in runs if name in each]).T
        found[f"beside_{name}"] = (
            f"told {len(z)}, z rms {math.sqrt(float(np.mean(z**2))):.2f}, within U "
            f"{100.0 * np.mean(np.abs(share) <= 1.0):.0f} %, largest {np.max(np.abs(share)):.2f} of U"
        )
    return found
