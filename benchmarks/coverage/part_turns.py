"""Families of records of less than two mechanical revolutions, of machines with many poles: an error of the
position sensor once or twice in a revolution is then nearly a change of speed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.named_truths import of_groups, of_harmonics, of_white_noise
from benchmarks.coverage.noise import UNCORRELATED, Kind, noise_of
from benchtool.analysis import current_spectrum, track_angle
from benchtool.block import Block

Floats = NDArray[np.float64]

RATE_HZ = 10_000.0
_HARMONICS = (5, 7, 11, 13)
_FEWEST_PERIODS, _LEAST_POLE_PAIRS, _MOST_POLE_PAIRS = 5.3, 6, 24


@dataclass(frozen=True)
class PartOfTurn:
    """A current along a rotor that turns `revolutions`, and its angle by a sensor that errs by 1 to 10 mrad
    once in a revolution, and up to 40 % of that twice, if it `errs`, or counts in `counts` a turn.

    The speed drifts by up to 2 % and swings by up to `swing` of it at most three times over the record. The
    noise of the current is between -80 and -40 dB.
    """

    revolutions: float
    errs: bool = True
    counts: int = 0
    swing: float = 0.0
    kind: Kind = "white"


def _trial(what: PartOfTurn, random: np.random.Generator) -> Iterator[Compared]:
    least = max(_LEAST_POLE_PAIRS, int(_FEWEST_PERIODS / what.revolutions) + 1)
    pole_pairs = int(random.integers(least, _MOST_POLE_PAIRS + 1))
    f_Hz = random.uniform(20.0, 120.0)
    count = round(what.revolutions * pole_pairs / f_Hz * RATE_HZ)
    place = np.arange(count) / count
    swung, size = random.uniform(0.5, 3.0), what.swing * random.uniform(0.1, 1.0)
    course = place + random.uniform(-0.01, 0.01) * (place**2 - place)
    course += size / (2 * np.pi * swung) * np.sin(2 * np.pi * swung * place + random.uniform(0, 2 * np.pi))
    theta_e = 2 * np.pi * f_Hz * count / RATE_HZ * course + random.uniform(0, 2 * np.pi)
    theta_m = theta_e / pole_pairs + random.uniform(0, 2 * np.pi)
    current = np.cos(theta_e)
    amplitudes = {1: 1.0} | {order: random.uniform(2e-3, 0.03) for order in _HARMONICS}
    for order in _HARMONICS:
        current += amplitudes[order] * np.cos(order * theta_e + random.uniform(0, 2 * np.pi))
    noise_rms = 10.0 ** random.uniform(-4.0, -2.0)
    current += noise_rms * noise_of(what.kind, random, count)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
    found = current_spectrum(block, "i_a", track_angle(_read(what, theta_m, random), pole_pairs))
    true_Hz = float(theta_e[-1] - theta_e[0]) / (2 * np.pi) * RATE_HZ / (count - 1)
    truths = {"fundamental_frequency": true_Hz} | of_harmonics(amplitudes)
    if what.kind in UNCORRELATED:
        truths |= of_white_noise(noise_rms, RATE_HZ, found.measurements) | of_groups(
            amplitudes, noise_rms, RATE_HZ / f_Hz
        )
    yield from selected(found.measurements, truths)


def _read(what: PartOfTurn, theta_m: Floats, random: np.random.Generator) -> Floats:
    """Return the angle as the sensor gives it, rad."""
    angle = theta_m.copy()
    if what.errs:
        error_rad = random.uniform(1e-3, 1e-2)
        for order, share in ((1, 1.0), (2, random.uniform(0.0, 0.4))):
            angle += share * error_rad * np.sin(order * theta_m + random.uniform(0, 2 * np.pi))
    if what.counts:
        return np.asarray(np.floor(angle * what.counts / (2 * np.pi)) * (2 * np.pi / what.counts))
    return np.asarray(angle + 3e-5 * random.standard_normal(len(angle)))


PARTS: Mapping[str, PartOfTurn] = {
    "part_turn_third": PartOfTurn(0.35),
    "part_turn_half": PartOfTurn(0.55),
    "part_turn_half_true_angle": PartOfTurn(0.55, errs=False),
    "part_turn_most": PartOfTurn(0.85),
    "part_turn_most_counts": PartOfTurn(0.85, counts=4096),
    "part_turn_swing": PartOfTurn(0.7, swing=0.01),
    "part_turn_pink": PartOfTurn(0.7, kind="pink"),
    "part_turn_popcorn": PartOfTurn(0.7, kind="popcorn"),
    "turn_and_a_fifth_swing": PartOfTurn(1.2, swing=0.01),
}

FAMILIES = families_of(_trial, PARTS)
