"""Profiles: a motor, its drive and the bench they stand on, as one validated TOML file.

A number's key ends in its unit. `[drive.parameters]` uses the dictionary's names with the unit appended
(`u_s_V`, `omega_observer_rad_s`). Motor quantities are amplitude-invariant (peak) and per phase.
"""

from benchtool.profile.bench import Bench
from benchtool.profile.claims import Choice, Claim, Comparison, Reference
from benchtool.profile.drive import Drive
from benchtool.profile.emulator import Emulator, Inverter, Sensors, TrueMotor
from benchtool.profile.motor import Motor
from benchtool.profile.profile import Profile, altered, eds_path, load_profile, profile_path

__all__ = [
    "Bench",
    "Choice",
    "Claim",
    "Comparison",
    "Drive",
    "Emulator",
    "Inverter",
    "Motor",
    "Profile",
    "Reference",
    "Sensors",
    "TrueMotor",
    "altered",
    "eds_path",
    "load_profile",
    "profile_path",
]
