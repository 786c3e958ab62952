"""The balance of the stator flux over a control tick, in stator coordinates, and its derivatives.

    psi_s(k+1) - psi_s(k) = T_s (u_s - u_0 - R_s mean(i_s) - u_d mean(sign(i_abc)))

    psi_s = e^(j theta) ((L_d i_d + psi_r) + j L_q i_q),     theta = p theta_m + delta

u_s is the voltage asked for, delta the error of the encoder's zero, u_d what dead time and devices take from
the mean voltage of a phase, u_0 an offset. A phase's measured current is 1 + g times the true one, where the
g of the phases add up to zero: what they have in common scales R_s, L_d and L_q and is not told.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple, Self

import numpy as np

from benchtool.analysis.balances.angle import smooth_angle
from benchtool.analysis.balances.pwm_period import Edges
from benchtool.analysis.balances.space_vectors import AXES, Complex, Floats, space_vector
from benchtool.analysis.quantisation.resolution import counting_step
from benchtool.block import Block
from benchtool.profile import Motor

PHASES: Final = ("i_a", "i_b", "i_c")
NEEDED: Final = (*PHASES, "theta_m", "u_alpha", "u_beta", "u_dc")
"""Channels of a flux balance."""

_SEED = 18_940_101


class Electrical(NamedTuple):
    """The unknowns, in SI."""

    R_s: float
    L_d: float
    L_q: float
    psi_r: float
    encoder_offset: float
    dead_time_voltage: float
    current_gain_a: float
    current_gain_b: float
    u_alpha_offset: float
    u_beta_offset: float

    @classmethod
    def of(cls, motor: Motor) -> Self:
        """Return the parameters that a profile states; sensors and power stage are taken for faultless."""
        parameters = (motor.R_s_ohm, motor.L_d_H, motor.L_q_H, motor.psi_r_Wb)
        return cls(*parameters, *(0.0 for _ in cls._fields[len(parameters) :]))

    @property
    def current_gain_c(self) -> float:
        """The error of the gain of phase c."""
        return -self.current_gain_a - self.current_gain_b

    @property
    def gains(self) -> Floats:
        """The phases' gains, shape (3, 1)."""
        errors = np.array([self.current_gain_a, self.current_gain_b, self.current_gain_c])
        return 1.0 + errors[:, np.newaxis]


@dataclass(frozen=True)
class Ticks:
    """A capture as n periods between n + 1 ticks.

    Attributes:
        T_s: length of a period in s.
        phases: measured phase currents at the ticks, shape (3, n + 1).
        step_A: step of the converter of the currents; 0 where they show none.
        rotor: e^(j p theta_m) at the ticks, shape (n + 1,).
        u_s: mean voltage asked for in each period, shape (n,).
        u_dc: dc link when it was asked for, shape (n,).
        edges: of the legs.
    """

    T_s: float
    phases: Floats
    step_A: float
    rotor: Complex
    u_s: Complex
    u_dc: Floats
    edges: Edges

    @classmethod
    def of(cls, block: Block, pole_pairs: int, delay: int) -> Self:
        """Return the ticks of a capture of every tick, whose voltage acts `delay` ticks after its row."""
        T_s, last = block.tick_s * block.stride, len(block.data) - 1
        currents = np.stack([block.column(name) for name in PHASES])[:, delay:]
        u_s = (block.column("u_alpha") + 1j * block.column("u_beta"))[: last - delay]
        u_dc = np.ascontiguousarray(block.column("u_dc")[: last - delay])
        theta_m = smooth_angle(np.ascontiguousarray(block.column("theta_m")))[delay:]
        rotor = np.exp(1j * pole_pairs * theta_m)
        step_A = max(counting_step(phase) for phase in currents)
        return cls(T_s, currents, step_A, rotor, u_s, u_dc, Edges.of(u_s, u_dc, T_s))

    @property
    def measured_dq(self) -> Complex:
        """The measured current in the encoder's frame, shape (n + 1,)."""
        return np.asarray(space_vector(self.phases) * np.conj(self.rotor))

    def with_noise(self, rms_A: float) -> Self:
        """Return the ticks with noise added to the currents, the same at every call."""
        noise = rms_A * np.random.default_rng(_SEED).standard_normal(self.phases.shape)
        return replace(self, phases=self.phases + noise)

    def currents(self, p: Electrical) -> Complex:
        """Return the current without the errors of the gains, shape (n + 1,)."""
        return space_vector(self.phases / p.gains)

    def direction(self, p: Electrical) -> Complex:
        """Return e^(j theta) at the ticks, shape (n + 1,)."""
        return np.asarray(self.rotor * np.exp(1j * p.encoder_offset))

    def errors(self, p: Electrical, signs: Complex) -> Complex:
        """Return by how much the balance is not met, in Vs, shape (n,); `signs` as `Edges.signs` has them."""
        i_s, direction = self.currents(p), self.direction(p)
        flux = direction * flux_of(i_s * np.conj(direction), p)
        drop = p.R_s * self._mean(i_s, flux, direction, p) + p.dead_time_voltage * signs
        offset = p.u_alpha_offset + 1j * p.u_beta_offset
        return np.asarray(self.T_s * (self.u_s - offset - drop) - np.diff(flux))

    def derivatives(self, p: Electrical, signs: Complex) -> Complex:
        """Return those of the right-hand side, by each unknown, shape (n, unknowns): minus those of
        `errors`."""
        i_s, direction = self.currents(p), self.direction(p)
        i_dq = i_s * np.conj(direction)
        found = np.empty((len(self.u_s), len(p)), dtype=np.complex128)
        found[:, 0] = self.T_s * self._mean(i_s, direction * flux_of(i_dq, p), direction, p)
        found[:, 1] = np.diff(direction * i_dq.real)
        found[:, 2] = np.diff(1j * direction * i_dq.imag)
        found[:, 3] = np.diff(direction)
        turned = 1j * flux_of(i_dq, p) + (p.L_d * i_dq.imag - 1j * p.L_q * i_dq.real)
        found[:, 4] = np.diff(direction * turned)
        found[:, 5] = self.T_s * signs
        for column, phase in ((6, 0), (7, 1)):
            by_gain = -2.0 / 3.0 * (AXES[phase] * self.phases[phase] - AXES[2] * self.phases[2])
            own = by_gain * np.conj(direction)
            flux = direction * (p.L_d * own.real + 1j * p.L_q * own.imag)
            found[:, column] = np.diff(flux) + p.R_s * self.T_s * 0.5 * (by_gain[1:] + by_gain[:-1])
        found[:, 8], found[:, 9] = self.T_s, 1j * self.T_s
        return found

    def _mean(self, i_s: Complex, flux: Complex, direction: Complex, p: Electrical) -> Complex:
        """Return the mean currents between the ticks, shape (n,), of currents, fluxes and directions at them.

        Under a constant voltage the flux moves along a parabola, which the drop of resistance bends, and the
        rotor turns evenly: by the current of its middle, and Simpson's rule.
        """
        forth = direction[1:] + direction[:-1]
        middle = forth / np.abs(forth)
        halfway = 0.5 * (flux[1:] + flux[:-1]) + 0.125 * p.R_s * self.T_s * np.diff(i_s)
        of_middle = current_of(halfway * np.conj(middle), p) * middle
        return np.asarray((i_s[:-1] + 4.0 * of_middle + i_s[1:]) / 6.0)


def flux_of(i_dq: Complex, p: Electrical) -> Complex:
    """Return the flux of currents in the rotor's frame, d real and q imaginary."""
    return np.asarray(p.L_d * i_dq.real + p.psi_r + 1j * p.L_q * i_dq.imag)


def current_of(psi_dq: Complex, p: Electrical) -> Complex:
    """Return the current of a flux in the rotor's frame."""
    return np.asarray((psi_dq.real - p.psi_r) / p.L_d + 1j * psi_dq.imag / p.L_q)
