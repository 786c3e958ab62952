"""Parameters of machine and inverter from the flux balance of an excited capture.

Over each tick the balance of the stator flux (`flux_model`) predicts the current at its end. The parameters
are those of the least prediction errors (L. Ljung, System Identification, 2nd ed., 7.2), by the method of
Gauss and Newton. Measured currents stand on both sides of the balance; in the prediction error the current at
the end of a tick is the predicted one, which the noise of the measured one does not reach, so that noise does
not pull the inductances towards zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.balances.flux_model import NEEDED, PHASES, Electrical, Ticks, flux_of
from benchtool.analysis.balances.space_vectors import Complex, Floats
from benchtool.analysis.balances.unknowns import ABOVE_NOISE, Solution, solve
from benchtool.analysis.balances.whitening import Whitening, likeliest
from benchtool.analysis.sensors.mean_reading import MeanReading
from benchtool.analysis.validity import clipping, require_finite_channels, require_unbroken
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError
from benchtool.profile import Motor

ESTIMATED: Final = (
    "R_s",
    "L_d",
    "L_q",
    "psi_r",
    "encoder_offset",
    "dead_time_voltage",
    "current_gain_a",
    "current_gain_b",
    "current_gain_c",
)
"""What a flux balance estimates, by the names of the dictionary where it has them."""

_FEWEST, _LEAST_SHARE = 500, 1.0 / 6.0  # periods; of all of them
_ITERATIONS, _SEARCHES = 15, 3
_FIRST_SHARE = 0.1  # of the voltage's errors in those of the flux, until the data tell
_CONVERGED = 0.02  # standard uncertainties
_STEPS_UNSURE, _DROPS_UNSURE = 2.0, 2.0  # of the sign of a current: in steps of the converter, in dead times
UNEXPLAINED = 0.04
"""Of the voltage, rms, that a balance leaves at most; more is refused."""

_STRETCH = 50  # periods, over which that is averaged
_LEAST_FLUX, _MOST_GAIN = 0.2, 0.5  # of the rotor flux believed; of an error of a gain
_PHASE_OF_ERROR = 0.5 * math.sqrt(1.5)  # noise of a phase over that of a predicted current: of two vectors
_BY_CHANCE = 2.0  # standard uncertainties
_SPAN_ANGLE_RAD, _SPAN_VOLTAGE, _SPAN_GAIN = 0.4, 0.04, 0.2
_LEAST_SPAN = 1e-3  # of the voltage over the current, for a resistance of zero
_STEP_OF_PARAMETER = 0.5  # most that one iteration changes an inductance or a flux by


@dataclass(frozen=True)
class FluxBalance:
    """What a flux balance came to.

    Attributes:
        ticks: the capture.
        belief: the parameters that were believed.
        solution: of the unknowns of `Electrical`, and of the gain of phase c.
        left_out: the periods of which the balance is not used, shape (n,).
        squares_A2: of the length of the error of the current predicted a tick ahead with the estimate, in the
            periods that are used, shape (periods,).
        belief_error_A: rms of that error with the belief.
        unexplained_V: rms of the voltage that no parameters explain, over stretches of 50 periods.
    """

    ticks: Ticks
    belief: Electrical
    solution: Solution
    left_out: NDArray[np.bool_]
    squares_A2: Floats
    belief_error_A: float
    unexplained_V: float

    @property
    def error_A(self) -> tuple[float, float]:
        """The rms error of the current predicted a tick ahead with the estimate, and with the belief."""
        return math.sqrt(float(np.mean(self.squares_A2))), self.belief_error_A

    @property
    def current_A(self) -> float:
        """The current vector's length, peak, rms over the capture."""
        return math.sqrt(float(np.mean(np.abs(self.ticks.measured_dq) ** 2)))

    @property
    def omega_e_rad_s(self) -> float:
        """The mean electrical speed, without its sign."""
        turned = np.angle(self.ticks.rotor[1:] * np.conj(self.ticks.rotor[:-1]))
        return abs(float(np.mean(turned))) / self.ticks.T_s

    @cached_property
    def link(self) -> MeanReading:
        """The mean dc link: the drive makes a voltage as much larger than it asks for as its reading of the
        link is too small, and every flux and impedance with it."""
        return MeanReading.of(Channel("u_dc", "V"), self.ticks.u_dc, 1.0 / self.ticks.T_s)

    @property
    def estimate(self) -> Electrical:
        """The estimated parameters; those that the capture does not tell are as they are believed."""
        found = Electrical(*(self.solution.value(name) for name in Electrical._fields))
        return found._replace(
            **{
                name: getattr(self.belief, name)
                for name in Electrical._fields
                if name in ESTIMATED and not self.solution.told(name)
            }
        )

    def torque(self, p: Electrical, pole_pairs: int) -> Floats:
        """Return the torque of the measured currents at the ticks, with some parameters, shape (n + 1,)."""
        i_dq = self.ticks.currents(p) * np.conj(self.ticks.direction(p))
        return np.asarray(1.5 * pole_pairs * np.imag(np.conj(flux_of(i_dq, p)) * i_dq))

    def torque_between_ticks(self, p: Electrical, pole_pairs: int) -> Floats:
        """Return by how much the mean torque around the ticks exceeds that at them, shape (n + 1,), if all of
        the dead-time voltage is by dead time, which takes it at the edges; voltages of devices act throughout
        a period."""
        ticks = self.ticks
        taken = -p.dead_time_voltage * ticks.T_s
        i_s = ticks.currents(p)
        in_mean_Vs = taken * ticks.edges.before_middle(i_s, 0.5 * (p.L_d + p.L_q))
        half = np.append(0.5 * in_mean_Vs, 0.0)
        turned = np.conj(ticks.direction(p))
        psi_dq, i_dq = (half + np.roll(half, 1)) * turned, i_s * turned
        by_flux = psi_dq.real / p.L_d + 1j * psi_dq.imag / p.L_q
        torque = np.imag(np.conj(psi_dq) * i_dq + np.conj(flux_of(i_dq, p)) * by_flux)
        return np.asarray(1.5 * pole_pairs * torque)


def flux_balance(block: Block, motor: Motor, *, delay_ticks: int = 1) -> FluxBalance:
    """Return the parameters under which the flux of a capture is balanced.

    Periods are left out in which a phase current is close to zero at an edge of its leg, and those without
    voltage, in which the power stage may be off.

    Args:
        block: a capture without gaps, every tick, with the channels `NEEDED`.
        motor: the parameters as they are believed, and the pole pairs.
        delay_ticks: from a row to the period over which its voltage acts.

    Raises:
        AnalysisError: a gap, a number that is not finite, a clipped current, ticks that were left out, too
            few periods with voltage, or no parameters that explain the currents.
    """
    require_unbroken(block)
    if block.stride != 1:
        raise AnalysisError(
            f"the capture holds one tick in {block.stride}, each is needed to balance the flux: record with "
            f"stride = 1"
        )
    require_finite_channels(block, NEEDED)
    for name in PHASES:
        if clipped := clipping(block.column(name), block.unit(name)):
            raise AnalysisError(f"'{name}': {clipped}: lower the current, or widen its range")
    if len(block.data) < _FEWEST:
        raise AnalysisError(
            f"{len(block.data)} rows to balance the flux in, at least {_FEWEST} are needed: record longer"
        )
    ticks = Ticks.of(block, motor.pole_pairs, delay_ticks)
    silent = int(np.count_nonzero(ticks.u_s == 0.0))
    if len(ticks.u_s) - silent < _FEWEST:
        raise AnalysisError(
            f"the drive asked for a voltage in {len(ticks.u_s) - silent} of {len(ticks.u_s)} periods, at "
            f"least {_FEWEST} are needed: record an enabled drive"
        )
    return _balance(ticks, Electrical.of(motor))


def _balance(ticks: Ticks, belief: Electrical) -> FluxBalance:
    spans = _spans(ticks, belief)
    solution, p, weighting = _iterate(ticks, belief, spans)
    left_out, errors = _errors(ticks, p)
    share = _unexplained(ticks, p, errors, left_out)
    if share > UNEXPLAINED or float(np.max(np.abs(p.gains - 1.0))) > _MOST_GAIN:
        raise AnalysisError(
            f"{100.0 * share:.2g} % of the voltage are not explained by any parameters of a machine of this "
            f"kind: check the order of the phases, the direction of the encoder, the pole pairs and "
            f"delay_ticks, and raise a current that hardly overcomes the dead time"
        )
    squares_A2 = _squares(ticks, errors, p, left_out)
    if solution.told("psi_r") and p.psi_r < _LEAST_FLUX * belief.psi_r:
        raise AnalysisError(
            f"no rotor flux turns with pole pairs times theta_m: the balance finds {p.psi_r:.3g} Wb, "
            f"{belief.psi_r:.3g} Wb is believed: check the pole pairs, the encoder's lines and direction"
        )
    # as much noise again moves the estimate by as much as the noise that is there
    noise_A = _PHASE_OF_ERROR * math.sqrt(float(np.mean(squares_A2)))
    noisy, _, _ = _iterate(ticks.with_noise(noise_A), p, spans, weighting)
    moved = np.abs(noisy.values - solution.values)
    bias = np.maximum(0.0, moved - _BY_CHANCE * np.sqrt(np.diag(noisy.covariance)))
    # without a dead time the signs count for nothing
    of_belief_A2 = _squares(ticks, ticks.errors(belief, np.zeros_like(ticks.u_s)), belief, left_out)
    belief_error_A = math.sqrt(float(np.mean(of_belief_A2)))
    found = replace(solution, bias=bias, hidden=_hidden(ticks, errors, p, left_out))
    unexplained_V = share * math.sqrt(float(np.mean(np.abs(ticks.u_s) ** 2)))
    return FluxBalance(
        ticks, belief, _with_phase_c(found), left_out, squares_A2, belief_error_A, unexplained_V
    )


def _iterate(
    ticks: Ticks, belief: Electrical, spans: Floats, share: float | None = None
) -> tuple[Solution, Electrical, float]:
    """Return the solution, its parameters, and the share of the voltage's errors by which it was weighted:
    the likeliest, or the one that is given."""
    p, believed, before = belief, np.array(belief), None
    given, share = share is not None, share if share is not None else _FIRST_SHARE
    for iteration in range(_ITERATIONS):
        signs, left_out = _signs(ticks, p)
        used = len(left_out) - int(np.count_nonzero(left_out))
        if used < max(_FEWEST, _LEAST_SHARE * len(left_out)):
            raise AnalysisError(
                f"in {len(left_out) - used} of {len(left_out)} periods a phase current is close to zero at "
                f"an edge of its leg, or there is no voltage; {_FEWEST} others and a sixth of all are "
                f"needed: turn the shaft, raise the current or record longer"
            )
        errors = ticks.errors(p, signs)
        search = 0 < iteration <= _SEARCHES and not given
        whitening = likeliest(errors, left_out) if search else Whitening.of(left_out, share)
        share = whitening.share
        rows, innovations_A = _prediction(ticks, p, ticks.derivatives(p, signs), errors, whitening)
        solution = solve(Electrical._fields, rows, innovations_A, np.array(p), believed, spans)
        p = _bounded(Electrical(*solution.values.tolist()), p)
        if before is not None and (given or iteration > _SEARCHES):
            moved = np.abs(solution.values - before.values)
            if np.all(moved <= _CONVERGED * np.sqrt(np.diag(solution.covariance))):
                break
        before = solution
    return solution, p, share


def _signs(ticks: Ticks, p: Electrical) -> tuple[Complex, NDArray[np.bool_]]:
    """Return the mean signs of the currents, and the periods that are left out."""
    L = 0.5 * (p.L_d + p.L_q)
    least_A = _STEPS_UNSURE * ticks.step_A + _DROPS_UNSURE * abs(p.dead_time_voltage) * ticks.T_s / L
    shortest_s = _DROPS_UNSURE * abs(p.dead_time_voltage) * ticks.T_s / float(np.mean(ticks.u_dc))
    return ticks.edges.signs(ticks.currents(p), L, least_A, shortest_s)


def _errors(ticks: Ticks, p: Electrical) -> tuple[NDArray[np.bool_], Complex]:
    signs, left_out = _signs(ticks, p)
    return left_out, ticks.errors(p, signs)


def _prediction(
    ticks: Ticks, p: Electrical, derivatives: Complex, errors: Complex, whitening: Whitening
) -> tuple[Floats, Floats]:
    """Return derivatives and errors of the predicted current in the rotor's frame, each over its scale,
    shapes (2, n, unknowns) and (2, n)."""
    filtered = whitening.filtered(np.column_stack([derivatives, errors]))
    filtered *= np.conj(ticks.direction(p)[1:])[:, np.newaxis]
    along, across = filtered.real / p.L_d, filtered.imag / p.L_q
    # the flux at the end of a tick is that of the predicted current, not of the measured one
    along[:, 1] += along[:, -1] / p.L_d
    across[:, 2] += across[:, -1] / p.L_q
    scaled = np.stack([along, across]) / whitening.scale[:, np.newaxis]
    return scaled[:, :, :-1], scaled[:, :, -1]


def _bounded(found: Electrical, before: Electrical) -> Electrical:
    """Return the parameters with inductances and flux that moved by no more than half, so that they stay
    above zero."""
    bounds = {
        name: min(
            max(getattr(found, name), (1.0 - _STEP_OF_PARAMETER) * getattr(before, name)),
            (1.0 + _STEP_OF_PARAMETER) * getattr(before, name),
        )
        for name in ("L_d", "L_q", "psi_r")
    }
    angle = min(max(found.encoder_offset - before.encoder_offset, -_STEP_OF_PARAMETER), _STEP_OF_PARAMETER)
    return found._replace(**bounds, encoder_offset=before.encoder_offset + angle)


def _unexplained(ticks: Ticks, p: Electrical, errors_Vs: Complex, left_out: NDArray[np.bool_]) -> float:
    """Return the share of the voltage, in the rotor's frame over stretches long enough for noise to be small,
    that the parameters do not explain."""
    turned = np.where(left_out, 0.0, np.conj(ticks.direction(p)[1:]))
    starts = np.arange(0, len(turned), _STRETCH)
    left, whole = (
        math.sqrt(float(np.mean(np.abs(np.add.reduceat(turned * each, starts)) ** 2)))
        for each in (errors_Vs, ticks.T_s * ticks.u_s)
    )
    return left / whole


def _squares(ticks: Ticks, errors_Vs: Complex, p: Electrical, left_out: NDArray[np.bool_]) -> Floats:
    """Return the squared error of the current at the end of each tick that is used, predicted from its
    measured beginning."""
    turned = (errors_Vs * np.conj(ticks.direction(p)[1:]))[~left_out]
    return np.asarray((turned.real / p.L_d) ** 2 + (turned.imag / p.L_q) ** 2)


def _hidden(ticks: Ticks, errors_Vs: Complex, p: Electrical, left_out: NDArray[np.bool_]) -> frozenset[str]:
    """Return the inductances along whose axis the current moves by hardly more than the errors of its
    prediction: steps of the encoder move that of a steady torque as well."""
    moves_A = ticks.measured_dq[1:][~left_out]
    error_Vs = (errors_Vs * np.conj(ticks.direction(p)[1:]))[~left_out]
    axes = (
        ("L_d", moves_A.real, error_Vs.real / p.L_d),
        ("L_q", moves_A.imag, error_Vs.imag / p.L_q),
    )
    return frozenset(name for name, i, error in axes if np.std(i) < ABOVE_NOISE * np.std(error))


def _spans(ticks: Ticks, belief: Electrical) -> Floats:
    """Return what each unknown is, or could be, in a machine of this rating."""
    u_dc = float(np.mean(ticks.u_dc))
    current = math.sqrt(float(np.mean(ticks.phases**2))) or 1.0
    voltage = max(_SPAN_VOLTAGE * u_dc, np.finfo(np.float64).tiny)
    return np.array(
        Electrical(
            R_s=max(belief.R_s, _LEAST_SPAN * voltage / current),
            L_d=belief.L_d,
            L_q=belief.L_q,
            psi_r=belief.psi_r,
            encoder_offset=_SPAN_ANGLE_RAD,
            dead_time_voltage=voltage,
            current_gain_a=_SPAN_GAIN,
            current_gain_b=_SPAN_GAIN,
            u_alpha_offset=voltage,
            u_beta_offset=voltage,
        )
    )


def _with_phase_c(found: Solution) -> Solution:
    """Return the solution with the gain of phase c, which is minus those of the others together."""
    count = len(found.names)
    turn = np.vstack([np.eye(count), np.zeros(count)])
    a, b = (found.names.index(f"current_gain_{phase}") for phase in "ab")
    turn[count, [a, b]] = -1.0
    return replace(
        found,
        names=(*found.names, "current_gain_c"),
        values=turn @ found.values,
        covariance=turn @ found.covariance @ turn.T,
        spans=np.append(found.spans, found.spans[a]),
        certain=turn @ found.certain @ turn.T,
        bias=np.append(found.bias, math.hypot(found.bias[a], found.bias[b])),
    )
