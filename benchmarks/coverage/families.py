"""Families of signals, and the scoring of their numbers against the truth."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np

from benchtool.analysis import Measurement
from benchtool.errors import AnalysisError

OF_THE_ENSEMBLE = math.nan
"""Truth of a number that is random itself, such as a peak-to-peak value: the ensemble's mean."""

NEVER = math.inf
"""Truth of a number of what does not happen, such as a crossing: none is right."""

Compared = tuple[Measurement, float | None]
"""A measurement with its truth; None where the family does not tell it."""

Trial = Callable[[np.random.Generator], Iterable[Compared]]
"""Measurements of one random record of a family, each with its truth; may raise AnalysisError."""

LEAST_COVERED, LEAST_RMS, LARGEST_RMS = 0.90, 0.7, 1.4
_FEWEST_ANSWERS = 0.05  # of the repetitions: fewer numbers than that are not scored
_ROUNDING = 1e-8
_CLEARLY = 2.0  # standard deviations of a share over so many repetitions


@dataclass(frozen=True)
class Family:
    """A name, and a function that makes one record and measures it, of `what` where that is stated.

    `fixed_within_bound` tells of a bench that is always of one kind among those that its profile allows, such
    as a sensor of exactly the least bandwidth stated. An uncertainty is of all these kinds (JCGM 100:2008,
    4.3.7), so that the errors of one kind may be smaller, never larger.
    """

    name: str
    trial: Trial
    fixed_within_bound: bool = False
    what: object = None


What = TypeVar("What")


def families_of(
    trial: Callable[[What, np.random.Generator], Iterable[Compared]],
    records: Mapping[str, What],
    fixed_within_bound: Callable[[What], bool] = lambda _: False,
) -> tuple[Family, ...]:
    """Return a family for each kind of record, by its name, of which `trial` makes one and measures it."""
    return tuple(
        Family(name, partial(trial, what), fixed_within_bound(what), what) for name, what in records.items()
    )


@dataclass(frozen=True)
class Score:
    """How errors of a measurement compare with its uncertainty over the repetitions of a family.

    `answered` of `repetitions` gave a number with an uncertainty and are compared with the truth;
    `uncompared` gave one whose truth the family does not tell, the others null with a reason. `within_u`,
    `within_2u` and `within_U` are shares of the answers; `rms` is that of error / u, `mean` its mean, both
    without numbers that are exact and stated as exact, but for rounding.
    """

    family: str
    fixed_within_bound: bool
    measurement: str
    repetitions: int
    answered: int
    uncompared: int
    within_u: float
    within_2u: float
    within_U: float
    rms: float
    mean: float

    @property
    def verdict(self) -> str:
        """`null` (refused), `uncounted` (no truth), `holds`, `wide` (u too large), `narrow` (u too small), or
        `bound` (errors smaller than u, of a kind that is one of many within a bound)."""
        if self.answered <= _FEWEST_ANSWERS * self.repetitions:
            return "uncounted" if self.uncompared > _FEWEST_ANSWERS * self.repetitions else "null"
        if self.rms == 0.0:
            return "holds"
        # so few repetitions that the share itself scatters, as a binomial one
        slack = _CLEARLY * math.sqrt(LEAST_COVERED * (1.0 - LEAST_COVERED) / self.answered)
        covered = max(self.within_2u, self.within_U)
        if covered < LEAST_COVERED - slack or self.rms > LARGEST_RMS * (1.0 + 1.0 / math.sqrt(self.answered)):
            return "narrow"
        if self.rms >= LEAST_RMS * (1.0 - 1.0 / math.sqrt(self.answered)):
            return "holds"
        return "bound" if self.fixed_within_bound else "wide"


def scores(family: Family, repetitions: int, seed: int = 0) -> Iterator[Score]:
    """Yield every measurement of a family, over that many random records."""
    found: dict[str, list[Compared]] = {}
    # equal records in many families would be one chance, counted often
    own = zlib.crc32(family.name.encode())
    for number in range(repetitions):
        random = np.random.default_rng([seed, own, number])
        try:
            for measured, truth in family.trial(random):
                found.setdefault(measured.name, []).append((measured, truth))
        except AnalysisError:
            continue
    for name, results in (found or {"all": []}).items():
        yield _score(family, name, repetitions, results)


def _score(family: Family, name: str, repetitions: int, results: Sequence[Compared]) -> Score:
    scored = partial(Score, family.name, family.fixed_within_bound, name, repetitions)
    stated = [
        (each.value, truth, each.uncertainty)
        for each, truth in results
        if math.isfinite(each.value) and each.uncertainty is not None
    ]
    answers = [(value, truth, uncertain) for value, truth, uncertain in stated if truth is not None]
    uncompared = len(stated) - len(answers)
    if not answers:
        return scored(0, uncompared, *(math.nan,) * 5)
    value = np.array([each for each, _, _ in answers])
    truth = np.array([each for _, each, _ in answers])
    standard = np.array([max(each.standard, 1e-300) for _, _, each in answers])
    expanded = np.array([each.expanded for _, _, each in answers])
    of_ensemble = np.isnan(truth)
    truth[of_ensemble] = float(np.mean(value))
    error = value - truth
    if len(value) > 1:  # from their own mean the values deviate less than from that of the ensemble
        error[of_ensemble] *= math.sqrt(len(value) / (len(value) - 1.0))
    error[np.abs(error) < _ROUNDING * np.abs(truth)] = 0.0
    relative = error / standard
    told = relative[(error != 0.0) | (standard >= _ROUNDING * np.abs(truth))]
    return scored(
        len(answers),
        uncompared,
        float(np.mean(np.abs(relative) <= 1.0)),
        float(np.mean(np.abs(relative) <= 2.0)),
        float(np.mean(np.abs(error) <= expanded)),
        float(np.sqrt(np.mean(np.clip(told, -1e6, 1e6) ** 2))) if len(told) else 0.0,
        float(np.mean(told)) if len(told) else 0.0,
    )


def selected(measurements: Iterable[Measurement], truths: Mapping[str, float]) -> Iterator[Compared]:
    """Yield the measurements whose truth is known with it, and without one the others that state an
    uncertainty."""
    for each in measurements:
        if each.name in truths:
            yield each, truths[each.name]
        elif each.uncertainty is not None:
            yield each, None
