"""What `twin` prints with `--json`.

The description of a key is the string literal below it. A key that may be left out has None as its default.
"""

from __future__ import annotations

from docs.generate.json_results import Document, Measurement


class Parameter(Measurement):
    """A parameter as the run tells it, beside what is believed."""

    believed: float
    """What the drive held, in `unit`; 0 of an error that it does not correct."""
    difference: float | None
    """Estimate minus belief; null where the run does not tell it."""
    difference_percent: float | None
    """That in percent of the belief; null of a belief of 0."""
    threshold: float
    """Difference beyond which the belief is contradicted: three standard uncertainties, more of them with few
    degrees of freedom, or the tolerance."""
    contradicts: bool
    """Whether it is."""


class Residual(Document):
    """A signal of the twin, less the measured one."""

    unit: str
    """Of the signal."""
    measured_rms: float
    """Rms of the measured signal."""
    residual_rms_believed: float | None
    """Rms of the residual with the parameters that were believed; null where their simulation diverges."""
    residual_rms_estimated: float | None
    """Rms of the residual with those that the run tells; likewise."""
    reason: str | None = None
    """Why a residual is null."""


class TwinCase(Document):
    """One capture beside its twin."""

    bundle: str
    """Folder of the recording."""
    wrong: list[str]
    """Parameters whose belief is contradicted, the plainest first."""
    shared_cause: str | None
    """What explains several of them at once."""
    parameters: dict[str, Parameter]
    """By the names of the dictionary."""
    residuals: dict[str, Residual]
    """By signal: `i_d`, `i_q`, and `omega_m` where the run tells the inertia."""
    motion: str | None = None
    """Why there is no balance of torque."""


class Twins(Document):
    """`twin`."""

    cases: dict[str, TwinCase]
    """By the name of the case."""
    figure: str | None = None
    """The figure that was drawn."""
