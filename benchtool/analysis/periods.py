"""Where the electrical periods of a record are: from the rotor angle, or from the signal itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.validity import require_signal
from benchtool.errors import AnalysisError

_FEWEST_PERIODS = 2
_LARGEST_SPEED_CHANGE = 0.1
_SINE_FIT_STEPS = 8  # one to find amplitude and phase, then quadratic convergence
_NEWTON_STEPS = 6  # quadratic convergence from within 10 %: 1e-1, 1e-2, 1e-4, 1e-8, 1e-16, one to spare


@dataclass(frozen=True)
class PhaseTrack:
    """Electrical phase as a smooth function of the sample number.

    `phase` gives rad over sample numbers 0 to `samples` - 1, increasing; as a low-order polynomial it follows
    a drift of the speed and nothing faster, so that oscillations within a period stay in the signal, where a
    spectrum shows them. `source` says in words what it was made from.
    """

    phase: Polynomial
    samples: int
    source: str

    @property
    def periods(self) -> float:
        """Electrical periods between the first and the last sample."""
        return float(self.phase(self.samples - 1) - self.phase(0)) / (2 * np.pi)

    def sample_numbers(self, phase: NDArray[np.float64]) -> NDArray[np.float64]:
        """Fractional sample numbers, shape (m,), at which the track has these phases (Newton's method)."""
        begin, end = float(self.phase(0)), float(self.phase(self.samples - 1))
        number = (phase - begin) * ((self.samples - 1) / (end - begin))
        slope = self.phase.deriv()
        for _ in range(_NEWTON_STEPS):
            number -= (self.phase(number) - phase) / slope(number)
        return number


def track_angle(theta_m: NDArray[np.float64], pole_pairs: int) -> PhaseTrack:
    """Track of the measured rotor angle, rad mechanical, shape (n,), wrapped or not, of either direction.

    Quadratic least-squares fit to `pole_pairs * theta_m`: mean speed and mean acceleration.

    Raises:
        AnalysisError: fewer than two periods, not finite, standstill, or the speed changes by
            more than 10 % within the record.
    """
    require_signal(theta_m, "theta_m")
    theta_e = pole_pairs * np.unwrap(theta_m)
    if theta_e[-1] < theta_e[0]:
        theta_e = -theta_e
    _require_periods(float(theta_e[-1] - theta_e[0]), "theta_m")
    number = np.arange(len(theta_e), dtype=np.float64)
    phase = Polynomial.fit(number, theta_e, deg=min(2, len(theta_e) - 1))
    speed = phase.deriv()
    mean_speed = float(theta_e[-1] - theta_e[0]) / (len(theta_e) - 1)
    change = abs(float(speed(len(theta_e) - 1) - speed(0))) / mean_speed
    if change > _LARGEST_SPEED_CHANGE:
        raise AnalysisError(
            f"the speed changes by {100 * change:.0f} % within the window, at most "
            f"{100 * _LARGEST_SPEED_CHANGE:.0f} % is allowed: choose a window in steady state"
        )
    return PhaseTrack(phase, len(theta_e), f"quadratic fit to {pole_pairs} x theta_m")


def track_tone(samples: NDArray[np.float64], name: str = "signal") -> PhaseTrack:
    """Track of the largest sinusoid in uniformly sampled values, shape (n,), at constant frequency.

    The largest bin under a Hann window begins a four-parameter sine fit (IEEE Std 1057-2007), weighted
    with the same window so that harmonics do not pull at it; for records without an angle channel. A drift
    of the speed is not followed and shows as sidebands.

    Raises:
        AnalysisError: too short, not finite, constant, or fewer than two periods.
    """
    require_signal(samples, name)
    count = len(samples)
    window = np.hanning(count + 1)[:count]
    bins = np.abs(np.fft.rfft((samples - np.mean(samples)) * window))
    omega = 2 * np.pi * int(np.argmax(bins)) / count
    number = np.arange(count) - count / 2  # from the middle, where the phase hangs least on the frequency
    in_phase, quadrature = 0.0, 0.0
    for _ in range(_SINE_FIT_STEPS):
        cosine, sine = np.cos(omega * number), np.sin(omega * number)
        slope = number * (quadrature * cosine - in_phase * sine)
        columns = np.stack([cosine, sine, np.ones(count), slope], axis=1)
        solution = np.linalg.lstsq(columns * window[:, np.newaxis], samples * window, rcond=None)[0]
        in_phase, quadrature = float(solution[0]), float(solution[1])
        omega += float(solution[3])
    _require_periods(omega * count, name)
    # in_phase cos x + quadrature sin x = A cos(x - atan2(quadrature, in_phase))
    begin = -omega * count / 2 - float(np.arctan2(quadrature, in_phase))
    return PhaseTrack(
        Polynomial([begin, omega]), count, f"the largest sinusoid of {name}, constant frequency"
    )


def _require_periods(phase: float, name: str) -> None:
    if phase < 2 * np.pi * _FEWEST_PERIODS:
        raise AnalysisError(
            f"'{name}' covers {max(0.0, phase) / (2 * np.pi):.2f} electrical periods, at least "
            f"{_FEWEST_PERIODS} are needed: record a longer window"
        )
