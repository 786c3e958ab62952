"""Inertia and friction from the balance of torque over an excited capture.

    J d omega_m/dt = T - B omega_m - T_c sign(omega_m) - T_0

T is the torque of the currents with the parameters of the flux balance, T_0 a constant load. The equation is
weighted with a smooth function phi that is zero at both ends of a window, and integrated by parts, so that
the encoder's angle is never differentiated (modulating functions: M. Shinbrot, Trans. ASME 79 (1957) 579):

    J int phi'' theta_m = int phi T + B int phi' theta_m - T_c int phi sign(omega_m) - T_0 int phi

Windows in which the shaft stands or turns back are left out: what dry friction does there is not this law.

Cogging is as large as the torque that swings a small rotor, and within a window it does not average out: for
each order that is known the sine and the cosine of so many times the angle are unknowns beside these.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Final

import numpy as np
from pydantic import Field

from benchtool.analysis.balances.angle import smooth_angle
from benchtool.analysis.balances.flux_balance import FluxBalance
from benchtool.analysis.balances.flux_measurements import FluxBalanceSettings, balance_of
from benchtool.analysis.balances.flux_model import NEEDED
from benchtool.analysis.balances.modulation import HOP, WINDOW, Modulation
from benchtool.analysis.balances.readings import of_readings
from benchtool.analysis.balances.space_vectors import Floats
from benchtool.analysis.balances.unknowns import ABOVE_NOISE, Solution, solve
from benchtool.analysis.declaration import Analysis, Findings, Measured, Quantity
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.quantisation.resolution import counting_step
from benchtool.analysis.uncertainty import Contribution
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.profile import Motor

ESTIMATED: Final = ("J", "friction", "coulomb")
"""What a balance of torque estimates, by the names of the dictionary where it has them."""

UNITS: Final = {"J": "kgm2", "friction": "Nms/rad", "coulomb": "Nm"}

_NAMES: Final = (*ESTIMATED, "load")
_FEWEST = 20  # windows
_COUNTS_OF_MOTION = 4.0  # that the shaft must go in half a window, to turn
_SPAN_OF_FRICTION = 0.1  # of the rated torque
_ITERATIONS, _CONVERGED = 15, 0.02  # standard uncertainties


@dataclass(frozen=True)
class MotionBalance:
    """What a balance of torque came to.

    Attributes:
        flux: the flux balance whose parameters give the torque.
        solution: of J, friction, coulomb and load.
        between_ticks: by how much each of these may be off, either way, as it is not told how much of the
            dead-time voltage moves the current between the ticks, shape (unknowns,).
        omega_m_rad_s: speed at the ticks by the encoder, shape (n,).
        windows: how many were used.
        error_Nm: rms of what the balance of a window leaves, as a mean torque.
    """

    flux: FluxBalance
    solution: Solution
    between_ticks: Floats
    omega_m_rad_s: Floats
    windows: int
    error_Nm: float


class MotionBalanceSettings(FluxBalanceSettings):
    """When the voltage of a row acts, and what torque the angle alone makes."""

    cogging_orders: Annotated[tuple[Annotated[int, Field(ge=1, strict=True)], ...], Field(strict=False)] = ()
    """How many times in a revolution each part of the cogging torque comes; without, none is taken to be
    there."""


def motion_balance(
    block: Block, motor: Motor, flux: FluxBalance, cogging_orders: Sequence[int] = ()
) -> MotionBalance:
    """Return inertia and friction under which torque and motion of a capture are balanced.

    Args:
        block: the capture of `flux`.
        motor: the inertia as it is believed, and the rating.
        flux: its flux balance.
        cogging_orders: see `MotionBalanceSettings`.

    Raises:
        AnalysisError: the shaft does not turn long enough.
    """
    torque = flux.torque(flux.estimate, motor.pole_pairs)
    rows = block.data.shape[0] - len(torque)
    measured = np.unwrap(np.ascontiguousarray(block.column("theta_m")))[rows:]
    speed = np.gradient(smooth_angle(measured))
    count_rad = counting_step(block.column("theta_m"))
    turning = _turning(speed, count_rad)
    T_s = flux.ticks.T_s
    windows = Modulation.of(turning, T_s)
    count = len(windows.starts)
    if count < _FEWEST:
        raise AnalysisError(
            f"the shaft turns one way throughout in {count} windows of {WINDOW} ticks, at least {_FEWEST} "
            f"are needed: turn it faster or longer"
        )
    angle = windows.samples(measured)
    angle = angle - angle[:, WINDOW // 2, np.newaxis]
    impulse_s = float(np.sum(windows.weight))
    names = list(_NAMES)
    cogging = []
    for order in cogging_orders:
        names += [f"cogging_{order}_cos", f"cogging_{order}_sin"]
        cogging += [windows.samples(wave(order * measured)) @ windows.weight for wave in (np.cos, np.sin)]
    columns = np.stack(
        [
            angle @ windows.second,
            -angle @ windows.first,
            turning[windows.starts] * impulse_s,
            np.full(count, impulse_s),
            *cogging,
        ],
        axis=1,
    )
    # by dead time alone the torque between the ticks is off by all of it, by voltages of devices by none
    half = 0.5 * flux.torque_between_ticks(flux.estimate, motor.pole_pairs)
    impulse, moved = (windows.samples(each) @ windows.weight for each in (torque + half, half))
    believed = np.array([motor.J_kgm2, *(len(names) - 1) * (0.0,)])
    friction_Nm = _SPAN_OF_FRICTION * motor.T_N_Nm
    of_shaft = (motor.J_kgm2, friction_Nm / motor.omega_m_N_rad_s, friction_Nm, friction_Nm)
    spans = np.array([*of_shaft, *len(cogging) * (friction_Nm,)])
    # half the error of a current predicted from a tick to the next is the noise of one axis at one of them
    noise_Nm = 1.5 * motor.pole_pairs * flux.estimate.psi_r * 0.5 * flux.error_A[0]
    white, sides = windows.whitened(columns, np.column_stack([impulse, impulse + moved]), noise_Nm)
    solution, beside = (_solved(names, white, side, believed, spans) for side in sides.T)
    # what counts of the encoder alone make of an even speed
    noise_rad_s = count_rad / math.sqrt(12.0) * math.sqrt(float(np.sum(windows.second**2)))
    left = (impulse - columns @ solution.values) / impulse_s
    error_Nm = math.sqrt(float(np.mean(left**2)))
    changing = float(np.std(columns[:, 0]))
    of_inertia_Nm = abs(solution.value("J")) * changing / impulse_s
    # where torque that is not balanced is more than the inertia takes, it is that which moves the shaft
    if changing < ABOVE_NOISE * noise_rad_s or of_inertia_Nm < error_Nm:
        solution = replace(solution, hidden=frozenset({"J"}))
    return MotionBalance(
        flux,
        solution,
        np.abs(beside.values - solution.values),
        speed / T_s,
        count,
        error_Nm,
    )


def _solved(
    names: Sequence[str], columns: Floats, impulse: Floats, believed: Floats, spans: Floats
) -> Solution:
    """Return the unknowns of linear equations, with the covariance by the errors that are left there.

    Errors at any other place count what the place is off by as noise of the data, beside which the belief
    counts for too much: the step from the belief itself does not arrive.
    """
    at = believed
    for _ in range(_ITERATIONS):
        solution = solve(names, columns, impulse - columns @ at, at, believed, spans, block_rows=1)
        moved = np.abs(solution.values - at)
        at = solution.values
        if np.all(moved <= _CONVERGED * np.sqrt(np.diag(solution.covariance))):
            break
    return solution


def _turning(speed: Floats, count: float) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return at each tick the direction in which the shaft turns, 0 where it hardly does, by its speed in rad
    per tick."""
    least = 2.0 * _COUNTS_OF_MOTION * count / WINDOW
    return np.where(np.abs(speed) > least, np.sign(speed), 0.0).astype(np.int64)


def _of_window(window: Window, settings: MotionBalanceSettings) -> MotionBalance:
    flux = balance_of(window, settings.delay_ticks)
    assert window.motor is not None
    return motion_balance(window.block, window.motor, flux, settings.cogging_orders)


def _measure(window: Window, settings: MotionBalanceSettings) -> Findings:
    found = _of_window(window, settings)
    rate_Hz = window.block.sample_rate_Hz
    basis = Basis(
        samples=found.windows * HOP,
        sample_rate_Hz=rate_Hz,
        duration_s=len(window.block.data) / rate_Hz,
        bandwidth_Hz=2.0 * rate_Hz / WINDOW,
        window=f"{found.windows} windows of {WINDOW} ticks, {HOP} apart, (1 - s^2)^3",
        gaps=0,
    )
    return Findings(tuple(_measurements(found, basis)), (), found)


def _measurements(found: MotionBalance, basis: Basis) -> Iterator[Measurement]:
    flux = found.flux.solution
    told = flux.told("psi_r")
    relative = flux.standard("psi_r") / flux.value("psi_r") if told else math.nan
    link = found.flux.link if told else None  # a rotor flux that is believed does not come from voltages
    for name in ESTIMATED:
        definition, unit, full = _DEFINITIONS[name], UNITS[name], f"motion_balance_{name}"
        reason = found.solution.why_not(name)
        if reason:
            yield Measurement.undefined(full, unit, definition, reason, basis)
            continue
        value = found.solution.value(name)
        lines = [Contribution("rotor flux", "B", abs(value) * relative)] if told else []
        if link is not None:
            lines += link.line(value / link.mean)
        between = float(found.between_ticks[found.solution.names.index(name)])
        lines.append(Contribution("current between the ticks", "B", between))
        reference = "torque by the parameters of the flux balance" if told else "torque by the psi_r believed"
        uncertain = found.solution.uncertainty(name, *lines)
        of_found, sensed = replace(basis, reference=reference), of_readings(value, link, 1)
        each = Measurement(full, value, unit, definition, of_found, uncertain, sensitivities=sensed)
        yield each.without_resolution_of(*(link.unresolved if link else ()))


_DEFINITIONS: Final = {
    "J": "moment of inertia that balances torque and acceleration",
    "friction": "viscous friction: torque per mechanical speed",
    "coulomb": "Coulomb friction of the turning shaft: torque that changes its sign with the speed",
}

MOTION_BALANCE: Final = Analysis(
    name="motion_balance",
    title="balance of torque",
    measure=_measure,
    quantities=tuple(
        Quantity(
            (f"motion_balance_{name}",),
            UNITS[name],
            _DEFINITIONS[name],
            "noise of angle and torque that the balance leaves; of `psi_r`; resolution of `u_dc`; current "
            "between the ticks by dead time",
        )
        for name in ESTIMATED
    ),
    settings=MotionBalanceSettings,
    measured=Measured.ON_REQUEST,
    channels=NEEDED,
    every_tick=True,
)
