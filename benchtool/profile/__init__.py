"""Profiles: a motor, its drive and the bench they stand on, as one validated TOML file.

A number's key ends in its unit. `[drive.parameters]` uses the dictionary's names with the unit appended
(`u_s_V`, `omega_observer_rad_s`). Motor quantities are amplitude-invariant (peak) and per phase.
"""

from benchtool.profile.bench import Bench, Instrument, ReferenceClock, Sensor
from benchtool.profile.claims import Choice, Claim, Comparison, Reference
from benchtool.profile.drive import Drive, RoleObject
from benchtool.profile.emulator import Emulator, Inverter, Sensors, TrueMotor
from benchtool.profile.motor import Motor
from benchtool.profile.profile import (
    Profile,
    altered,
    bench_of,
    eds_path,
    load_bench,
    load_profile,
    profile_path,
)

__all__ = [
    "Bench",
    "Choice",
    "Claim",
    "Comparison",
    "Drive",
    "Emulator",
    "Instrument",
    "Inverter",
    "Motor",
    "Profile",
    "Reference",
    "ReferenceClock",
    "RoleObject",
    "Sensor",
    "Sensors",
    "TrueMotor",
    "altered",
    "bench_of",
    "eds_path",
    "load_bench",
    "load_profile",
    "profile_path",
]
