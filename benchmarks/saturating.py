"""Machines that saturate, drawn at random, and what a saturation curve of theirs is to be.

`python -m benchmarks.commissioning --series saturating` commissions them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from benchtool.emulator.machine.saturation import SaturationTruth, flux_at

PERCENT = (-80, -40, 40, 80)
"""Of the rated current, at which a curve is told."""

_LEFT = 0.05  # of what does not saturate, at least


def saturate(profile: dict[str, Any], rng: np.random.Generator) -> None:
    """Have the machine of a profile saturate along both axes, and make these share iron.

    At its rated current along the flux, or across it, it has up to a third less of the differential
    inductance; a current across makes up to a tenth of it along the flux, where that is kept.
    """
    stated, true = profile["motor"], profile["emulator"]["motor"]
    psi_r, L_d, L_q = true["psi_r_Wb"], true["L_d_H"], true["L_q_H"]
    I_N = math.sqrt(2.0) * stated["I_N_A_rms"]
    S, T = int(rng.integers(3, 7)), int(rng.integers(1, 3))
    psi_q = L_q * I_N
    share = (1.0 + L_d * I_N / psi_r) ** S - 1.0
    a_dd = min(rng.uniform(0.1, 0.5) / share, 1.0 - _LEFT) / (L_d * (S + 1.0) * psi_r**S)
    a_qq = rng.uniform(0.1, 0.5) / ((T + 1.0) * L_q * psi_q**T)
    a_dq = rng.uniform(0.0, 0.1) * 2.0 * I_N / (psi_q**2 * psi_r)
    a_dq = min(a_dq, (1.0 - _LEFT) * 2.0 / (L_q * psi_r**2))
    true["saturation"] = {"a_dd": a_dd, "a_qq": a_qq, "a_dq": a_dq, "S": S, "T": T, "U": 0, "V": 0}


def curve(profile: dict[str, Any], seen: float) -> dict[str, float]:
    """Return the inductances at shares of the rated current, by the names of the estimates.

    Args:
        profile: of a machine that saturates.
        seen: current read over current, common to all sensors.
    """
    true = profile["emulator"]["motor"]
    machine = SaturationTruth(**true["saturation"]).coefficients(
        true["L_d_H"], true["L_q_H"], true["psi_r_Wb"]
    )
    I_N = math.sqrt(2.0) * profile["motor"]["I_N_A_rms"]
    found = {}
    for percent in PERCENT:
        read_A = percent / 100.0 * I_N
        i_A = read_A / seen
        sign = "minus_" if percent < 0 else ""
        found[f"L_d_at_{sign}{abs(percent)}"] = (
            flux_at(machine, i_A, 0.0, None).psi_d - true["psi_r_Wb"]
        ) / read_A
        if percent > 0:
            found[f"L_q_at_{percent}"] = flux_at(machine, 0.0, i_A, None).psi_q / read_A
    return found
