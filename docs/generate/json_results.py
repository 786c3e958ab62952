"""What runs print with `--json`: measurements, their uncertainty, limits, cases.

The description of a key is the string literal below it. A key that may be left out has None as its default.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

Plain = int | float | str | None
VerdictWord = Literal["none", "pass", "marginal", "undecided", "fail"]


class Document(BaseModel):
    """A JSON object: keys that are not listed are refused."""

    model_config = ConfigDict(extra="forbid")


class Correction(Document):
    """A known effect of a sensor that was corrected (JCGM 100:2008, 3.2.3)."""

    added: float
    """What was added to the value as it was read, in the unit of the measurement."""
    of: str
    """The effect, whose it is, and what is known of it."""


class Contribution(Document):
    """One line of an uncertainty's budget."""

    name: str
    """What contributes."""
    evaluation: Literal["A", "B"]
    """Type A, from the scatter of the data, or type B, from other knowledge (JCGM 100:2008)."""
    standard: float | None
    """Standard uncertainty that it adds, in the unit of the measurement."""
    dof: float | None
    """Degrees of freedom; null for infinitely many."""
    instrument: dict[str, Any] | None = None
    """The instrument that it is of, where the profile states one."""
    sign: Literal[-1, 1] | None = None
    """Sign with which the instrument's error enters."""
    of_student: bool | None = None
    """Whether the standard uncertainty is the standard deviation of Student's distribution: the experimental
    one times sqrt(dof / (dof - 2)), with fewer than 2.5 degrees of freedom times sqrt(2 dof)."""
    adds_power: bool | None = None
    """Whether it is what noise adds to a root of powers, in every record alike."""


class Uncertainty(Document):
    """The uncertainty of a measurement in the terms of the GUM (JCGM 100:2008)."""

    standard: float | None
    """Combined standard uncertainty u: a standard deviation, to which few observations add (JCGM 101:2008,
    6.4.9.4), so that ±2u holds about 95 % of few as of many."""
    experimental: float | None
    """Experimental standard uncertainty s: the same by the experimental standard deviations of the
    contributions of type A (JCGM 100:2008, 4.2.3), without what few observations add."""
    dof: float | None
    """Effective degrees of freedom; null for infinitely many."""
    student_factor: float | None
    """Student's factor t of 95 % and these degrees of freedom (JCGM 100:2008, G.3.2): U = t s. Null where
    there is a half_width, which U is then."""
    k: float | None
    """Coverage factor U / u: t where few observations add nothing to u, else less."""
    coverage: float
    """Probability that the interval covers the value: 0.95."""
    expanded: float | None
    """Expanded uncertainty U."""
    source: str
    """What it was estimated from, the larger part first."""
    half_width: float | None = None
    """Half of the interval, where its distribution is not Student's."""
    budget: list[Contribution] | None = None
    """The contributions, where there is more than one."""


class Basis(Document):
    """What a measurement rests on; what does not apply is left out."""

    samples: float | None = None
    """Samples used, a whole number: of whole periods the nearest."""
    sample_rate_Hz: float | None = None
    """Their rate."""
    duration_s: float | None = None
    """The time that they span."""
    bandwidth_Hz: float | None = None
    """Components up to this frequency could contribute."""
    window: str | None = None
    """Window and what it spans."""
    harmonics: int | None = None
    """Highest harmonic counted."""
    reference: str | None = None
    """What a ratio is a ratio to."""
    gaps: int | None = None
    """Places where rows are missing."""
    sensors: str | None = None
    """What is not known of the sensors."""
    line_Hz: float | None = None
    """The line of the spectrum that is meant; lines of two runs are compared where they are the same."""
    frequency_Hz: float | None = None
    """The frequency of the line that the number is; of a table of orders that of the first."""
    order: int | None = None
    """How often in a revolution the component repeats itself that the number is of."""
    bin_Hz: float | None = None
    """Width of the bins that noise is stated of; noise of two runs is compared where it is the same."""
    band: float | None = None
    """Half the width, in the signal's unit, within which it counts as settled; compared likewise."""
    span_s: float | None = None
    """How long after a step the samples count; compared likewise."""
    angle_Hz: float | None = None
    """Electrical frequency by the rotor angle, where the phase of the signal gave another."""
    flat_crest: float | None = None
    """Share of a period for which a current is level at its crest, if it is."""
    alignment_s: float | None = None
    """Standard uncertainty with which samples of another clock stand at the drive's ticks."""


class Measurement(Document):
    """One number with its definition."""

    value: float | None
    """The value in `unit`; null where it is undefined."""
    unit: str
    """Its unit; empty for a pure number."""
    definition: str
    """One line that lets another person compute the same number."""
    reason: str | None = None
    """Why it is undefined."""
    basis: Basis | None = None
    """What it rests on."""
    uncertainty: Uncertainty | None = None
    """Its uncertainty, where the data give one."""
    uncertainty_reason: str | None = None
    """Why a value has none."""
    repeatability: Contribution | None = None
    """By how much the value of another record of the same state differs besides."""
    correction: Correction | None = None
    """What was added to the value as it was read, for a known effect of a sensor."""
    below: float | None = None
    """What an amplitude without a value is less than."""


class Column(Document):
    """A column of a table of results."""

    name: str
    """Its name."""
    unit: str
    """Its unit."""


class ResultTable(Document):
    """A result that is a table, such as the harmonics of a current."""

    definition: str
    """What its rows are."""
    uncertainty_reason: str | None = None
    """Why rows have no uncertainty."""
    basis: Basis
    """What it rests on."""
    columns: list[Column]
    """Its columns."""
    rows: list[list[float | str | None]]
    """Its rows, a value for each column."""


class Coordinates(Document):
    """Coordinates of a case in its plan."""

    group: str
    """Name of the case without its repetition."""
    variant: str
    """Name of the variant."""
    point: dict[str, float | str]
    """Swept values."""
    repetition: int
    """Number of the repetition, from 1."""


class LimitDocument(Document):
    """A limit and what came of it."""

    min: float | None = None
    """Least value."""
    max: float | None = None
    """Greatest value."""
    margin: float | Literal["U"]
    """Margin of the plan."""
    unit: str | None = None
    """Unit, where the plan states it."""
    rule: str
    """Decision rule in words."""
    verdict: VerdictWord
    """Verdict on the measurement."""
    remark: str | None = None
    """That no value can pass, with bounds closer together than 2 U."""
    conformance: float | None = None
    """Probability that the true value lies within the bounds."""
    conformance_reason: str | None = None
    """Why there is no such probability: value or uncertainty are not known."""
    requirement: str | None = None
    """Requirement that the limit is evidence for."""
    waived: dict[str, str] | None = None
    """Of a limit that need not be met: `reason`, and `by` whom."""


class DisagreementDocument(Document):
    """A number of which the drive's estimate and the torque transducer differ beyond their uncertainty."""

    estimate: float | None
    """By the drive's own estimate."""
    transducer: float | None
    """By the transducer on the shaft."""
    unit: str
    """Unit of both."""
    standard_uncertainty: float | None
    """Standard uncertainty of the difference."""
    verdict_by_transducer: VerdictWord | None
    """Verdict by the transducer, where a limit holds for the number."""
    estimate_in_band: float | None = None
    """By the estimate in the band of a transducer that is slower than the capture: what was compared."""
    transducer_in_band: float | None = None
    """What the transducer read, which it was compared with."""
    band_Hz: float | None = None
    """Where that band ends."""


class Overdue(Document):
    """An instrument that was used after its calibration was due."""

    channel: str
    """Channel that it measures."""
    sensor: str
    """Its type."""
    serial_number: str
    """Its serial number."""
    certificate: str
    """Its certificate."""
    due: str
    """Day on which the calibration was due."""
    on: str
    """Day of the run."""


class LimitOfRepetitions(Document):
    """A limit that holds for all repetitions of a case together."""

    min: float | None = None
    """Least value."""
    max: float | None = None
    """Greatest value."""
    margin: float | Literal["U"]
    """Margin of the plan."""
    unit: str | None = None
    """Unit, where the plan states it."""
    rule: str
    """Decision rule in words."""
    requirement: str | None = None
    """Requirement that the limit is evidence for."""
    waived: dict[str, str] | None = None
    """Of a limit that need not be met: `reason`, and `by` whom."""


class LimitsTogether(Document):
    """Limits that one repetition of a case is not held against alone."""

    judge: Literal["mean", "worst"]
    """What of the repetitions is held against them."""
    repetitions: int
    """Number of repetitions that belong together."""
    limits: dict[str, LimitOfRepetitions]
    """Limits by measurement; the verdicts are those of `repeated`."""


class Case(Document):
    """One case: what was measured and judged."""

    bundle: str
    """Folder of its recording."""
    coordinates: Coordinates
    """Where it stands in the plan."""
    verdict: VerdictWord
    """Verdict by the drive's own estimate; none where `limits` are met and there are `limits_together`."""
    verdict_by_transducer: VerdictWord | None
    """Verdict by the torque transducer, where there is one."""
    missed: list[str]
    """A sentence for each limit that was not clearly met."""
    waived: dict[str, str]
    """A sentence for each limit that was not met and does not count, by measurement."""
    limits: dict[str, LimitDocument]
    """Limits by measurement."""
    disagreements: dict[str, DisagreementDocument]
    """Numbers of which estimate and transducer differ, by measurement."""
    refusal: str
    """Why nothing could be measured; empty otherwise."""
    not_measured: dict[str, list[str]]
    """Analyses that were not made, by title, with the channels that they lack."""
    refused: dict[str, str]
    """Analyses that the rows do not allow, by title, with the reason."""
    different_parameters: dict[str, Any]
    """Parameters in which drive and profile differ."""
    unstated_parameters: dict[str, Any]
    """Parameters that the profile does not state and the drive does not have at their default."""
    measurements: dict[str, Measurement]
    """Measurements by name; see [measurements](measurements.md)."""
    source: dict[str, Any] | None = None
    """Of a recording: stream, hash, rate and part that was measured."""
    overdue: list[Overdue] | None = None
    """Instruments whose calibration was due."""
    remarks: list[str] | None = None
    """A sentence for each oddity of what was recorded, such as an encoder that slips."""
    tables: dict[str, ResultTable] | None = None
    """Results that are tables, by name."""
    limits_together: LimitsTogether | None = None
    """Limits that hold for the repetitions of this case together."""


class RepeatedDocument(Document):
    """A measurement over the repetitions of a case."""

    mean: float | None
    """Mean of the repetitions."""
    standard_uncertainty: float | None
    """Standard uncertainty of the mean."""
    n: int
    """Number of repetitions."""
    unit: str
    """Unit of the mean."""
    remark: str | None = None
    """That some repetitions have no value, with the reason."""
    reason: str | None = None
    """Why there is no mean."""
    below: float | None = None
    """What the mean is less than where there is none, as some repetitions only tell a bound."""
    uncertainty: Uncertainty | None = None
    """Its uncertainty."""
    uncertainty_reason: str | None = None
    """Why it has none."""
    limit: LimitDocument | None = None
    """The limit that holds for all repetitions together."""
    disagreement: DisagreementDocument | None = None
    """Where estimate and transducer differ."""


class Run(Document):
    """`demo`, `run` of one plan, and `analyze` of a run."""

    verdict: VerdictWord
    """The worst verdict of the cases and of their repetitions together; undecided of one repetition alone,
    where limits hold for all together."""
    verdict_by_transducer: VerdictWord | None
    """The same by the torque transducer."""
    cases: dict[str, Case]
    """Cases by name."""
    repeated: dict[str, dict[str, RepeatedDocument]] | None = None
    """Measurements over the repetitions, by case and name."""


class Plans(Document):
    """`run` of a folder of plans."""

    verdict: VerdictWord
    """The worst verdict of the plans."""
    plans: dict[str, Run]
    """Plans by name."""


class Verified(Document):
    """`verify`."""

    verdict: Literal["pass", "fail"]
    """Whether every file fits its hash and every result its data."""
    folder: str
    """Folder of the run."""
    files: int
    """Files that fit their hashes."""
    recomputed: int
    """Results that the raw data give to the bit."""
    damaged: dict[str, str]
    """Files that do not fit, with what is wrong."""
    different: dict[str, str]
    """Results that the raw data do not give, with what they give."""
    not_recomputed: dict[str, str]
    """Bundles whose results were not measured again, with the reason."""
    unlisted: list[str]
    """Files without a hash."""
    incomplete: list[str]
    """Of runs that did not come to their end: what is there, and what to do."""
