"""A commissioning as one JSON document."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from benchtool.analysis import Measurement
from benchtool.commission.execution import Commissioning, StepResult, StepVerdict

_NAMEPLATE: Mapping[str, str] = {
    "R_s": "R_s_ohm",
    "L_d": "L_d_H",
    "L_q": "L_q_H",
    "psi_r": "psi_r_Wb",
    "pole_pairs": "pole_pairs",
    "J": "J_kgm2",
}
"""Keys of `[motor]` that an estimate is compared with."""


def document(done: Commissioning) -> dict[str, Any]:
    """Return verdict, steps, estimates and findings; neither a profile nor a bundle is written yet."""
    motor = done.known.motor
    estimates: dict[str, Any] = {}
    for result in done.results:
        for name, each in result.estimates.items():
            stated = getattr(motor, _NAMEPLATE[name]) if name in _NAMEPLATE else None
            estimates[name] = _estimate(each, stated)
        if result.verdict is not StepVerdict.PASS:
            estimates |= {name: _nothing(result) for name in result.sets if name not in estimates}
    return {
        "verdict": "pass" if done.passed else "fail",
        "steps": {
            each.name: {"verdict": each.verdict.value, "reason": each.reason, "energy_J": each.planned_J}
            for each in done.results
        },
        "estimates": estimates,
        "findings": [finding.to_json() for each in done.results for finding in each.findings],
        "profile": None,
        "bundle": None,
    }


def _nothing(result: StepResult) -> dict[str, Any]:
    return {"value": None, "reason": f"step {result.name}: {result.reason}"}


def _estimate(of: Measurement, nameplate: float | None) -> dict[str, Any]:
    found: dict[str, Any] = {
        "value": of.value if math.isfinite(of.value) else None,
        "unit": of.unit,
        "uncertainty": None,
        "method": of.definition,
        "nameplate": nameplate,
    }
    if of.uncertainty is not None:
        dof = of.uncertainty.dof
        found["uncertainty"] = {
            "standard": of.uncertainty.standard,
            "k": of.uncertainty.k,
            "dof": dof if math.isfinite(dof) else None,
        }
    if of.reason:
        found["reason"] = of.reason
    return found
