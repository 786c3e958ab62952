"""Uncertainty in the terms of the GUM (JCGM 100:2008): standard, expanded, degrees of freedom, budget."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, Literal

from scipy.special import ndtr, stdtr, stdtrit

COVERAGE: Final = 0.95
"""Coverage probability of an expanded uncertainty."""


@dataclass(frozen=True)
class Contribution:
    """One line of a budget: a standard uncertainty in the unit of the result.

    `evaluation` is A where it comes from the statistics of repeated observations, B where it comes from
    anything else, such as a resolution (JCGM 100:2008, 2.3.2 and 2.3.3); `dof` are its degrees of freedom.
    """

    name: str
    evaluation: Literal["A", "B"]
    standard: float
    dof: float = math.inf

    def to_json(self) -> dict[str, Any]:
        """Its fields; infinite degrees of freedom are null."""
        return {
            "name": self.name,
            "evaluation": self.evaluation,
            "standard": _finite(self.standard),
            "dof": _finite(self.dof),
        }


@dataclass(frozen=True)
class Uncertainty:
    """Combined standard uncertainty of a result, in its unit (JCGM 100:2008, 2.3.1 and 2.3.4).

    `source` says what it was estimated from, and with that what it leaves out. `dof` are the effective
    degrees of freedom, `budget` the contributions; a budget of one line may be left out. `half_width` is half
    of the interval that covers 95 % where a derived distribution gives one; it is then the expanded
    uncertainty in place of a multiple from Student's distribution.
    """

    standard: float
    source: str
    dof: float = math.inf
    budget: tuple[Contribution, ...] = ()
    half_width: float | None = None

    @property
    def expanded(self) -> float:
        """U, half of the interval that covers the true value with a probability of 95 %."""
        if self.half_width is not None:
            return self.half_width
        return coverage_factor(self.dof) * self.standard

    @property
    def k(self) -> float:
        """Coverage factor, U over the standard uncertainty (JCGM 100:2008, 2.3.6)."""
        if self.half_width is not None and self.standard > 0.0:
            return self.half_width / self.standard
        return coverage_factor(self.dof)

    def probability_within(self, least: float, greatest: float) -> float:
        """Probability that the true value less the result lies from `least` to `greatest`: of a normal
        distribution, of Student's with finite degrees of freedom, as wide as the expanded uncertainty says.
        """
        dof, U = max(1.0, self.dof), self.expanded
        if U <= 0.0:
            return 1.0 if least <= 0.0 <= greatest else 0.0
        low, high = (bound * coverage_factor(dof) / U for bound in (least, greatest))
        if math.isfinite(dof):
            return float(stdtr(dof, high) - stdtr(dof, low))
        return float(ndtr(high) - ndtr(low))

    def scaled(self, factor: float, source: str = "") -> Uncertainty:
        """That of the result times a constant."""
        size = abs(factor)
        budget = tuple(
            Contribution(each.name, each.evaluation, size * each.standard, each.dof) for each in self.budget
        )
        width = None if self.half_width is None else size * self.half_width
        return Uncertainty(size * self.standard, source or self.source, self.dof, budget, width)

    def to_json(self) -> dict[str, Any]:
        """Fields and `k`, `coverage` and `expanded` besides; what is not finite is null."""
        document: dict[str, Any] = {
            "standard": _finite(self.standard),
            "dof": _finite(self.dof),
            "k": _finite(self.k),
            "coverage": COVERAGE,
            "expanded": _finite(self.expanded),
            "source": self.source,
        }
        if self.half_width is not None:
            document["half_width"] = _finite(self.half_width)
        if self.budget:
            document["budget"] = [each.to_json() for each in self.budget]
        return document


def combined(
    contributions: Iterable[Contribution], source: str, *, half_width: float | None = None
) -> Uncertainty | None:
    """Root of the sum of squares, with Welch and Satterthwaite's degrees of freedom (JCGM 100:2008, G.4.1).

    None where a contribution is not known (nan): then the whole is not known either.
    """
    budget = tuple(contributions)
    squares = sum(each.standard**2 for each in budget)
    if not math.isfinite(squares):
        return None
    fourth = sum(each.standard**4 / each.dof for each in budget)
    dof = squares**2 / fourth if fourth > 0.0 else math.inf
    return Uncertainty(math.sqrt(squares), source, dof, budget, half_width)


def of_difference(one: Uncertainty, two: Uncertainty) -> Uncertainty:
    """Uncertainty of the difference of two independent results (JCGM 100:2008, 5.1.2 and G.4.1).

    Where a derived distribution gives the interval of one, the intervals' half-widths are combined as the
    standard uncertainties are.
    """
    standard = math.hypot(one.standard, two.standard)
    fourth = (
        sum((each.standard / standard) ** 4 / max(1.0, each.dof) for each in (one, two))
        if standard > 0.0
        else 0.0
    )
    derived = one.half_width is not None or two.half_width is not None
    return Uncertainty(
        standard,
        "both values",
        1.0 / fourth if fourth > 0.0 else math.inf,
        half_width=math.hypot(one.expanded, two.expanded) if derived else None,
    )


def coverage_factor(dof: float) -> float:
    """k of 95 %: the two-sided quantile of Student's distribution (JCGM 100:2008, G.3.2), 1.96 for many."""
    return float(stdtrit(max(1.0, min(dof, 1e12)), 0.5 + 0.5 * COVERAGE))


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
