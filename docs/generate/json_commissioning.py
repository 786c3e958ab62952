"""What `commission` prints with `--json`.

The description of a key is the string literal below it. A key that may be left out has None as its default.
"""

from __future__ import annotations

from typing import Literal

from docs.generate.json_results import Document


class EstimateUncertainty(Document):
    """The uncertainty of an estimate in the terms of the GUM (JCGM 100:2008)."""

    standard: float
    """Combined standard uncertainty u."""
    k: float
    """Coverage factor of 95 %."""
    dof: float | None
    """Effective degrees of freedom; null for infinitely many."""
    expanded: float
    """Expanded uncertainty U, of 95 %."""


class Estimate(Document):
    """One estimate; without a value only `value` and `reason` are there."""

    value: float | None
    """Value per phase, peak; null where the data do not define it."""
    unit: str | None = None
    """Its unit."""
    uncertainty: EstimateUncertainty | None = None
    """Its uncertainty; null where the data give none."""
    method: str | None = None
    """What it is by."""
    nameplate: float | None = None
    """What the profile lets expect, as a nameplate; of `R_s` with what it states to be in series with the
    winding; null where it states nothing."""
    deviation_percent: float | None = None
    """Value over nameplate, less 1, in percent; null where the nameplate states nothing."""
    looks_like: str | None = None
    """What a deviation by a telling factor (2, 3/2, sqrt 3, p, ...) probably is; left out of others."""
    contains: str | None = None
    """What the value contains that its name does not say, as `R_s` the devices; left out of others."""
    order: int | None = None
    """How often in a revolution of the shaft it comes, of the amplitude of a torque; left out of others."""
    reason: str | None = None
    """Why there is no value."""


class CommissionedStep(Document):
    """What became of a step."""

    verdict: Literal["pass", "fail", "skipped"]
    """Whether it passed; skipped: a step that it needs did not."""
    reason: str
    """Why it did not pass; empty if it did."""
    energy_J: float
    """Heat in the winding and work against friction, as planned with what was known then."""
    spent_J: float
    """The same of its captures."""
    resumed: bool
    """Whether an earlier session has done it."""
    sets: list[str]
    """Results that it is for."""


class FoundDeviation(Document):
    """Something that is not as it should be."""

    what: str
    """What was seen, and what was expected."""
    cause: str
    """What probably causes it."""
    remedy: str
    """What to do about it."""


class InConvention(Document):
    """An estimate as a nameplate states it."""

    name: str
    """What, and by which convention: `Ke, line to line, rms`."""
    value: float
    """Its value."""
    unit: str
    """Its unit."""


class Commissioned(Document):
    """`commission`."""

    verdict: Literal["pass", "fail"]
    """pass: every step passed and nothing was found that is not as it should be."""
    steps: dict[str, CommissionedStep]
    """The steps by name, in their order."""
    estimates: dict[str, Estimate]
    """Estimates by the dictionary's names."""
    findings: list[FoundDeviation]
    """What is not as it should be."""
    conventions: list[InConvention]
    """The estimates in every convention of nameplates."""
    parameters: dict[str, float | int | str]
    """What the drive is to hold by it, by the keys of a profile."""
    saved: bool
    """Whether the drive has stored them."""
    not_saved: str
    """Why not; empty if it has."""
    profile: str | None
    """New profile, with the estimates in place of the nameplate's values."""
    bundle: str | None
    """Folder of the recording, a bundle for each step."""
    report: str | None
    """Report as an HTML page."""


class PlannedStep(Document):
    """What a step would put in, and for which parameters."""

    energy_J: float
    """Heat in the winding and work against friction, by the nameplate."""
    sets: list[str]
    """Parameters that its estimates are for."""


class PlannedCommissioning(Document):
    """`commission --dry-run`."""

    dry_run: bool
    """true."""
    steps: dict[str, PlannedStep]
    """The steps by name, in their order."""
    energy_J: float
    """Energy of all steps, by the resistance that is stated."""
    energy_range_J: tuple[float, float]
    """The least and the most of it, as far as that and the friction are off, and with the speed loop tuned
    again."""
