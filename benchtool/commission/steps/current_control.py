"""The current loop: its bandwidth from the control period, checked by a Bode plot of i_d at standstill."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from benchtool.analysis import Measurement
from benchtool.block import Block
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.alignment import aligning
from benchtool.commission.steps.step import Finding, Loop
from benchtool.commission.tuning.bode_check import (
    ExcitedRows,
    deviations,
    measured,
    numbers,
    repetitions,
)
from benchtool.commission.tuning.loops import CurrentLoop, tuned_current_loop
from benchtool.drive import CaptureRequest, Stimulus
from benchtool.protocol import Mode

OF_SAMPLING = 0.05
"""Bandwidth asked for, of 2 pi / T_s."""

_ANGLE_RAD = math.radians(15.0)  # at which no phase current is near zero
_OFFSET_SHARE, _AMPLITUDE_SHARE = 0.4, 0.12  # of the rated current, peak
_VOLTAGE_SHARE = 0.25  # of u_dc / sqrt 3, that a change of the reference may ask for
_BITS = 10
_FEWEST, _MOST, _LONGEST_S = 11, 41, 1.2  # repetitions, as many as there is time for
_MOST_DECAY = 0.5  # beyond it a nameplate is wrong


class CurrentControl:
    """Tune the current controller of law `foc`, and measure its closed loop.

    The rotor stands where an alignment has left it, and a binary sequence on i_d, beside a steady part, makes
    no torque, as long as the drive has the angle at which it stands.
    """

    name = "current_loop"
    needs: tuple[str, ...] = ("mechanics",)
    sets: tuple[str, ...] = ("omega_current",)

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return an alignment and a binary sequence."""
        T_s, loop = known.control_period_s, current_loop(known)
        parameters = {**known.in_force, "law": "foc", "omega_current": loop.omega_rad_s}
        align = aligning(known, parameters, _ANGLE_RAD)
        stimulus = _sequence(known, loop)
        ticks = stimulus.ticks(T_s) * stimulus.repetitions
        return (
            align,
            Excitation(
                "sequence of i_d",
                stimulus,
                CaptureRequest(("i_d", "i_q", "stimulus", "law_clipped"), ticks),
                (stimulus.offset**2 + stimulus.amplitude**2) * ticks * T_s,
                parameters,
                mode=Mode.TORQUE,
                standing=True,
            ),
        )

    def loops(self, known: Known) -> tuple[Loop, ...]:
        """Return which capture holds the loop's response."""
        rows = ExcitedRows.of(_sequence(known, current_loop(known)), known.control_period_s, 1)
        return (Loop(1, "current loop, i_d over its reference", "stimulus", "i_d", vars(rows)),)

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `omega_current` as it was tuned, and crossover and margins as measured.

        Raises:
            AnalysisError: the capture does not define them.
        """
        loop = current_loop(known)
        rows = ExcitedRows.of(_sequence(known, loop), known.control_period_s, 1)
        found = numbers(measured(blocks[1], "stimulus", "i_d", rows), self.name)
        text = f"{OF_SAMPLING:g} of 2 pi / T_s, or less, by the margins of the loop that L_d and T_s make"
        return {"omega_current": Measurement("omega_current", loop.omega_rad_s, "rad/s", text), **found}

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what of the measured loop is not as designed."""
        return deviations(found, self.name, current_loop(known).margins)


def current_loop(known: Known) -> CurrentLoop:
    """Return the loop of i_d that the control period allows."""
    T_s = known.control_period_s
    return tuned_current_loop(OF_SAMPLING * 2.0 * math.pi / T_s, T_s, decay(known, known.identified.L_d_H))


def decay(known: Known, L_H: float) -> float:
    """Return the share of the current in an inductance that the resistance takes off in a period."""
    return min(known.R_s_ohm * known.control_period_s / L_H, _MOST_DECAY)


def _sequence(known: Known, loop: CurrentLoop) -> Stimulus:
    """Return a binary sequence of i_d about a negative current, which weakens the flux."""
    L_d = known.value("L_d", known.motor.L_d_H)
    per_ampere = loop.share * L_d / known.control_period_s + known.R_s_ohm
    most_A = 0.5 * _VOLTAGE_SHARE * known.u_dc_V / math.sqrt(3.0) / per_ampere
    return Stimulus(
        quantity="d_current",
        shape="prbs",
        amplitude_A=min(_AMPLITUDE_SHARE * known.I_N_A, most_A),
        offset_A=-_OFFSET_SHARE * known.I_N_A,
        prbs_clock_s=known.control_period_s,
        prbs_length=_BITS,
        seed=1,
        repetitions=repetitions((2**_BITS - 1) * known.control_period_s, _LONGEST_S, _FEWEST, _MOST),
    )
