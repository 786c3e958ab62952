"""Whether every phase is connected, and every current sensor as it should be, before a loop is closed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Basis, Measurement
from benchtool.block import Block
from benchtool.commission.estimators.connections import Fault, Response, diagnosis, response
from benchtool.commission.estimators.vectors import vector_of
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest, Stimulus
from benchtool.errors import SetUpError

_PERIODS = 14.0  # control periods in a turn of the vector
_ROWS = 240
_STAGES = 9  # each with twice the voltage of the one before
_SHARE = 0.4  # of the rated current, of the last stage
_DROP_SHARE = 0.09  # of the dc link, that dead time and devices may take
_VOLTAGE_SHARE = 0.5  # of u_dc / sqrt(3)
_ENOUGH = 0.2  # of the rated current, by which the connections are told
_LEAST = 0.05  # of the rated current, below which none flows
_SHORTED = 3.0  # times the current that the nameplate's impedance lets flow

_SAYINGS: Mapping[Fault, tuple[str, str, str]] = {
    Fault.OPEN: (
        "hardly any current flows in phase {x} while a voltage turns, and the other two carry the same",
        "phase {x} is open: its cable is off or broken, a fuse, or a winding or leg that is interrupted",
        "check the cable and the terminal of phase {x}, and measure the resistance between the terminals",
    ),
    Fault.SHORTED: (
        "phase {x} takes far more current than the other two while a voltage turns",
        "a shorted phase: turns of phase {x} are shorted, or its end touches the star point",
        "measure the winding between each two terminals and against earth; do not run this motor",
    ),
    Fault.DEAD: (
        "the sensor of output {x} reads no current while the other two do not add up to zero",
        "the current sensor of output {x} is dead, or not connected",
        "check the sensor of output {x}, its supply and its cable",
    ),
    Fault.REVERSED: (
        "the three currents add up to zero only with the sign of output {x} reversed",
        "the sign of the current of output {x}: its sensor is mounted the other way round",
        "turn the sensor of output {x} round, or exchange the leads of its signal",
    ),
    Fault.ALL_REVERSED: (
        "the currents have the opposite sign of what the voltage drives",
        "the sign of the currents: all sensors are mounted the other way round, or the firmware counts "
        "current into the drive",
        "turn the sensors round, or reverse the sign of their gains in the firmware; a current loop would "
        "run away",
    ),
    Fault.GAIN: (
        "the three currents do not add up to zero: output {x} reads too little or too much",
        "the gain of a current sensor is wrong, or current leaks to earth",
        "check the sensors' gains and the insulation of the winding",
    ),
    Fault.ORDER: (
        "the currents do not turn as the voltage does",
        "current sensors and phases are swapped: the sensor of one output measures another one's current",
        "compare the order of the current sensors with that of the legs, and phase_order",
    ),
}


class Connections:
    """Turn a voltage vector, too fast for the rotor to follow, twice as long each time until the currents are
    clear.

    No loop is closed yet: a sign or an order that is wrong would have it run away.
    """

    name = "connections"
    needs: tuple[str, ...] = ("offsets",)
    sets: tuple[str, ...] = ()

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return the stages, each of twice the voltage of the one before; those beyond what is needed are
        left out."""
        last_V, duration_s = _last_V(known), (_ROWS + 2) * known.control_period_s
        omega_e = _omega_e(known)
        return tuple(
            Excitation(
                f"{last_V * share:.3g} V at {omega_e / (2.0 * math.pi):.4g} Hz",
                Stimulus(
                    quantity="voltage",
                    shape="ramp",
                    amplitude_V=last_V * share,
                    duration_s=duration_s,
                    omega_e_rad_s=omega_e,
                ),
                CaptureRequest((*CURRENTS, "u_alpha", "u_beta"), rows=_ROWS),
                (_SHARE * share * known.I_N_A) ** 2 * duration_s / 3.0,
                {"dead_time_compensation": 0.0, **known.offsets},
            )
            for share in (0.5 ** (_STAGES - 1 - k) for k in range(_STAGES))
        )

    def suffices(self, block: Block, known: Known) -> bool:
        """Return whether a capture has currents that tell the connections."""
        return float(np.max(np.abs(_readings(block)))) > _ENOUGH * known.I_N_A

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return how long the current vector was that showed all connected, and the unbalance of the phases.

        Raises:
            AnalysisError: the capture does not tell.
            SetUpError: something is not connected as it should be.
        """
        block = blocks[-1]
        u_V = (block.column("u_alpha") + 1j * block.column("u_beta"))[:-2]
        found = response(u_V, _readings(block)[1:])
        _require_current(found, float(np.max(np.abs(u_V))), known)
        L = min(known.motor.L_d_H, known.motor.L_q_H)
        fault, k = diagnosis(found, known.motor.R_s_ohm, L, _omega_e(known))
        if fault is not Fault.NONE:
            what, cause, remedy = (each.format(x="abc"[k]) for each in _SAYINGS[fault])
            raise SetUpError(what, cause, remedy)
        basis = Basis(samples=len(block.data), sample_rate_Hz=1.0 / known.control_period_s)
        largest = float(np.max(np.abs(vector_of(_readings(block)))))
        unbalance = 100.0 * abs(found.against_S) / abs(found.with_S)
        definition = (
            "of what turns against the voltage over what turns with it: saliency, or phases that differ"
        )
        return {
            each.name: each
            for each in (
                Measurement("current_tried", largest, "A", "longest current vector of the capture", basis),
                Measurement("current_unbalance", unbalance, "%", definition, basis),
                Measurement(
                    "inductance_seen",
                    (1.0 / found.slope_S).imag / _omega_e(known),
                    "H",
                    "voltage over current a quarter of a turn apart, about",
                    basis,
                ),
                Measurement(
                    "admittance", abs(found.with_S), "S", "current over the voltage that turns", basis
                ),
            )
        }

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return whether more current flows than the nameplate's inductance lets flow."""
        times = found["admittance"].value * _impedance_ohm(known)
        if times < _SHORTED:
            return ()
        return (
            Finding(
                f"the current is {times:.3g} times what the nameplate's inductance lets flow",
                "shorted turns or a shorted phase, or an inductance that is stated far too large",
                "measure the winding between each two terminals, and check motor.L_d_H and L_q_H",
            ),
        )


def _readings(block: Block) -> NDArray[np.float64]:
    return np.column_stack([block.column(name) for name in CURRENTS])


def _omega_e(known: Known) -> float:
    return min(2.0 * math.pi / (_PERIODS * known.control_period_s), 20_000.0)


def _impedance_ohm(known: Known) -> float:
    return math.hypot(known.motor.R_s_ohm, _omega_e(known) * min(known.motor.L_d_H, known.motor.L_q_H))


def _last_V(known: Known) -> float:
    """Return the voltage of the last stage."""
    needed = _SHARE * known.I_N_A * _impedance_ohm(known) + _DROP_SHARE * known.u_dc_V
    return min(_VOLTAGE_SHARE * known.u_dc_V / math.sqrt(3.0), needed)


def _require_current(found: Response, u_V: float, known: Known) -> None:
    """Raise where no current flows at the largest voltage."""
    if found.largest_A >= _LEAST * known.I_N_A:
        return
    raise SetUpError(
        f"{found.largest_A:.3g} A flow at {u_V:.4g} V that turns, more than {_LEAST * known.I_N_A:.3g} A are "
        f"expected by the nameplate",
        "the motor is not connected or two phases are open, the current sensors are dead, or rated current "
        "or inductance are stated far too large or too small",
        "check the motor's cables, the sensors, and motor.I_N_A_rms, L_d_H and L_q_H of the profile",
    )
