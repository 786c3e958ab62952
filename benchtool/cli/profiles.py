"""`benchtool profiles`: the profiles that ship, a line for each."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer

from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import ProfileError
from benchtool.profile import Profile, load_profile, shipped_profiles


def profiles(
    folder: Annotated[
        str,
        typer.Argument(metavar="[FOLDER]", help="Folder of shipped profiles, such as motors; all of them."),
    ] = "",
    as_json: options.Json = False,
) -> int:
    """The profiles that ship: motor, rated values, dc link, law and control rate."""
    output = Output(as_json=as_json)
    names = [each for each in shipped_profiles() if not folder or f"{each}/".startswith(f"{folder}/")]
    if not names:
        raise ProfileError(f"no profile ships in '{folder}': leave it out to list all")
    found = {name: load_profile(name) for name in names}
    by_resistance = sorted(found, key=lambda name: found[name].motor.R_s_ohm)
    output.table(
        "profiles",
        ("profile", "motor", ">R_s", ">T_N", ">omega_m_N", ">I_N", ">u_dc", ">control", "law"),
        [(name, found[name].title, *_row(found[name])) for name in by_resistance],
    )
    output.note("take one with --profile NAME; benchtool profile new writes one of another motor")
    output.document({name: _document(profile) for name, profile in found.items()})
    return 0


def _row(profile: Profile) -> tuple[str, ...]:
    motor = profile.motor
    return (
        f"{motor.R_s_ohm:.3g} ohm",
        f"{motor.T_N_Nm:.3g} Nm",
        f"{motor.omega_m_N_rad_s * 30.0 / math.pi:.0f} rpm",
        f"{motor.I_N_A_rms:.3g} A rms",
        "" if profile.emulator is None else f"{profile.emulator.inverter.u_dc_V:g} V",
        f"{1e-3 / profile.control_period_s:.3g} kHz",
        str(profile.drive.parameters.get("law", "")),
    )


def _document(profile: Profile) -> dict[str, Any]:
    return {
        "title": profile.title,
        "motor": profile.motor.model_dump(exclude_none=True),
        "u_dc_V": None if profile.emulator is None else profile.emulator.inverter.u_dc_V,
        "control_period_s": profile.control_period_s,
        "law": profile.drive.parameters.get("law"),
    }
