"""Uncertainty of an estimate: the scatter about the fit, and what is known beside it; that of two methods."""

from __future__ import annotations

import math

from benchtool.analysis import Contribution, Measurement, Uncertainty, combined
from benchtool.commission.known import Known


def of_fit(
    value: float,
    standard: float,
    dof: float,
    scatter: str,
    known: Known,
    left_out: float = 0.0,
    saturation: float = 0.0,
) -> Uncertainty:
    """Return the uncertainty of a value that is in proportion to the voltage of the dc link.

    The drive makes its voltages with the dc link as its converter reads it: within half a step of the true
    one, a rectangular distribution (JCGM 100:2008, 4.3.7). Of a converter of unknown steps ten bits are
    assumed. Its gain, like that common to the current sensors, is not contained: no current tells of it.

    A current is sampled where the pulses of the period are symmetric about it; the dead time, by V_drop no
    longer than V_drop / u_dc T_s, moves them by up to half of it, and the sample off the mean by what the
    current changes meanwhile, R_s / L of the voltage.

    Args:
        value: the estimate; 0 for one to which neither matters.
        standard: by the fit, with `dof`.
        scatter: what that was estimated from.
        left_out: largest relative deviation by what the equation of the fit leaves out, a rectangular
            distribution as well.
        saturation: largest deviation by the course of an inductance over the current, in its unit.
    """
    step = known.link_step_V / known.u_dc_V
    late_s = 0.5 * known.drop_V / known.u_dc_V * known.control_period_s
    L = min(known.value("L_d", known.motor.L_d_H), known.value("L_q", known.motor.L_q_H))
    lines = [Contribution(scatter, "A", standard, dof)]
    for name, relative in (
        ("step of the converter of the dc link", step / math.sqrt(12.0)),
        ("moment of sampling", abs(late_s) * known.R_s_ohm / L / math.sqrt(3.0)),
        ("what the equation leaves out", left_out / math.sqrt(3.0)),
    ):
        if value * relative != 0.0:
            lines.append(Contribution(name, "B", abs(value) * relative))
    if saturation > 0.0:
        lines.append(Contribution("course of saturation", "B", saturation / math.sqrt(3.0)))
    found = combined(lines, scatter)
    assert found is not None  # every line is a number
    return found


def of_two(one: Measurement, other: Measurement | None, left_out: float = 0.0) -> Uncertainty | None:
    """Return the uncertainty of the difference of two estimates of one quantity; None where neither states
    one.

    Args:
        one, other: the estimates; the other may be exact, or not have been made.
        left_out: largest deviation by what both leave out, a rectangular distribution.
    """
    lines = [
        each.known_uncertainty.line(each.name)
        for each in (one, other)
        if each is not None and each.known_uncertainty is not None
    ]
    if left_out > 0.0:
        lines.append(Contribution("what the two leave out", "B", left_out / math.sqrt(3.0)))
    return combined(lines, "both estimates") if lines else None
