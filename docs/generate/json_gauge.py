"""The JSON document of a gauge study, `gauge`."""

from __future__ import annotations

from docs.generate.json_results import Document, VerdictWord


class Design(Document):
    """How often what was varied; 1 where it was not."""

    parts: int
    """Parts."""
    operators: int
    """Operators."""
    mountings: int
    """Mountings of each part by each operator."""
    repetitions: int
    """Readings of each mounting."""


class VarianceLine(Document):
    """A line of the analysis of variance."""

    dof: int
    """Degrees of freedom."""
    sum_of_squares: float
    """Sum of squares, in the square of the readings' unit."""
    mean_square: float
    """Sum of squares over degrees of freedom."""
    F: float | None
    """Ratio to the mean square that it is tested against."""
    p: float | None
    """Probability of such a ratio by chance."""
    variance: float | None
    """Variance component; `null` of an interaction that was pooled with the error."""


class StandardDeviations(Document):
    """Standard deviations in the unit of the readings."""

    repeatability: float
    """Of repetitions."""
    reproducibility: float
    """Of operators, with their interaction with parts."""
    mounting: float | None
    """Of mounting a part again."""
    gauge: float
    """Of the measurement as a whole."""
    part: float | None
    """Of the parts."""
    total: float
    """Of a reading of any part."""


class GaugeStudied(Document):
    """`gauge`."""

    verdict: VerdictWord
    """Whether `--limit` is kept, by the rule of `--margin`; `none` without it."""
    conformance: float | None = None
    """Probability that %GRR is at most that limit."""
    file: str
    """The table."""
    readings: str
    """Column of the readings."""
    design: Design
    """Parts, operators, mountings, repetitions."""
    anova: dict[str, VarianceLine]
    """Analysis of variance, by the source of variation."""
    standard_deviations: StandardDeviations
    """Standard deviations."""
    gauge_interval: list[float] | None
    """Interval in which that of the gauge lies with 95 %."""
    percent_of_total: float | None
    """%GRR of the total variation."""
    percent_of_total_interval: list[float] | None
    """Interval in which it lies with 95 %."""
    percent_of_tolerance: float | None
    """Six standard deviations of the gauge in percent of the tolerance."""
    percent_of_tolerance_interval: list[float] | None
    """Interval in which that lies with 95 %."""
    ndc: int | None
    """Number of distinct categories."""
    ndc_interval: list[int] | None
    """Interval in which that lies with 95 %."""
