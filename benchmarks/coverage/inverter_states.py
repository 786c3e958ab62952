"""Families of an inverter: how long it uses which of its states, and how often its switches turn on.

The means of the processes are known: a vector that turns, states that last for random times, loads that
alternate.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e

from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.noise import Kind as OfNoise, coloured, converted, noise_of
from benchtool.analysis import SwitchingStates, switching_frequency, switching_states
from benchtool.block import Block

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

RATE_HZ, U_DC = 10_000.0, 120.0
_USED = 1e-5  # of a period
_SECTOR = math.pi / 3.0


@dataclass(frozen=True)
class Turning:
    """A voltage that turns: its size over u_dc / sqrt(3), which the hexagon holds in all directions.

    Attributes:
        noise: of both axes, over the same.
        other: size at the other of two loads that alternate, at `alternates_Hz`; for random times of an
            exponential distribution where it is `at_random`.
        wander: of the size, relative rms, and its correlation time in s.
        step_V, dc_step_V: of the converters of the voltage asked and of the dc link.
        dc_ripple: relative, at twice the frequency of the mains.
    """

    size: float = 0.6
    frequency_Hz: float = 23.7
    duration_s: float = 1.0
    noise: float = 0.01
    kind: OfNoise = "white"
    colour: float = 0.0
    drift: float = 0.0
    other: float = 0.0
    alternates_Hz: float = 0.0
    at_random: bool = False
    wander: tuple[float, float] = (0.0, 1.0)
    step_V: float = 0.0
    dc_step_V: float = 0.0
    dc_ripple: float = 0.0


@dataclass(frozen=True)
class Single:
    """A law that gives each period one state: a zero vector, or the active one for `duty` of the period.

    Zero and active vectors last for a geometric number of periods, of these means, in turn; `duty` has this
    mean, a rms deviation and a correlation from period to period.
    """

    zero: float = 2.0
    active: float = 3.0
    duty: tuple[float, float, float] = (1.0, 0.0, 0.0)
    frequency_Hz: float = 23.7
    duration_s: float = 1.0
    ripple: float = 0.0  # of the probability that the active vector goes on, six times in a period


@dataclass(frozen=True)
class Counter:
    """Turn-ons of three legs.

    Attributes:
        rates_Hz: of each leg at two loads that alternate.
        lasting_s: mean time of a load.
        at_random: whether these times are exponential ones; all equal ones otherwise.
        scatter: of the time between two turn-ons of a leg, relative to it.
        carrier: whether all legs turn on at one time, as by one carrier.
        clamped_Hz: of the fundamental, of which each leg rests for two sixths, in a law with one pulse a row;
            0 of others.
        held: rows for which a drive gives the same count.
    """

    rates_Hz: tuple[float, float] = (1234.5, 1234.5)
    lasting_s: float = 0.05
    at_random: bool = True
    scatter: float = 0.3
    carrier: bool = False
    clamped_Hz: float = 0.0
    held: int = 1
    duration_s: float = 1.0


def _alternating(
    lasting_s: float, at_random: bool, count: int, random: np.random.Generator
) -> NDArray[np.bool_]:
    """Return in which rows the second of two loads is on, which both last as long on average."""
    rows = lasting_s * RATE_HZ
    if not at_random:
        return np.asarray((np.arange(count) / rows + random.uniform(0.0, 2.0)) % 2.0 >= 1.0)
    # without a memory the first one lasts on as if it began with the record
    changes = np.cumsum(random.exponential(rows, int(4 * count / rows) + 60))
    return np.asarray((np.searchsorted(changes, np.arange(count)) + random.integers(2)) % 2 == 1)


def _turning(what: Turning, random: np.random.Generator) -> Iterator[Compared]:
    count = round(what.duration_s * RATE_HZ)
    time = np.arange(count) / count
    angle = 2 * np.pi * what.frequency_Hz * what.duration_s * (time + 0.5 * what.drift * (time**2 - time))
    size, loads = np.full(count, what.size), [what.size]
    if what.alternates_Hz:
        second = _alternating(0.5 / what.alternates_Hz, what.at_random, count, random)
        size, loads = np.where(second, what.other, what.size), [what.size, what.other]
    rms, memory_s = what.wander
    if rms:
        size *= 1.0 + rms * coloured(random.standard_normal(count), math.exp(-1.0 / (memory_s * RATE_HZ)))
    u_s = size * np.exp(1j * (angle + random.uniform(0, 2 * np.pi)))
    for axis in (1.0, 1j):
        u_s += axis * what.noise * coloured(noise_of(what.kind, random, count), what.colour)
    u_s *= U_DC / math.sqrt(3.0)
    if what.step_V:
        u_s = converted(u_s.real, what.step_V, random) + 1j * converted(u_s.imag, what.step_V, random)
    link = what.dc_ripple * np.cos(2 * np.pi * (100.0 * what.duration_s * time + random.uniform()))
    u_dc = U_DC * (1.0 + link) + 0.05 * random.standard_normal(count)
    if what.dc_step_V:
        u_dc = converted(u_dc, what.dc_step_V, random)
    # the drive makes its pulses by what it reads
    scale = U_DC * float(np.mean(1.0 / u_dc))
    of_loads = [
        _means_of_circle(scale * each, scale * what.noise, scale * each * what.wander[0]) for each in loads
    ]
    zero, active = np.mean(of_loads, axis=0)
    truths = {"zero_vector_share": 100.0 * zero, "active_vectors_mean": active}
    yield from selected(_measured(u_s, u_dc).measurements, truths)


def _measured(u_s: Complex, u_dc: Floats) -> SwitchingStates:
    columns = {"u_alpha": u_s.real, "u_beta": u_s.imag, "u_dc": u_dc}
    return switching_states(Block.from_arrays(RATE_HZ, dict.fromkeys(columns, "V"), **columns))


def _means_of_circle(size: float, noise: float, wander: float) -> tuple[float, float]:
    """Return the mean share of the zero vectors and the mean number of active ones of a voltage in any
    direction, with normal noise in both axes and in its size."""
    place, weight = np.polynomial.hermite_e.hermegauss(12)
    weight = weight / np.sum(weight)
    angle = np.pi * (np.arange(240) + 0.5) / 720.0  # of a sector, the others are like it
    along = (size + math.hypot(noise, wander) * place)[:, np.newaxis, np.newaxis]
    u = (along + 1j * noise * place[:, np.newaxis]) * np.exp(1j * angle)
    legs = np.stack([np.real(u * np.exp(-2j * np.pi * k / 3.0)) for k in range(3)]) / math.sqrt(3.0)
    zero = np.maximum(0.0, 1.0 - np.ptp(legs, axis=0))
    # beside one of three lines between sectors, by less than the least that counts, there is but one vector
    spread = max(noise, 1e-9 * size)
    density = i0e((0.5 * size / spread) ** 2) / (spread * math.sqrt(2.0 * math.pi))
    return float(weight @ np.mean(zero, axis=2) @ weight), 2.0 - 6.0 * _USED * float(density)


def _single(what: Single, random: np.random.Generator) -> Iterator[Compared]:
    count = round(what.duration_s * RATE_HZ)
    angle = 2 * np.pi * (what.frequency_Hz * np.arange(count) / RATE_HZ + random.uniform())
    if what.ripple:  # from period to period with a probability that follows the angle
        share = what.active / (what.active + what.zero)
        on = random.random(count) < share * (1.0 + what.ripple * np.cos(6.0 * angle))
    else:
        share = what.active / (what.active + what.zero)
        begins = random.random() < share  # that it lasts already does not make it end sooner
        means = (what.active, what.zero) if begins else (what.zero, what.active)
        pairs = int(2.0 * count / (what.zero + what.active)) + 60
        edges = np.cumsum(np.stack([random.geometric(1.0 / each, pairs) for each in means], axis=1))
        on = (np.searchsorted(edges, np.arange(count), side="right") % 2 == 0) == begins
    mean, rms, memory = what.duty
    duty = mean + rms * coloured(random.uniform(-1.0, 1.0, count) * math.sqrt(3.0), memory)
    sector = np.floor(angle / _SECTOR)
    u_s = on * np.clip(duty, 0.0, 1.0) * 2.0 / 3.0 * U_DC * np.exp(1j * _SECTOR * sector)
    truths = {"zero_vector_share": 100.0 * (1.0 - share * mean), "active_vectors_mean": share}
    yield from selected(_measured(u_s, np.full(count, U_DC)).measurements, truths)


def _counter(what: Counter, random: np.random.Generator) -> Iterator[Compared]:
    count = round(what.duration_s * RATE_HZ) + 1
    if what.clamped_Hz:
        turns = what.clamped_Hz * np.arange(count + 1) / RATE_HZ + random.uniform()
        each = np.zeros(count, dtype=np.int64)
        for leg in range(3):
            sixth = np.floor(6.0 * (turns - leg / 3.0)).astype(np.int64) % 6
            high, low = sixth == 0, sixth == 3
            each += ~(high | low)[1:] | (high[1:] & ~high[:-1])
        total = np.cumsum(each)
        truth_Hz = 2.0 / 3.0 * RATE_HZ + what.clamped_Hz
    else:
        rates = np.array(what.rates_Hz)
        on = _alternating(what.lasting_s, what.at_random, count, random)
        turns = np.cumsum(rates[on.astype(np.int64)]) / RATE_HZ
        total = np.zeros(count, dtype=np.int64)
        for _ in range(1 if what.carrier else 3):
            if what.scatter:
                steps = random.gamma(1 / what.scatter**2, what.scatter**2, int(2 * turns[-1]) + 100)
                events = np.cumsum(steps) - 20.0
            else:
                events = np.arange(-1.0, turns[-1] + 1.0) + random.uniform()
            total += np.searchsorted(events, turns) * (3 if what.carrier else 1)
        truth_Hz = float(np.mean(rates))
    total += int(random.integers(1 << 32))
    rows = np.arange(count) // what.held * what.held
    block = Block.from_arrays(RATE_HZ, {}, switching_count=np.mod(total[rows], 1 << 32).astype(np.float64))
    yield switching_frequency(block), truth_Hz


_TURNING, _SINGLE, _COUNTER = Turning(), Single(), Counter()
TURNING: Mapping[str, Turning] = {
    "states_turning": _TURNING,
    "states_turning_no_noise": replace(_TURNING, noise=0.0),
    "states_turning_coloured": replace(_TURNING, colour=0.98, noise=0.03),
    "states_turning_slow_noise": replace(_TURNING, colour=0.998, noise=0.03),
    "states_turning_few_periods": replace(_TURNING, duration_s=0.11),
    "states_turning_two_periods": replace(_TURNING, duration_s=0.09),
    "states_turning_few_rows": replace(_TURNING, duration_s=3e-3, noise=0.05, frequency_Hz=803.0),
    "states_turning_drift": replace(_TURNING, drift=0.3),
    "states_turning_slowly": replace(_TURNING, frequency_Hz=2.3),
    "states_turning_fast": replace(_TURNING, frequency_Hz=410.3, size=0.9),
    "states_turning_little_voltage": replace(_TURNING, size=0.03, noise=0.02),
    "states_turning_beyond": replace(_TURNING, size=1.08),
    "states_turning_far_beyond": replace(_TURNING, size=1.3),
    "states_turning_steps": replace(_TURNING, step_V=0.1, noise=1e-3),
    "states_turning_coarse_steps": replace(_TURNING, step_V=2.0, noise=1e-3),
    "states_turning_steps_of_link": replace(_TURNING, dc_step_V=0.5),
    "states_turning_link_ripples": replace(_TURNING, dc_ripple=0.03),
    "states_turning_wander": replace(_TURNING, wander=(0.1, 0.01)),
    "states_turning_slow_wander": replace(_TURNING, wander=(0.1, 0.05), duration_s=2.0),
    "states_turning_two_loads": replace(_TURNING, other=0.3, alternates_Hz=11.3, at_random=True),
    "states_turning_load_cycle": replace(_TURNING, other=0.3, alternates_Hz=7.3),
    "states_turning_slow_load_cycle": replace(_TURNING, other=0.3, alternates_Hz=2.6),
}  # fmt: skip
SINGLE: Mapping[str, Single] = {
    "states_single": _SINGLE,
    "states_single_short": replace(_SINGLE, duration_s=0.03),
    "states_single_long_vectors": replace(_SINGLE, zero=40.0, active=90.0),
    "states_single_rare_zero": replace(_SINGLE, zero=1.0, active=2000.0),
    "states_single_duty": replace(_SINGLE, duty=(0.6, 0.15, 0.0)),
    "states_single_duty_memory": replace(_SINGLE, duty=(0.5, 0.05, 0.95)),
    "states_single_ripple": replace(_SINGLE, ripple=0.4),
}  # fmt: skip
COUNTERS: Mapping[str, Counter] = {
    "frequency_two_loads": replace(_COUNTER, rates_Hz=(900.0, 2100.0)),
    "frequency_two_loads_slow": replace(_COUNTER, rates_Hz=(900.0, 2100.0), lasting_s=0.15, duration_s=3.0),
    "frequency_load_cycle": replace(_COUNTER, rates_Hz=(900.0, 2100.0), lasting_s=0.07, at_random=False),
    "frequency_fast_load_cycle": replace(_COUNTER, rates_Hz=(900.0, 2100.0), lasting_s=3.1e-3,
        at_random=False),
    "frequency_carrier": replace(_COUNTER, carrier=True, scatter=0.0, rates_Hz=(3967.3, 3967.3)),
    "frequency_carrier_short": replace(_COUNTER, carrier=True, scatter=0.0, rates_Hz=(3967.3, 3967.3),
        duration_s=0.011),
    "frequency_spread_carrier": replace(_COUNTER, carrier=True, scatter=0.2, rates_Hz=(3967.3, 3967.3)),
    "frequency_clamped": replace(_COUNTER, clamped_Hz=21.3),
    "frequency_clamped_few_periods": replace(_COUNTER, clamped_Hz=21.3, duration_s=0.17),
    "frequency_clamped_slow": replace(_COUNTER, clamped_Hz=1.3),
    "frequency_held_count": replace(_COUNTER, held=8),
    "frequency_held_count_regular": replace(_COUNTER, held=16, scatter=0.0, duration_s=0.2),
    "frequency_few_rows": replace(_COUNTER, duration_s=1.5e-3),
}  # fmt: skip


FAMILIES = (
    *families_of(_turning, TURNING),
    *families_of(_single, SINGLE),
    *families_of(_counter, COUNTERS),
)
