"""Whether two numbers are of one quantity, and the uncertainty of their difference."""

from __future__ import annotations

from typing import Final

from benchtool.analysis import Correction, Measurement, Uncertainty, of_difference, raw, with_unit

_SAME_LINE = 2.0  # bins of both spectra: half the main lobe of a Hann window
SAME: Final = 0.01
"""Relative: of the longer record, whose whole periods differ by less; of the wider bin or band."""


def of_two_quantities(one: Measurement, two: Measurement) -> str:
    """Return why two values are not of one quantity, so that nothing is decided; empty if they are."""
    return (
        _other_line(one, two)
        or _other_order(one, two)
        or _other_extent(one, two)
        or _corrected_alone(one, two)
    )


def why_undecided(one: Measurement, two: Measurement) -> str:
    """Return why the difference of two values has no uncertainty; empty where it has one or nothing is known
    of a value."""
    if not (one.is_told and two.is_told):
        return ""
    here, there = (
        each.uncertainty_reason or "it has no uncertainty"
        if each.uncertainty is None and each.upper_bound is None
        else ""
        for each in (one, two)
    )
    if here == there:
        return here
    told = (f"in the reference, {here}" if here else "", f"here, {there}" if there else "")
    return "; ".join(filter(None, told))


def _other_line(one: Measurement, two: Measurement) -> str:
    """Return why the largest lines of two spectra may be two lines of each; empty if they are one."""
    here, there = one.basis, two.basis
    if here.line_Hz is None or there.line_Hz is None or not here.duration_s or not there.duration_s:
        return ""
    if abs(there.line_Hz - here.line_Hz) <= _SAME_LINE * (1.0 / here.duration_s + 1.0 / there.duration_s):
        return ""
    return (
        f"the largest line is at {raw(here.line_Hz, 6)} Hz in the reference and at "
        f"{raw(there.line_Hz, 6)} Hz here: two lines, whose numbers are not compared"
    )


def _other_order(one: Measurement, two: Measurement) -> str:
    """Return that two amplitudes are those of two orders; empty if they are of one."""
    here, there = one.basis.order, two.basis.order
    if here is None or there is None or here == there:
        return ""
    return (
        f"the largest order is {here} in the reference and {there} here: two orders, whose numbers are not "
        f"compared"
    )


def _other_extent(one: Measurement, two: Measurement) -> str:
    """Return that noise is stated of bins of other widths, that a signal settled within another band, or that
    a transient was followed for another time; empty if they are the same."""
    here, there = one.basis, two.basis
    if bins := _unlike(here.bin_Hz, there.bin_Hz, "Hz"):
        return (
            f"a bin is {bins[0]} wide in the reference and {bins[1]} here, and holds another share of the "
            f"noise: compare its density"
        )
    if bands := _unlike(here.band, there.band, ""):
        return (
            f"it counts as settled within {bands[0]} of its level in the reference and within {bands[1]} "
            f"here, by the step or the noise of each record"
        )
    if spans := _unlike(here.span_s, there.span_s, "s"):
        return f"samples count for {spans[0]} after the step in the reference and for {spans[1]} here"
    return ""


def _unlike(one: float | None, two: float | None, unit: str) -> tuple[str, str] | None:
    """Return two sizes with their unit where they differ; None where they are the same, or one is not
    stated."""
    if one is None or two is None or abs(one - two) <= SAME * max(one, two):
        return None
    return with_unit(raw(one, 4), unit), with_unit(raw(two, 4), unit)


def _corrected_alone(one: Measurement, two: Measurement) -> str:
    """Return that one number alone is corrected for its sensors by more than the uncertainty of both; empty
    if neither is."""
    match one.correction, two.correction:
        case Correction() as correction, None:
            which = "the reference"
        case None, Correction() as correction:
            which = "this"
        case _:
            return ""
    uncertainty = uncertainty_of_difference(one, two)
    if uncertainty is not None and abs(correction.added) <= uncertainty.expanded:
        return ""
    return (
        f"{which} alone is corrected, by {raw(correction.added, 4)} {one.unit} for the {correction.of}: a "
        f"number that is corrected and one as it was read are not compared, state the sensor's bandwidth of "
        f"both runs"
    )


def uncertainty_of_difference(one: Measurement, two: Measurement) -> Uncertainty | None:
    """Return that of the difference of two values, with the repeatability of both; None where one has
    none."""
    first, second = one.uncertainty_of_state, two.uncertainty_of_state
    if first is None or second is None:
        return None
    return of_difference(first, second, (one.value, two.value))
