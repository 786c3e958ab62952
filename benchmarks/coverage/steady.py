"""Families of steady and less steady records: current, torque and angle, with disturbances."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.families import OF_THE_ENSEMBLE, Family, selected
from benchmarks.coverage.noise import coloured, converted
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
HARMONICS: Mapping[int, float] = {5: 0.03, 7: 0.02}
TORQUE_NM, RIPPLE_NM, COGGING_NM = 2.0, 0.1, 0.05
RIPPLE_ORDER, COGGING_ORDER = 6 * POLE_PAIRS, 3 * POLE_PAIRS
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
    drift: float = 0.0
    swing: tuple[float, float] = (0.0, 1.0)
    reverses: bool = False
    stands_still: float = 0.0  # share of the record, from 0.6 of it on
    phase_step_rad: float = 0.0  # of the current against the rotor, at 0.4 of the record
    lines: tuple[tuple[float, float], ...] = ()
    offset: float = 0.0
    decay: tuple[float, float] = (0.0, 1.0)  # relative dc at the beginning, time constant over the duration
    amplitude_noise: tuple[float, float] = (0.0, 0.0)  # rms, correlation over periods
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


@dataclass(frozen=True)
class Record:
    """A block and its true values."""

    block: Block
    frequency_Hz: float
    clean_torque_Nm: Floats
    noise_A: Floats


def record(what: Disturbance, random: np.random.Generator) -> Record:
    """Return one random record: phases of everything are random, and so is the noise."""
    count = round(what.periods / what.frequency_Hz * RATE_HZ)
    time_s = (np.arange(count) + what.time_jitter * random.standard_normal(count)) / RATE_HZ
    duration_s = count / RATE_HZ
    deviation, swing_Hz = what.swing
    swing_rad = 2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi)
    speed = 2 * np.pi * what.frequency_Hz
    cycles = speed * time_s + 0.5 * speed * what.drift * (time_s**2 / duration_s - time_s)
    if deviation:
        cycles = cycles + speed * deviation / (2 * np.pi * swing_Hz) * np.sin(swing_rad)
    if what.reverses:
        cycles = np.where(time_s < 0.7 * duration_s, cycles, 2 * cycles[int(0.7 * count)] - cycles)
    if what.stands_still:
        at, back = (int(share * count) for share in (0.6, 0.6 + what.stands_still))
        cycles = cycles - np.clip(cycles, cycles[at], cycles[back])  # it turns on where it stood
    theta_e = cycles + random.uniform(0, 2 * np.pi)
    frequency_Hz = float(theta_e[-1] - theta_e[0]) / (2 * np.pi * (time_s[-1] - time_s[0]))

    noise = coloured(random.standard_normal(count), what.colour)
    noise_A = what.noise * what.amplitude_A * noise if what.amplitude_A else what.noise * noise
    theta_i = theta_e + np.where(time_s < 0.4 * duration_s, 0.0, what.phase_step_rad)
    current = np.cos(theta_i)
    for order, amplitude in what.harmonics.items():
        current += amplitude * np.cos(order * theta_i + random.uniform(0, 2 * np.pi))
    period = np.floor((theta_e - theta_e[0]) / (2 * np.pi)).astype(np.int64)
    period -= period.min()
    current *= 1.0 + _by_period(what.amplitude_noise, period, random)
    current *= np.where(time_s < 0.5 * duration_s, 1.0, what.second_regime)
    for place, amplitude in what.lines:
        current += amplitude * np.cos(
            2 * np.pi * place * what.frequency_Hz * time_s + random.uniform(0, 6.28)
        )
    start, constant = what.decay
    current += what.offset + start * random.choice([-1, 1]) * np.exp(-time_s / (constant * duration_s))
    if what.spikes:
        current[random.integers(0, count, 10)] += what.spikes
    current = what.amplitude_A * current + noise_A
    current = np.clip(current, -what.clip * AMPLITUDE_A, what.clip * AMPLITUDE_A)

    theta_true = theta_e / POLE_PAIRS
    torque = what.torque_Nm + RIPPLE_NM * (1.0 + _by_period(what.ripple_noise, period, random)) * np.cos(
        RIPPLE_ORDER * theta_true + 0.3
    )
    torque += COGGING_NM * np.cos(COGGING_ORDER * theta_true + 1.1)
    torque += 0.1 * TORQUE_NM * what.noise * 10.0 * coloured(random.standard_normal(count), what.colour)
    clean_torque = torque
    if what.bits:
        step_A, step_Nm = 2.0 * AMPLITUDE_A / 2**what.bits * 1.02, 2.0 * TORQUE_NM / 2**what.bits
        current, torque = (
            converted(each, step, random) for each, step in ((current, step_A), (torque, step_Nm))
        )

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
    return Record(block, frequency_Hz, clean_torque, noise_A)


def trial(what: Disturbance, random: np.random.Generator) -> Iterator[tuple[Measurement, float]]:
    """Yield all measurements of one record with a known truth."""
    made = record(what, random)
    noise_rms = what.noise * (what.amplitude_A or 1.0)
    thd = 100.0 * math.sqrt(sum(each**2 for each in what.harmonics.values()))
    is_noise_alone = not what.lines and not what.decay[0] and not what.bits and math.isinf(what.clip)
    is_steady = not (
        what.drift or what.swing[0] or what.amplitude_noise[0] or what.spikes or what.time_jitter
    )
    truths = {
        "fundamental_frequency": made.frequency_Hz,
        "current_fundamental": what.amplitude_A * 0.5 * (1.0 + what.second_regime),
        "current_thd_f": thd,
        "current_thd_f_noise_corrected": thd,
        "current_thd_r": 100.0 / math.sqrt(1.0 + (100.0 / thd) ** 2) if thd else 0.0,
        "torque_mean": what.torque_Nm,
        "torque_ripple_pp": OF_THE_ENSEMBLE,
        "torque_ripple_percentile_range": percentile_range(made.clean_torque_Nm)
        if what.bits
        else OF_THE_ENSEMBLE,
        "torque_ripple_rms": math.sqrt(
            0.5 * RIPPLE_NM**2 * (1.0 + what.ripple_noise[0] ** 2)
            + 0.5 * COGGING_NM**2
            + (TORQUE_NM * what.noise) ** 2
        ),
        "current_thd_f_subgroups": OF_THE_ENSEMBLE,
        "current_thd_f_groups": OF_THE_ENSEMBLE,
    }
    if what.torque_Nm:
        truths["torque_ripple_percent_of_mean"] = OF_THE_ENSEMBLE
    if is_noise_alone and is_steady and what.second_regime == 1.0:
        truths["current_noise_floor"] = math.nan
    if not any(relative > 0.03 for _, relative in what.lines) and not what.decay[0]:
        truths["current_max_low_harmonic"] = what.amplitude_A * max(what.harmonics.values(), default=0.0)
    steady = analyze_steady_state(
        made.block, pole_pairs=POLE_PAIRS, torque_rated_Nm=TORQUE_NM, current_rated_A_rms=4.0
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
                yield number, what.amplitude_A * relative
    if what.angle:
        try:
            orders = order_analysis(made.block, "torque", pole_pairs=POLE_PAIRS)
        except AnalysisError:
            return
        listed = {
            f"torque_order_{RIPPLE_ORDER}": RIPPLE_NM,
            f"torque_order_{COGGING_ORDER}": COGGING_NM,
        }
        yield from selected(orders.measurements, listed)


def _share_between(pole: float, spectrum: CoherentSpectrum) -> float:
    """Return the root of the mean density in the bins between the harmonics, over that of white noise of
    equal rms."""
    bins = np.arange(len(spectrum.amplitude))
    place = bins % spectrum.periods
    guard = 2 if spectrum.periods >= 4 else 1
    omega = 2 * np.pi * bins[(place >= guard) & (place <= spectrum.periods - guard)] / spectrum.samples
    density = (1.0 - pole**2) / np.abs(1.0 - pole * np.exp(-1j * omega)) ** 2
    return math.sqrt(float(np.mean(density)))


def _by_period(noise: tuple[float, float], period: NDArray[np.int64], random: np.random.Generator) -> Floats:
    """Return a Gauss-Markov sequence, one value a period, smooth between."""
    rms, memory = noise
    if not rms:
        return np.zeros(len(period))
    values = rms * coloured(random.standard_normal(int(period.max()) + 1), memory)
    return np.asarray(values[period])


_QUIET = Disturbance()
_DRIFT = replace(_QUIET, periods=100.3, noise=1e-4)
DISTURBANCES: Mapping[str, Disturbance] = {
    "plain": _QUIET,
    "plain_no_angle": replace(_QUIET, angle=False),
    "white_-40dB": replace(_QUIET, noise=1e-2),
    "white_-40dB_no_angle": replace(_QUIET, noise=1e-2, angle=False),
    "white_-80dB": replace(_QUIET, noise=1e-4),
    "loud_white_-20dB": replace(_QUIET, noise=0.1),
    "non_integer_periods": replace(_QUIET, periods=23.37, noise=3e-3),
    "non_integer_no_angle": replace(_QUIET, periods=23.37, noise=3e-3, angle=False),
    "few_periods": replace(_QUIET, periods=4.6, noise=3e-3),
    "few_periods_no_angle": replace(_QUIET, periods=4.6, noise=3e-3, angle=False),
    "three_periods_interharmonic": replace(_QUIET, periods=3.4, noise=3e-3, lines=((2.3, 0.02),)),
    "many_periods": replace(_QUIET, periods=400.2, noise=1e-2, frequency_Hz=133.3),
    "fast_fundamental": replace(_QUIET, periods=300.4, noise=3e-3, frequency_Hz=401.3),
    "coloured": replace(_QUIET, noise=1e-2, colour=0.95),
    "strongly_coloured": replace(_QUIET, noise=1e-2, colour=0.998),
    "coloured_no_angle": replace(_QUIET, noise=1e-2, colour=0.98, angle=False),
    "drift_angle": replace(_DRIFT, drift=0.05),
    "drift_0.5_no_angle": replace(_DRIFT, drift=0.005, angle=False),
    "drift_8_no_angle": replace(_DRIFT, drift=0.08, angle=False),
    "drift_3_no_angle_noise": replace(_DRIFT, drift=0.03, angle=False, noise=1e-2, periods=60.7),
    "swing_2Hz_angle": replace(_DRIFT, swing=(0.01, 2.0)),
    "swing_2Hz_no_angle": replace(_DRIFT, swing=(0.01, 2.0), angle=False),
    "swing_7Hz_angle": replace(_DRIFT, swing=(0.01, 7.3), noise=1e-3),
    "swing_0.5Hz_no_angle": replace(_DRIFT, swing=(0.02, 0.5), angle=False, noise=1e-3),
    "swing_30Hz_angle": replace(_DRIFT, swing=(0.02, 31.7), noise=1e-3),
    "swing_encoder": replace(_DRIFT, swing=(0.005, 1.3), counts=10_000, noise=1e-3),
    "reversal": replace(_QUIET, reverses=True, periods=80.0),
    "reversal_no_angle": replace(_QUIET, reverses=True, periods=80.0, angle=False),
    "slip_0.3": replace(_QUIET, slip=0.003, periods=100.0),
    "slip_0.05": replace(_QUIET, slip=0.0005, periods=100.0),
    "slip_0.3_noise": replace(_QUIET, slip=0.003, periods=60.3, noise=1e-2),
    "encoder_1000": replace(_QUIET, counts=1000),
    "encoder_4096_noise": replace(_QUIET, counts=4096, noise=1e-2),
    "encoder_64": replace(_QUIET, counts=64, noise=3e-3),
    "angle_noise": replace(_QUIET, angle_noise_rad=2e-3),
    "wobble_1.48": replace(_QUIET, wobble_rad=(1.48e-3, 1), periods=80.0),
    "wobble_10": replace(_QUIET, wobble_rad=(1e-2, 1), periods=80.0),
    "wobble_3_order_2": replace(_QUIET, wobble_rad=(3e-3, 2), periods=80.0, noise=3e-3),
    "interharmonic": replace(_QUIET, lines=((3.37, 0.01),), noise=1e-3),
    "interharmonic_close": replace(_QUIET, lines=((1.18, 0.02),), noise=1e-3),
    "interharmonic_no_angle": replace(_QUIET, lines=((1.41, 0.02), (4.63, 0.01)), angle=False),
    "offset": replace(_QUIET, offset=0.2, noise=3e-3),
    "offset_no_angle": replace(_QUIET, offset=0.2, periods=17.4, noise=3e-3, angle=False),
    "decaying_dc": replace(_QUIET, decay=(0.5, 0.2), noise=1e-3),
    "decaying_dc_slow": replace(_QUIET, decay=(0.2, 0.7), periods=12.3),
    "decaying_dc_no_angle": replace(_QUIET, decay=(0.3, 0.1), periods=21.7, angle=False),
    "clipped": replace(_QUIET, clip=0.93, noise=1e-4),
    "clipped_hard": replace(_QUIET, clip=0.7),
    "bits_8": replace(_QUIET, bits=8, noise=1e-6),
    "bits_8_pure_sine": replace(_QUIET, bits=8, noise=0.0, harmonics={}),
    "bits_10_noise": replace(_QUIET, bits=10, noise=1e-3),
    "bits_12": replace(_QUIET, bits=12, noise=1e-4, frequency_Hz=19.37),
    "amplitude_noise": replace(_QUIET, amplitude_noise=(0.01, 0.0), periods=80.0),
    "amplitude_noise_memory": replace(_QUIET, amplitude_noise=(0.01, 0.9), periods=200.0),
    "ripple_noise": replace(_QUIET, ripple_noise=(0.2, 0.0), periods=80.0),
    "ripple_noise_memory": replace(_QUIET, ripple_noise=(0.2, 0.9), periods=200.0),
    "two_regimes": replace(_QUIET, second_regime=2.2),
    "two_regimes_no_angle": replace(_QUIET, second_regime=2.2, angle=False),
    "no_harmonics_noise": replace(_QUIET, harmonics={}, noise=1e-2),
    "low_distortion_noise": replace(_QUIET, harmonics={5: 0.001}, noise=1e-2),
    "standstill_current": replace(_QUIET, amplitude_A=0.0, noise=1e-2, harmonics={}),
    "no_mean_torque": replace(_QUIET, torque_Nm=0.0, noise=1e-2),
    "little_mean_torque": replace(_QUIET, torque_Nm=0.004, noise=1e-2),
    "jittered_samples": replace(_QUIET, time_jitter=0.05),
    "spikes": replace(_QUIET, spikes=0.3),
    "white_-60dB_long": replace(_QUIET, noise=1e-3, periods=250.6, frequency_Hz=50.0),
    # components above half the rate alias, which no analysis can detect
    "few_samples_a_period": replace(
        _QUIET, noise=3e-3, periods=500.3, frequency_Hz=811.7, harmonics={5: HARMONICS[5]}
    ),
    "two_periods": replace(_QUIET, periods=2.9, noise=3e-3),
    "six_periods_coloured": replace(_QUIET, periods=6.45, noise=1e-2, colour=0.98, angle=False),
    "standstill_within": replace(_QUIET, stands_still=0.1, periods=80.0),
    "standstill_within_no_angle": replace(_QUIET, stands_still=0.06, periods=80.0, angle=False),
    "phase_step": replace(_QUIET, phase_step_rad=0.6),
    "phase_step_no_angle": replace(_QUIET, phase_step_rad=0.6, angle=False),
    "offset_and_interharmonic": replace(_QUIET, offset=0.3, lines=((2.61, 0.01),), periods=31.3, noise=3e-3),
    "decaying_dc_fast": replace(_QUIET, decay=(1.0, 0.03), periods=60.2),
    "swing_and_interharmonic": replace(_DRIFT, swing=(0.01, 3.1), lines=((1.63, 0.01),), noise=1e-3),
    "swing_coloured_no_angle": replace(_DRIFT, swing=(0.005, 1.1), noise=1e-2, colour=0.95, angle=False),
    "drift_encoder": replace(_DRIFT, drift=0.04, counts=4096, noise=1e-3),
    "wobble_and_noise": replace(_QUIET, wobble_rad=(5e-3, 1), angle_noise_rad=1e-3, periods=80.0, noise=3e-3),
    "bits_6": replace(_QUIET, bits=6, noise=1e-3),
    "bits_8_drift": replace(_DRIFT, bits=8, drift=0.01, noise=1e-3),
    "bits_10_fast": replace(_QUIET, bits=10, noise=1e-4, frequency_Hz=133.3, periods=200.4),
    "bits_16": replace(_QUIET, bits=16, noise=1e-5),
    **{
        f"bits_{bits}_{noise:g}": replace(_QUIET, bits=bits, noise=noise, frequency_Hz=21.7, periods=33.3)
        for bits in (12, 14, 16, 18)
        for noise in (1e-6, 1e-5, 1e-4)
    },
    "ripple_noise_some_memory": replace(_QUIET, ripple_noise=(0.1, 0.6), periods=60.0),
}  # fmt: skip


def _family(name: str, what: Disturbance) -> Family:
    return Family(name, lambda random: trial(what, random))


FAMILIES = tuple(_family(name, what) for name, what in DISTURBANCES.items())
