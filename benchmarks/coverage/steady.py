"""Families of steady and less steady records: current, torque and angle, with disturbances."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import OF_THE_ENSEMBLE, Compared, selected
from benchmarks.coverage.noise import UNCORRELATED, Kind, coloured, converted, noise_of
from benchtool.analysis import (
    CoherentSpectrum,
    Measurement,
    Uncertainty,
    analyze_steady_state,
    order_analysis,
    percentile_range,
)
from benchtool.block import Block
from benchtool.errors import AnalysisError

Floats = NDArray[np.float64]

RATE_HZ = 10_000.0
POLE_PAIRS = 4
AMPLITUDE_A = 5.0
RATED_A_RMS = 4.0
HARMONICS: Mapping[int, float] = {5: 0.03, 7: 0.02}
TORQUE_NM, RIPPLE_NM, COGGING_NM = 2.0, 0.1, 0.05
RIPPLE_ORDER, COGGING_ORDER = 6 * POLE_PAIRS, 3 * POLE_PAIRS
_MEAN_OF_PEAKS = float(np.i0(6.0)) * math.exp(-6.0)
_MUCH_LESS = 0.05  # of a step
_NO_POWER = 1e-5
_BETWEEN_CLOCKS = 2e-5  # relative
THD_PERCENT = 100.0 * math.sqrt(sum(each**2 for each in HARMONICS.values()))


@dataclass(frozen=True)
class Disturbance:
    """Disturbances of a record besides a current of 5 A, its harmonics, and a torque with ripple.

    Relative quantities are relative to the current's amplitude, or a tenth of that to the mean torque. Lines
    are (order, relative amplitude), swings (relative deviation of the speed, Hz).
    """

    periods: float = 40.0
    frequency_Hz: float = 20.0
    noise: float = 1e-3
    colour: float = 0.0  # pole of a first-order low-pass that the noise has passed
    kind: Kind = "white"
    drift: float = 0.0
    swing: tuple[float, float] = (0.0, 1.0)
    settling: tuple[float, float] = (0.0, 1.0)  # relative speed at the beginning, time constant over duration
    speed_walk: float = 0.0  # relative deviation, rms, at the end of a random walk of the speed
    speed_memory: tuple[float, float] = (0.0, 1.0)  # relative rms of a speed, its memory over the duration
    reverses: bool = False
    stands_still: float = 0.0  # share of the record, from 0.6 of it on
    phase_step_rad: float = 0.0  # of the current against the rotor, at 0.4 of the record
    lines: tuple[tuple[float, float], ...] = ()
    offset: float = 0.0
    decay: tuple[float, float] = (0.0, 1.0)  # relative dc at the beginning, time constant over the duration
    amplitude_noise: tuple[float, float] = (0.0, 0.0)  # rms, correlation over periods
    amplitude_swing: tuple[float, float] = (0.0, 1.0)  # relative, Hz
    amplitude_ramp: float = 0.0  # relative, from the beginning to the end
    alternates: float = 0.0  # relative deviation of the amplitude, up in one period and down in the next
    frozen: int = 0  # rows for which the sensors of current and torque repeat their last value
    sawtooth: tuple[float, float] = (0.0, 0.0)  # of the torque, Nm, five a period; jitter of its teeth
    ripple_noise: tuple[float, float] = (0.0, 0.0)
    second_regime: float = 1.0
    clip: float = math.inf
    bits: int = 0
    harmonics: Mapping[int, float] = field(default_factory=lambda: HARMONICS)
    amplitude_A: float = AMPLITUDE_A
    torque_Nm: float = TORQUE_NM
    angle: bool = True
    counts: int = 0
    wobble_rad: tuple[float, int] = (0.0, 1)  # rms of the encoder's own error, and its order
    slip: float = 0.0
    angle_noise_rad: float = 0.0
    time_jitter: float = 0.0  # of a sample period, rms
    spikes: float = 0.0  # relative height, some ten in a record
    chirp: tuple[float, float, float] = (0.0, 1.0, 1.0)  # relative amplitude; first and last order
    turns_Nm: tuple[float, float] = (0.0, 0.0)  # of the torque, once and twice in a revolution
    peaked: float = 0.0  # of the torque: ripple of narrow crests to one side, Nm


@dataclass(frozen=True)
class Record:
    """A block and its true values."""

    block: Block
    frequency_Hz: float
    clean_torque_Nm: Floats
    noise_A: Floats
    phases_rad: Mapping[int, float]  # of the harmonics, when the fundamental is at its maximum
    begin_rad: float


def record(what: Disturbance, random: np.random.Generator) -> Record:
    """Return one random record: phases of everything are random, and so is the noise."""
    count = round(what.periods / what.frequency_Hz * RATE_HZ)
    time_s = (np.arange(count) + what.time_jitter * random.standard_normal(count)) / RATE_HZ
    duration_s = count / RATE_HZ
    deviation, swing_Hz = what.swing
    swing_rad = 2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi)
    speed = 2 * np.pi * what.frequency_Hz
    if what.counts:  # the rotor and the samples have no clock in common, to which counts would be locked
        speed *= 1.0 + _BETWEEN_CLOCKS * random.standard_normal()
    cycles = speed * time_s + 0.5 * speed * what.drift * (time_s**2 / duration_s - time_s)
    if deviation:
        cycles = cycles + speed * deviation / (2 * np.pi * swing_Hz) * np.sin(swing_rad)
    cycles = cycles + _of_speed(what, time_s / duration_s, random) * speed * duration_s
    if what.reverses:
        cycles = np.where(time_s < 0.7 * duration_s, cycles, 2 * cycles[int(0.7 * count)] - cycles)
    if what.stands_still:
        at, back = (int(share * count) for share in (0.6, 0.6 + what.stands_still))
        cycles = cycles - np.clip(cycles, cycles[at], cycles[back])  # it turns on where it stood
    begin_rad = random.uniform(0, 2 * np.pi)
    theta_e = cycles + begin_rad
    frequency_Hz = float(theta_e[-1] - theta_e[0]) / (2 * np.pi * (time_s[-1] - time_s[0]))

    noise = coloured(noise_of(what.kind, random, count), what.colour)
    noise_A = what.noise * what.amplitude_A * noise if what.amplitude_A else what.noise * noise
    theta_i = theta_e + np.where(time_s < 0.4 * duration_s, 0.0, what.phase_step_rad)
    current = np.cos(theta_i)
    phases_rad = {order: random.uniform(0, 2 * np.pi) for order in what.harmonics}
    for order, amplitude in what.harmonics.items():
        current += amplitude * np.cos(order * theta_i + phases_rad[order])
    period = np.floor((theta_e - theta_e[0]) / (2 * np.pi)).astype(np.int64)
    period -= period.min()
    current *= 1.0 + _by_period(what.amplitude_noise, period, random)
    size, swing_Hz = what.amplitude_swing
    current *= 1.0 + size * np.cos(2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi))
    current *= 1.0 + what.amplitude_ramp * (time_s / duration_s - 0.5)
    current *= 1.0 + what.alternates * (1.0 - 2.0 * (period % 2))
    current *= np.where(time_s < 0.5 * duration_s, 1.0, what.second_regime)
    for place, amplitude in what.lines:
        current += amplitude * np.cos(
            2 * np.pi * place * what.frequency_Hz * time_s + random.uniform(0, 6.28)
        )
    if what.chirp[0]:
        size, first, last = what.chirp
        turned = (first + 0.5 * (last - first) * time_s / duration_s) * what.frequency_Hz * time_s
        current += size * np.cos(2 * np.pi * turned + random.uniform(0, 2 * np.pi))
    start, constant = what.decay
    current += what.offset + start * random.choice([-1, 1]) * np.exp(-time_s / (constant * duration_s))
    if what.spikes:
        current[random.integers(0, count, 10)] += what.spikes
    current = what.amplitude_A * current + noise_A
    current = np.clip(current, -what.clip * AMPLITUDE_A, what.clip * AMPLITUDE_A)

    theta_true = theta_e / POLE_PAIRS
    # between the levels of a converter the extremes are anywhere; without it the ensemble's are the truth
    of_ripple, of_cogging = random.uniform(0, 2 * np.pi, 2) if _is_clean(what) else (0.3, 1.1)
    torque = what.torque_Nm + RIPPLE_NM * (1.0 + _by_period(what.ripple_noise, period, random)) * np.cos(
        RIPPLE_ORDER * theta_true + of_ripple
    )
    torque += COGGING_NM * np.cos(COGGING_ORDER * theta_true + of_cogging)
    for order, size_Nm in enumerate(what.turns_Nm, 1):
        torque += size_Nm * np.cos(order * theta_true + 0.7 * order)
    torque += TORQUE_NM * what.noise * coloured(noise_of(what.kind, random, count), what.colour)
    if what.peaked:
        torque += what.peaked * (np.exp(6.0 * np.cos(RIPPLE_ORDER * theta_true) - 6.0) - _MEAN_OF_PEAKS)
    torque += _sawtooth(what.sawtooth, 5.0 * theta_e / (2 * np.pi), random)
    clean_torque = torque
    if what.bits:
        step_A, step_Nm = 2.0 * AMPLITUDE_A / 2**what.bits * 1.02, 2.0 * TORQUE_NM / 2**what.bits
        current, torque = (
            converted(each, step, random) for each, step in ((current, step_A), (torque, step_Nm))
        )

    if what.frozen:
        begin = int(random.integers(count // 4, count // 2))
        rows = slice(begin, begin + what.frozen)
        current[rows], torque[rows] = current[begin], torque[begin]

    rms_rad, order_of_wobble = what.wobble_rad
    angle = theta_true * (1.0 + what.slip)
    angle += math.sqrt(2.0) * rms_rad * np.sin(order_of_wobble * theta_true + random.uniform(0, 2 * np.pi))
    angle += what.angle_noise_rad * random.standard_normal(count)
    angle = np.mod(angle, 2 * np.pi)
    if what.counts:
        angle = np.floor(angle * what.counts / (2 * np.pi)) * (2 * np.pi / what.counts)
    columns = {"i_a": current, "torque": torque} | ({"theta_m": angle} if what.angle else {})
    units = {"i_a": "A", "torque": "Nm", "theta_m": "rad"}
    block = Block.from_arrays(RATE_HZ, {name: units[name] for name in columns}, **columns)
    if what.reverses and not what.angle:
        frequency_Hz = what.frequency_Hz  # a cosine alone does not tell its direction
    return Record(block, frequency_Hz, clean_torque, noise_A, phases_rad, begin_rad)


def trial(what: Disturbance, random: np.random.Generator) -> Iterator[Compared]:
    """Yield all measurements of one record with a known truth."""
    made = record(what, random)
    noise_rms = what.noise * (what.amplitude_A or 1.0)
    thd = 100.0 * math.sqrt(sum(each**2 for each in what.harmonics.values()))
    is_noise_alone = not what.lines and not what.decay[0] and not what.bits and math.isinf(what.clip)
    is_steady = not any(
        (
            what.drift,
            what.swing[0],
            what.settling[0],
            what.speed_walk,
            what.speed_memory[0],
            what.amplitude_noise[0],
            what.alternates,
            what.frozen,
            what.spikes,
            what.time_jitter,
            what.kind not in UNCORRELATED,
            what.chirp[0],
        )
    )
    truths = {
        "fundamental_frequency": made.frequency_Hz,
        "current_fundamental": what.amplitude_A * 0.5 * (1.0 + what.second_regime),
        "current_thd_f": thd,
        "current_thd_f_noise_corrected": thd,
        "current_thd_r": 100.0 / math.sqrt(1.0 + (100.0 / thd) ** 2) if thd else 0.0,
        "torque_mean": what.torque_Nm,
        "torque_ripple_pp": float(np.ptp(made.clean_torque_Nm)) if _is_clean(what) else OF_THE_ENSEMBLE,
        "torque_ripple_percentile_range": percentile_range(made.clean_torque_Nm)
        if _is_clean(what)
        else OF_THE_ENSEMBLE,
        "torque_ripple_rms": math.sqrt(
            0.5 * RIPPLE_NM**2 * (1.0 + what.ripple_noise[0] ** 2)
            + 0.5 * COGGING_NM**2
            + what.sawtooth[0] ** 2 / 12.0
            + 0.5 * sum(each**2 for each in what.turns_Nm)
            + (TORQUE_NM * what.noise) ** 2
        ),
        "current_thd_f_subgroups": OF_THE_ENSEMBLE,
        "current_thd_f_groups": OF_THE_ENSEMBLE,
    }
    if _is_clean(what) and what.noise <= _NO_POWER:  # what is between harmonics is nothing
        truths["current_thd_f_subgroups"] = truths["current_thd_f_groups"] = thd
    if what.alternates:  # which is in the groups of the record's own phases
        truths["current_thd_f_groups"] = _groups_of_two(what, made)
    if what.amplitude_noise[0] and not what.lines:  # likewise
        truths["current_thd_f_groups"] = _groups_of_steps(what, made)
    truths["current_tdd"] = thd * truths["current_fundamental"] / (math.sqrt(2.0) * RATED_A_RMS)
    if what.peaked or what.kind == "walk":
        truths["torque_ripple_rms"] = OF_THE_ENSEMBLE  # crests are ripple too, and a walk has no rms
    if what.torque_Nm:
        truths["torque_ripple_percent_of_mean"] = 100.0 * truths["torque_ripple_pp"] / abs(what.torque_Nm)
    has_regimes = abs(what.second_regime - 1.0) > 0.1  # whose difference hides the harmonics too
    if is_noise_alone and is_steady and not has_regimes:
        truths["current_noise_floor"] = math.nan
    if not what.decay[0] and not has_regimes and not any(relative > 0.03 for _, relative in what.lines):
        largest = max(what.harmonics.values(), default=0.0)
        truths["current_max_low_harmonic"] = truths["current_fundamental"] * largest
    steady = analyze_steady_state(
        made.block, pole_pairs=POLE_PAIRS, torque_rated_Nm=TORQUE_NM, current_rated_A_rms=RATED_A_RMS
    )
    if "current_noise_floor" in truths and steady.spectrum is not None:
        density = 2.0 * noise_rms * _share_between(what.colour, steady.spectrum)
        truths["current_noise_floor"] = density / math.sqrt(steady.spectrum.samples)
    yield from selected(steady.measurements, truths)
    for table in steady.tables:
        if table.name == "current_harmonics":
            for order, relative in what.harmonics.items():
                if order > len(table.rows):
                    reason = "no harmonic was measured"
                    yield Measurement.undefined(f"harmonic_{order}", "A", "", reason), math.nan
                    continue
                row = table.rows[order - 1]
                uncertain = Uncertainty(row[5], "") if math.isfinite(row[5]) else None
                number = Measurement(f"harmonic_{order}", row[2], "A", "", uncertainty=uncertain)
                yield number, truths["current_fundamental"] * relative
    if what.angle and not what.peaked:
        try:
            orders = order_analysis(made.block, "torque", pole_pairs=POLE_PAIRS)
        except AnalysisError:
            return
        listed = {
            f"torque_order_{RIPPLE_ORDER}": RIPPLE_NM,
            f"torque_order_{COGGING_ORDER}": COGGING_NM,
        }
        yield from selected(orders.measurements, listed)


def _groups_of_two(what: Disturbance, made: Record) -> float:
    """Return THDG of an amplitude that alternates, by its line spectrum: orders k and k +- 1/2, 3/2 ...

    A group of order h holds order h, and half of the squares of h - 1/2 and h + 1/2.
    """
    points = 1 << 14
    theta = made.begin_rad + 4 * np.pi * np.arange(points) / points
    wave = np.cos(theta)
    for order, amplitude in what.harmonics.items():
        wave += amplitude * np.cos(order * theta + made.phases_rad[order])
    wave *= np.where(np.arange(points) < points // 2, 1.0 + what.alternates, 1.0 - what.alternates)
    square = 2.0 * np.abs(np.fft.rfft(wave)[:104] / points) ** 2
    noise2 = 2.0 * what.noise**2 * what.frequency_Hz / RATE_HZ  # of the ten bins of a group
    groups = square[2:102:2] + 0.5 * (square[1:101:2] + square[3:103:2]) + noise2
    return 100.0 * math.sqrt(float(np.sum(groups[1:]) / groups[0]))


def _groups_of_steps(what: Disturbance, made: Record) -> float:
    """Return THDG, on average, of an amplitude that is another in each period, by the covariance of a window.

    How far the sidebands of the fundamental are in the group of order 2 depends on its phase where the
    amplitude steps, which is the same in all of a record.
    """
    periods, points, last = 10, 512, 50
    rms, memory = what.amplitude_noise
    theta = made.begin_rad + 2 * np.pi * np.arange(points) / points
    wave = np.cos(theta)
    for order, amplitude in what.harmonics.items():
        wave += amplitude * np.cos(order * theta + made.phases_rad[order])
    bins = np.arange(periods * last + periods // 2 + 1)
    turned = np.exp(-2j * np.pi * np.outer(bins / periods, np.arange(points) / points))
    lags = np.arange(1 - periods, periods)
    shares = (periods - np.abs(lags)) * (float(memory) ** np.abs(lags))
    steps = rms**2 * np.real(np.exp(-2j * np.pi * np.outer(bins / periods, lags)) @ shares)
    square = np.abs(turned @ wave) ** 2 * (np.where(bins % periods, 0.0, periods**2) + steps)
    noise2 = 2.0 * what.noise**2 * what.frequency_Hz / (periods * RATE_HZ)
    square = 2.0 * square / (periods * points) ** 2 + noise2
    at = periods * np.arange(1, last + 1)
    groups = sum(square[at + k] for k in range(-4, 5)) + 0.5 * (square[at - 5] + square[at + 5])
    return 100.0 * math.sqrt(float(np.sum(groups[1:]) / groups[0]))


def _is_clean(what: Disturbance) -> bool:
    """Return whether there is a converter, whose steps are much more than the noise."""
    return bool(what.bits) and what.noise <= _MUCH_LESS * 2.0 / 2**what.bits


def _share_between(pole: float, spectrum: CoherentSpectrum) -> float:
    """Return the root of the mean density in the bins between the harmonics, over that of white noise of
    equal rms."""
    bins = np.arange(len(spectrum.amplitude))
    place = bins % spectrum.periods
    guard = 2 if spectrum.periods >= 4 else 1
    omega = 2 * np.pi * bins[(place >= guard) & (place <= spectrum.periods - guard)] / spectrum.samples
    density = (1.0 - pole**2) / np.abs(1.0 - pole * np.exp(-1j * omega)) ** 2
    return math.sqrt(float(np.mean(density)))


def _of_speed(what: Disturbance, time: Floats, random: np.random.Generator) -> Floats:
    """Return the phase that deviations of the speed add, over that of the whole record; time from 0 to 1."""
    begin, constant = what.settling
    added = begin * constant * (1.0 - np.exp(-time / constant))
    steps = math.sqrt(1.0 / len(time))
    if what.speed_walk:
        walk = what.speed_walk * steps * np.cumsum(random.standard_normal(len(time)))
        added = added + np.cumsum(walk) / len(time)
    rms, memory = what.speed_memory
    if rms:
        speed = coloured(random.standard_normal(len(time)), math.exp(-1.0 / (memory * len(time))))
        added = added + rms * np.cumsum(speed) / len(time)
    return added


def _sawtooth(size: tuple[float, float], place: Floats, random: np.random.Generator) -> Floats:
    """Return teeth about zero, one for each whole number of `place`, each of which begins a little off."""
    height, jitter = size
    if not height:
        return np.zeros(len(place))
    first, last = math.floor(place.min()) - 2, math.ceil(place.max()) + 3
    edges = np.arange(first, last) + jitter * random.standard_normal(last - first)
    edges.sort()
    at = np.searchsorted(edges, place, side="right") - 1
    return np.asarray(height * ((place - edges[at]) / (edges[at + 1] - edges[at]) - 0.5))


def _by_period(noise: tuple[float, float], period: NDArray[np.int64], random: np.random.Generator) -> Floats:
    """Return a Gauss-Markov sequence, one value a period, smooth between."""
    rms, memory = noise
    if not rms:
        return np.zeros(len(period))
    values = rms * coloured(random.standard_normal(int(period.max()) + 1), memory)
    return np.asarray(values[period])
