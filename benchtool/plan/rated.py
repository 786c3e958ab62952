"""A plan in parts of rated values, which fits any motor, in SI for one motor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from benchtool.errors import PlanError
from benchtool.plan.limits import RATED_UNITS, Limit
from benchtool.plan.model import OF_RATED, Plan
from benchtool.profile import Motor


def for_motor(plan: Plan, motor: Motor) -> Plan:
    """Return the plan with setpoints and limits in SI that it states in parts of rated values.

    Those are `load_torque_of_rated` and its like of the operating point and of its sweep, and limits whose
    unit is `T_N`, `omega_m_N` or `I_N_peak`.
    """
    point = plan.operating_point
    in_si: dict[str, Any] = {}
    for key, si in OF_RATED.items():
        if (part := getattr(point, key)) is not None:
            in_si |= {key: None, si: part * _rated_of(si, motor)}
    swept = {
        OF_RATED.get(key, key): values
        if key not in OF_RATED
        else tuple(each * _rated_of(OF_RATED[key], motor) for each in values)
        for key, values in plan.sweep.operating_point.items()
    }
    changed: dict[str, Any] = {
        "operating_point": point.model_copy(update=in_si),
        "sweep": plan.sweep.model_copy(update={"operating_point": swept}),
        "limits": _in_si(plan.limits, motor),
        "case_limits": {case: _in_si(limits, motor) for case, limits in plan.case_limits.items()},
    }
    return plan.model_copy(
        update={key: value for key, value in changed.items() if value != getattr(plan, key)}
    )


def require_in_si(plan: Plan) -> None:
    """Refuse a plan that is still in parts of rated values, or for several profiles.

    Raises:
        PlanError: it is.
    """
    stated = [key for key in OF_RATED if getattr(plan.operating_point, key) is not None]
    stated += [key for key in plan.sweep.operating_point if key in OF_RATED]
    if stated:
        raise PlanError(
            f"plan '{plan.title}' states {', '.join(stated)}, of no motor yet: run it with a profile, by "
            f"benchtool run or benchtool.run_plan"
        )


def _rated_of(key: str, motor: Motor) -> float:
    return motor.T_N_Nm if key.endswith("_Nm") else motor.omega_m_N_rad_s


def _in_si(limits: Mapping[str, Limit], motor: Motor) -> dict[str, Limit]:
    values = (motor.T_N_Nm, "Nm"), (motor.omega_m_N_rad_s, "rad/s"), (math.sqrt(2.0) * motor.I_N_A_rms, "A")
    units = dict(zip(RATED_UNITS, values, strict=True))
    found = {}
    for name, limit in limits.items():
        rated, unit = units.get(limit.unit or "", (1.0, limit.unit))
        found[name] = limit if unit == limit.unit else _scaled(limit, rated, unit)
    return found


def _scaled(limit: Limit, rated: float, unit: str | None) -> Limit:
    bounds = {key: getattr(limit, key) for key in ("min", "max", "margin")}
    scaled = {key: each * rated for key, each in bounds.items() if isinstance(each, float)}
    return limit.model_copy(update={**scaled, "unit": unit})
