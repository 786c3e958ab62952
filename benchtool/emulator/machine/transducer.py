"""A torque transducer on the bench, not part of the drive, oversampled.

It tells the machine's true air-gap torque, or, where the bench has one at the flange, what that reads.
Between the ends of an integration step the electrical states are cubic Hermite polynomials through their
values and rates, which is of fourth order like the step itself, so that sampling costs no further steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block, Channel
from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.drive_train import DriveTrain, Far, Flange, slip_of
from benchtool.emulator.machine.energies import FIELDS
from benchtool.emulator.machine.flange import flange_torque, reading
from benchtool.emulator.machine.plant import airgap_torque, derivative, scaled_voltage
from benchtool.emulator.machine.state import State, electrical, state_at
from benchtool.emulator.memory import Record, record_type
from benchtool.emulator.rotate import rotate
from benchtool.errors import ValueRefused

MAX_TICKS = 2_000_000

# `next_sample` counts within the control period under way. The energies are those of `energies`, in J.
TRANSDUCER = record_type(
    [
        ("recording", "u4"),
        ("filled", "u4"),
        ("next_sample", "u4"),
        ("samples_per_tick", "u4"),
        ("spacing", "f8"),
        *FIELDS,
        ("rows", "i8"),  # of the energies that are recorded
        ("flange", "f8"),  # what a transducer at the flange reads
        ("flange_before", "f8"),  # the torque there that it read last
        ("until_next", "f8"),  # s from then to what it reads next; 0 if it has read nothing
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
    """Take the samples due within a step that started `time` seconds into the control period and took `h`."""
    if transducer.recording == 0 or transducer.next_sample * transducer.spacing >= time + h:
        return
    _take(time, h, before, after, u_alpha, u_beta, machine, T_load, transducer, torque)


@called
def _take(
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
    d0, q0 = electrical(machine.saturation, before)
    d1, q1 = electrical(machine.saturation, after)
    p0 = rates(before, u_alpha, u_beta, machine, T_load)
    p1 = rates(after, u_alpha, u_beta, machine, T_load)
    while transducer.next_sample < transducer.samples_per_tick:
        due = transducer.next_sample * transducer.spacing
        if due >= time + h or transducer.filled >= torque.shape[0]:
            return
        s = (due - time) / h
        y_d = _hermite(s, h, d0, d1, p0[0], p1[0])
        y_q = _hermite(s, h, q0, q1, p0[1], p1[1])
        theta_e = _hermite(s, h, before.theta_e, after.theta_e, before.omega_e, after.omega_e)
        row = torque[transducer.filled]
        row[0] = airgap_torque(y_d, y_q, theta_e, machine)
        _take_flange(machine.train, row, y_d, y_q, theta_e, s, h, before, after, machine, T_load, transducer)
        transducer.filled += 1
        transducer.next_sample += 1


@njit
def _take_flange(
    train: DriveTrain | None,
    row: NDArray[np.float64],
    y_d: float,
    y_q: float,
    theta_e: float,
    s: float,
    h: float,
    before: State,
    after: State,
    machine: Machine,
    T_load: float,
    transducer: Any,
) -> None:
    """Take a sample at the flange as well, if there is a transducer."""
    if train is None:
        return
    _take_reading(
        train.flange, train, row, y_d, y_q, theta_e, s, h, before, after, machine, T_load, transducer
    )


@njit
def _take_reading(
    flange: Flange | None,
    train: DriveTrain,
    row: NDArray[np.float64],
    y_d: float,
    y_q: float,
    theta_e: float,
    s: float,
    h: float,
    before: State,
    after: State,
    machine: Machine,
    T_load: float,
    transducer: Any,
) -> None:
    if flange is None:
        return
    slip0, slip1 = slip_of(train, before.far, before.omega_e), slip_of(train, after.far, after.omega_e)
    far = Far(
        _line(s, before.far.omega, after.far.omega),
        _hermite(s, h, before.far.twist, after.far.twist, slip0, slip1),
        _line(s, before.far.torque, after.far.torque),
    )
    omega_e = _line(s, before.omega_e, after.omega_e)
    cos_theta, sin_theta = rotate(before.cos_theta, before.sin_theta, theta_e - before.theta_e)
    x = state_at(machine.saturation, y_d, y_q, omega_e, theta_e, 0.0, cos_theta, sin_theta, far)
    row[1] = reading(flange, flange_torque(train, x, machine, T_load), transducer)
    transducer.until_next = transducer.spacing


@njit
def coasts(train: DriveTrain | None, transducer: Any) -> bool:
    """Return whether a period without current is one long step to the transducer: nothing is recorded of
    it but that there is no torque."""
    if train is None:
        return True
    return bool(transducer.recording == 0)


@njit
def _line(s: float, y0: float, y1: float) -> float:
    return y0 + s * (y1 - y0)


@njit
def rates(
    x: State, u_alpha: float, u_beta: float, machine: Machine, T_load: float
) -> tuple[float, float, float, float, float]:
    """Return `derivative` of a state under a stator voltage."""
    v_d, v_q = scaled_voltage(x, u_alpha, u_beta, machine)
    y_d, y_q = electrical(machine.saturation, x)
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
        flange: what a transducer at the flange makes of the torque there; without it the air-gap torque is
            recorded as it is.
    """

    def __init__(
        self,
        tick: Callable[[], int],
        control_period_s: float,
        samples_per_tick: int = 20,
        flange: FlangeError | None = None,
    ) -> None:
        self._tick = tick
        self.samples_per_tick = samples_per_tick
        self.tick_s = control_period_s / samples_per_tick
        self.record: Record = np.zeros(1, TRANSDUCER)
        self.record[0].samples_per_tick = samples_per_tick
        self.record[0].spacing = self.tick_s
        self._flange = flange
        self.torque = self._empty(0)
        self._first_tick = 0

    def _empty(self, samples: int) -> NDArray[np.float64]:
        """Return a buffer: a column of the air-gap torque, one of that at the flange if it is measured."""
        return np.zeros((samples, 1 if self._flange is None else 2))

    def start(self, ticks: int) -> None:
        """Discard earlier samples and record the next `ticks` drive ticks.

        Raises:
            ValueRefused: `ticks` is not between 1 and 2 000 000.
        """
        if not 1 <= ticks <= MAX_TICKS:
            raise ValueRefused(f"transducer: {ticks} ticks asked, 1 to {MAX_TICKS} can be: record in parts")
        self.torque = self._empty(ticks * self.samples_per_tick)
        self._first_tick = self._tick()
        self.record[0].filled = 0
        self.record[0].recording = 1

    def stop(self) -> None:
        """Stop recording; recorded samples stay readable."""
        self.record[0].recording = 0

    def block(self) -> Block:
        """Return what was recorded since `start`: channel `torque_transducer` in Nm.

        Its tick is the sample, `samples_per_tick` of which make a drive tick, so drive tick k is its tick
        k * samples_per_tick. With a transducer at the flange that is its reading, and the true air-gap torque
        is channel `torque_airgap`.
        """
        first = self._first_tick * self.samples_per_tick
        recorded = self.torque[: int(self.record[0].filled)]
        channels = [Channel("torque_transducer", "Nm")]
        if self._flange is not None:
            read = self._flange.read(recorded[:, 1], first)
            recorded = np.column_stack((read, recorded[:, 0]))
            channels.append(Channel("torque_airgap", "Nm"))
        return Block(
            channels=tuple(channels),
            first_tick=first,
            stride=1,
            tick_s=self.tick_s,
            data=recorded.copy(),
        )


@dataclass(frozen=True)
class FlangeError:
    """What a transducer at the flange adds to the torque, after its lag: gain, offset, and noise of each
    sample."""

    gain: float
    offset_Nm: float
    noise_Nm_rms: float
    seed: int

    def read(self, torque_Nm: NDArray[np.float64], first: int) -> NDArray[np.float64]:
        """Return readings of this torque, whose first sample has this number."""
        return (
            self.gain * torque_Nm + self.offset_Nm + self.noise_Nm_rms * self._normal(first, len(torque_Nm))
        )

    def _normal(self, first: int, count: int) -> NDArray[np.float64]:
        """Return standard normal numbers (Box and Muller), each drawn by the number of its sample, so that
        they are the same however recordings divide the time."""
        skipped = first % 2  # a step of the counter makes four numbers, for two samples
        draws = np.random.Philox(key=self.seed, counter=first // 2).random_raw(4 * (count // 2 + 2))
        uniform = (draws >> np.uint64(11)).reshape(-1, 2) * 2.0**-53
        normal = np.sqrt(-2.0 * np.log1p(-uniform[:, 0])) * np.cos(2.0 * np.pi * uniform[:, 1])
        return np.asarray(normal[skipped : skipped + count], np.float64)
