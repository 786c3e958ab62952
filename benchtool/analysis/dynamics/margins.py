"""Stability margins of a loop from the response of the controlled quantity to its reference.

With unity feedback the closed loop is T = L / (1 + L), so that the open loop is L = T / (1 - T), and the
sensitivity S = 1 / (1 + L) = 1 - T (Astroem and Murray, Feedback Systems, 2nd ed., 10.3 and 12.1).
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.dynamics.estimated_response import NEPER_DB, decibels
from benchtool.analysis.dynamics.response_curve import Point, ResponseCurve
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.uncertainty import Uncertainty

Floats = NDArray[np.float64]

_LEAST = 1e-9  # of 1 - T: a loop that is perfect except for rounding
_MOST_UNCERTAIN = 0.1  # of the sensitivity
_SMALL_DB = 1.0
_SMALL_RAD = 0.1
_SOURCE = "random error of H1, propagated to the open loop"


def margins(
    frequency_Hz: Floats, closed: NDArray[np.complex128], error: Floats, basis: Basis
) -> Iterator[Measurement]:
    """Yield the crossover, phase margin, gain margin and greatest sensitivity of the loop behind a response.

    `closed` is the response of the controlled quantity to its reference, shape (n,), a pure number, `error`
    its standard uncertainty relative to it, along it and across it.
    """
    sensitivity = 1.0 - closed
    magnitude = np.maximum(np.abs(sensitivity), _LEAST)
    opened = closed / np.where(np.abs(sensitivity) < _LEAST, _LEAST, sensitivity)
    spread = error / magnitude  # dL / L = dT / (T (1 - T))
    gain = ResponseCurve(frequency_Hz, decibels(opened), NEPER_DB * spread, _SMALL_DB)
    phase = ResponseCurve(frequency_Hz, np.unwrap(np.angle(opened)), spread, _SMALL_RAD)

    text = "lowest frequency at which the open loop T / (1 - T) has the gain 1"
    crossover = gain.falls_to(0.0)
    reason = _why_not(crossover, frequency_Hz, "its gain stays above 1")
    if crossover is None or reason:
        yield Measurement.undefined("crossover", "Hz", text, reason, basis)
        yield Measurement.undefined(
            "phase_margin", "deg", "180 degrees + phase of the open loop at crossover", reason, basis
        )
    else:
        yield Measurement(
            "crossover",
            crossover.frequency_Hz,
            "Hz",
            text,
            basis,
            Uncertainty(crossover.standard_Hz, _SOURCE),
        )
        angle, angle_error = phase.at(crossover.frequency_Hz)
        along = phase.slope_at(crossover.frequency_Hz) * crossover.standard_Hz
        text = "180 degrees + phase of the open loop at crossover"
        uncertain = Uncertainty(math.degrees(math.hypot(angle_error, along)), _SOURCE)
        margin = math.remainder(180.0 + math.degrees(angle), 360.0)
        yield Measurement("phase_margin", margin, "deg", text, basis, uncertain)

    text = "gain of the open loop below 1 at the lowest frequency where its phase is -180 degrees"
    turned = phase.falls_to(-math.pi)
    reason = _why_not(turned, frequency_Hz, "its phase stays above -180 degrees")
    if turned is None or reason:
        yield Measurement.undefined("gain_margin", "dB", text, reason, basis)
    else:
        level_dB, level_error = gain.at(turned.frequency_Hz)
        along = gain.slope_at(turned.frequency_Hz) * turned.standard_Hz
        yield Measurement(
            "gain_margin", -level_dB, "dB", text, basis, Uncertainty(math.hypot(level_error, along), _SOURCE)
        )

    yield _sensitivity_peak(frequency_Hz, magnitude, error * np.abs(closed) / magnitude, basis)


def _sensitivity_peak(frequency_Hz: Floats, magnitude: Floats, error: Floats, basis: Basis) -> Measurement:
    """Return the greatest sensitivity, of magnitudes with their relative errors.

    Far above the crossover every loop opens and S tends to 1, so that a greatest value below 1 is not that of
    the loop but of the frequencies used.
    """
    name, text = "sensitivity_peak", "greatest magnitude of the sensitivity 1 - T, M_s"
    peak_dB, peak_error_dB = ResponseCurve(
        frequency_Hz, decibels(magnitude), NEPER_DB * error, _SMALL_DB
    ).greatest()
    peak, relative = 10.0 ** (peak_dB / 20.0), peak_error_dB / NEPER_DB
    reason = ""
    if not relative <= _MOST_UNCERTAIN:
        reason = f"it is uncertain by {100.0 * relative:.2g} %: raise the stimulus"
    elif peak < 1.0:
        last_Hz = frequency_Hz[-1]
        reason = f"it is {peak:.2g} up to {last_Hz:.4g} Hz and reaches 1 above that: play higher frequencies"
    if reason:
        return Measurement.undefined(name, "", text, reason, basis)
    return Measurement(name, peak, "", text, basis, Uncertainty(peak * relative, _SOURCE))


def _why_not(found: Point | None, frequency_Hz: Floats, otherwise: str) -> str:
    """Return the reason why a crossing is undefined; empty if it is defined."""
    if found is None:
        return f"{otherwise} up to {frequency_Hz[-1]:.4g} Hz"
    return found.undefined_because
