"""The speed loop: a PI for a crossover and a phase margin, checked by a Bode plot of a turning shaft.

Where the plot is not as designed, it shows the plant that the gains really work on. The loop is tuned for
that, and checked again; what is stored was checked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from benchtool.analysis import Bode, Contribution, Measurement, combined
from benchtool.block import Block
from benchtool.commission.estimators.orders import without_orders
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.current_control import current_loop, decay
from benchtool.commission.steps.step import Finding, Loop
from benchtool.commission.tuning.bode_check import (
    ExcitedRows,
    deviations,
    measured,
    numbers,
    repetitions,
)
from benchtool.commission.tuning.harmonic_brake import HarmonicBrake
from benchtool.commission.tuning.loops import (
    SpeedLoop,
    has_room,
    inner_loop,
    mean_square_of_sequence,
    tuned_speed_loop,
)
from benchtool.commission.tuning.plant_seen import SeenPlant, seen_plant
from benchtool.drive import CaptureRequest, Stimulus
from benchtool.errors import AnalysisError, ValueRefused
from benchtool.protocol import Mode

_CASCADE = 10.0  # by which it is slower than the loop of torque
_TORQUE_OF_A_COUNT = 0.002  # of the rated torque, that a step of the encoder may make
_OBSERVER = 5.0  # its poles over the crossover
_MOST_OBSERVER_RAD_S = 5000.0
_SPEED_SHARES = 0.1, 0.25  # of the rated speed, least and most
_AMPLITUDES = 2.0  # of the sequence, in the speed that it is added to: decision 0194
_TORQUE_SHARE = 0.25  # of the rated torque, that a change of the reference asks for
_AMPLITUDE_SHARE = 0.1  # of the rated speed
_BITS = 8
_FEWEST, _MOST, _LONGEST_S = 6, 12, 5.0  # repetitions, as many as there is time for
_LONG_S = 8.0  # that a sequence takes which is played twice at most
_SLOW_S = 12.0  # that the fewest take: a sequence has a bit less
_APART = 0.2  # of an inertia that was identified: another is a load
_SEEN_J, _SEEN_FRICTION = "speed_loop_J", "speed_loop_friction"
_CLOCKS = 20.0  # in a period of the crossover
_ROWS_OF_A_CLOCK = 10
_RUN_UP_S = 1.0
_RIPPLE = 0.5  # rms ripple of the current over what one vector changes


class SpeedControl:
    """Tune the speed controller for the inertia that was found, and measure its closed loop.

    The crossover is a tenth of the current loop's bandwidth, or where a step of the encoder makes a torque
    that is heard. A binary sequence is added to the reference of a shaft that turns twice as fast, so that
    dry friction does not change its sign, and no faster: that friction takes most of the energy, and
    harmonics of the EMF damp the loop with the square of the speed, for which it is not tuned.
    """

    most_rounds = 3
    name = "speed_loop"
    needs: tuple[str, ...] = ("current_loop",)
    sets: tuple[str, ...] = ("K_p_speed", "K_i_speed", "omega_observer")

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a run with a binary sequence."""
        loop = speed_loop(known)
        stimulus, stride = _sequence(known, loop)
        ticks = stimulus.ticks(known.control_period_s) * stimulus.repetitions
        duration_s = ticks * known.control_period_s
        omega, brake = _turning_rad_s(known, stimulus), _brake(known, loop)
        friction = known.friction_Nm(omega) + brake.torque_Nm(omega)
        assert stimulus.prbs_clock_s is not None
        assert stimulus.prbs_length is not None
        shaken = mean_square_of_sequence(
            loop, stimulus.amplitude, stimulus.prbs_clock_s, stimulus.prbs_length
        )
        squares = (friction**2 + shaken) / known.torque_per_A**2 + (_RIPPLE * known.vector_A) ** 2
        squares += brake.current_squared_A2(omega)
        return (
            Excitation(
                "sequence of the speed",
                stimulus,
                CaptureRequest(
                    ("omega_m", "stimulus", "torque", "torque_reference", "i_d", "i_q", "law_clipped"),
                    ticks // stride,
                    stride,
                ),
                squares * duration_s,
                {**known.in_force, **gains(known)},
                work_J=friction * omega * duration_s,
                mode=Mode.VELOCITY,
                omega_m_rad_s=omega,
                settle_s=_RUN_UP_S,
                most_times=self.most_rounds,
            ),
        )

    def loops(self, known: Known) -> tuple[Loop, ...]:
        """Return which capture holds the loop's response."""
        stimulus, stride = _sequence(known, speed_loop(known))
        rows = ExcitedRows.of(stimulus, known.control_period_s, stride)
        return (Loop(0, "speed loop, omega_m over its reference", "stimulus", "omega_m", vars(rows)),)

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return the gains as they were tuned, and crossover and margins as measured.

        Raises:
            AnalysisError: the capture does not define them.
        """
        found = numbers(_response(blocks[0], known), self.name)
        margin = "for the crossover and a phase margin of 60 degrees, by J, the loop of torque and T_s"
        texts = {
            "K_p_speed": ("Nms/rad", margin),
            "K_i_speed": ("Nm/rad", margin),
            "omega_observer": ("rad/s", f"{_OBSERVER:g} times the crossover"),
        }
        tuned = {name: Measurement(name, value, *texts[name]) for name, value in gains(known).items()}
        return {**tuned, **found}

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what of the measured loop is not as designed."""
        return deviations(found, self.name, speed_loop(known).margins)

    def refined(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return inertia and damping as the loop shows them.

        Nothing where the inertia that was identified is another; where no loop can be tuned for them that
        keeps its gain margin and its sensitivity at standstill, too, where harmonics of the EMF do not damp;
        nor of a slow loop that was tuned again already, for the time that it takes.
        """
        (played,) = self.plan(known)
        duration_s = played.request.rows * played.request.stride * known.control_period_s
        if _SEEN_J in known.estimates and duration_s > _LONG_S:
            return {}
        try:
            refined = _seen(seen_plant(_response(blocks[0], known), speed_loop(known)))
            loop = speed_loop(known.with_estimates(refined))
        except (AnalysisError, ValueRefused):  # the findings of this round stand
            return {}
        J = known.value("J", loop.J_kgm2)
        if abs(loop.J_kgm2 / J - 1.0) > _APART:
            return {}
        at_standstill = replace(loop, friction_Nms=max(0.0, known.value("friction", 0.0)))
        return refined if has_room(at_standstill) else {}


def speed_loop(known: Known) -> SpeedLoop:
    """Return the loop for what is known of the shaft.

    As long as no loop has shown its damping, it is that of friction, and of what harmonics of the EMF brake
    at the speed of the check; without the latter where the loop would not keep gain margin and sensitivity
    at standstill.
    """
    friction = max(0.0, known.value("friction", 0.0))
    if _SEEN_FRICTION in known.estimates:
        return _tuned(known, max(0.0, known.value(_SEEN_FRICTION, friction)))
    loop = _tuned(known, friction)
    damping = _brake(known, loop).damping_Nms(_turning_rad_s(known, _sequence(known, loop)[0]))
    try:
        damped = _tuned(known, friction + max(0.0, damping))
    except ValueRefused:
        return loop
    return damped if has_room(replace(damped, friction_Nms=friction)) else loop


def _brake(known: Known, loop: SpeedLoop) -> HarmonicBrake:
    """Return what harmonics of the EMF brake; nothing under a law without a current controller."""
    motor, inner = known.identified, loop.inner
    if inner is None:
        return HarmonicBrake(motor.pole_pairs, {}, ())
    axes = [(replace(inner, decay=decay(known, L_H)), L_H) for L_H in (motor.L_d_H, motor.L_q_H)]
    return HarmonicBrake(motor.pole_pairs, known.flux_harmonics, axes)


def _turning_rad_s(known: Known, stimulus: Stimulus) -> float:
    """Return the speed at which the sequence is added."""
    least, most = (share * known.motor.omega_m_N_rad_s for share in _SPEED_SHARES)
    return min(max(_AMPLITUDES * stimulus.amplitude, least), most)


def _tuned(known: Known, friction_Nms: float) -> SpeedLoop:
    J = known.value("J", known.motor.J_kgm2)
    count_rad = 2.0 * math.pi / (4.0 * known.encoder_lines)
    heard = math.sqrt(_TORQUE_OF_A_COUNT * known.motor.T_N_Nm / (_OBSERVER * J * count_rad))
    decays = decay(known, known.identified.L_q_H)
    inner = inner_loop(known.law, current_loop(known).omega_rad_s, known.control_period_s, decays)
    crossover = min(current_loop(known).omega_rad_s / _CASCADE, heard)
    return tuned_speed_loop(crossover, known.value(_SEEN_J, J), friction_Nms, inner, known.control_period_s)


def gains(known: Known) -> dict[str, float]:
    """Return the parameters of the tuned loop."""
    loop = speed_loop(known)
    observer = min(_OBSERVER * loop.margins.crossover_rad_s, _MOST_OBSERVER_RAD_S)
    return {"K_p_speed": loop.K_p_Nms_rad, "K_i_speed": loop.K_i_Nm_rad, "omega_observer": observer}


def _response(block: Block, known: Known) -> Bode:
    stimulus, stride = _sequence(known, speed_loop(known))
    rows = ExcitedRows.of(stimulus, known.control_period_s, stride)
    return measured(_without_orders(block, rows, known), "stimulus", "omega_m", rows)


def _seen(seen: SeenPlant) -> dict[str, Measurement]:
    scatter = "scatter about the fit"
    lines = (
        (_SEEN_J, seen.J_kgm2, "kgm2", "inertia", seen.J_standard),
        (_SEEN_FRICTION, seen.friction_Nms, "Nms", "damping", seen.friction_standard),
    )
    return {
        name: Measurement(
            name,
            value,
            unit,
            f"{what} that the speed loop shows about its crossover, by a Bode plot before the last",
            uncertainty=combined([Contribution(scatter, "A", standard, seen.dof)], scatter),
        )
        for name, value, unit, what, standard in lines
    }


def _without_orders(block: Block, rows: ExcitedRows, known: Known) -> Block:
    """Return a capture without what the shaft's angle repeats in its speed: cogging as far as it was found,
    an eccentric encoder (once and twice in a revolution), sensors that differ (in an electrical one), and the
    harmonics of the EMF (six times in that)."""
    p, names = known.pole_pairs, [each.name for each in block.channels]
    orders = sorted({1, 2, p, 2 * p, 6 * p, *known.cogging_orders})
    place, played = names.index("omega_m"), slice(rows.begin_row, rows.end_row)
    row_s = block.stride * block.tick_s
    orders = [each for each in orders if each * float(np.mean(block.data[played, place])) * row_s < math.pi]
    data = np.array(block.data)
    data[played, place] = without_orders(data[played, place], rows.period_rows, row_s, orders)
    return replace(block, data=data)


def _sequence(known: Known, loop: SpeedLoop) -> tuple[Stimulus, int]:
    """Return a binary sequence, and the stride of its capture, which divides its clock."""
    T_s, omega_N = known.control_period_s, known.motor.omega_m_N_rad_s
    clock_s = 2.0 * math.pi / loop.margins.crossover_rad_s / _CLOCKS
    stride = max(1, round(clock_s / T_s / _ROWS_OF_A_CLOCK))
    ticks = stride * max(1, round(clock_s / T_s / stride))
    amplitude = min(
        0.5 * _TORQUE_SHARE * known.motor.T_N_Nm / loop.K_p_Nms_rad,
        _AMPLITUDE_SHARE * omega_N,
    )
    fewest_s = _FEWEST * (2**_BITS - 1) * ticks * T_s
    bits = _BITS if fewest_s < _SLOW_S else _BITS - 1
    stimulus = Stimulus(
        quantity="speed",
        shape="prbs",
        amplitude_rad_s=amplitude,
        prbs_clock_s=ticks * T_s,
        prbs_length=bits,
        seed=1,
        repetitions=repetitions((2**bits - 1) * ticks * T_s, _LONGEST_S, _FEWEST, _MOST),
    )
    return stimulus, stride
