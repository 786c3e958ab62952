"""Mutants of the bench: sensors, magnets and encoder that are not what the profile says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from benchtool.emulator.mutants.mutant import Mutant
from benchtool.profile import Emulator, Profile


def _emulator(profile: Profile) -> Emulator:
    assert profile.emulator is not None  # mutants are of emulated benches
    return profile.emulator


def _peak_A(profile: Profile) -> float:
    return math.sqrt(2.0) * profile.motor.I_N_A_rms


def _offset_of_encoder(profile: Profile) -> Mapping[str, float]:
    offset = _emulator(profile).sensors.encoder_offset_rad
    return {"sensors.encoder_offset_rad": offset + math.radians(5.0) / profile.motor.pole_pairs}


def _weak_magnets(profile: Profile) -> Mapping[str, float]:
    true = _emulator(profile).motor.psi_r_Wb or profile.motor.psi_r_Wb
    return {"motor.psi_r_Wb": 0.9 * true}


def _lines(profile: Profile) -> Mapping[str, float]:
    return {"sensors.encoder_lines": round(0.98 * _emulator(profile).sensors.encoder_lines)}


BENCH: Final = (
    Mutant("phase_gain", "+5 % gain in one phase", lambda _: {"sensors.i_b.gain": 1.05}),
    Mutant(
        "current_offset",
        "an offset of 4 % of the rated current in one phase",
        lambda profile: {"sensors.i_a.offset_A": 0.04 * _peak_A(profile)},
    ),
    Mutant(
        "current_noise",
        "currents with noise of 5 % of the rated one",
        lambda profile: {"sensors.current_noise_A_rms": 0.05 * _peak_A(profile)},
    ),
    Mutant("encoder_offset", "an encoder that is 5 electrical degrees off", _offset_of_encoder),
    Mutant("encoder_lines", "an encoder with 2 % fewer lines than the drive believes", _lines),
    Mutant("weak_magnets", "magnets with 10 % less flux", _weak_magnets),
    Mutant("u_dc_gain", "+10 % gain of the dc link's sensor", lambda _: {"sensors.u_dc.gain": 1.1}),
)
"""Defects of the plant, by keys of the emulated bench."""
