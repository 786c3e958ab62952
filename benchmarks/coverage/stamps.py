"""Families of imported records: time stamps that jitter or are coarse, and rows that are missing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.coverage.families import OF_THE_ENSEMBLE, Compared, families_of, selected
from benchmarks.coverage.named_truths import of_harmonics, of_orders, of_white_noise
from benchmarks.coverage.noise import UNCORRELATED, Kind, converted, noise_of
from benchtool.analysis import Measurement, Uncertainty, current_spectrum, order_analysis, track_tone
from benchtool.block import Block, Gap
from benchtool.errors import AnalysisError
from benchtool.tables.time_base import time_base

FREQUENCY_HZ, RATE_HZ = 20.0, 10_000.0
AMPLITUDE_A = 5.0
POLE_PAIRS = 4
_NUMBERED = 1e-12  # relative uncertainty of a rate, of stamps in equal steps by their digits alone


@dataclass(frozen=True)
class Stamps:
    """A current of 40.3 periods with harmonics and noise; the rate is off 10 kHz by some 100 ppm."""

    jitter: float = 0.0  # rms, of a step
    resolution_s: float = 0.0
    noise: float = 1e-3
    lost: tuple[int, int] = (0, 0)  # how many gaps, of how many rows each
    periods: float = 40.3
    drift: float = 0.0  # of the speed, relative
    swing: tuple[float, float] = (0.0, 1.0)  # relative deviation of the speed, Hz
    wobble_rad: tuple[float, int] = (0.0, 1)  # rms of the encoder's own error, and its order
    slip: float = 0.0
    counts: int = 0
    bits: int = 0
    kind: Kind = "white"
    line: tuple[float, float] = (0.0, 0.0)  # order and relative amplitude of an interharmonic


def trial(what: Stamps, random: np.random.Generator) -> Iterator[Compared]:
    """Yield one record: the rate by its stamps, and the numbers of the uniform rows."""
    rate_Hz = RATE_HZ * (1.0 + 1e-4 * random.standard_normal())
    rows = round(what.periods / FREQUENCY_HZ * rate_Hz)
    time_s = np.arange(rows) / rate_Hz
    omega, duration_s = 2 * np.pi * FREQUENCY_HZ, rows / rate_Hz
    theta_e = omega * time_s + random.uniform(0, 2 * np.pi)
    theta_e += 0.5 * omega * what.drift * (time_s**2 / duration_s - time_s)
    deviation, swing_Hz = what.swing
    if deviation:
        of_swing = 2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi)
        theta_e += omega * deviation / (2 * np.pi * swing_Hz) * np.sin(of_swing)
    frequency_Hz = float(theta_e[-1] - theta_e[0]) / (2 * np.pi * (time_s[-1] - time_s[0]))
    current = np.cos(theta_e) + 0.03 * np.cos(5 * theta_e + 1.0)
    current += what.noise * noise_of(what.kind, random, rows)
    torque = 2.0 + 0.1 * np.cos(6 * theta_e) + what.noise * noise_of(what.kind, random, rows)
    order, size = what.line
    if size:
        current += size * np.cos(order * omega * time_s + random.uniform(0, 2 * np.pi))
    if what.bits:
        current = converted(current, 2.1 / 2**what.bits, random)
        torque = converted(torque, 4.0 / 2**what.bits, random)
    theta_m = theta_e * (1.0 + what.slip) / POLE_PAIRS
    rms_rad, order_of_wobble = what.wobble_rad
    if rms_rad:
        theta_m += math.sqrt(2.0) * rms_rad * np.sin(order_of_wobble * theta_m + random.uniform(0, 2 * np.pi))
    theta_m = np.mod(theta_m, 2 * np.pi)
    if what.counts:
        theta_m = np.floor(theta_m * what.counts / (2 * np.pi)) * (2 * np.pi / what.counts)
    stamps = time_s + 12.0 + what.jitter / rate_Hz * random.standard_normal(rows)
    if what.resolution_s:
        stamps = np.round(stamps / what.resolution_s) * what.resolution_s
    kept = np.ones(rows, dtype=np.bool_)
    gaps, size = what.lost
    for place in np.sort(random.choice(np.arange(1000, rows - 1000, 2 * size + 1), gaps, replace=False)):
        kept[place : place + size] = False
    base = time_base(stamps[kept])
    if base.refusal:
        raise AnalysisError(base.refusal)
    if base.rate_relative < _NUMBERED:  # stamps that number the rows leave out their clock
        frequency_Hz *= base.rate_Hz / rate_Hz
    else:
        of_rate = Uncertainty(base.rate_relative * base.rate_Hz, "time stamps")
        yield Measurement("sample_rate", base.rate_Hz, "Hz", "", uncertainty=of_rate), rate_Hz
    missing = base.gaps
    whole = Block.from_arrays(
        base.rate_Hz,
        {"i_a": "A", "torque": "Nm", "theta_m": "rad"},
        i_a=AMPLITUDE_A * current[kept],
        torque=torque[kept],
        theta_m=theta_m[kept],
    )
    block = replace(whole, gaps=tuple(Gap(each.row, each.missing_rows) for each in missing))
    order = 6 * POLE_PAIRS
    found = order_analysis(block, "torque", pole_pairs=POLE_PAIRS)
    named = of_orders({order: 0.1}, POLE_PAIRS, int(found.spectrum.order[-1]))
    yield from selected(found.measurements, named)
    if missing:
        return
    track = track_tone(np.ascontiguousarray(block.column("i_a")), "i_a")
    spectrum = current_spectrum(block, "i_a", track, rate_relative=base.rate_relative)
    truths = {
        "fundamental_frequency": frequency_Hz,
        **of_harmonics({1: AMPLITUDE_A, 5: 0.03 * AMPLITUDE_A}),
        "current_thd_f_groups": OF_THE_ENSEMBLE,
        "current_thd_f_subgroups": OF_THE_ENSEMBLE,
        "current_noise_floor": OF_THE_ENSEMBLE,
        "current_noise_density": OF_THE_ENSEMBLE,
    }
    if not what.bits and what.kind in UNCORRELATED:
        truths |= of_white_noise(AMPLITUDE_A * what.noise, rate_Hz, spectrum.measurements)
    yield from selected(spectrum.measurements, truths)


_EVEN = Stamps()
RECORDS: Mapping[str, Stamps] = {
    "stamps_jitter_1": replace(_EVEN, jitter=0.01),
    "stamps_jitter_30": replace(_EVEN, jitter=0.3),
    "stamps_microseconds": replace(_EVEN, resolution_s=1e-6),
    "stamps_milliseconds": replace(_EVEN, resolution_s=1e-3),
    "stamps_as_coarse_as_rows": replace(_EVEN, resolution_s=1e-4),
    "stamps_jitter_and_resolution": replace(_EVEN, jitter=0.1, resolution_s=1e-5),
    "stamps_jitter_short": replace(_EVEN, jitter=0.02, periods=8.3, noise=5e-3),
    "stamps_gap": replace(_EVEN, lost=(1, 40)),
    "stamps_many_gaps": replace(_EVEN, lost=(12, 25), noise=1e-2),
}


FAMILIES = families_of(trial, RECORDS)
