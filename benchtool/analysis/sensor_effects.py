"""What the bandwidth and the resolution of a stated sensor do to a measurement, by the kind of number it is.

The kind is that of `benchtool.analysis.sensitivity`, the change that of the recorded waveform.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from typing import Final

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.sensitivity import Declared, Found, Sensitivity
from benchtool.analysis.waveform import (
    Waveform,
    by_steps,
    lost_of_feature,
    lost_of_harmonics,
    lost_of_line,
)

NOT_KNOWN: Final = "how much the sensor's bandwidth takes off is not known without "
"""How a remark begins on a loss that cannot be computed."""

_OF_READING = "noise is that of the reading: the sensor attenuates what comes before it"
_BEYOND = "lose more than 29 % to the sensor and count only as far as they were read"


def top_Hz(stated: Declared, found: Found, each: Measurement) -> float:
    """Return the highest frequency that contributes; nan if it is unknown."""
    if stated.line_Hz is not None:
        return abs(stated.line_Hz(found))
    if each.basis.harmonics is not None:
        return each.basis.harmonics * found.other("fundamental_frequency")
    return math.nan if each.basis.bandwidth_Hz is None else each.basis.bandwidth_Hz


def lost(
    stated: Declared, found: Found, highest_Hz: float, bandwidth_Hz: float, waveform: Waveform | None
) -> tuple[float, str]:
    """Return what a first-order lag has taken off a number, relative to what was read, and a remark on what
    that leaves out."""
    if stated.bandwidth == "noise":
        return 0.0, _OF_READING
    if stated.bandwidth == "line":
        known = math.isfinite(highest_Hz)
        return (lost_of_line(highest_Hz, bandwidth_Hz), "") if known else (0.0, f"{NOT_KNOWN}the frequency")
    if waveform is None:
        return 0.0, f"{NOT_KNOWN}a record of even samples without gaps"
    if stated.bandwidth == "band":
        fundamental_Hz = found.other("fundamental_frequency")
        share = lost_of_harmonics(
            waveform, fundamental_Hz, highest_Hz, bandwidth_Hz, as_ratio=stated.as_ratio
        )
    elif stated.bandwidth == "power":
        share = lost_of_feature(waveform, bandwidth_Hz, lambda of: of.rms)
    else:
        share = lost_of_feature(waveform, bandwidth_Hz, lambda of: of.peak_to_peak)
    if not math.isfinite(share):
        return 0.0, f"{NOT_KNOWN}a harmonic in the band"
    beyond = math.isfinite(highest_Hz) and highest_Hz > bandwidth_Hz
    return share, f"components from {bandwidth_Hz:g} to {highest_Hz:.4g} Hz {_BEYOND}" if beyond else ""


def moved_by_lags(found: Found, turned: Sequence[float]) -> float:
    """Return how far the lags of three phases move a symmetrical component, in its unit; nan if unknown.

    To first order a lag turns its phase by x = f / bandwidth, of which `turned` has the three, and leaves its
    length: of the positive sequence the mean of x is left, and |x_a + a x_b + a^2 x_c| / 3 of it is in each
    of the others, a = exp(2j pi / 3). So equal lags leave no unbalance.
    """
    positive = found.other("current_sequence_positive")
    if found.name == "current_sequence_positive":
        return positive * (math.hypot(1.0, sum(turned) / 3.0) - 1.0)
    scale = 100.0 if found.name.endswith("_percent") else positive
    return scale * abs(sum(x * cmath.exp(2j * k * math.pi / 3.0) for k, x in enumerate(turned))) / 3.0


def moved_by_steps(
    part: Sensitivity,
    stated: Declared,
    found: Found,
    highest_Hz: float,
    resolution: float,
    waveform: Waveform | None,
) -> float:
    """Return the standard uncertainty by the steps in which a sensor reads, in the number's unit.

    Where no waveform tells how far their errors average out, it is that of the declaration; so it is of
    extremes, each a single reading.
    """
    if stated.bandwidth == "extremes":
        return part.resolution(found) * resolution
    if waveform is not None and stated.bandwidth == "level":
        return abs(part.offset(found)) * by_steps(waveform, resolution, lambda of: of.mean)
    feature = _feature(stated, found, highest_Hz)
    read = 0.0 if waveform is None else abs(feature(waveform))
    if waveform is None or not read > 0.0:
        return part.resolution(found) * resolution
    scale = part.gain(found) if stated.bandwidth == "sequence" else found.value
    return abs(scale) * by_steps(waveform, resolution, feature) / read


def _feature(stated: Declared, found: Found, highest_Hz: float) -> Callable[[Waveform], complex]:
    """Return the feature of a waveform that such a number is proportional to, 0 where it is not known."""
    fundamental_Hz = found.other("fundamental_frequency")

    def harmonics(of: Waveform) -> float:
        whole = math.hypot(*(amplitude for _, amplitude in of.harmonics(fundamental_Hz, highest_Hz)))
        return whole / abs(of.line(fundamental_Hz)) if stated.as_ratio and whole else whole

    match stated.bandwidth:
        case "line":
            return lambda of: abs(of.line(highest_Hz))
        case "sequence":
            return lambda of: of.line(highest_Hz)
        case "band":
            return harmonics
        case "noise":
            return lambda of: of.between(fundamental_Hz)
        case _:
            return lambda of: of.rms
