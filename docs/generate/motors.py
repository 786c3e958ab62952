"""The page of the motors that ship, from their profiles: values, and the sources that each file states."""

from __future__ import annotations

import math

from benchtool.profile import Profile, load_profile, profile_path, shipped_profiles

_FOLDER = "motors/"
_HEAD = """\
# Motors

Profiles of motors as they stand on benches, from a few milliohms to tens of ohms, each with an emulated bench
and a law that holds speed and load on it. They are plausible machines to test a plan, an analysis or a
firmware with, no reference values: others have identified them, and the page says who. Values are per phase
and peak, see [notation](notation.md). [A motor of your own](../start/own_motor.md) says how to take one, and
how to make another. This page is generated from the profiles.

"""
_COLUMNS = (
    *("profile", "motor", "R_s Ω", "L_d, L_q", "ψ_r mWb", "p", "J kg m²", "u_dc V", "T_s, t_d"),
    *("T_N Nm", "ω_N rad/s", "I_N A rms", "law"),
)


def page() -> str:
    """Return the page."""
    names = [name for name in shipped_profiles() if name.startswith(_FOLDER)]
    found = {name: load_profile(name) for name in names}
    ordered = sorted(found, key=lambda name: found[name].motor.R_s_ohm)
    lines = [_row(_COLUMNS), _row(["---"] * len(_COLUMNS))]
    lines += [_row((f"`{name}`", *_values(found[name]))) for name in ordered]
    sources = (f"**{found[name].title}** (`{name}`): {_source(name)}\n" for name in ordered)
    return f"{_HEAD}{chr(10).join(lines)}\n\n## Sources\n\n{chr(10).join(sources)}"


def _row(cells: tuple[str, ...] | list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _values(profile: Profile) -> tuple[str, ...]:
    motor, emulator = profile.motor, profile.emulator
    assert emulator is not None
    L_d, L_q = _inductance(motor.L_d_H), _inductance(motor.L_q_H)
    return (
        profile.title,
        f"{motor.R_s_ohm:g}",
        L_d if L_d == L_q else f"{L_d}, {L_q}",
        f"{1e3 * motor.psi_r_Wb:.4g}",
        str(motor.pole_pairs),
        f"{motor.J_kgm2:g}",
        f"{emulator.inverter.u_dc_V:g}",
        f"{1e6 * profile.control_period_s:g} µs, {1e6 * emulator.inverter.dead_time_s:g} µs",
        f"{motor.T_N_Nm:.3g}",
        f"{motor.omega_m_N_rad_s:.4g}",
        f"{motor.I_N_A_rms:.3g}",
        f"`{profile.drive.parameters['law']}`",
    )


def _inductance(henry: float) -> str:
    return f"{1e6 * henry:.4g} µH" if math.log10(henry) < -3.0 else f"{1e3 * henry:.4g} mH"


def _source(name: str) -> str:
    """Return what the file says of its values, at its head."""
    head = profile_path(name).read_text(encoding="utf-8").partition("\n\n")[0]
    return " ".join(line.removeprefix("#").strip() for line in head.splitlines())
