"""Estimates of the steps against those of the flux balance, another method, on captures of a turning
motor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from benchtool.analysis import Contribution, Measurement, combined, sure_of
from benchtool.analysis.balances import Solution, flux_balance
from benchtool.block import Block
from benchtool.commission.budget import of_two
from benchtool.commission.known import Known
from benchtool.commission.steps.speed_loop import FASTEST
from benchtool.commission.steps.step import Finding
from benchtool.errors import AnalysisError

_LEAST_SHARE: Final = (
    0.5  # of the captures: what a limit lets through beside many that it refuses tells nothing
)
_TOLERANCES: Final[Mapping[str, float]] = {"R_s": 0.05, "psi_r": 0.01}
"""Relative differences below which two methods agree, however sure of themselves they are."""

ACROSS: Final = 0.25
"""Of what dead time and devices take, that may be across the flux and look like an EMF."""

_SPAN: Final = 10  # rows to either side, over which a speed is told: of fewer it is counts of the encoder
_ACTS_ROWS: Final = 1.5  # middle of the period in which a voltage acts, after the row that asks for it
_UNITS = {"R_s": "ohm", "psi_r": "Wb"}
PREFIX: Final = "balance_"


def balanced(blocks: Sequence[Block], known: Known) -> tuple[Measurement, ...]:
    """Return what the flux balance estimates of captures, the mean over those that tell it.

    The names are those of the parameters after `PREFIX`; what fewer than half of the captures tell is
    undefined, with a reason.
    """
    values: dict[str, list[tuple[float, float, float]]] = {name: [] for name in _TOLERANCES}
    reasons = dict.fromkeys(_TOLERANCES, "")
    for block in blocks:
        try:
            balance = flux_balance(of_a_sine(block, known), known.identified)
            found = _at_known_dead_time(balance.solution, known)
        except AnalysisError as failed:
            reasons = {name: why or str(failed) for name, why in reasons.items()}
            continue
        # what is left of the voltage is along the current, or along the EMF, as much as anywhere else
        left = {
            "R_s": balance.unexplained_V / balance.current_A,
            "psi_r": balance.unexplained_V / balance.omega_e_rad_s,
        }
        for name, each in values.items():
            if why := found.why_not(name):
                reasons[name] = reasons[name] or why
            else:
                each.append((found.value(name), found.standard(name), left[name]))
    for name, each in values.items():
        if len(each) < _LEAST_SHARE * len(blocks):
            reasons[name] = f"{len(each)} of {len(blocks)} captures tell it, half are needed: {reasons[name]}"
            each.clear()
    return tuple(_mean(name, each, reasons[name]) for name, each in values.items())


def _at_known_dead_time(found: Solution, known: Known) -> Solution:
    """Return a balance with the voltage of the dead time as several levels of current have told it.

    One level of current that turns tells only the sum of that and of the resistance's, from which noise and
    harmonics make any two parts: of 0.29 ohm and 0.32 V they made -0.01 ohm and 1.4 V.
    """
    drop = known.estimates.get("dead_time_voltage")
    if drop is None or drop.uncertainty is None:
        return found
    return found.given("dead_time_voltage", drop.value, drop.uncertainty.standard)


def contradictions(found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
    """Return where the estimates of this and of earlier steps differ from the flux balance's."""
    findings = []
    for name, tolerance in _TOLERANCES.items():
        own, other = found.get(name, known.estimates.get(name)), found.get(f"{PREFIX}{name}")
        if own is None or other is None or not math.isfinite(other.value - own.value):
            continue
        difference = other.value - own.value
        agreed = max(sure_of(of_two(own, other)), tolerance * abs(own.value))
        if name == "psi_r":  # dead time across the flux looks like an EMF, at the fastest speed the least
            omega_e = FASTEST * known.motor.omega_m_N_rad_s * known.identified.pole_pairs
            agreed = max(agreed, ACROSS * abs(known.drop_fundamental_V) / omega_e)
        if abs(difference) <= agreed:
            continue
        findings.append(
            Finding(
                f"{name} is {own.value:.4g} {own.unit} by its own step and {other.value:.4g} "
                f"{own.unit} by the "
                f"flux balance of the turning motor",
                "a sensor or the encoder is not what was found of it, or the machine is not of this kind "
                "(saturated, phases that differ)",
                "look at the findings of the earlier steps first, then repeat the commissioning",
            )
        )
    return tuple(findings)


def of_a_sine(block: Block, known: Known) -> Block:
    """Return a capture, of every tick, as a centred encoder would have it of a machine whose EMF is a sine.

    The balance knows of no harmonics, and of a fifth and a seventh of 2 % of the rotor flux the EMF has 24 %.
    A voltage acts from the row after it to the one after that.
    """
    names = [each.name for each in block.channels]
    data = np.array(block.data)
    theta_m = known.without_eccentricity(np.unwrap(data[:, names.index("theta_m")]))
    data[:, names.index("theta_m")] = theta_m % (2.0 * math.pi)
    if len(theta_m) > 2 * _SPAN:
        step_s, p = block.tick_s * block.stride, known.identified.pole_pairs
        omega_e = np.empty(len(theta_m))
        omega_e[_SPAN:-_SPAN] = p * (theta_m[2 * _SPAN :] - theta_m[: -2 * _SPAN]) / (2 * _SPAN * step_s)
        omega_e[:_SPAN], omega_e[-_SPAN:] = omega_e[_SPAN], omega_e[-_SPAN - 1]
        theta_e = p * theta_m + omega_e * _ACTS_ROWS * step_s
        EMF_V = np.zeros(len(theta_m), np.complex128)
        for order, psi in known.flux_harmonics.items():
            EMF_V += 1j * order * omega_e * psi * np.exp(1j * order * theta_e)
        data[:, names.index("u_alpha")] -= EMF_V.real
        data[:, names.index("u_beta")] -= EMF_V.imag
    return replace(block, data=data)


def _mean(name: str, values: Sequence[tuple[float, float, float]], reason: str) -> Measurement:
    """Return the mean of the captures' estimates, each with the standard uncertainty of its fit and what is
    left unexplained; both are the same in every capture, of one motor and one inverter."""
    unit, definition = _UNITS[name], "by the balance of the stator flux over each tick, mean of the captures"
    if not values:
        return Measurement.undefined(f"{PREFIX}{name}", unit, definition, reason or "nothing was captured")
    each, standards, left = np.array(values).T
    mean, n = float(np.mean(each)), len(each)
    lines = [
        Contribution("fits of the captures", "A", math.sqrt(float(np.mean(standards**2)))),
        Contribution("voltage left unexplained", "B", math.sqrt(float(np.mean(left**2)))),
    ]
    if n > 1:
        scatter = float(np.std(each, ddof=1)) / math.sqrt(n)
        lines.append(Contribution("scatter over the captures", "A", scatter, n - 1.0))
    u = combined(lines, "scatter over the captures and what they leave unexplained")
    if u is not None and u.expanded > abs(mean):
        reason = f"{mean:.3g} {unit} with an expanded uncertainty of {u.expanded:.2g}: not determined"
        return Measurement.undefined(f"{PREFIX}{name}", unit, definition, reason)
    return Measurement(f"{PREFIX}{name}", mean, unit, definition, uncertainty=u)
