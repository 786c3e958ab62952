"""The operating points that a recording went through, and what lies between them.

A recording is divided into parts of a tenth of a second. A regime is a stretch of parts over which speed,
torque and dc link stay within the tolerances of an operating point (`benchtool.plan.operating_point`) and the
noise of the parts, and the ripple of the torque within a factor. What keeps changing, a run-up or an approach
to a steady value, falls into short or drifting stretches and is a transient.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby, pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import raw, slope_of, slope_weights
from benchtool.block import Block
from benchtool.profile import Motor
from benchtool.results.windows import rows_of

Floats = NDArray[np.float64]

_UNITS: Final = {"omega_m": "rad/s", "torque": "Nm", "u_dc": "V", "i_q": "A"}

SHORTEST_S: Final = 0.5
"""What is shorter is part of a transient."""

_PART_S, _FEWEST_ROWS, _FEWEST_PARTS = 0.1, 4, 5
_NOISE = 8.0  # standard deviations between least and greatest of many parts
_DRIFT = 0.5  # of the tolerance: what follows or precedes another such stretch is a ramp
_TREND = 4.0  # standard deviations of a trend over the stretch, from which it is one
_RIPPLE_CHANGE = 0.7  # of the rms of the torque about its mean, between parts
_SMALL_RIPPLE = 1e-3  # of the rated torque
_OF_SECOND_DIFFERENCE = 0.6745 * math.sqrt(6.0)  # median of the magnitude over the standard deviation


@dataclass(frozen=True)
class Regime:
    """Rows from `first` to before `last` of a recording; `levels` are the means of its operating point."""

    first: int
    last: int
    from_s: float
    to_s: float
    steady: bool
    levels: Mapping[str, float]

    @property
    def text(self) -> str:
        """As one line tells it."""
        what = "steady" if self.steady else "transient"
        levels = ", ".join(f"{name} {raw(value, 4)} {_UNITS[name]}" for name, value in self.levels.items())
        told = f", {levels}" if self.steady and levels else ""
        return f"{raw(self.from_s, 6)} s to {raw(self.to_s, 6)} s {what}{told}"

    def of(self, block: Block) -> Block:
        """Return its rows, with the gaps in them."""
        return rows_of(block, self.first, self.last)

    def to_json(self) -> dict[str, object]:
        """Return the ends in seconds after the first row, whether it is steady, and the means."""
        return {"from_s": self.from_s, "to_s": self.to_s, "steady": self.steady, "levels": dict(self.levels)}


@dataclass(frozen=True)
class _Feature:
    """A number of every part, and by how much it may differ within a regime of that mean."""

    values: Floats
    tolerance: Callable[[float], float]
    noise: float

    @classmethod
    def of(cls, values: Floats, tolerance: Callable[[float], float]) -> _Feature:
        second = np.diff(values, 2)
        noise = float(np.median(np.abs(second))) / _OF_SECOND_DIFFERENCE if len(second) else 0.0
        return cls(values, tolerance, noise)

    def allows(self, low: float, high: float, mean: float) -> bool:
        return high - low <= self.tolerance(mean) + _NOISE * self.noise

    def drift(self, first: int, last: int) -> int:
        """Return whether parts go up (1) or down (-1) by much of the tolerance, or neither (0)."""
        values = self.values[first:last]
        if len(values) < 2:
            return 0
        change = len(values) * slope_of(values)
        noise = len(values) * self.noise * float(np.linalg.norm(slope_weights(len(values))))
        small = abs(change) < max(_DRIFT * self.tolerance(float(np.mean(values))), _TREND * noise)
        return 0 if small else (1 if change > 0.0 else -1)


def regimes(block: Block, motor: Motor) -> tuple[Regime, ...]:
    """Return the regimes and the transients between them, in their order; one steady regime where nothing
    tells more.

    Args:
        block: a stream; rows may be missing.
        motor: whose rating the tolerances are shares of.
    """
    edges = _edges(block)
    features = _features(block, motor, edges)
    if len(edges) < _FEWEST_PARTS + 1 or not features:
        return (_regime(block, 0, len(block.data), steady=True),)
    stretches = list(_stretches(features, len(edges) - 1))
    fewest = max(_FEWEST_PARTS, round(SHORTEST_S / _part_s(block)))
    ramps = _ramps(features, stretches)
    parts: list[tuple[int, int, bool]] = []
    for (first, last), ramp in zip(stretches, ramps, strict=True):
        # the part in which it began or ended belongs to the change
        begin = first if first == 0 else first + 1
        end = last if last == len(edges) - 1 else last - 1
        if ramp or end - begin < fewest:
            parts.append((first, last, False))
        else:
            parts += [(first, begin, False), (begin, end, True), (end, last, False)]
    return tuple(_joined(block, edges, parts))


def _joined(block: Block, edges: Sequence[int], parts: Sequence[tuple[int, int, bool]]) -> Iterator[Regime]:
    """Yield the regimes of parts, neighbouring transients as one."""
    kept = [
        (first, last, steady, place if steady else -1) for place, (first, last, steady) in enumerate(parts)
    ]
    for (steady, _), group in groupby(
        (each for each in kept if each[0] < each[1]), key=lambda each: each[2:]
    ):
        found = list(group)
        yield _regime(block, edges[found[0][0]], edges[found[-1][1]], steady=steady)


def _regime(block: Block, first: int, last: int, *, steady: bool) -> Regime:
    time_s = block.time_s()
    period_s = block.stride * block.tick_s
    left_out = {"i_q"} if "torque" in block.names else set()
    names = [name for name in _UNITS if name in block.names and name not in left_out]
    levels = {name: float(np.mean(block.column(name)[first:last])) for name in names}
    finite = {name: value for name, value in levels.items() if math.isfinite(value)}
    return Regime(first, last, float(time_s[first]), float(time_s[last - 1]) + period_s, steady, finite)


def _part_s(block: Block) -> float:
    return max(_PART_S, _FEWEST_ROWS * block.stride * block.tick_s)


def _edges(block: Block) -> list[int]:
    """Return the rows at which parts begin, and the number of rows; parts without a row are none."""
    number = np.floor(block.time_s() / _part_s(block) + 1e-6)
    edges = [0, *(np.flatnonzero(np.diff(number)) + 1).tolist(), len(block.data)]
    if len(edges) > 2 and edges[-1] - edges[-2] < _FEWEST_ROWS:
        del edges[-2]  # the rest is too short for a part of its own
    return edges


def _features(block: Block, motor: Motor, edges: Sequence[int]) -> list[_Feature]:
    speed, torque = motor.omega_m_N_rad_s, motor.T_N_Nm
    current = math.sqrt(2.0) * motor.I_N_A_rms
    tolerances: dict[str, Callable[[float], float]] = {
        "omega_m": lambda mean: max(0.02 * abs(mean), 0.005 * speed),
        "torque": lambda mean: max(0.05 * abs(mean), 0.01 * torque),
        "u_dc": lambda mean: 0.1 * abs(mean),
    }
    if "torque" not in block.names:
        tolerances["i_q"] = lambda mean: max(0.05 * abs(mean), 0.01 * current)
    begin = np.array(edges[:-1])
    counts = np.diff(edges)
    found = []
    for name, tolerance in tolerances.items():
        if name not in block.names or not np.all(np.isfinite(samples := block.column(name))):
            continue
        means = np.add.reduceat(samples, begin) / counts
        found.append(_Feature.of(means, tolerance))
        if name == "torque":
            squares = np.add.reduceat(np.square(samples - np.repeat(means, counts)), begin) / counts
            found.append(_Feature.of(np.sqrt(squares), partial(_ripple_tolerance, torque)))
    return found


def _ripple_tolerance(rated_Nm: float, rms_Nm: float) -> float:
    return max(_RIPPLE_CHANGE * rms_Nm, _SMALL_RIPPLE * rated_Nm)


def _stretches(features: Sequence[_Feature], count: int) -> Iterator[tuple[int, int]]:
    """Yield the from the first part on, the longest stretch over which every feature stays within its
    tolerance."""
    first = 0
    while first < count:
        low = [float(each.values[first]) for each in features]
        high, total, last = list(low), list(low), first + 1
        while last < count:
            now = [float(each.values[last]) for each in features]
            lows, highs = list(map(min, low, now)), list(map(max, high, now))
            totals = [sum(pair) for pair in zip(total, now, strict=True)]
            length = last + 1 - first
            if not all(
                each.allows(least, greatest, sum_ / length)
                for each, least, greatest, sum_ in zip(features, lows, highs, totals, strict=True)
            ):
                break
            low, high, total, last = lows, highs, totals, last + 1
        yield first, last
        first = last


def _ramps(features: Sequence[_Feature], stretches: Sequence[tuple[int, int]]) -> list[bool]:
    """Return whether a stretch and one beside it drift the same way, in the same number."""
    drifts = [tuple(each.drift(*stretch) for each in features) for stretch in stretches]
    alike = [any(a != 0 and a == b for a, b in zip(*pair, strict=True)) for pair in pairwise(drifts)]
    return [before or after for before, after in pairwise([False, *alike, False])]
