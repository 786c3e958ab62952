"""From recorded blocks to measurements and verdicts: the same for a fresh run and for a bundle read back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from benchtool.analysis import SteadyState, analyze_steady_state
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.experiment.limits import Limit, Verdict, worst
from benchtool.experiment.plan import Plan
from benchtool.profile import Motor
from benchtool.recording import Bundle


@dataclass(frozen=True)
class Assessment:
    """What a case measured, and how each limit was met."""

    case: str
    bundle: Path
    steady: SteadyState
    limits: Mapping[str, Limit]

    @property
    def verdicts(self) -> Mapping[str, Verdict]:
        """Verdict of each limit; a limit on something that was not measured fails."""
        values = {each.name: each.value for each in self.steady.measurements}
        return {name: limit.judge(values.get(name)) for name, limit in self.limits.items()}

    @property
    def verdict(self) -> Verdict:
        return worst(self.verdicts.values())

    def to_json(self) -> dict[str, Any]:
        """The case as the JSON document of a run lists it."""
        return {"bundle": str(self.bundle), "measurements": self.steady.to_json()}


@dataclass(frozen=True)
class RunResult:
    """What every case of a plan came to."""

    assessments: tuple[Assessment, ...]

    @property
    def verdict(self) -> Verdict:
        return worst(each.verdict for each in self.assessments)

    def to_json(self) -> dict[str, Any]:
        """The document that `--json` prints."""
        return {
            "verdict": str(self.verdict),
            "cases": {each.case: each.to_json() for each in self.assessments},
        }


def assess(
    plan: Plan, case: str, motor: Motor, bundle: Path, capture: Block, transducer: Block | None
) -> Assessment:
    """Analyse what one case recorded.

    Raises:
        AnalysisError: the data cannot answer what the plan asks.
    """
    steady = analyze_steady_state(
        capture, pole_pairs=motor.pole_pairs, torque_rated_Nm=motor.T_N_Nm, transducer=transducer
    )
    return Assessment(case, bundle, steady, plan.limits)


def assess_bundle(bundle: Bundle) -> Assessment:
    """Analyse a bundle again, by the plan and the motor that it carries.

    Raises:
        AnalysisError: it is not of a plan, or its data cannot answer what the plan asks.
    """
    details = bundle.manifest.details
    try:
        plan, motor = Plan.model_validate(details["plan"]), Motor.model_validate(details["motor"])
        case = str(details["case"])
    except (KeyError, ValidationError):
        raise AnalysisError(
            f"{bundle.directory} carries no plan that this version understands: analyse a bundle that "
            f"'benchtool run' wrote"
        ) from None
    if "capture" not in bundle.streams:
        failure = details.get("failure", "it was cut short")
        raise AnalysisError(f"{bundle.directory} holds no capture ({failure}): run the plan again")
    transducer = bundle.block("transducer") if "transducer" in bundle.streams else None
    return assess(plan, case, motor, bundle.directory, bundle.block("capture"), transducer)
