"""How often the rotor turns within a block, and whether its rows show it.

Rows that are half an electrical period apart or more show a current of another frequency, which no analysis
of the current itself can tell from the true one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from benchtool.analysis import Window, change_of_regime, raw
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.profile import Motor

ROTATING: Final = frozenset({"i_a", "i_b", "i_c", "theta_m"})
"""Channels from whose order in time the electrical periods are read."""

_FEWEST_PERIODS = 2.0
_SWING = 1.05  # of the mean speed, that a steady one may reach
_BEYOND_RATED = 2.0  # speed over rated speed, that a machine may reach by field weakening


@dataclass(frozen=True)
class Rotation:
    """What keeps the electrical periods from being read off the rows.

    `folded` says why the rows are too far apart, and is empty where they are not. `untold` is whether a speed
    that was recorded, and is steady, tells that there are hardly two periods, or that the current is too
    small to show them.
    """

    folded: str = ""
    untold: bool = False

    @classmethod
    def of(cls, window: Window, motor: Motor) -> Rotation:
        """By the speed that was recorded; without it, by the highest that the machine may have."""
        block = window.block
        if ROTATING.isdisjoint(block.names):
            return cls()
        band_Hz = 0.5 * block.sample_rate_Hz
        if "omega_m" in block.names:
            omega_m = float(np.mean(np.abs(block.column("omega_m"))))
            if not math.isfinite(omega_m):
                return cls()
            electrical_Hz = motor.pole_pairs * omega_m / (2.0 * math.pi)
            if _SWING * electrical_Hz >= band_Hz:
                return cls(
                    f"by omega_m the current has {raw(electrical_Hz, 4)} Hz, rows at "
                    f"{raw(2.0 * band_Hz, 6)} Hz show less than {raw(band_Hz, 4)} Hz: stream faster"
                )
            periods = electrical_Hz * len(block.data) / block.sample_rate_Hz
            return cls(untold=periods < _FEWEST_PERIODS or (_steady(block) and not _tracked(window)))
        highest_Hz = _BEYOND_RATED * motor.pole_pairs * motor.omega_m_N_rad_s / (2.0 * math.pi)
        if highest_Hz >= band_Hz:
            return cls(
                f"rows at {raw(2.0 * band_Hz, 6)} Hz show less than {raw(band_Hz, 4)} Hz, the current of "
                f"this motor may have {raw(highest_Hz, 4)} Hz: record omega_m too, which tells, or stream "
                f"faster"
            )
        return cls()


def _steady(block: Block) -> bool:
    return "theta_m" not in block.names and not change_of_regime(block.column("omega_m"), "omega_m")


def _tracked(window: Window) -> bool:
    try:
        return window.track is not None
    except AnalysisError:
        return False
