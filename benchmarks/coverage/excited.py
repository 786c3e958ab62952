"""A machine that is excited for its parameters to be found, as an inverter drives it and sensors read it.

Between the edges of its inverter the currents in the rotor's frame follow linear equations, whose solution is
a power series of time that is summed up to rounding.

    L_d d i_d/dt = u_d - R_s i_d + omega_e L_q i_q
    L_q d i_q/dt = u_q - R_s i_q - omega_e (L_d i_d + psi_r)
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from benchmarks.coverage.channels import MOTOR
from benchmarks.coverage.noise import Kind as OfNoise, coloured, noise_of
from benchtool.block import Block

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

T_S, U_DC = 1e-4, 150.0
_TERMS = 7  # of the series: the eighth is 1e-9 of the first at the longest step and the highest speed
_GAIN_V_A = 20.0  # of the current control
_MOST_V = 0.95 * U_DC / math.sqrt(3.0)  # whose pulses are longer than any dead time here
_HELD_TICKS = 20  # for which a d-current is asked for
_FROM_SPEED_TO_SPEED = 0.1  # of the record, which a load takes
_UNITS = {
    **dict.fromkeys(("i_a", "i_b", "i_c"), "A"),
    **dict.fromkeys(("u_alpha", "u_beta", "u_dc"), "V"),
    "theta_m": "rad",
}


@dataclass(frozen=True)
class Machine:
    """A machine and its inverter, in SI; `dead_time_V` is what that takes of the mean voltage of a phase."""

    R_s: float
    L_d: float
    L_q: float
    psi_r: float
    J: float
    friction: float
    coulomb: float
    encoder_offset: float
    dead_time_V: float
    gains: tuple[float, float, float]
    cogging: tuple[int, float] = (0, 0.0)
    load_Nm: float = 0.0
    warming: float = 0.0  # of the resistance over the record, relative

    @classmethod
    def believed(cls) -> Self:
        """Return the machine that the profile has, without flaws of its sensors and its inverter."""
        of_motor = MOTOR.R_s_ohm, MOTOR.L_d_H, MOTOR.L_q_H, MOTOR.psi_r_Wb, MOTOR.J_kgm2
        return cls(*of_motor, 0.0, 0.0, 0.0, 0.0, (1.0, 1.0, 1.0))

    def torque_Nm(self, i_d: float, i_q: float) -> float:
        """Return the torque of the currents."""
        return 1.5 * MOTOR.pole_pairs * (self.psi_r + (self.L_d - self.L_q) * i_d) * i_q

    @property
    def truths(self) -> dict[str, float]:
        """The parameters by the names of the measurements."""
        gains = {f"current_gain_{phase}": each - 1.0 for phase, each in zip("abc", self.gains, strict=True)}
        electrical = {
            "R_s": self.R_s, "L_d": self.L_d, "L_q": self.L_q, "psi_r": self.psi_r,
            "encoder_offset": self.encoder_offset, "dead_time_voltage": self.dead_time_V, **gains,
        }  # fmt: skip
        of_shaft = {"J": self.J, "friction": self.friction, "coulomb": self.coulomb}
        return {f"flux_balance_{name}": each for name, each in electrical.items()} | {
            f"motion_balance_{name}": each for name, each in of_shaft.items()
        }


@dataclass(frozen=True)
class Sensors:
    """Noise and steps of the currents, A, of the dc link, V, and of the encoder."""

    noise_A: float = 0.005
    kind: OfNoise = "white"
    colour: float = 0.0
    step_A: float = 0.01
    noise_V: float = 0.0
    step_V: float = 0.0
    counts: int = 10_000
    eccentricity_rad: float = 0.0


@dataclass(frozen=True)
class Excitation:
    """What is asked for: a q-current that swings, and a d-current that is switched at random.

    `speeds_rad_s` are those at which a load holds the shaft, one after the other; none of a free one.
    """

    i_q: tuple[float, float] = (2.0, 6.0)  # A and Hz
    i_q_mean_A: float = 0.0
    i_d_A: float = 1.0
    speeds_rad_s: tuple[float, ...] = ()


def machine(random: np.random.Generator, dead_time: bool = True) -> Machine:
    """Return a machine that is not as the profile has it."""

    def scaled(spread: float) -> float:
        return math.exp(random.uniform(-spread, spread))

    L_d = MOTOR.L_d_H * scaled(0.2)
    gains = 1.0 + random.uniform(-0.02, 0.02, 3)
    first, second, third = (gains / np.mean(gains)).tolist()
    return Machine(
        R_s=MOTOR.R_s_ohm * scaled(0.3),
        L_d=L_d,
        L_q=L_d * random.uniform(1.0, 1.6),
        psi_r=MOTOR.psi_r_Wb * scaled(0.08),
        J=MOTOR.J_kgm2 * scaled(0.3),
        friction=random.uniform(2e-4, 3e-3),
        coulomb=random.uniform(0.02, 0.2),
        encoder_offset=random.uniform(-0.1, 0.1),
        dead_time_V=random.uniform(0.2, 2.0) if dead_time else 0.0,
        gains=(first, second, third),
    )


@dataclass(frozen=True)
class Record:
    """What a drive captures, and what is true at its rows, all of shape (n,).

    Attributes:
        block: the capture.
        i_s, theta: current in the stator's frame and angle, as sensors without noise and steps read them.
        noise: what these add to the current.
        u_s: voltage asked of the tick behind a row.
        omega: speed in the middle of that.
    """

    block: Block
    i_s: Complex
    noise: Complex
    u_s: Complex
    theta: Floats
    omega: Floats


def record(
    what: Machine, sensors: Sensors, excitation: Excitation, rows: int, random: np.random.Generator
) -> Record:
    """Return what a drive captures of a machine."""
    p = MOTOR.pole_pairs
    noise = [coloured(noise_of(sensors.kind, random, rows), sensors.colour) for _ in range(3)]
    noise_A = (sensors.noise_A * np.array(noise)).T.tolist()
    offset = random.uniform(-0.5, 0.5, 3).tolist()  # of a converter's levels, in steps
    read_V = U_DC + sensors.noise_V * random.standard_normal(rows)
    if sensors.step_V:
        at = random.uniform(-0.5, 0.5)
        read_V = (np.round(read_V / sensors.step_V + at) - at) * sensors.step_V
    link = read_V.tolist()
    d_wanted = (excitation.i_d_A * random.choice([-1.0, 1.0], rows // _HELD_TICKS + 1)).tolist()
    at_rad, of_disc_rad = random.uniform(0, 2 * math.pi, 2)
    held = excitation.speeds_rad_s
    loaded = _speed_of_load(held, rows) if held else []
    omega, theta = (loaded[0] if held else 0.0), random.uniform(0, 2 * math.pi)
    i_d = i_q = 0.0
    asked, ratio = 0j, 1.0
    found = np.empty((rows, len(_UNITS)))
    true = np.empty((rows, 4), dtype=np.complex128)
    third = complex(-0.5, 0.5 * math.sqrt(3.0))
    for k in range(rows):
        rotor = complex(math.cos(p * theta), math.sin(p * theta))
        i_s = complex(i_d, i_q) * rotor
        phases = (i_s.real, (i_s * third.conjugate()).real, (i_s * third).real)
        read = [each * gain + n for each, gain, n in zip(phases, what.gains, noise_A[k], strict=True)]
        if sensors.step_A:
            read = [(round(each / sensors.step_A + o) - o) * sensors.step_A
                for each, o in zip(read, offset, strict=True)]  # fmt: skip
        angle = theta - what.encoder_offset / p + sensors.eccentricity_rad * math.sin(theta + of_disc_rad)
        if sensors.counts:
            count = math.floor(angle / (2 * math.pi) * sensors.counts) % sensors.counts
            angle = (count + 0.5) * 2 * math.pi / sensors.counts
        u_s = asked * ratio  # from here to the next row
        seen = complex(math.cos(p * angle), math.sin(p * angle))
        i_seen = 2.0 / 3.0 * (read[0] + read[1] * third + read[2] * third.conjugate()) * seen.conjugate()
        size_A, swing_Hz = excitation.i_q
        wanted = complex(
            d_wanted[k // _HELD_TICKS],
            excitation.i_q_mean_A + size_A * math.cos(2 * math.pi * swing_Hz * k * T_S + at_rad),
        )
        asked = (_GAIN_V_A * (wanted - i_seen) + 1j * p * omega * MOTOR.psi_r_Wb) * seen
        asked *= min(1.0, _MOST_V / max(abs(asked), 1e-9))
        ratio = U_DC / link[k]  # the pulses are made by what is read of the link
        found[k] = (*read, asked.real, asked.imag, link[k], angle % (2 * math.pi))
        torque = what.torque_Nm(i_d, i_q)
        resistance = what.R_s * (1.0 + what.warming * (k / rows - 0.5))
        middle = 0.5 * (omega + (loaded[k + 1] if held else _speed_after(what, torque, theta, omega)))
        true[k] = (i_s, u_s / ratio, theta - what.encoder_offset / p, middle)
        i_d, i_q, mean_Nm = _over_a_tick(what, resistance, i_d, i_q, u_s, theta, middle)
        omega = loaded[k + 1] if held else _speed_after(what, mean_Nm, theta + 0.5 * T_S * middle, omega)
        theta += T_S * middle
    block = Block.from_arrays(1.0 / T_S, _UNITS, **dict(zip(_UNITS, found.T, strict=True)))
    as_read = np.zeros(rows, dtype=np.complex128)
    for gain, axis in zip(what.gains, _AXES, strict=True):
        as_read += 2.0 / 3.0 * gain * axis * np.real(true[:, 0] * axis.conjugate())
    read_A = sum(2.0 / 3.0 * axis * found[:, k] for k, axis in enumerate(_AXES))
    return Record(block, as_read, read_A - as_read, true[:, 1], true[:, 2].real, true[:, 3].real)


def _speed_of_load(speeds_rad_s: tuple[float, ...], rows: int) -> list[float]:
    """Return the speed at each row and one behind, from one to the next along half a cosine."""
    place = np.arange(rows + 1) / rows * len(speeds_rad_s)
    found = np.full(rows + 1, speeds_rad_s[0])
    for number, (first, then) in enumerate(itertools.pairwise(speeds_rad_s), 1):
        share = np.clip((place - number) / (_FROM_SPEED_TO_SPEED * len(speeds_rad_s)) + 0.5, 0.0, 1.0)
        found += (then - first) * 0.5 * (1.0 - np.cos(np.pi * share))
    return found.tolist()


def error_of_prediction(what: Machine, found: Record, least_A: float) -> float:
    """Return the rms error of the current that a machine is believed to have a tick ahead, A: its length.

    Ticks are left out in which a phase has less than `least_A`.
    """
    p, error2 = MOTOR.pole_pairs, 0.0
    near = np.min([np.abs(np.real(found.i_s * axis.conjugate())) for axis in _AXES], axis=0) < least_A
    used = np.flatnonzero(~(near[1:] | near[:-1]))
    for k in used:
        omega, angle = p * found.omega[k], p * found.theta[k]
        rotor = complex(math.cos(angle), math.sin(angle))
        i_dq, u_dq = found.i_s[k] * rotor.conjugate(), found.u_s[k] * rotor.conjugate()
        then = complex(*_advanced(what, what.R_s, omega, i_dq.real, i_dq.imag, u_dq, T_S))
        turned = rotor * complex(math.cos(omega * T_S), math.sin(omega * T_S))
        error2 += abs(found.i_s[k + 1] - then * turned) ** 2
    return math.sqrt(error2 / len(used))


def _speed_after(what: Machine, torque_Nm: float, theta: float, omega: float) -> float:
    """Return the speed of a free shaft after a tick: dry friction takes what it can, and does not turn it."""
    order, size_Nm = what.cogging
    torque_Nm -= what.load_Nm + size_Nm * math.sin(order * theta)
    rubbing = 0.5 * T_S * what.friction / what.J  # at the mean of both speeds
    free = ((1.0 - rubbing) * omega + T_S / what.J * torque_Nm) / (1.0 + rubbing)
    return math.copysign(max(0.0, abs(free) - what.coulomb * T_S / what.J), free)


def _over_a_tick(
    what: Machine, resistance: float, i_d: float, i_q: float, u_s: complex, theta: float, omega_m: float
) -> tuple[float, float, float]:
    """Return the currents after a tick at a constant speed under a mean voltage, by pulses about the middle
    whose edges a dead time delays, and the mean torque until then."""
    omega = MOTOR.pole_pairs * omega_m
    rotor = complex(math.cos(MOTOR.pole_pairs * theta), math.sin(MOTOR.pole_pairs * theta))
    impulse_Nms, before = 0.0, what.torque_Nm(i_d, i_q)
    if not what.dead_time_V:
        i_d, i_q = _advanced(what, resistance, omega, i_d, i_q, u_s * rotor.conjugate(), T_S)
        return i_d, i_q, 0.5 * (before + what.torque_Nm(i_d, i_q))
    legs = [(u_s * axis.conjugate()).real for axis in _AXES]
    centre = 0.5 * (max(legs) + min(legs))
    duty = [min(1.0, max(0.0, 0.5 + (each - centre) / U_DC)) for each in legs]
    dead_s = what.dead_time_V / U_DC * T_S
    edges = [(0.5 * (1.0 - each) * T_S, leg, 1) for leg, each in enumerate(duty) if each > 0.0]
    edges += [(0.5 * (1.0 + each) * T_S, leg, -1) for leg, each in enumerate(duty) if each > 0.0]
    now_s, high = 0.0, [0, 0, 0]
    edges.sort()
    delayed: list[tuple[float, int, int]] = []
    while edges or delayed:
        waiting = bool(delayed) and (not edges or delayed[0][0] <= edges[0][0])
        at_s, leg, sign = delayed.pop(0) if waiting else edges.pop(0)
        at_s = min(at_s, T_S)
        u = U_DC * 2.0 / 3.0 * sum((_AXES[k] for k in range(3) if high[k]), 0j)
        turned = rotor * complex(math.cos(omega * now_s), math.sin(omega * now_s))
        i_d, i_q = _advanced(what, resistance, omega, i_d, i_q, u * turned.conjugate(), at_s - now_s)
        after = what.torque_Nm(i_d, i_q)
        impulse_Nms += 0.5 * (before + after) * (at_s - now_s)
        now_s, before = at_s, after
        if waiting:
            high[leg] = int(sign > 0)
            continue
        place = rotor * complex(math.cos(omega * now_s), math.sin(omega * now_s))
        of_leg = (complex(i_d, i_q) * place * _AXES[leg].conjugate()).real
        if sign * of_leg > 0.0:  # it holds the leg until the other switch turns on
            delayed.append((at_s + dead_s, leg, sign))
            delayed.sort()
        else:
            high[leg] = int(sign > 0)
    u = U_DC * 2.0 / 3.0 * sum((_AXES[k] for k in range(3) if high[k]), 0j)
    turned = rotor * complex(math.cos(omega * now_s), math.sin(omega * now_s))
    i_d, i_q = _advanced(what, resistance, omega, i_d, i_q, u * turned.conjugate(), T_S - now_s)
    impulse_Nms += 0.5 * (before + what.torque_Nm(i_d, i_q)) * (T_S - now_s)
    return i_d, i_q, impulse_Nms / T_S


_AXES = (1.0 + 0j, complex(-0.5, 0.5 * math.sqrt(3.0)), complex(-0.5, -0.5 * math.sqrt(3.0)))


def _advanced(
    what: Machine, resistance: float, omega: float, i_d: float, i_q: float, u_dq: complex, step_s: float
) -> tuple[float, float]:
    """Return the currents after some time at a constant speed and a voltage that stands still in the
    stator."""
    if step_s <= 0.0:
        return i_d, i_q
    L_d, L_q = what.L_d, what.L_q
    u_d, u_q, rotor_V = u_dq.real, u_dq.imag, omega * what.psi_r
    d, q, factor = i_d, i_q, 1.0
    for term in range(1, _TERMS + 1):
        d, q = (
            (u_d - resistance * d + omega * L_q * q) / L_d,
            (u_q - resistance * q - omega * L_d * d - rotor_V) / L_q,
        )
        u_d, u_q, rotor_V = omega * u_q, -omega * u_d, 0.0
        factor *= step_s / term
        i_d += factor * d
        i_q += factor * q
    return i_d, i_q
