"""True numbers of steady and less steady records, by their definitions and how the records were made."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from benchmarks.coverage.families import OF_THE_ENSEMBLE
from benchmarks.coverage.named_truths import HIGHEST_ORDER, of_orders, of_ripple
from benchmarks.coverage.noise import UNCORRELATED
from benchmarks.coverage.steady_records import (
    COGGING_NM,
    COGGING_ORDER,
    CREST,
    POLE_PAIRS,
    RATE_HZ,
    RATED_A_RMS,
    RIPPLE_NM,
    RIPPLE_ORDER,
    RIPPLE_RAD,
    TOOTH_ORDER,
    TORQUE_NM,
    Disturbance,
    Record,
    is_clean,
)
from benchtool.analysis import CoherentSpectrum, percentile_range

Floats = NDArray[np.float64]

_NO_POWER = 1e-5
_IN_THD_PLUS_NOISE = (
    "periods", "frequency_Hz", "noise", "colour", "kind", "lines", "offset", "bits", "harmonics",
    "amplitude_A", "torque_Nm", "angle", "ripple_noise", "sawtooth", "turns_Nm", "peaked",
)  # fmt: skip
_HIGHEST_GROUP, _TOLD = 50, 0.45  # of the rate, up to which a spectrum is told


def true_numbers(what: Disturbance, made: Record, spectrum: CoherentSpectrum | None) -> Mapping[str, float]:
    """Return the truth of the current's and the torque's numbers, of one record and its spectrum's bins."""
    counted, others = (
        sum(size**2 for order, size in what.harmonics.items() if (order <= _HIGHEST_GROUP) is each)
        for each in (True, False)
    )
    thd = 100.0 * math.sqrt(counted)
    fundamental_A = what.amplitude_A * 0.5 * (1.0 + what.second_regime)
    truths = {
        "fundamental_frequency": made.frequency_Hz,
        "current_fundamental": fundamental_A,
        "current_thd_f": thd,
        "current_thd_r": 100.0 / math.sqrt(1.0 + (100.0 / thd) ** 2) if thd else 0.0,
        "current_tdd": thd * fundamental_A / (math.sqrt(2.0) * RATED_A_RMS),
        "current_thd_f_subgroups": OF_THE_ENSEMBLE,
        "current_thd_f_groups": OF_THE_ENSEMBLE,
    }
    if is_clean(what) and what.noise <= _NO_POWER:  # what is between harmonics is nothing
        truths["current_thd_f_subgroups"] = truths["current_thd_f_groups"] = thd
    has_density = what.kind in UNCORRELATED
    if what.alternates and has_density:  # which is in the groups of the record's own phases
        truths["current_thd_f_groups"] = _groups_of_two(what, made)
    is_steps_alone = not (what.lines or what.decay[0] or what.time_jitter)
    if what.amplitude_noise[0] and has_density and is_steps_alone:  # likewise
        truths["current_thd_f_groups"] = _groups_of_steps(what, made)
    has_regimes = abs(what.second_regime - 1.0) > 0.1  # whose difference hides the harmonics too
    if not what.decay[0] and not has_regimes and not any(relative > 0.03 for _, relative in what.lines):
        truths["current_max_low_harmonic"] = fundamental_A * max(what.harmonics.values(), default=0.0)
    steps_each_period = what.alternates or what.amplitude_noise[0]  # how high, where a period begins tells
    if spectrum is not None and not steps_each_period:
        floor_A = _noise_floor_A(what, made, spectrum)
        bin_Hz = RATE_HZ / spectrum.samples
        truths |= {
            "current_noise_floor": floor_A,
            "current_noise_density": floor_A / math.sqrt(2.0 * bin_Hz),
        }
    if spectrum is not None:
        truths["current_thd_f_plus_noise"] = _thd_plus_noise(
            what, made, math.hypot(thd, 100.0 * math.sqrt(others)), spectrum
        )
    return truths | _ripple(what, made)


def _thd_plus_noise(what: Disturbance, made: Record, thd: float, spectrum: CoherentSpectrum) -> float:
    """Return THD with all noise in the band, in percent: of a steady current by what it is made of."""
    only = replace(Disturbance(), **{name: getattr(what, name) for name in _IN_THD_PLUS_NOISE})
    if what != only or what.kind not in UNCORRELATED or is_clean(what):
        return OF_THE_ENSEMBLE
    omega = 2.0 * np.pi * np.arange(1.0, float(len(spectrum.amplitude)), dtype=np.float64) / spectrum.samples
    share = float(np.mean(_density(what.colour, omega))) * 2.0 * spectrum.frequency_Hz[-1] / RATE_HZ
    step = 0.0 if made.converter is None else made.converter.step / what.amplitude_A
    noise2 = 2.0 * (what.noise**2 + step**2 / 12.0) * share + sum(relative**2 for _, relative in what.lines)
    return math.sqrt(thd**2 + 1e4 * noise2)


def _noise_floor_A(what: Disturbance, made: Record, spectrum: CoherentSpectrum) -> float:
    """Return the root of the mean square of a bin between the harmonics."""
    of_other_power = (
        what.frozen,
        what.across,
        what.spikes,
        what.time_jitter,
        what.chirp[0],
        what.kind not in UNCORRELATED,
        math.isfinite(what.clip),
    )
    if any(of_other_power):
        return OF_THE_ENSEMBLE
    rms_A = what.noise * (what.amplitude_A or 1.0)
    if made.converter is not None:  # whose errors noise makes white
        rms_A = math.hypot(rms_A, made.converter.step / math.sqrt(12.0))
    return 2.0 * rms_A * _share_between(what.colour, spectrum) / math.sqrt(spectrum.samples)


def _ripple(what: Disturbance, made: Record) -> dict[str, float]:
    """Return the truth of the torque's mean and ripple."""
    rms_Nm = math.sqrt(
        0.5 * RIPPLE_NM**2 * (1.0 + what.ripple_noise[0] ** 2)
        + 0.5 * COGGING_NM**2
        + what.sawtooth[0] ** 2 / 12.0
        + 0.5 * sum(each**2 for each in what.turns_Nm)
        + (TORQUE_NM * what.noise) ** 2
    )
    if what.peaked or what.kind == "walk":
        rms_Nm = OF_THE_ENSEMBLE  # crests are ripple too, and a walk has no rms
    clean, is_read = made.clean_torque_Nm, is_clean(what)
    pp_Nm = float(np.ptp(clean)) if is_read else OF_THE_ENSEMBLE
    percentile_Nm = percentile_range(clean) if is_read else OF_THE_ENSEMBLE
    return of_ripple(what.torque_Nm, rms_Nm, pp_Nm, percentile_Nm, TORQUE_NM)


def true_orders(what: Disturbance, highest: int) -> Mapping[str, float]:
    """Return the amplitude of every order of the torque, in Nm, by all names that a number of it may have."""
    orders = dict.fromkeys(range(1, HIGHEST_ORDER + 1), 0.0)
    orders[COGGING_ORDER] = COGGING_NM
    orders |= dict(enumerate(what.turns_Nm, 1))
    for k in range(1, HIGHEST_ORDER // RIPPLE_ORDER + 1):
        crest_Nm = 2.0 * what.peaked * math.exp(-CREST) * float(special.iv(k, CREST))
        ripple_Nm = RIPPLE_NM * cmath.exp(1j * RIPPLE_RAD) if k == 1 else 0.0
        orders[k * RIPPLE_ORDER] += abs(crest_Nm + ripple_Nm)
    height_Nm, jitter = what.sawtooth
    for k in range(1, HIGHEST_ORDER // TOOTH_ORDER + 1):
        orders[k * TOOTH_ORDER] += OF_THE_ENSEMBLE if height_Nm and jitter else height_Nm / (math.pi * k)
    return of_orders({order: size for order, size in orders.items() if size}, POLE_PAIRS, highest)


def _groups_of_two(what: Disturbance, made: Record) -> float:
    """Return THDG of an amplitude that alternates, by its line spectrum: orders k and k +- 1/2, 3/2 ...

    A group of order h holds order h, and half of the squares of h - 1/2 and h + 1/2.
    """
    points = 1 << 14
    theta = made.theta_e[0] + 4 * np.pi * np.arange(points) / points
    wave = np.cos(theta)
    for order, amplitude in what.harmonics.items():
        wave += amplitude * np.cos(order * theta + made.phases_rad[order])
    wave *= np.where(np.arange(points) < points // 2, 1.0 + what.alternates, 1.0 - what.alternates)
    last = _last_group(what)
    square = 2.0 * np.abs(np.fft.rfft(wave)[: 2 * last + 2] / points) ** 2
    noise2 = _noise2_per_order(what, np.arange(1.0, last + 1.0))
    groups = square[2::2] + 0.5 * (square[1:-1:2] + square[3::2]) + noise2
    return 100.0 * math.sqrt(float(np.sum(groups[1:]) / groups[0]))


def _groups_of_steps(what: Disturbance, made: Record) -> float:
    """Return THDG, on average, of an amplitude that is another in each period, by the covariance of a window.

    How far the sidebands of the fundamental are in the group of order 2 depends on its phase where the
    amplitude steps, which is the same in all of a record.
    """
    periods, points, last = 10, 512, _last_group(what)
    rms, memory = what.amplitude_noise
    theta = made.theta_e[0] + 2 * np.pi * np.arange(points) / points
    wave = np.cos(theta)
    for order, amplitude in what.harmonics.items():
        wave += amplitude * np.cos(order * theta + made.phases_rad[order])
    bins = np.arange(periods * last + periods // 2 + 1)
    turned = np.exp(-2j * np.pi * np.outer(bins / periods, np.arange(points) / points))
    lags = np.arange(1 - periods, periods)
    shares = (periods - np.abs(lags)) * (float(memory) ** np.abs(lags))
    steps = rms**2 * np.real(np.exp(-2j * np.pi * np.outer(bins / periods, lags)) @ shares)
    square = np.abs(turned @ wave) ** 2 * (np.where(bins % periods, 0.0, periods**2) + steps)
    noise2 = _noise2_per_order(what, bins / periods) / periods
    square = 2.0 * square / (periods * points) ** 2 + noise2
    at = periods * np.arange(1, last + 1)
    groups = sum(square[at + k] for k in range(-4, 5)) + 0.5 * (square[at - 5] + square[at + 5])
    return 100.0 * math.sqrt(float(np.sum(groups[1:]) / groups[0]))


def _last_group(what: Disturbance) -> int:
    """Return the order of the last group, up to whose end the rate tells."""
    return min(_HIGHEST_GROUP, math.floor(_TOLD * RATE_HZ / what.frequency_Hz - 1.0))


def _noise2_per_order(what: Disturbance, orders: Floats) -> Floats:
    """Return the mean square of the noise between two orders, about these, relative to the amplitude's."""
    omega = 2.0 * np.pi * orders * what.frequency_Hz / RATE_HZ
    return 2.0 * what.noise**2 * what.frequency_Hz / RATE_HZ * _density(what.colour, omega)


def _density(pole: float, omega: Floats) -> Floats:
    """Return the density at angles per sample, over that of white noise of equal rms."""
    return np.asarray((1.0 - pole**2) / np.abs(1.0 - pole * np.exp(-1j * omega)) ** 2)


def _share_between(pole: float, spectrum: CoherentSpectrum) -> float:
    """Return the root of the mean density in the bins between the harmonics, over that of white noise of
    equal rms."""
    bins = np.arange(len(spectrum.amplitude), dtype=np.float64)
    place = bins % spectrum.periods
    guard = 2 if spectrum.periods >= 4 else 1
    omega = 2 * np.pi * bins[(place >= guard) & (place <= spectrum.periods - guard)] / spectrum.samples
    return math.sqrt(float(np.mean(_density(pole, omega))))
