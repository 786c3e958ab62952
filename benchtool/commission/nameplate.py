"""Estimates beside a nameplate: the deviation, what a telling one probably is, and every convention.

Statements of one quantity differ by 2 (line to line or phase), sqrt 2 (peak or rms), sqrt 3 (voltage between
lines or of a phase), 3/2 (amplitude- or power-invariant torque), p (mechanical or electrical) and products of
these.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from benchtool.profile import Motor

KEYS: Final[Mapping[str, str]] = {
    "R_s": "R_s_ohm",
    "L_d": "L_d_H",
    "L_q": "L_q_H",
    "psi_r": "psi_r_Wb",
    "J": "J_kgm2",
    "pole_pairs": "pole_pairs",
}
"""Keys of `[motor]` that an estimate is compared with."""

WINDING_R: Final = "R_winding"
"""Name of the estimate of what `R_s` is without what is stated to be in series."""

IN_SERIES_OHM: Final = 0.008
"""Of devices, cable and plugs, which are in the resistance that is measured."""

_NEAR: Final = 0.06
_NOT_A_DEVIATION: Final = 1.12
_WINDING: Final = ("R_s", "L_d", "L_q")
_WITH_SERIES: Final = ("R_s", "R_a", "R_b", "R_c")
_OF_WINDING: Final = {
    2.0: "the value between two terminals, stated as that of a phase",
    0.5: "half of the phase's value: that of a phase was halved once more",
    1.5: "the value of one terminal against the other two, stated as that of a phase",
    3.0: "the value of a phase in delta, stated as that of the equivalent star",
}
_OF_FLUX: Final = {
    math.sqrt(3.0): "a voltage between lines, stated as that of a phase",
    math.sqrt(2.0): "a peak value, stated as rms, or a torque constant per A rms, stated as per A peak",
    math.sqrt(6.0): "a peak voltage between lines, stated as rms of a phase",
    math.sqrt(1.5): "a flux linkage of power-invariant vectors, stated as amplitude-invariant",
    1.5: "a torque constant without the 3/2 of amplitude-invariant vectors",
    2.0: "twice the flux linkage: peak to peak, stated as peak",
}


def stated(name: str, motor: Motor, series_ohm: float | None = None) -> float | None:
    """Return what the nameplate lets expect of an estimate, of `R_s` with what is stated to be in series with
    the winding; None where it states nothing."""
    if name == WINDING_R:
        return motor.R_s_ohm
    value: float | None = getattr(motor, KEYS[name]) if name in KEYS else None
    return value + (series_ohm or 0.0) if name == "R_s" and value is not None else value


def deviation(name: str, value: float, motor: Motor, series_ohm: float | None = None) -> float | None:
    """Return estimate over what the nameplate lets expect, less 1; None where that is nothing, or zero."""
    expected = stated(name, motor, series_ohm)
    return value / expected - 1.0 if expected and math.isfinite(value) else None


def contained(name: str, series_ohm: float | None) -> str:
    """Return what an estimate contains that its name does not say; empty of one with nothing else in it."""
    if name not in _WITH_SERIES:
        return ""
    known = f"{series_ohm:.3g} ohm by the profile" if series_ohm else "drive.on_resistance_ohm states none"
    return f"the devices of the power stage, cable and plugs in series with the winding ({known})"


def probable_cause(name: str, value: float, motor: Motor, near: float = _NEAR) -> str:
    """Return what a deviation from the nameplate probably is; empty of one that is near to no such factor.

    The factor is that of the stated value over the estimate; `near`, how far off it may be.
    """
    off = deviation(name, value, motor)
    if off is None or off <= -1.0 or max(1.0 + off, 1.0 / (1.0 + off)) < _NOT_A_DEVIATION:
        return ""
    factor = 1.0 / (1.0 + off)
    p = float(motor.pole_pairs)
    causes: dict[float, str] = {}
    if name == "R_s" and 0.0 < value - motor.R_s_ohm < IN_SERIES_OHM:
        return ""
    if name in _WINDING:
        causes = _OF_WINDING
    elif name == "psi_r":
        inverse = {1.0 / each: f"the inverse: {cause}" for each, cause in _OF_FLUX.items()}
        of_pairs = {
            p: "a back-EMF constant per mechanical rad/s, stated as flux linkage, which is per electrical",
            1.0 / p: "a flux linkage divided by the number of pole pairs twice",
            1.0
            / (value * value): "a speed constant, stated as the back-EMF constant of which it is the inverse",
        }
        causes = {**inverse, **of_pairs, **_OF_FLUX}
    elif name == "pole_pairs":
        causes = {2.0: "the number of poles, stated as that of pole pairs"}
    like = [each for each in causes if abs(factor / each - 1.0) < near]
    if not like:
        return ""
    closest = min(like, key=lambda each: abs(factor / each - 1.0))
    looks = {"R_s": "R", "L_d": "L", "L_q": "L"}.get(name, name)
    if name in _WINDING and closest == 2.0:
        return f"{looks} looks line to line: {causes[closest]}"
    return f"{looks} is stated {factor:.3g} times as large as it is: {causes[closest]}"


def conventions(estimates: Mapping[str, float], pole_pairs: int) -> tuple[tuple[str, float, str], ...]:
    """Return the estimates as nameplates state them: what, value, unit."""
    rows: list[tuple[str, float, str]] = []
    resistance = (WINDING_R, WINDING_R) if WINDING_R in estimates else ("R_s", "R_s with what is in series")
    for name, label, unit in ((*resistance, "ohm"), ("L_d", "L_d", "H"), ("L_q", "L_q", "H")):
        if name in estimates:
            rows.append((f"{label}, per phase", estimates[name], unit))
            rows.append((f"{label}, line to line", 2.0 * estimates[name], unit))
    if (psi_r := estimates.get("psi_r", 0.0)) > 0.0:
        rows += _of_flux(psi_r, pole_pairs)
    return tuple(rows)


def _of_flux(psi_r_Wb: float, pole_pairs: int) -> list[tuple[str, float, str]]:
    phase = pole_pairs * psi_r_Wb  # V peak of a phase at 1 rad/s
    per_krpm = 1000.0 * math.pi / 30.0
    rows = [("psi_r, peak", psi_r_Wb, "Wb")]
    for what, volts in (
        ("phase, peak", phase),
        ("phase, rms", phase / math.sqrt(2.0)),
        ("line to line, peak", math.sqrt(3.0) * phase),
        ("line to line, rms", math.sqrt(1.5) * phase),
    ):
        rows.append((f"Ke, {what}", volts * per_krpm, "V/krpm"))
        rows.append((f"Kv, {what}", 30.0 / math.pi / volts, "rpm/V"))
    rows.append(("V/Hz, line to line, rms", 2.0 * math.pi * psi_r_Wb * math.sqrt(1.5), "V/Hz"))
    rows.append(("Kt, per A peak", 1.5 * phase, "Nm/A"))
    rows.append(("Kt, per A rms", 1.5 * math.sqrt(2.0) * phase, "Nm/A"))
    return rows
