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
from benchtool.analysis.balances.readings import of_readings
from benchtool.analysis.balances.space_vectors import Floats
from benchtool.analysis.balances.unknowns import Solution, solve
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
_WINDOW = 200  # ticks
_FEWEST = 20  # windows
_COUNTS_OF_MOTION = 4.0  # that the shaft must go in half a window, to turn
_SPAN_OF_FRICTION = 0.1  # of the rated torque
_BLOCK_ROWS, _MOST_BLOCKS = 4, 40
_MOVED = 1.0 / 6.0  # of the change of current that dead time makes in a period: of its mean, at most


@dataclass(frozen=True)
class MotionBalance:
    """What a balance of torque came to.

    Attributes:
        flux: the flux balance whose parameters give the torque.
        solution: of J, friction, coulomb and load.
        pole_pairs: of the motor.
        omega_m_rad_s: speed at the ticks by the encoder, shape (n,).
        windows: how many were used.
        error_Nm: rms of what the balance of a window leaves, as a mean torque.
    """

    flux: FluxBalance
    solution: Solution
    pole_pairs: int
    omega_m_rad_s: Floats
    windows: int
    error_Nm: float

    @property
    def between_ticks_Nm(self) -> float:
        """By how much the torque of the mean current within a tick may differ from that of its ends.

        By what dead time takes beyond what the drive makes up for.
        """
        p = self.flux.estimate
        moved_A = between_ticks_A(p.dead_time_voltage, self.flux.ticks.T_s, p.L_d, p.L_q)
        return 1.5 * self.pole_pairs * p.psi_r * moved_A


def between_ticks_A(dead_time_V: float, T_s: float, L_d_H: float, L_q_H: float) -> float:
    """Return by how much the mean current within a tick may differ from that of its ends.

    Dead time acts near one end of a period, and moves that mean by up to a sixth of the change of current
    that it makes.
    """
    return _MOVED * abs(dead_time_V) * T_s / (0.5 * (L_d_H + L_q_H))


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
    turning = _turning(speed, counting_step(block.column("theta_m")))
    inside = np.lib.stride_tricks.sliding_window_view(turning, _WINDOW)[:: _WINDOW // 2]
    used = np.abs(np.sum(inside, axis=1)) == _WINDOW
    if np.count_nonzero(used) < _FEWEST:
        raise AnalysisError(
            f"the shaft turns one way throughout in {np.count_nonzero(used)} windows of {_WINDOW} ticks, at "
            f"least {_FEWEST} are needed: turn it faster or longer"
        )
    T_s = flux.ticks.T_s
    weight, first, second = _modulating(T_s)
    angle = _windows(measured, used)
    angle = angle - angle[:, _WINDOW // 2, np.newaxis]
    direction = inside[used, 0].astype(np.float64)
    names = list(_NAMES)
    cogging = []
    for order in cogging_orders:
        names += [f"cogging_{order}_cos", f"cogging_{order}_sin"]
        cogging += [T_s * _windows(wave(order * measured), used) @ weight for wave in (np.cos, np.sin)]
    columns = np.stack(
        [
            T_s * angle @ second,
            -T_s * angle @ first,
            direction * T_s * np.sum(weight),
            np.full(len(angle), T_s * np.sum(weight)),
            *cogging,
        ],
        axis=1,
    )
    impulse = T_s * _windows(torque, used) @ weight
    believed = np.array([motor.J_kgm2, *(len(names) - 1) * (0.0,)])
    friction_Nm = _SPAN_OF_FRICTION * motor.T_N_Nm
    of_shaft = (motor.J_kgm2, friction_Nm / motor.omega_m_N_rad_s, friction_Nm, friction_Nm)
    spans = np.array([*of_shaft, *len(cogging) * (friction_Nm,)])
    blocks = {"block_rows": _BLOCK_ROWS, "most_blocks": _MOST_BLOCKS}
    found = solve(names, columns, impulse - columns @ believed, believed, believed, spans, **blocks)
    at = found.values  # the equations are linear: with the errors that are left there, so is the covariance
    solution = solve(names, columns, impulse - columns @ at, at, believed, spans, **blocks)
    left = (impulse - columns @ solution.values) / (T_s * np.sum(weight))
    return MotionBalance(
        flux, solution, motor.pole_pairs, speed / T_s, len(angle), math.sqrt(float(np.mean(left**2)))
    )


def _turning(speed: Floats, count: float) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return at each tick the direction in which the shaft turns, 0 where it hardly does, by its speed in rad
    per tick."""
    least = 2.0 * _COUNTS_OF_MOTION * count / _WINDOW
    return np.where(np.abs(speed) > least, np.sign(speed), 0.0).astype(np.int64)


def _modulating(T_s: float) -> tuple[Floats, Floats, Floats]:
    """Return phi = (1 - s^2)^3 over a window, s from -1 to 1, and its first two derivatives by time."""
    s = (2.0 * np.arange(_WINDOW) + 1.0) / _WINDOW - 1.0
    rate = 2.0 / (_WINDOW * T_s)
    inner = 1.0 - s * s
    return inner**3, -6.0 * rate * s * inner**2, 6.0 * rate**2 * (4.0 * s * s - inner) * inner


def _windows(samples: Floats, used: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Floats:
    """Return the samples in the windows that are used, shape (windows, ticks)."""
    views = np.lib.stride_tricks.sliding_window_view(samples, _WINDOW)[:: _WINDOW // 2]
    return np.asarray(views[used])


def _of_window(window: Window, settings: MotionBalanceSettings) -> MotionBalance:
    flux = balance_of(window, settings.delay_ticks)
    assert window.motor is not None
    return motion_balance(window.block, window.motor, flux, settings.cogging_orders)


def _measure(window: Window, settings: MotionBalanceSettings) -> Findings:
    found = _of_window(window, settings)
    rate_Hz = window.block.sample_rate_Hz
    basis = Basis(
        samples=found.windows * _WINDOW / 2,
        sample_rate_Hz=rate_Hz,
        duration_s=len(window.block.data) / rate_Hz,
        bandwidth_Hz=2.0 * rate_Hz / _WINDOW,
        window=f"{found.windows} windows of {_WINDOW} ticks, half overlapping, (1 - s^2)^3",
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
        if name in ("friction", "coulomb"):
            between = found.between_ticks_Nm / math.sqrt(3.0)
            speed = math.sqrt(float(np.mean(found.omega_m_rad_s**2))) if name == "friction" else 1.0
            lines.append(Contribution("current between the ticks", "B", between / speed))
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
            "scatter of the errors of the balance over blocks of windows; of `psi_r`; resolution of `u_dc`"
            + ("" if name == "J" else "; current between the ticks by dead time"),
        )
        for name in ESTIMATED
    ),
    settings=MotionBalanceSettings,
    measured=Measured.ON_REQUEST,
    channels=NEEDED,
    every_tick=True,
)
