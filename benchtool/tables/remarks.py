"""Remarks on oddities of the columns of a table that do not prevent measurements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import clipping, resolution
from benchtool.profile import Bench, Instrument
from benchtool.tables.record import Record

_PARTS = 64
_FEWEST_PER_PART = 8
_EXPLAINED = 0.88  # of the variance over parts by two levels: a line has 0.75, a sine 0.81, noise 0.64
_LARGEST_CHANGE = 0.1  # of the greatest value
_REPEATED_SHARE = 0.02
_FINE = 10.0


class RemarkKind(StrEnum):
    """Kind of a remark."""

    CLIPPED = "clipped"
    REPEATED_ROWS = "repeated_rows"
    TWO_REGIMES = "two_regimes"
    SEVERAL_REGIMES = "several_regimes"
    ROWS_LEFT_OUT = "rows_left_out"
    NAMED_BY_A_NUMBER = "named_by_a_number"
    OTHER_FREQUENCY = "other_frequency"
    CALIBRATION_OVERDUE = "calibration_overdue"


@dataclass(frozen=True)
class Remark:
    """One oddity: `column` is the kind of the column ("current"), or empty for all rows."""

    kind: RemarkKind
    column: str
    text: str

    def to_json(self) -> dict[str, str]:
        return {"kind": str(self.kind), "column": self.column, "text": self.text}


def overdue(bench: Bench, on: date) -> Iterator[Remark]:
    """Yield the instruments of a bench, by their columns, and its clock, whose calibration was due before a
    day."""
    instruments: dict[str, Instrument] = {**bench.channels}
    if bench.clock is not None:
        instruments["the clock"] = bench.clock
    for column, each in instruments.items():
        if each.overdue(on):
            label = f" ({each.label})" if each.label else ""
            text = f"calibration of {column}{label} was due on {each.due}, before this record of {on}"
            yield Remark(RemarkKind.CALIBRATION_OVERDUE, column, text)


def remarks(record: Record) -> Iterator[Remark]:
    """Yield the clipping, rows that repeat the one before, and two regimes that one number would average."""
    if text := _left_out(record):
        yield Remark(RemarkKind.ROWS_LEFT_OUT, "", text)
    if text := _repeated(record.data[:, 1:]):
        yield Remark(RemarkKind.REPEATED_ROWS, "", text)
    for what, channel in record.channels.items():
        samples = record.column(what)
        if what == "angle":
            continue
        if clipped := clipping(samples):
            yield Remark(RemarkKind.CLIPPED, what, f"'{channel.name}': {clipped}")
        for values, of in ((_means(samples), "average"), (_deviations(samples), "have an rms deviation of")):
            if text := _two_levels(values, float(np.max(np.abs(samples))), channel.unit, of):
                yield Remark(RemarkKind.TWO_REGIMES, what, f"'{channel.name}': {text}")
                break


def _left_out(record: Record) -> str:
    lost = record.lost
    if not lost.left_out:
        return ""
    reasons = ", ".join(f"{count} with {why}" for why, count in lost.left_out.items())
    first = f", the first {lost.first}" if lost.first else ""
    within = (
        f"; {lost.within} are between rows that were used, and mean and ripple have no uncertainty"
        if lost.within
        else ""
    )
    return f"rows were left out: {reasons}{first}{within}"


def _repeated(values: NDArray[np.float64]) -> str:
    if len(values) < 2:
        return ""
    steps = np.diff(values, axis=0)
    if not any(_is_fine(column, step) for column, step in zip(values.T, steps.T, strict=True)):
        return ""
    same = np.all(steps == 0.0, axis=1)
    share = float(np.mean(same))
    if share < _REPEATED_SHARE:
        return ""
    return (
        f"{100 * share:.2g} % of the rows repeat all values of the row before, the first is row "
        f"{int(np.argmax(same)) + 2} of those used: values were held or written twice, and count as often"
    )


def _is_fine(samples: NDArray[np.float64], steps: NDArray[np.float64]) -> bool:
    """Return whether a column changes by many of its least steps, so that equal neighbours are not by
    chance."""
    moved = steps[steps != 0.0]
    least = resolution(samples)
    return bool(len(moved)) and (least == 0.0 or float(np.median(np.abs(moved))) > _FINE * least)


def _means(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([float(np.mean(each)) for each in _parts(samples)])


def _deviations(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([float(np.std(each)) for each in _parts(samples)])


def _parts(samples: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    count = min(_PARTS, len(samples) // _FEWEST_PER_PART)
    return np.array_split(samples, count) if count >= _FEWEST_PER_PART else []


def _two_levels(values: NDArray[np.float64], greatest: float, unit: str, of: str) -> str:
    """Yield a remark if parts of the record have either of two levels, with hardly any between.

    Return the best split in two of the sorted values, by the share of their variance that the two means
    explain (Otsu, IEEE Trans. Syst. Man Cybern. 9 (1979) 62).
    """
    count = len(values)
    if not count or not float(np.var(values)) > 0.0:
        return ""
    ordered = np.sort(values)
    below = np.arange(1, count)
    lower = np.cumsum(ordered)[:-1] / below
    upper = (np.sum(ordered) - np.cumsum(ordered)[:-1]) / (count - below)
    share = below / count
    explained = share * (1.0 - share) * (upper - lower) ** 2 / float(np.var(values))
    best = int(np.argmax(explained))
    fewest = min(below[best], count - below[best])
    change = float(upper[best] - lower[best])
    if explained[best] < _EXPLAINED or fewest < 0.05 * count or change < _LARGEST_CHANGE * greatest:
        return ""
    is_low = values <= ordered[best]
    if np.count_nonzero(np.diff(is_low)) > count // 4:  # it oscillates, and has no regimes
        return ""
    return (
        f"two regimes: {100 * share[best]:.0f} % of the record {of} {lower[best]:.3g} {unit}, the rest "
        f"{upper[best]:.3g} {unit}; the numbers are of both together: choose one with --from and --to"
    )
