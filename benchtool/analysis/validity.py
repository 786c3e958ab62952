"""Validity checks of signals, common to all analyses."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.ticks import TICKS

_FEWEST_IN_A_ROW, _FEWEST_APART, _CLIPPED_SHARE = 8, 5, 2e-3
_OFTENER, _VALUES_BESIDE, _FEWEST_VALUES = 4.0, 3, 16
_ONE_VALUE = 1e-10  # of the peak-to-peak: nearer values differ by rounding
_FEWEST_TURNS = 6  # from one of two counts to the other, at rest
_CRESTS_BY_CHANCE = 1e-4  # of crests of waves in steps
_LOOKED_AT = 1 << 16  # samples, to count values by
_RARELY, _LONG = 0.02, 30  # of neighbours are equal; samples in a row
_FEWEST_HELD, _BY_CHANCE, _JUMPS = 6, 1e-6, 4.0  # samples; of a record; of the usual change
_FEWEST_STAYS = 10  # values that are held as long, by which is told how many of them are held on
_FEWEST_RUNS, _REGULAR_RUNS = 20, 0.9  # of equal values; share of them that is as long as usual
_BEYOND_A_STEP = 0.1  # of the changes of a signal that moves by more than a step from value to value


def require_signal(samples: NDArray[np.float64], name: str, unit: str = "") -> None:
    """Refuse samples, shape (n,), from which no number should be made.

    A constant is refused, because sampled noise is never constant: the channel is dead or the drive is off,
    and a ripple of zero would look like a success. One is constant as well that a computation has rounded, as
    much as a sum of so many samples can be off.

    Raises:
        AnalysisError: fewer than two samples, one that is not finite, or all of the same value.
    """
    if len(samples) < 2:
        raise AnalysisError(
            f"'{name}' has {len(samples)} samples, at least 2 are needed: record a longer window"
        )
    require_finite(samples, name)
    low, high = float(np.min(samples)), float(np.max(samples))
    rounding = len(samples) * np.finfo(np.float64).eps * max(abs(low), abs(high))
    if high - low <= rounding:
        raise AnalysisError(
            f"'{name}' is constant at {with_unit(low, unit)} over {len(samples)} samples, a live signal is "
            f"expected: check that the drive was enabled and the channel is measured"
        )


def with_unit(value: float, unit: str) -> str:
    """Return a value as messages have it, with its unit if it has one."""
    return f"{value:.6g} {unit}".rstrip()


def require_finite(samples: NDArray[np.float64], name: str) -> None:
    """Refuse samples, shape (n,), among which are infinities or nan.

    Raises:
        AnalysisError: one is not finite.
    """
    if bad := int(np.count_nonzero(~np.isfinite(samples))):
        raise AnalysisError(
            f"'{name}' has {bad} samples that are not finite, numbers are needed: check the drive's "
            f"estimator and record again"
        )


def require_finite_channels(block: Block, names: Iterable[str]) -> None:
    """Refuse a block of which one of these channels has infinities or nan, as `require_finite`."""
    for name in names:
        require_finite(block.column(name), name)


def require_dc_link(u_dc: NDArray[np.float64]) -> None:
    """Refuse the voltage of a dc link, shape (n,), that is not above zero all along."""
    if not np.all(u_dc > 0.0):
        raise AnalysisError(
            f"'u_dc' is {float(np.nanmin(u_dc)):g} V in places, a dc link above 0 V is needed: "
            f"check that it was on and is measured"
        )


def require_unbroken(block: Block) -> None:
    """Refuse a block that is not uniformly sampled, by its gaps and, where recorded, by its own `tick`.

    Raises:
        AnalysisError: rows are missing, or `tick` (u32, wrapping) does not advance by the block's stride.
    """
    block.require_uniform()
    if "tick" not in block.names:
        return
    steps = np.diff(block.column("tick"))
    wrong = np.flatnonzero(steps != block.stride)  # remaining deviations are not wraps
    steps = np.mod(steps[wrong], TICKS)
    wrong, steps = wrong[steps != block.stride], steps[steps != block.stride]
    if len(wrong):
        raise AnalysisError(
            f"'tick' advances by {steps[0]:g} at row {wrong[0] + 1} and not by the stride of "
            f"{block.stride} in {len(wrong)} places: rows were lost or repeated, record again"
        )


def clipping(samples: NDArray[np.float64], unit: str = "") -> str:
    """Return why a record, shape (n,), of a signal that changes counts as clipped; empty if it does not.

    Clipped is what is at its greatest or least value much oftener than at the values beside it: the peak of a
    sine in steps of q is at most 2.4 times as often in the last step as in the one before. Either it stays
    there, for three samples in a row or more, or so many are there that a crest has them once in ten thousand
    records, as where periods have few samples. What rests there as the record begins or ends is not clipped,
    and signals with less than sixteen different values are not tested.
    """
    for sign, word in ((1.0, "greatest"), (-1.0, "least")):
        if share := clipped_share(sign * samples):
            value = sign * float(np.max(sign * samples))
            return (
                f"{100.0 * share:.2g} % of the samples are at the {word} value, {with_unit(value, unit)}: "
                f"the record is clipped"
            )
    return ""


def require_unheld(samples: NDArray[np.float64], name: str, unit: str = "") -> None:
    """Refuse samples, shape (n,), that are clipped or held for a while: lines of them are too small.

    Raises:
        AnalysisError: one is not finite, or as `clipping` and `standing` say.
    """
    require_finite(samples, name)
    if invalid := clipping(samples, unit) or standing(samples, unit):
        raise AnalysisError(f"'{name}': {invalid}")


def clipped_share(samples: NDArray[np.float64]) -> float:
    """Return the share of samples, shape (n,), that are clipped at their greatest value; 0 if none is, and
    none where the record begins or ends at rest there."""
    greatest = float(np.max(samples))
    if not _may_be_clipped(samples == greatest):
        return 0.0
    samples = samples[_rows_at_rest(samples, greatest) :]
    samples = samples[: len(samples) - _rows_at_rest(samples[::-1], greatest)]
    at_end = samples == greatest
    if not _may_be_clipped(at_end):
        return 0.0
    count = int(np.count_nonzero(at_end))
    values, counts = _levels(samples[:: max(1, len(samples) // _LOOKED_AT)])
    if len(values) < _FEWEST_VALUES or not counts[-1] > _OFTENER * np.max(counts[-1 - _VALUES_BESIDE : -1]):
        return 0.0
    in_a_row = bool(np.any(at_end[2:] & at_end[1:-1] & at_end[:-2]))
    is_clipped = (in_a_row and count >= _FEWEST_IN_A_ROW) or _is_no_crest(values, counts)
    return count / len(samples) if is_clipped else 0.0


def _may_be_clipped(at_end: NDArray[np.bool_]) -> bool:
    """Return whether so many samples are at the end, shape (n,), that it is worth looking at the others."""
    return int(np.count_nonzero(at_end)) >= max(_FEWEST_APART, _CLIPPED_SHARE * len(at_end))


def _rows_at_rest(samples: NDArray[np.float64], greatest: float) -> int:
    """Return for how many samples, shape (n,), a signal rests before it moves: it goes back and forth between
    its greatest value and one beside, as between two counts, or is zero, as where it is switched off."""
    values, counts = _levels(samples[:: max(1, len(samples) // _LOOKED_AT)])
    if len(values) < _FEWEST_VALUES:
        return 0
    beside = values[-1 - _VALUES_BESIDE : -1][np.argmax(counts[-1 - _VALUES_BESIDE : -1])]
    begin = int(np.argmin(samples >= beside))
    if np.count_nonzero(np.diff(samples[:begin] == greatest)) >= _FEWEST_TURNS:
        return begin
    return int(np.argmin(samples == greatest)) if greatest == 0.0 else 0


def _levels(samples: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the different values of samples, shape (n,), rising, and how many have each; those that differ
    by rounding count as one."""
    values, counts = np.unique(samples, return_counts=True)
    begins = np.flatnonzero(np.diff(values, prepend=-np.inf) > _ONE_VALUE * (values[-1] - values[0]))
    return values[begins], np.add.reduceat(counts, begins)


def _is_no_crest(values: NDArray[np.float64], counts: NDArray[np.int64]) -> bool:
    """Return whether more samples have the last of `values`, shape (m,), than crests have by chance.

    Of the samples that a crest has within k + 1 steps it has at most 1 / sqrt(k + 1) in the last, as a
    parabola. The steps are the least distance of values; of values in no steps that is next to nothing. The
    probability of as many is bounded by Chernoff's exp(-n D), D the divergence of both shares.
    """
    steps = (values[-1] - values[-1 - _VALUES_BESIDE]) / float(np.min(np.diff(values)))
    expected, within = 1.0 / math.sqrt(1.0 + steps), int(np.sum(counts[-1 - _VALUES_BESIDE :]))
    share = float(counts[-1]) / within
    divergence = share * math.log(share / expected)
    if share < 1.0:
        divergence += (1.0 - share) * math.log((1.0 - share) / (1.0 - expected))
    return share > expected and within * divergence > -math.log(_CRESTS_BY_CHANCE)


def standing(samples: NDArray[np.float64], unit: str = "") -> str:
    """Return why a record, shape (n,), of a signal that changes counts as held for a while, as by a sensor or
    a link that repeats its last value (`held_stretch`); empty if it does not."""
    if (held := held_stretch(samples)) is None:
        return ""
    after = "the next is elsewhere" if held.stop < len(samples) else "it ends so"
    return (
        f"{len(held)} samples in a row from row {held.start} (from 0) are "
        f"{with_unit(float(samples[held.start]), unit)}, and {after}: the sensor or the link stood still"
    )


def held_stretch(samples: NDArray[np.float64]) -> range | None:
    """Return the rows of the longest stretch for which a signal, shape (n,), counts as held.

    Held is what has one value for six samples in a row or more, for longer than by chance (once in a million
    records) where neighbours are equal as often as here, and stay so as often as before other such jumps: a
    current rests for as long as a converter leaves it alone, again and again. Where others are equal at
    times, as in steps, it goes on elsewhere: by more than four times of what it usually changes by from
    sample to sample. The crest of a wave in steps goes on by one of them, and is short where neighbours are
    equal rarely. Zero, as of a current that is switched off, counts likewise, and not at all before it is
    switched on and after it is switched off for good.
    """
    filled = np.flatnonzero(samples)
    if len(filled) and (first := int(filled[0])) + len(samples) - 1 - int(filled[-1]):
        inner = held_stretch(samples[first : int(filled[-1]) + 1])
        return None if inner is None else range(inner.start + first, inner.stop + first)
    steps = np.diff(samples)
    moves = np.flatnonzero(steps)
    if len(moves) < 2:
        return None
    begins = np.concatenate([[-1], moves])  # the change before each value that is held
    runs = np.diff(np.append(begins, len(steps))) - 1  # changes of zero after it
    longest = int(np.argmax(runs))
    held = int(runs[longest]) + 1
    if held < _FEWEST_HELD:
        return None
    equal = (len(steps) - len(moves) - (held - 1)) / len(steps)
    row = int(begins[longest]) + 1
    is_rare = equal == 0.0 or (equal < _RARELY and held >= _LONG)
    if not is_rare or samples[row] == 0.0:
        usual, to_end = float(np.median(np.abs(steps[moves]))), longest in (0, len(begins) - 1)
        if to_end or not abs(float(steps[moves[longest]])) > _JUMPS * usual:
            return None
        others = np.delete(runs[:-1], longest)[np.delete(np.abs(steps[moves]), longest) > _JUMPS * usual]
        stays = max(equal, _stays_equal(others))
        if stays > 0.0 and (held - 1) * math.log(stays) + math.log(len(steps)) > math.log(_BY_CHANCE):
            return None
    return range(row, row + held)


def _stays_equal(runs: NDArray[np.int64]) -> float:
    """Return how probably a value that is held goes on to be, by for how many samples others are, shape (n,):
    the most that it is on average after any time that ten of them or more have reached; 0 of fewer."""
    found = 0.0
    for reached in np.unique(runs[runs > 0]):
        beyond = runs[runs >= reached] - reached
        if len(beyond) < _FEWEST_STAYS:
            break
        found = max(found, float(np.sum(beyond)) / float(np.sum(beyond) + len(beyond)))
    return found


def held_rows(values: NDArray[np.float64]) -> float:
    """Return for how many rows on average each of the values, shape (n,), is held, by a slower converter for
    example; 1 if not, or where all changes are of one step: a signal that moves by less than that from row to
    row repeats as well, and loses next to nothing where it is held."""
    moves = np.abs(np.diff(values))
    changes = np.flatnonzero(moves)
    runs = np.diff(changes)
    if len(runs) < _FEWEST_RUNS:
        return 1.0
    jumps = moves[changes]
    if np.mean(jumps > 1.5 * np.min(jumps)) < _BEYOND_A_STEP:
        return 1.0
    usual = int(np.median(runs))
    is_regular = np.mean(np.abs(runs - usual) <= 1) > _REGULAR_RUNS and np.mean(runs == usual) > 0.5
    return float(np.mean(runs)) if usual > 1 and is_regular else 1.0
