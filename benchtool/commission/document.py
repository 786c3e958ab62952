"""A commissioning as one JSON document."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from benchtool.analysis import Measurement
from benchtool.commission.known import Known
from benchtool.commission.nameplate import contained, conventions, deviation, probable_cause, stated
from benchtool.commission.results import Commissioning, StepResult, StepVerdict


def document(
    done: Commissioning,
    *,
    profile: Path | None = None,
    bundle: Path | None = None,
    report: Path | None = None,
) -> dict[str, Any]:
    """Return verdict, steps, estimates and findings, what the drive stores, and what was written."""
    known, motor = done.known, done.known.motor
    estimates: dict[str, Any] = {}
    for result in done.results:
        for name, each in result.estimates.items():
            estimates[name] = _estimate(each, known)
        if result.verdict is not StepVerdict.PASS:
            estimates |= {name: _nothing(result) for name in result.sets if name not in estimates}
    values = {name: each.value for name, each in done.estimates.items() if math.isfinite(each.value)}
    pole_pairs = round(values.get("pole_pairs", motor.pole_pairs))
    return {
        "verdict": "pass" if done.passed else "fail",
        "steps": {each.name: _step(each) for each in done.results},
        "estimates": estimates,
        "findings": [finding.to_json() for each in done.results for finding in each.findings],
        "conventions": [
            {"name": name, "value": value, "unit": unit}
            for name, value, unit in conventions(values, pole_pairs)
        ],
        "parameters": dict(done.parameters),
        "saved": done.saved,
        "not_saved": done.not_saved,
        "profile": None if profile is None else str(profile),
        "bundle": None if bundle is None else str(bundle),
        "report": None if report is None else str(report),
    }


def _step(result: StepResult) -> dict[str, Any]:
    return {
        "verdict": result.verdict.value,
        "reason": result.reason,
        "energy_J": result.planned_J,
        "spent_J": result.spent_J,
        "resumed": result.resumed,
        "sets": list(result.sets),
    }


def _nothing(result: StepResult) -> dict[str, Any]:
    return {"value": None, "reason": f"step {result.name}: {result.reason}"}


def _estimate(of: Measurement, known: Known) -> dict[str, Any]:
    motor, series_ohm = known.motor, known.series_ohm
    off = deviation(of.name, of.value, motor, series_ohm)
    found: dict[str, Any] = {
        "value": of.value if math.isfinite(of.value) else None,
        "unit": of.unit,
        "uncertainty": None,
        "method": of.definition,
        "nameplate": stated(of.name, motor, series_ohm),
        "deviation_percent": None if off is None else 100.0 * off,
    }
    if of.uncertainty is not None:
        dof = of.uncertainty.dof
        found["uncertainty"] = {
            "standard": of.uncertainty.standard,
            "k": of.uncertainty.k,
            "dof": dof if math.isfinite(dof) else None,
            "expanded": of.uncertainty.expanded,
        }
    if contains := contained(of.name, series_ohm):
        found["contains"] = contains
    if cause := probable_cause(of.name, of.value, motor):
        found["looks_like"] = cause
    if of.basis.order is not None:
        found["order"] = of.basis.order
    if of.reason:
        found["reason"] = of.reason
    return found
