"""Families of the balances of flux and of torque: excited machines whose parameters are known."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.coverage.channels import MOTOR
from benchmarks.coverage.excited import (
    T_S,
    U_DC,
    Excitation,
    Machine,
    Record,
    Sensors,
    error_of_prediction,
    machine,
    record,
)
from benchmarks.coverage.families import Compared, families_of, selected
from benchmarks.coverage.noise import UNCORRELATED
from benchtool.analysis import Instruments, Window
from benchtool.analysis.balances import (
    FLUX_BALANCE,
    MOTION_BALANCE,
    FluxBalanceSettings,
    MotionBalanceSettings,
)
from benchtool.profile import Bench, Sensor

_SENSORS, _EXCITATION = Sensors(), Excitation()
_COARSE = 4.0  # of noise: such steps read neighbours alike
_FINEST_V = 1e-6  # resolution that is stated of a dc link that is read without steps


@dataclass(frozen=True)
class Balance:
    """How a machine of random parameters is excited, read and captured, and what disturbs it.

    `cogging`, an order and its size in Nm, is stated to the analysis; a `load_Nm` and what the resistance
    rises by are not.
    """

    sensors: Sensors = _SENSORS
    excitation: Excitation = _EXCITATION
    rows: int = 4000
    has_dead_time: bool = True
    cogging: tuple[int, float] = (0, 0.0)
    load_Nm: float = 0.0
    warming: float = 0.0


def _trial(what: Balance, random: np.random.Generator) -> Iterator[Compared]:
    true = replace(
        machine(random, what.has_dead_time),
        cogging=what.cogging,
        load_Nm=what.load_Nm,
        warming=what.warming,
    )
    found = record(true, what.sensors, what.excitation, what.rows, random)
    window = Window.of(found.block, MOTOR)
    truths = true.truths | _errors(what, true, found)
    link = Sensor.model_validate({"resolution_V": what.sensors.step_V or _FINEST_V})
    instruments = Instruments(Bench(channels={"u_dc": link}), [found.block])
    flux = FLUX_BALANCE.measure(window, FluxBalanceSettings()).measurements
    yield from selected(instruments.applied(flux), truths)
    if what.excitation.speeds_rad_s:
        return
    settings = MotionBalanceSettings(cogging_orders=(what.cogging[0],) if what.cogging[0] else ())
    motion = MOTION_BALANCE.measure(window, settings).measurements
    yield from selected(instruments.applied(motion), truths)


def _errors(what: Balance, true: Machine, found: Record) -> dict[str, float]:
    """Return the rms errors of the currents predicted a tick ahead: noise of a vector of three phases at both
    ends, and what the believed parameters add; not what the angle between the counts of an encoder does."""
    read = what.sensors
    phase2 = read.noise_A**2 * (1.0 - read.colour) + read.step_A**2 / 12.0
    noise2 = 8.0 / 3.0 * phase2
    if read.kind not in UNCORRELATED or read.step_A > read.noise_A * _COARSE:
        noise2 = float(np.mean(np.abs(np.diff(found.noise)) ** 2))
    # what the dc link is read as scales the voltage
    link_V = read.noise_V / U_DC * math.sqrt(float(np.mean(np.abs(found.u_s) ** 2)))
    noise2 += 0.5 * (T_S * link_V) ** 2 * (true.L_d**-2 + true.L_q**-2)
    noise_A = math.sqrt(noise2)
    # beside a crossing of zero the sign of the current is not told, by steps and by what dead time makes
    least_A = 2.0 * read.step_A + 2.0 * true.dead_time_V * T_S / (0.5 * (true.L_d + true.L_q))
    by_belief_A = error_of_prediction(Machine.believed(), found, least_A)
    return {
        "flux_balance_error_rms": noise_A,
        "flux_balance_belief_error_rms": math.hypot(noise_A, by_belief_A),
    }


_BALANCE = Balance()
BALANCES: Mapping[str, Balance] = {
    "excited": _BALANCE,
    "excited_no_dead_time": replace(_BALANCE, has_dead_time=False),
    "excited_loud": replace(_BALANCE, sensors=replace(_SENSORS, noise_A=0.05)),
    "excited_coloured": replace(_BALANCE, sensors=replace(_SENSORS, noise_A=0.03, colour=0.9)),
    "excited_pink": replace(_BALANCE, sensors=replace(_SENSORS, noise_A=0.02, kind="pink")),
    "excited_heavy": replace(_BALANCE, sensors=replace(_SENSORS, noise_A=0.02, kind="heavy")),
    "excited_no_steps": replace(_BALANCE, sensors=replace(_SENSORS, step_A=0.0, counts=0)),
    "excited_coarse_steps": replace(_BALANCE, sensors=replace(_SENSORS, step_A=0.08)),
    "excited_coarse_counts": replace(_BALANCE, sensors=replace(_SENSORS, counts=2048)),
    "excited_eccentric": replace(_BALANCE, sensors=replace(_SENSORS, eccentricity_rad=5e-4)),
    "excited_noisy_link": replace(_BALANCE, sensors=replace(_SENSORS, noise_V=0.5)),
    "excited_steps_of_link": replace(_BALANCE, sensors=replace(_SENSORS, step_V=0.6, noise_V=0.2)),
    "excited_still_link": replace(_BALANCE, sensors=replace(_SENSORS, step_V=0.6)),
    "excited_link_of_few_counts": replace(_BALANCE, sensors=replace(_SENSORS, step_V=0.6, noise_V=0.06)),
    "excited_short": replace(_BALANCE, rows=1800),
    "excited_long": replace(_BALANCE, rows=9000),
    "excited_held": replace(_BALANCE, excitation=Excitation(speeds_rad_s=(40.0,)), has_dead_time=False),
    "excited_held_two_speeds": replace(_BALANCE, excitation=Excitation(speeds_rad_s=(60.0, -25.0))),
    "excited_one_direction": replace(_BALANCE, excitation=Excitation(i_q_mean_A=0.3)),
    "excited_fast_swing": replace(_BALANCE, excitation=Excitation(i_q=(3.0, 11.0))),
    "excited_slow_swing": replace(_BALANCE, excitation=Excitation(i_q=(0.8, 2.5)), rows=8000),
    "excited_cogging": replace(_BALANCE, cogging=(24, 0.1)),
    "excited_load": replace(_BALANCE, load_Nm=0.15),
    "excited_warming": replace(_BALANCE, warming=0.1),
}

FAMILIES = families_of(_trial, BALANCES)
