"""Limits, the decision rule that turns a value and its uncertainty into a verdict, and the verdict.

The rules are those of JCGM 106:2012: simple acceptance (8.2) and guard bands (8.3).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import Field, field_validator, model_validator

from benchtool.analysis import as_written, raw, with_unit
from benchtool.document import Section, unit_suffix

if TYPE_CHECKING:
    from benchtool.analysis import Uncertainty

SIMPLE: Final = "simple acceptance"
"""The decision rule without a margin: the value alone is compared with the bounds (JCGM 106:2012, 8.2)."""

RATED_UNITS: Final = ("T_N", "omega_m_N", "I_N_peak")
"""Units of a limit that are rated values of the motor."""

_ROUNDING = 1e-9  # relative: of bounds as they are written
_NUMBERS: Final = ("min", "max", "margin")


class Verdict(StrEnum):
    """Verdict on a case or a run, from best to worst; `NONE` without limits."""

    NONE = "none"
    PASS = "pass"
    MARGINAL = "marginal"
    UNDECIDED = "undecided"
    FAIL = "fail"

    @property
    def met(self) -> bool:
        """Whether no limit is missed or undecided, so that a command exits with 0."""
        return self not in (Verdict.UNDECIDED, Verdict.FAIL)


class Waived(Section):
    """Consent to a limit that is not met: why, and by whom."""

    reason: Annotated[str, Field(min_length=1)]
    """Why it need not be met."""
    by: Annotated[str, Field(min_length=1)]
    """Who consents."""


class Limit(Section):
    """Bounds of one measurement in its own unit, and the decision rule.

    `margin` is a number, within which of a bound a value that meets it is marginal; 0 is simple acceptance.
    `margin = "U"` guards both sides of each bound with the expanded uncertainty of the measurement: a value
    further inside passes (guarded acceptance, JCGM 106:2012, 8.3.2), one further outside fails (guarded
    rejection, 8.3.3), and in between it is undecided. `unit` states the unit, or a key does (`max_Nm`); it is
    checked before a run, and nothing is converted. The units `T_N`, `omega_m_N` and `I_N_peak` are parts of
    the motor's rated values (`max_T_N`): each number of the limit states them then (`margin_T_N`), or `unit`
    does for all.
    """

    min: float | None = None
    """Least value; `min_Nm` states the unit."""
    max: float | None = None
    """Greatest value; `max_Nm` states the unit."""
    margin: float | Literal["U"] = 0.0
    """Within this distance of a bound a value is marginal; `"U"` guards with the expanded uncertainty."""
    unit: str | None = None
    """Unit of bounds and margin, which is checked, or `T_N`, `omega_m_N`, `I_N_peak`: parts of the rated."""
    requirement: str | None = None
    """Requirement that this limit is evidence for, as a specification numbers it."""
    waived: Waived | None = None
    """Consent to a value that does not meet the limit: it is reported, and does not count."""

    @model_validator(mode="before")
    @classmethod
    def _unit_of_the_keys(cls, table: Any) -> Any:
        if not isinstance(table, Mapping):
            return table
        for bound in _NUMBERS:
            same = [str(key) for key in table if str(key).partition("_")[0] == bound]
            if len(same) > 1:
                raise ValueError(f"{' and '.join(same)} in one limit, each states the same: leave one out")
        found: dict[Any, Any] = {}
        units = [str(table["unit"])] if isinstance(table.get("unit"), str) else []
        for key, value in table.items():
            bound, _, unit = str(key).partition("_")
            if bound not in _NUMBERS or not unit:
                found[key] = value
                continue
            found[bound] = value
            units.append(unit)
        if len({unit_suffix(unit) for unit in units}) > 1:
            raise ValueError(f"units {' and '.join(units)} in one limit, one is expected: convert the bounds")
        if units and units[0] in RATED_UNITS and "unit" not in table:
            _require_stated(table, units[0])
        return found | ({"unit": units[0]} if units else {})

    @field_validator("margin", mode="before")
    @classmethod
    def _margin_is_known(cls, margin: object) -> object:
        number = isinstance(margin, int | float) and not isinstance(margin, bool)
        if margin != "U" and not (number and 0 <= float(str(margin)) < math.inf):
            raise ValueError('a number from 0 on, or "U" for the expanded uncertainty, is expected')
        return margin

    @model_validator(mode="after")
    def _bounded(self) -> Limit:
        if self.min is None and self.max is None:
            raise ValueError("a limit needs min, max or both")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError(f"min {self.min} is above max {self.max}")
        if self.min is not None and self.max is not None and self.margin != "U":
            most = 0.5 * (self.max - self.min)
            if self.margin > most * (1.0 + _ROUNDING):
                raise ValueError(
                    f"margin {raw(self.margin)} lets no value pass, at most half of max − min is expected, "
                    f"{raw(most)}: state a smaller one"
                )
        return self

    def judge(self, value: float | None, uncertainty: Uncertainty | None = None) -> Verdict:
        """Return the verdict on a value; one that is missing or not finite fails, with `margin = "U"` also an
        expanded uncertainty that is."""
        if value is None or not math.isfinite(value):
            return Verdict.FAIL
        room = self.headroom(value)
        if self.margin == "U":
            U = math.nan if uncertainty is None else uncertainty.expanded
            if not math.isfinite(U) or room < -U:
                return Verdict.FAIL
            return Verdict.PASS if room >= U else Verdict.UNDECIDED
        if room < 0:
            return Verdict.FAIL
        return Verdict.MARGINAL if room < self.margin else Verdict.PASS

    def judge_below(self, below: float) -> Verdict:
        """Return the verdict on an amplitude of which no more is known than that it is less: an upper bound
        is met as far as that is below it, and none of a least amplitude."""
        if self.min is not None and self.min > 0.0:
            return Verdict.FAIL if below < self.min else Verdict.UNDECIDED
        room = self.headroom_below(below)
        if not room > 0.0:
            return Verdict.UNDECIDED
        return Verdict.MARGINAL if self.margin != "U" and room < self.margin else Verdict.PASS

    def counted(self, verdict: Verdict) -> Verdict:
        """Return a verdict on this limit as it counts for the whole: none where it is not met, and waived."""
        return Verdict.NONE if self.waived is not None and not verdict.met else verdict

    def conformance(self, value: float | None, uncertainty: Uncertainty | None) -> float | None:
        """Return the probability that the true value lies within the bounds (JCGM 106:2012, 7), by the
        measurement alone; None where value or uncertainty is not known."""
        if value is None or uncertainty is None:
            return None
        if not (math.isfinite(value) and math.isfinite(uncertainty.expanded)):
            return None
        return uncertainty.probability_within(*self.distances(value))

    def distances(self, value: float) -> tuple[float, float]:
        """Return how far from a value the least and the greatest one are that the bounds allow."""
        least = -math.inf if self.min is None else self.min - value
        return least, math.inf if self.max is None else self.max - value

    def headroom(self, value: float) -> float:
        """Return how far inside the nearer bound a value lies; negative outside."""
        least, greatest = self.distances(value)
        return min(-least, greatest)

    def headroom_below(self, below: float) -> float:
        """Return how far inside the upper bound an amplitude is at least of which no more is known than that
        it is less, or how far outside the lower one; nan where that tells neither."""
        if self.min is not None and self.min > 0.0:
            return below - self.min if below < self.min else math.nan
        return math.inf if self.max is None else self.max - below

    def is_narrower(self, U: float) -> bool:
        """Return whether both bounds lie so close together that a guard band of U on each lets no value
        pass."""
        if self.margin != "U" or self.min is None or self.max is None:
            return False
        return math.isfinite(U) and self.max - self.min < 2.0 * U

    def shortfall(self, value: float, unit: str) -> str:
        """Return the bound that a value in its unit violates and by how much; empty if it violates none."""
        if self.min is not None and value < self.min:
            least, lacking = (
                with_unit(as_written(self.min)[0], unit),
                with_unit(raw(self.min - value, 3), unit),
            )
            return f"at least {least} is asked for: {lacking} too little"
        if self.max is not None and value > self.max:
            greatest, beyond = (
                with_unit(as_written(self.max)[0], unit),
                with_unit(raw(value - self.max, 3), unit),
            )
            return f"at most {greatest} is allowed: {beyond} too much"
        return ""

    @property
    def bounds(self) -> str:
        """`≥ 1, ≤ 2`, or `= 1`, as they were written."""
        if self.min is not None and self.min == self.max:
            return f"= {raw(self.min, 12)}"
        signs = {sign: bound for sign, bound in (("≥", self.min), ("≤", self.max)) if bound is not None}
        texts = as_written(*signs.values())
        return ", ".join(f"{sign} {text}" for sign, text in zip(signs, texts, strict=True))

    @property
    def rule(self) -> str:
        """The decision rule, in words."""
        if self.margin == "U":
            return "guard band U (95 %)"
        return f"marginal within {as_written(self.margin)[0]}" if self.margin else SIMPLE


def _require_stated(table: Mapping[Any, Any], unit: str) -> None:
    """Refuse a bound or a margin without a unit beside one in parts of a rated value: it may be in the unit
    of the measurement. Zero and `"U"` are the same in both."""
    bare = [each for each in _NUMBERS if isinstance(table.get(each), int | float) and table[each] != 0]
    if bare:
        beside = next(str(key) for key in table if str(key).endswith(f"_{unit}"))
        keys = " and ".join(f"{each}_{unit}" for each in bare)
        raise ValueError(
            f"{' and '.join(bare)} without a unit beside {beside}: state {keys}, or each number in the unit "
            f"of the measurement"
        )


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst of several verdicts; `NONE` of none."""
    order = list(Verdict)
    return max(verdicts, key=order.index, default=Verdict.NONE)
