"""The loops of the reference drive: their open-loop responses, and gains for a bandwidth and a phase margin.

A current follows its reference by internal-model control over the computation delay, which the drive predicts
across (Harnefors and Nee, IEEE Trans. Ind. Appl. 34 (1998) no. 1): i[k+2] is i[k+1] and a share of what the
reference is beyond it. The drive takes the voltage of the resistance to be constant for a period, in which
the current decays. A law without a current controller makes its torque within that delay.

The speed controller is a PI around it, with the speed of an observer that is fed the drive's own torque, and
so follows it without lag but for a period.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.tuning.margins import Complex, Margins, margins
from benchtool.errors import ValueRefused

LEAST_PHASE_RAD = math.radians(60.0)
LEAST_GAIN = 2.0
MOST_SENSITIVITY = 2.0
_LAWS_OF_CURRENT = ("foc",)
_STEP = 0.9
_STEPS = 40
_CHIRP_POINTS = 100


@dataclass(frozen=True)
class CurrentLoop:
    """The loop of i_d or i_q with the bandwidth `omega_rad_s`.

    `decay` is R_s T_s / L, which the resistance takes off a current in a period, to first order.
    """

    omega_rad_s: float
    T_s: float
    decay: float = 0.0

    @property
    def share(self) -> float:
        """Share of an error that a period removes."""
        return -math.expm1(-self.omega_rad_s * self.T_s)

    def closed(self, z: Complex) -> Complex:
        """Return current over its reference."""
        numerator, denominator = self._open(z)
        return np.asarray(numerator / ((z - 1.0) * denominator + numerator))

    def open(self, z: Complex) -> Complex:
        """Return the open loop with unity feedback."""
        numerator, denominator = self._open(z)
        return np.asarray(numerator / ((z - 1.0) * denominator))

    def admittance(self, omega_rad_s: float, L_H: float) -> complex:
        """Return mean current over a voltage that drives it, such as an EMF, at an angular frequency, 1/ohm.

        That voltage acts at once, and the current is not predicted with it: i[k+1] is
        a i[k] + g (u[k-1] + e[k]) with voltages times T_s / L. The mean of a period lies between
        the currents at its ends.
        """
        z = cmath.exp(1j * omega_rad_s * self.T_s)
        a = math.exp(-self.decay)
        g = -math.expm1(-self.decay) / self.decay if self.decay else 1.0
        of_PI = self.share * (1.0 + (self.decay / (z - 1.0) if self.decay else 0.0))
        sampled = g * (z + of_PI) / ((z - a) * (z + of_PI) + g * of_PI * (1.0 - self.decay))
        return 0.5 * (z + 1.0) * sampled * self.T_s / L_H

    def _open(self, z: Complex) -> tuple[Complex, Complex]:
        """Return numerator and denominator of the open loop times z - 1.

        The current is i[k+1] = a i[k] + g u[k-1] T_s / L with a = exp(-decay), g = (1 - a) / decay, predicted
        as if a were 1 - decay and g were 1. The PI's zero lies at 1 - decay.
        """
        if self.decay == 0.0:
            return np.full_like(z, self.share), z + self.share
        a = math.exp(-self.decay)
        of_PI = self.share * (z - 1.0 + self.decay)
        return (1.0 - a) / self.decay * of_PI, z * (z - a) + of_PI

    @property
    def margins(self) -> Margins:
        """Its margins."""
        return margins(self.open, self.T_s)


@dataclass(frozen=True)
class SpeedLoop:
    """The loop of speed: gains, the inertia with its viscous friction, and the loop of torque within it."""

    K_p_Nms_rad: float
    K_i_Nm_rad: float
    J_kgm2: float
    friction_Nms: float
    inner: CurrentLoop | None
    T_s: float

    def plant(self, z: Complex) -> Complex:
        """Return speed over the torque reference."""
        torque = 1.0 / (z * z) if self.inner is None else self.inner.closed(z)
        pole = math.exp(-self.friction_Nms / self.J_kgm2 * self.T_s)
        return np.asarray(torque * self.T_s / self.J_kgm2 / (z - pole))

    def controller(self, z: Complex) -> Complex:
        """Return the torque reference over the error of the speed."""
        return np.asarray(self.K_p_Nms_rad + self.K_i_Nm_rad * self.T_s * z / (z - 1.0))

    def open(self, z: Complex) -> Complex:
        """Return the open loop."""
        return np.asarray(self.controller(z) * self.plant(z))

    def torque(self, omega_rad_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return torque over the reference of the speed at angular frequencies, Nm per rad/s."""
        z = np.exp(1j * omega_rad_s * self.T_s)
        return np.abs(self.controller(z) / (1.0 + self.open(z)))

    @property
    def margins(self) -> Margins:
        """Its margins."""
        return margins(self.open, self.T_s)


def tuned_current_loop(omega_rad_s: float, T_s: float, decay: float = 0.0) -> CurrentLoop:
    """Return the loop of this bandwidth, or of the next lower one that has the margins.

    Raises:
        ValueRefused: none has.
    """
    for _ in range(_STEPS):
        loop = CurrentLoop(omega_rad_s, T_s, decay)
        found = loop.margins
        if (
            found.phase_rad >= LEAST_PHASE_RAD
            and found.gain >= LEAST_GAIN
            and found.sensitivity <= MOST_SENSITIVITY
        ):
            return loop
        omega_rad_s *= _STEP
    raise ValueRefused(
        f"no bandwidth of the current loop has the margins at T_s = {T_s:g} s: check the period"
    )


def tuned_speed_loop(
    crossover_rad_s: float,
    J_kgm2: float,
    friction_Nms: float,
    inner: CurrentLoop | None,
    T_s: float,
    phase_rad: float = LEAST_PHASE_RAD,
) -> SpeedLoop:
    """Return the PI whose loop has this crossover and phase margin.

    The controller there is what the plant lacks: its length makes the gain 1, its angle the margin.

    Raises:
        ValueRefused: the plant leaves no room for an integral part with that margin.
    """
    plant = SpeedLoop(1.0, 0.0, J_kgm2, friction_Nms, inner, T_s).plant
    angle = crossover_rad_s * T_s
    z = np.exp(1j * np.array([angle]))
    wanted = cmath.rect(1.0, phase_rad - math.pi) / complex(plant(z)[0])
    K_i = -2.0 * wanted.imag * math.tan(0.5 * angle) / T_s
    K_p = wanted.real - 0.5 * K_i * T_s
    if not (K_p > 0.0 and K_i > 0.0):
        raise ValueRefused(
            f"no PI gives the speed loop a crossover of {crossover_rad_s:.4g} rad/s with a phase margin of "
            f"{math.degrees(phase_rad):.3g} degrees: lower the bandwidth"
        )
    return SpeedLoop(K_p, K_i, J_kgm2, friction_Nms, inner, T_s)


def has_room(loop: SpeedLoop) -> bool:
    """Return whether a loop's gain margin and greatest sensitivity are as they should be, whatever its phase
    margin."""
    found = loop.margins
    return found.gain >= LEAST_GAIN and found.sensitivity <= MOST_SENSITIVITY


def inner_loop(law: str, omega_current_rad_s: float, T_s: float, decay: float = 0.0) -> CurrentLoop | None:
    """Return the loop that makes the torque of a law; None of one that makes it within the delay."""
    return CurrentLoop(omega_current_rad_s, T_s, decay) if law in _LAWS_OF_CURRENT else None


def mean_square_of_sequence(loop: SpeedLoop, amplitude_rad_s: float, clock_s: float, bits: int) -> float:
    """Return the mean square of the torque, Nm^2, while a binary sequence is added to the reference.

    Its lines are a^2 (N + 1) / N^2 sinc^2(f T_c) each, with N = 2^bits - 1 (Godfrey, Perturbation Signals for
    System Identification, 1993, 1.3.2).
    """
    length = 2**bits - 1
    f_Hz = np.arange(1.0, math.floor(0.5 * length * clock_s / loop.T_s)) / (length * clock_s)
    lines = 2.0 * amplitude_rad_s**2 * (length + 1) / length**2 * np.sinc(f_Hz * clock_s) ** 2
    return float(np.sum(lines * loop.torque(2.0 * math.pi * f_Hz) ** 2))


def mean_square_of_chirp(loop: SpeedLoop, amplitude_rad_s: float, first_Hz: float, last_Hz: float) -> float:
    """Return the mean square of the torque, Nm^2, while a linear chirp is added to the reference."""
    omega = 2.0 * math.pi * np.linspace(first_Hz, last_Hz, _CHIRP_POINTS)
    return 0.5 * float(np.mean((amplitude_rad_s * loop.torque(omega)) ** 2))
