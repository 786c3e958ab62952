"""A torque transducer on the bench, not part of the drive: the machine's true air-gap torque, oversampled.

Between the ends of an integration step the electrical states are cubic Hermite polynomials through their
values and rates, which is of fourth order like the step itself, so that sampling costs no further steps.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block, Channel
from benchtool.emulator.jit import njit
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.plant import airgap_torque, derivative, scaled_voltage
from benchtool.emulator.machine.state import State, electrical
from benchtool.emulator.memory import Record, record_type
from benchtool.errors import ValueRefused

MAX_TICKS = 2_000_000

# `next_sample` counts within the PWM period under way. The energies are those of `accounts`, in J.
TRANSDUCER = record_type(
    [
        ("recording", "u4"),
        ("filled", "u4"),
        ("next_sample", "u4"),
        ("samples_per_tick", "u4"),
        ("spacing", "f8"),
        ("E_dc", "f8"),
        ("E_copper", "f8"),
        ("E_iron", "f8"),
        ("E_inverter", "f8"),
        ("E_friction", "f8"),
        ("E_shaft", "f8"),
        ("E_magnetic", "f8"),
        ("E_kinetic", "f8"),
    ]
)


@njit
def sample(
    time: float,
    h: float,
    before: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> None:
    """Take the samples due within a step that started `time` seconds into the PWM period and took `h`."""
    if transducer.recording == 0 or transducer.next_sample * transducer.spacing >= time + h:
        return
    d0, q0 = electrical(before.flux, before)
    d1, q1 = electrical(after.flux, after)
    p0 = rates(before, u_alpha, u_beta, machine, T_load)
    p1 = rates(after, u_alpha, u_beta, machine, T_load)
    while transducer.next_sample < transducer.samples_per_tick:
        due = transducer.next_sample * transducer.spacing
        if due >= time + h or transducer.filled >= torque.size:
            return
        s = (due - time) / h
        y_d = _hermite(s, h, d0, d1, p0[0], p1[0])
        y_q = _hermite(s, h, q0, q1, p0[1], p1[1])
        theta_e = _hermite(s, h, before.theta_e, after.theta_e, before.omega_e, after.omega_e)
        torque[transducer.filled] = airgap_torque(y_d, y_q, theta_e, machine)
        transducer.filled += 1
        transducer.next_sample += 1


@njit
def rates(
    x: State, u_alpha: float, u_beta: float, machine: Machine, T_load: float
) -> tuple[float, float, float, float, float]:
    """Return `derivative` of a state under a stator voltage."""
    v_d, v_q = scaled_voltage(x, u_alpha, u_beta, machine)
    y_d, y_q = electrical(x.flux, x)
    return derivative(y_d, y_q, x.omega_e, x.theta_e, v_d, v_q, machine, T_load)


@njit
def _hermite(s: float, h: float, y0: float, y1: float, rate0: float, rate1: float) -> float:
    """Return the cubic through (0, y0) and (h, y1) with the given slopes, at s * h."""
    r = 1.0 - s
    return (1.0 + 2.0 * s) * r * r * y0 + s * s * (3.0 - 2.0 * s) * y1 + s * r * h * (r * rate0 - s * rate1)


class Transducer:
    """The transducer's recorder; the kernel fills its buffer while the core runs.

    Args:
        tick: tells the drive's tick, counted on past 2**32.
        control_period_s: length of a drive tick.
        samples_per_tick: samples in it, the first at the tick itself.
    """

    def __init__(self, tick: Callable[[], int], control_period_s: float, samples_per_tick: int = 20) -> None:
        self._tick = tick
        self.samples_per_tick = samples_per_tick
        self.tick_s = control_period_s / samples_per_tick
        self.record: Record = np.zeros(1, TRANSDUCER)
        self.record[0].samples_per_tick = samples_per_tick
        self.record[0].spacing = self.tick_s
        self.torque = np.zeros(0)
        self._first_tick = 0

    def start(self, ticks: int) -> None:
        """Discard earlier samples and record the next `ticks` drive ticks.

        Raises:
            ValueRefused: `ticks` is not between 1 and 2 000 000.
        """
        if not 1 <= ticks <= MAX_TICKS:
            raise ValueRefused(f"transducer: {ticks} ticks asked, 1 to {MAX_TICKS} can be: record in parts")
        self.torque = np.zeros(ticks * self.samples_per_tick)
        self._first_tick = self._tick()
        self.record[0].filled = 0
        self.record[0].recording = 1

    def stop(self) -> None:
        """Stop recording; recorded samples stay readable."""
        self.record[0].recording = 0

    def block(self) -> Block:
        """Return what was recorded since `start`: channel `torque_transducer` in Nm.

        Its tick is the sample, `samples_per_tick` of which make a drive tick, so drive tick k is its tick
        k * samples_per_tick.
        """
        filled = int(self.record[0].filled)
        return Block(
            channels=(Channel("torque_transducer", "Nm"),),
            first_tick=self._first_tick * self.samples_per_tick,
            stride=1,
            tick_s=self.tick_s,
            data=self.torque[:filled].reshape(-1, 1).copy(),
        )
