"""Truths that follow from others, by the names of the measurements."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from benchtool.analysis import Measurement

HIGHEST_ORDER, _LOW_ORDERS = 200, 10
_OF_POLE_PAIRS = 1, 2, 6, 12
_HIGHEST_HARMONIC = 50


def of_orders(
    amplitudes: Mapping[int, float], pole_pairs: int, highest: int, name: str = "torque"
) -> dict[str, float]:
    """Return the amplitudes of orders in a revolution, 1 to `highest` measured, by all their names.

    Of the orders without a name of their own only those that are there: of those that noise alone brings to
    the list, one in a hundred records, the truth says nothing.
    """
    named = {f"{name}_order_{order}": size for order, size in amplitudes.items()}
    named |= {f"{name}_order_{k}p": amplitudes.get(k * pole_pairs, 0.0) for k in _OF_POLE_PAIRS}
    within = [size for order, size in amplitudes.items() if order <= highest and not math.isnan(size)]
    return named | {f"{name}_order_largest_amplitude": max(within, default=0.0)}


def of_ripple(
    mean: float,
    rms: float,
    pp: float | None = None,
    percentile: float | None = None,
    rated: float = 0.0,
    name: str = "torque",
) -> dict[str, float]:
    """Return mean and ripple, in the signal's unit, and their ratios in percent, as far as known."""
    truths = {f"{name}_mean": mean, f"{name}_ripple_rms": rms}
    truths |= {f"{name}_ripple_pp": pp} if pp is not None else {}
    truths |= {f"{name}_ripple_percentile_range": percentile} if percentile is not None else {}
    for reference, size in (("mean", abs(mean)), ("rated", rated)):
        if size:
            truths[f"{name}_ripple_rms_percent_of_{reference}"] = 100.0 * rms / size
            truths |= {f"{name}_ripple_percent_of_{reference}": 100.0 * pp / size} if pp is not None else {}
    return truths


def of_harmonics(amplitudes: Mapping[int, float]) -> dict[str, float]:
    """Return fundamental and distortion of a current with these harmonics, 1 among them, in A peak."""
    fundamental = amplitudes[1]
    others = {order: size for order, size in amplitudes.items() if order > 1}
    thd = math.sqrt(sum(size**2 for size in others.values())) / fundamental
    return {
        "current_fundamental": fundamental,
        "current_max_low_harmonic": max(
            (size for order, size in others.items() if order < _LOW_ORDERS), default=0.0
        ),
        "current_thd_f": 100.0 * thd,
        "current_thd_r": 100.0 * thd / math.hypot(1.0, thd),
    }


def of_groups(amplitudes: Mapping[int, float], noise: float, samples_a_period: float) -> dict[str, float]:
    """Return THDG and THDS of a current with these harmonics and white noise of this rms, A, up to order 50
    or 0.45 of the rate, over windows of ten periods.

    Bins of ten periods have the mean square 2 noise^2 / samples; a group holds ten, a subgroup three.
    """
    last = min(_HIGHEST_HARMONIC, int(0.45 * samples_a_period))
    found = {}
    for name, bins in (("groups", 10), ("subgroups", 3)):
        of_noise = bins * 2.0 * noise**2 / (10.0 * samples_a_period)
        own = [0.5 * amplitudes.get(order, 0.0) ** 2 + of_noise for order in range(1, last + 1)]
        found[f"current_thd_f_{name}"] = 100.0 * math.sqrt(sum(own[1:]) / own[0])
    return found


def of_white_noise(rms: float, rate_Hz: float, measurements: Iterable[Measurement]) -> dict[str, float]:
    """Return density of white noise of this rms, A, and its floor in bins as wide as those measured."""
    density = rms * math.sqrt(2.0 / rate_Hz)
    floors = {
        each.name: density * math.sqrt(2.0 * each.basis.bin_Hz)
        for each in measurements
        if each.name == "current_noise_floor" and each.basis.bin_Hz
    }
    return floors | {"current_noise_density": density}
