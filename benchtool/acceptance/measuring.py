"""What a test measures: values held against limits with unit, margin and decision rule."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from benchtool.acceptance.notes import Notes
    from benchtool.analysis import Measurement, Uncertainty
    from benchtool.plan import Limit, Verdict
    from benchtool.results import Judged


class Measure:
    """Holds values against limits; a test fails at its end if one of them is not met.

        measure("torque_error", error_Nm, "Nm", min=-0.1, max=0.1)
        measure(results["torque_ripple_pp"], max=0.06, margin="U", requirement="REQ-12")

    None, or a value that is not finite, was not measured, and fails. A test that asks for this fixture and
    measures nothing fails, too.
    """

    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        notes.must_measure = True

    def __call__(
        self,
        what: str | Measurement,
        value: float | None = None,
        unit: str = "",
        *,
        min: float | None = None,
        max: float | None = None,
        margin: float | Literal["U"] = 0.0,
        uncertainty: Uncertainty | float | None = None,
        requirement: str = "",
        reason: str = "",
        name: str = "",
    ) -> Verdict:
        """Hold a value against a limit, and return the verdict.

        Args:
            what: name of the quantity, or a measurement, which brings value, unit and uncertainty.
            value: in `unit`; None where it could not be measured.
            unit: of value and bounds.
            min, max, margin: the limit, as a plan states it; `margin = "U"` guards with the expanded
                uncertainty, which must be known then.
            uncertainty: of the value; a number is its standard uncertainty in `unit`.
            requirement: what is met by this limit, besides the requirements of the test.
            reason: why there is no value.
            name: name of the quantity in place of the measurement's.

        Raises:
            ValidationError: no bound, or the least is above the greatest.
        """
        from benchtool.plan import Limit

        below: float | None = None
        if not isinstance(what, str):
            uncertainty = what.uncertainty if uncertainty is None else uncertainty
            value, below, unit, reason = what.value, what.upper_bound, what.unit, reason or what.reason
            what = what.name
        limit = Limit(min=min, max=max, margin=margin)
        judged = held(name or what, value, unit, limit, uncertainty, requirement, reason, below)
        self._notes.judged.append(judged)
        return judged.judge()


def held(
    name: str,
    value: float | None,
    unit: str,
    limit: Limit,
    uncertainty: Uncertainty | float | None = None,
    requirement: str = "",
    reason: str = "",
    below: float | None = None,
) -> Judged:
    """Return a value with its limit and verdict; None, or one that is not finite, was not measured or is
    only known to be less than `below`."""
    from benchtool.results import Judged

    known = value is not None and math.isfinite(value)
    spread: dict[str, Any] = _stated(uncertainty) if known else {}
    found = Judged(
        name=name,
        value=float(value) if known and value is not None else None,
        unit=unit,
        limit=limit,
        requirement=requirement,
        reason=reason or ("" if known else "no finite value"),
        below=below,
        **spread,
    )
    return found.model_copy(update={"verdict": str(found.judge())})


def _stated(uncertainty: Uncertainty | float | None) -> dict[str, float | None]:
    """Return the fields of an uncertainty; nothing where it is not known.

    What few observations add to the standard uncertainty is not in the expanded one, which is stated then.
    """
    if uncertainty is None:
        return {}
    if isinstance(uncertainty, int | float):
        return {"standard": float(uncertainty)} if math.isfinite(uncertainty) else {}
    if not math.isfinite(uncertainty.expanded):
        return {}
    known = {
        "standard": float(uncertainty.standard),
        "dof": float(uncertainty.dof) if math.isfinite(uncertainty.dof) else None,
    }
    multiple = uncertainty.half_width is None and uncertainty.experimental == uncertainty.standard
    return known | {"half_width": None if multiple else float(uncertainty.expanded)}
