"""Torque and its ripple: the drive's estimate, and the torque of a transducer."""

from __future__ import annotations

from typing import Final

from numpy.polynomial import Polynomial

from benchtool.analysis.crop import crop_to
from benchtool.analysis.declaration import Analysis, Findings, NoSettings, Quantity
from benchtool.analysis.drawings import STEADY, TORQUE, WAVEFORMS
from benchtool.analysis.measurement import Measurement
from benchtool.analysis.numbers import raw
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.spectra.current import current_of
from benchtool.analysis.torque.estimate_error import TorqueOfBoth
from benchtool.analysis.torque.ripple import ripple_numbers
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.errors import AnalysisError


def torque_ripple(
    block: Block,
    channel: str = "torque",
    *,
    torque_rated_Nm: float | None = None,
    track: PhaseTrack | None = None,
    pole_pairs: int = 1,
    what: str = "",
) -> tuple[Measurement, ...]:
    """Return mean torque and torque ripple of one channel, in Nm: `ripple_numbers` under the names torque_*.

    `torque_rated_Nm` is the base of the numbers "of rated", which are left out without it. The other
    arguments and the errors are those of `ripple_numbers`.
    """
    reference = _REFERENCE if channel == "torque" and _REFERENCE in block.names else ""
    return ripple_numbers(
        block,
        channel,
        "torque",
        rated=torque_rated_Nm,
        track=track,
        pole_pairs=pole_pairs,
        what=what,
        reference=reference,
    )


def transducer_torque(
    transducer: Block,
    block: Block,
    *,
    estimate: Measurement | None = None,
    torque_rated_Nm: float | None = None,
    track: PhaseTrack | None = None,
    pole_pairs: int = 1,
) -> tuple[Measurement, ...]:
    """Return the mean and ripple of the torque that a transducer measured, and the error of the drive's
    estimate of it.

    The numbers are those of `torque_ripple` under the names transducer_torque_*.

    Args:
        transducer: channel torque_transducer, at any rate, covering the time of `block`.
        block: the capture, without gaps.
        estimate: `torque_mean` of `block`; torque_error is left out without it.
        torque_rated_Nm: the base of the numbers "of rated", which are left out without it.
        track: phase over the rows of `block`.
        pole_pairs: electrical periods in a mechanical revolution.

    Raises:
        AnalysisError: a gap, a time that is not covered, or a dead signal.
    """
    inside = crop_to(transducer, block)
    rows = None if track is None else _at_rows_of(track, inside, block)
    first = (inside.first_tick - transducer.first_tick) // transducer.stride
    begin_s, end_s = (row / inside.sample_rate_Hz for row in (first, first + len(inside.data)))
    what = (
        f"torque_transducer from {raw(begin_s)} s to {raw(end_s)} s after its first row, the time of the "
        f"capture (its rows {first} to {first + len(inside.data) - 1}, from 0)"
    )
    numbers = ripple_numbers(
        inside,
        "torque_transducer",
        "transducer_torque",
        rated=torque_rated_Nm,
        track=rows,
        pole_pairs=pole_pairs,
        what=what,
    )
    if estimate is None:
        return numbers
    per_revolution = 1 if track is None or track.residual_rad is None else pole_pairs
    both = TorqueOfBoth(block, inside, estimate, numbers[0], track, rows, per_revolution)
    return (*numbers, both.error(what))


def _at_rows_of(track: PhaseTrack, fine: Block, coarse: Block) -> PhaseTrack:
    """Return the same phase over the rows of a block of another rate."""
    step_s, coarse_step_s = fine.stride * fine.tick_s, coarse.stride * coarse.tick_s
    offset_s = fine.first_tick * fine.tick_s - coarse.first_tick * coarse.tick_s
    row = Polynomial([offset_s / coarse_step_s, step_s / coarse_step_s])
    departure = track.departure
    return PhaseTrack(
        track.phase(row),
        len(fine.data),
        track.source,
        track.residual_rad,
        departure=None if departure is None else lambda numbers: departure(row(numbers)),
        follows_signal=track.follows_signal,
        told_to=(track.told_to * coarse_step_s - offset_s) / step_s,
    )


_REFERENCE: Final = "torque_reference"
_NO_BASE: Final = (
    "undefined where |mean| is less than five of its standard uncertainties, half of pp where these are not "
    "known, or 2 % of pp"
)
_NUMBERS: Final = (
    (
        ("mean",),
        "Nm",
        "mean(x) over time, less what the incomplete last period makes of it, by as much of each whole one, "
        "or of the whole periods alone behind which no phase is told, moved along their course, and less "
        "incomplete cycles of sinusoids slower than a period, or faster and no harmonics of it; of eight "
        "revolutions or more whose slow orders stand out likewise over these",
        "s of the periods' means x sqrt(tau / N_p), less these sinusoids as far as they stand out and a "
        "drift of few constants, or by the five lowest frequencies where these hold less than a fifth of "
        "that, or by the density continued to zero frequency where that is 1.4 times as much, of few "
        "periods where it is more (none where it rises more steeply than that of 1/f noise), or of few "
        "pooled with it where it does not rise; less where it probably falls there, level above or with a "
        "crest; a torque_reference that it follows tells that density too; by how much what was "
        "taken out differs from period to period; resolution, by errors of steps that repeat, or along a "
        "record whose lines take the periods over the steps",
    ),
    (
        ("ripple_pp",),
        "Nm",
        "max(x) - min(x)",
        "how much the peak-to-peak of another record of this length differs: of the largest of the periods' "
        "maxima and of minima (of the curve between rows, where these differ by half as much, and not as "
        "something that repeats) by the generalised extreme value distribution of their L-moments, over all "
        "its shapes, and no less than of normal noise (Phi^N); of heavy tails, or where neighbours are "
        "alike, pi / sqrt(6) times the mean excess of the 1.5 sqrt(N_p) largest over the next, over that of "
        "scale 1 (Gumbel's distribution; of heavy tails Fréchet's), of up to twenty periods no less than 0.6 "
        "of their own s, and that of max - min where both grow together; "
        "of independent samples with heavy tails the root mean square of that and of what the largest "
        "twentieth of the samples says; "
        "of heaps 0.46 times the distance of the next; on a drift no less than their own s; none where the "
        "ripple grows or falls over the whole record; "
        "of a beat by its larger periods and where in it the record begins; the error of the mean size "
        "where it wanders; of samples at the same places of all periods the root mean square by which they "
        "miss the extremes of the curve between them; and resolution / sqrt(6), in U a whole step",
    ),
    (
        ("ripple_rms",),
        "Nm",
        "sqrt(mean((x - mean(x))^2) - q^2 / 12) in steps of q, of few steps the mean square that they add to "
        "signals that would be read alike in place of q^2 / 12; less the same as of the mean",
        "likewise of the periods' mean squares, over 2 rms, times 1 + half of the skewness of their mean, "
        "twice its share of them at least (mean squares that are low by chance scatter little); "
        "u(mean)^2 / (2 rms), by noise that moves the mean in place of the rms (none where u(mean) is not "
        "known, or of slow sinusoids that beat less than once)",
    ),
    (
        ("ripple_percentile_range",),
        "Nm",
        "99.5th - 0.5th percentile",
        "s of the periods' shares beyond the percentiles, less those expected of slow sinusoids and of a "
        "drift, of the mean and of the ripple's size as in a beat, x what the percentile moves with them x "
        "sqrt(tau / N_p), or by the density at zero frequency "
        "that does not fall; up to sqrt(1 + 2 / n) times as much where n of the periods, fewer than half, "
        "hold what is beyond; 1.27 s of those of eighths of the record, or of few single periods, / sqrt(n) "
        "besides, where the ripple's size differs by more and neighbours have it alike, or periods are few; "
        "where in a slow cycle the record begins; the curve between samples as for max - min; "
        "resolution / sqrt(6), "
        "in U a whole step; u(mean)^2 as for the rms; none of fewer than four periods, or of "
        "values that are held and fewer than 18 in a period",
    ),
    (("ripple_percent_of_mean",), "%", f"100 pp / |mean|; {_NO_BASE}", "those of pp and mean"),
    (("ripple_rms_percent_of_mean",), "%", f"100 rms / |mean|; {_NO_BASE}", "those of rms and mean"),
    (("ripple_percent_of_rated",), "%", "100 pp / T_N", "that of pp"),
    (("ripple_rms_percent_of_rated",), "%", "100 rms / T_N", "that of rms"),
)
_LABELS: Final = {"torque_ripple_pp": "ripple"}
_HEADLINE: Final = ("torque_ripple_pp", "transducer_torque_ripple_pp")


def _quantities(of: str) -> tuple[Quantity, ...]:
    """Return the mean and ripple under the names OF_mean, OF_ripple_pp, ..."""
    return tuple(
        Quantity(
            names := tuple(f"{of}_{each}" for each in ends),
            unit,
            formula,
            uncertainty,
            label=_LABELS.get(names[0], ""),
            headline=names[0] in _HEADLINE,
        )
        for ends, unit, formula, uncertainty in _NUMBERS
    )


def _of_estimate(window: Window) -> tuple[Measurement, ...]:
    """Return the mean and ripple of the drive's estimate."""
    what = "the drive's estimate torque"
    return torque_ripple(
        window.block,
        torque_rated_Nm=window.torque_rated_Nm,
        track=_followed(window),
        pole_pairs=window.pole_pairs,
        what=what,
    )


def _followed(window: Window) -> PhaseTrack | None:
    """Return the track by the angle, or without one that of the current, which its spectrum follows also
    while its frequency changes."""
    if window.track is None or window.track.residual_rad is not None:
        return window.track
    try:
        return window.cached(current_of).track
    except AnalysisError:  # too fast to be followed
        return window.track


def _of_transducer(window: Window) -> tuple[Measurement, ...]:
    """Return mean and ripple of the transducer's torque and, if there is an estimate, its error."""
    assert window.transducer is not None
    estimate = window.cached(_of_estimate)[0] if "torque" in window.block.names else None
    return transducer_torque(
        window.transducer,
        window.block,
        estimate=estimate,
        torque_rated_Nm=window.torque_rated_Nm,
        track=_followed(window),
        pole_pairs=window.pole_pairs,
    )


def _measure_ripple(window: Window, _: NoSettings) -> Findings:
    return Findings(window.cached(_of_estimate))


def _measure_true_ripple(window: Window, _: NoSettings) -> Findings:
    found = window.cached(_of_transducer)
    return Findings(tuple(each for each in found if each.name != "torque_error"))


def _measure_error(window: Window, _: NoSettings) -> Findings:
    found = window.cached(_of_transducer)
    return Findings(tuple(each for each in found if each.name == "torque_error"))


TORQUE_RIPPLE: Final = Analysis(
    name="torque_ripple",
    title="torque ripple",
    measure=_measure_ripple,
    quantities=_quantities("torque"),
    settings=NoSettings,
    channels=("torque",),
    figures=(WAVEFORMS,),
    comparisons=(TORQUE, STEADY),
)
TRANSDUCER_TORQUE_RIPPLE: Final = Analysis(
    name="transducer_torque_ripple",
    title="torque ripple on the shaft",
    measure=_measure_true_ripple,
    quantities=_quantities("transducer_torque"),
    settings=NoSettings,
    transducer=True,
)
TORQUE_ERROR: Final = Analysis(
    name="torque_error",
    title="error of the torque estimate",
    measure=_measure_error,
    quantities=(
        Quantity(
            ("torque_error",),
            "Nm",
            "mean of the estimate - mean of the transducer",
            "scatter of the difference over periods, which a load that wanders is not in, and what steps "
            "leave uncertain of each mean, of the rows above",
        ),
    ),
    settings=NoSettings,
    channels=("torque",),
    transducer=True,
)
