"""Verification run with the new parameters: flux and torque balances as a second opinion of the estimates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from benchtool.analysis import Contribution, Instruments, Measurement, Uncertainty, Window, sure_of
from benchtool.analysis.balances import (
    FLUX_BALANCE,
    MOTION_BALANCE,
    UNEXPLAINED,
    Deviation,
    FluxBalance,
    MotionBalanceSettings,
    contradictions,
    deviations,
)
from benchtool.block import Block
from benchtool.commission.budget import of_two
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.second_opinion import ACROSS, of_a_sine
from benchtool.commission.steps.speed_control import gains, speed_loop
from benchtool.commission.steps.step import Finding
from benchtool.commission.tuning.loops import mean_square_of_chirp
from benchtool.drive import CaptureRequest, Stimulus
from benchtool.errors import AnalysisError
from benchtool.profile import Bench, Sensor
from benchtool.protocol import Mode

_CHANNELS = ("i_a", "i_b", "i_c", "u_alpha", "u_beta", "u_dc", "theta_m", "omega_m", "torque")
_ROWS, _SHORTEST_S, _LONGEST_S = 20_000, 1.0, 2.0
_SPEED_SHARE, _VOLTAGE_SHARE, _TORQUE_SHARE = (
    0.4,
    0.5,
    0.35,
)  # of rated speed, of u_dc / sqrt 3, of rated torque
_SLOWEST_HZ, _FASTEST_HZ = 4.0, 10.0
_FIRST_SHARE = 0.25  # of the last frequency
_RIPPLE = 0.5  # rms ripple of the current over what one vector changes
_NEAR_ZERO = 0.5  # of the voltage of the dead time: within the ripple of the current it is not there
_FOLLOWS = 0.5  # of the speed asked for
_MOVED = 1.0 / 6.0  # of the change of current that dead time makes in a period: of its mean, at most
_BY_RIPPLE = ("L_d", "L_q")  # which a current without ripple does not tell
_ELECTRICAL = ("R_s", "L_d", "L_q", "psi_r", "encoder_offset")
_COMPENSATION = "dead_time_compensation"
_DEAD_TIME = "flux_balance_dead_time_voltage"
_REVERSED = 0.1  # of the greatest speed, beyond which it has turned back
_OF_RIPPLE = tuple(f"flux_balance_{name}" for name in _BY_RIPPLE)
_BRAKED = ("motion_balance_coulomb", "motion_balance_friction")


class Verification:
    """Swing the speed both ways, ever faster, with every parameter as it is to be kept but one.

    The drive does not compensate dead time meanwhile. It does that by the sign of a current that it predicts,
    once in a period; the balance has the sign at each edge, and where a ripple crosses zero the two differ by
    up to twice the dead time's voltage, which no parameter explains.

    The flux balance and the balance of torque of that one capture tell R_s, L_d, L_q, psi_r, J and the angle
    of the encoder again, by another method than the steps. Where they contradict these, nothing is kept.
    """

    name = "verification"
    needs: tuple[str, ...] = ("ripple",)
    sets: tuple[str, ...] = ()

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a swing of the speed."""
        motor = known.identified
        duration_s = min(max(_ROWS * known.control_period_s, _SHORTEST_S), _LONGEST_S)
        most = _SPEED_SHARE * known.motor.omega_m_N_rad_s
        most = min(most, _VOLTAGE_SHARE * known.u_dc_V / math.sqrt(3.0) / (motor.pole_pairs * motor.psi_r_Wb))
        reach = _TORQUE_SHARE * motor.T_N_Nm / (2.0 * math.pi * motor.J_kgm2)
        crossover_Hz = speed_loop(known).margins.crossover_rad_s / (2.0 * math.pi)
        last_Hz = min(max(reach / most, _SLOWEST_HZ), _FASTEST_HZ, max(crossover_Hz, _SLOWEST_HZ))
        amplitude = min(most, reach / last_Hz)
        stimulus = Stimulus(
            quantity="speed",
            shape="chirp_linear",
            amplitude_rad_s=amplitude,
            frequency_start_Hz=_FIRST_SHARE * last_Hz,
            frequency_end_Hz=last_Hz,
            duration_s=duration_s,
        )
        friction = known.friction_Nm(amplitude)
        swung = mean_square_of_chirp(speed_loop(known), amplitude, _FIRST_SHARE * last_Hz, last_Hz)
        squares = (swung + friction**2) / known.torque_per_A**2 + (_RIPPLE * known.vector_A) ** 2
        rows = math.floor(duration_s / known.control_period_s)
        parameters = {**known.in_force, **gains(known)}
        if _COMPENSATION in parameters:
            parameters[_COMPENSATION] = 0.0
        return (
            Excitation(
                "swing of the speed",
                stimulus,
                CaptureRequest(_CHANNELS, rows),
                squares * duration_s,
                parameters,
                settle_s=0.2,
                work_J=friction * 2.0 / math.pi * amplitude * duration_s,
                mode=Mode.VELOCITY,
            ),
        )

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return what the balances tell, each named after its balance.

        A capture that cannot be balanced, as where dead time takes most of the voltage, tells nothing of
        them; the response of the loops has then been measured all the same. Nor does one that is balanced by
        another dead time than several levels of current have told: of one level the balance knows only the
        sum of its voltage and that of the resistance, and the other parameters make up for the wrong shares.
        """
        (block,) = blocks
        window = Window.of(of_a_sine(block, known), known.identified)
        found: list[Measurement] = []
        link = Sensor.model_validate({"resolution_V": known.link_step_V})
        instruments = Instruments(Bench(channels={"u_dc": link}), [block])
        settings = MotionBalanceSettings(cogging_orders=known.cogging_orders)
        left: Mapping[str, float] = {}
        for kind, measure in (
            (FLUX_BALANCE, FLUX_BALANCE.measure),
            (MOTION_BALANCE, MOTION_BALANCE.measure),
        ):
            try:
                made = measure(window, settings)
                told = sound_balance(instruments.applied(made.measurements), known)
                if isinstance(made.result, FluxBalance):
                    left = unexplained(made.result, block, known)
                told = [_with_flux(_with_unexplained(each, left), known) for each in told]
                found += (_by_ripple(_beside_harmonics(each, known), known) for each in told)
            except AnalysisError as reason:
                definition = "second opinion by the balance of the verification run"
                found.append(Measurement.undefined(kind.name, "", definition, str(reason)))
        speed = Measurement(
            "speed_reached",
            float(np.max(np.abs(block.column("omega_m")))),
            "rad/s",
            "greatest speed of the swing",
        )
        return {each.name: each for each in (*found, speed)}

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what the balances contradict, by more than the uncertainty of both makes likely and by more
        than is worth a change, and a speed that was not reached."""
        (swing,) = self.plan(known)
        swing_A = math.sqrt(swing.squares_A2s / (swing.request.rows * known.control_period_s))
        asked = swing.stimulus
        assert asked is not None
        findings = [
            Finding(
                f"by the balance of the verification run, {each}",
                "the two methods disagree: the motor has warmed up, saturates, or one of them was disturbed",
                "let the motor cool, free the shaft, and commission it again",
                fails=False,
            )
            for each in contradictions(_beside(found, known))
            if abs(each.difference)
            > max(
                sure_of(_combined(each, known, swing_A)),
                _near_zero(each.name, known, swing_A, asked.amplitude),
            )
        ]
        if found["speed_reached"].value < _FOLLOWS * asked.amplitude:
            findings.append(
                Finding(
                    f"the speed reached {found['speed_reached'].value:.4g} of {asked.amplitude:.4g} rad/s",
                    "the shaft is loaded or held, or the torque limit is low",
                    "free the shaft, check torque_limit",
                )
            )
        return tuple(findings)


def sound_balance(found: Sequence[Measurement], known: Known) -> Sequence[Measurement]:
    """Return the estimates of a balance.

    Raises:
        AnalysisError: they rest on another dead time than the one that was found.
    """
    dead = next((each for each in found if each.name == _DEAD_TIME), None)
    if dead is not None and dead.known_uncertainty is not None:
        near_zero_V = _NEAR_ZERO * abs(known.drop_V)
        unsure_V = sure_of(of_two(dead, known.estimates.get("dead_time_voltage")))
        if abs(dead.value - known.drop_V) > max(unsure_V, near_zero_V):
            raise AnalysisError(
                f"the balance takes {dead.value:.3g} V for dead time, several levels of current have told "
                f"{known.drop_V:.3g} V, and a wrong part for the resistance with it: the swing takes too "
                f"little current to tell them apart"
            )
    return found


def unexplained(balance: FluxBalance, block: Block, known: Known) -> Mapping[str, float]:
    """Return by how much the voltage that no parameter explains may move each estimate of a flux balance.

    It is along the current, or the EMF, or takes part in dead time's, as much as anywhere else. Whatever
    makes it depends on speed and current, and may be another in each half of a swing. An inductance may be
    off by as much as a balance may leave unexplained at all: the voltage of a law whose ripple tells it is
    nearly all across it.
    """
    motor, omega_m = known.identified, block.column("omega_m")
    turns = np.sign(omega_m[np.abs(omega_m) > _REVERSED * np.max(np.abs(omega_m))])
    halves = 1 + int(np.count_nonzero(np.diff(turns)))
    omega_e = motor.pole_pairs * float(np.sqrt(np.mean(omega_m**2)))
    left_V = balance.unexplained_V / math.sqrt(halves)
    left_Wb = left_V / omega_e if omega_e > 0.0 else math.inf
    return {
        "flux_balance_R_s": left_V / balance.current_A,
        "flux_balance_psi_r": left_Wb,
        "flux_balance_encoder_offset": left_Wb / motor.psi_r_Wb,
        _DEAD_TIME: left_V * math.pi / 4.0,  # the fundamental of which is that
        "flux_balance_L_d": motor.L_d_H * UNEXPLAINED / math.sqrt(3.0),
        "flux_balance_L_q": motor.L_q_H * UNEXPLAINED / math.sqrt(3.0),
    }


def _with_unexplained(each: Measurement, left: Mapping[str, float]) -> Measurement:
    """Return an estimate with what is left unexplained in its uncertainty."""
    if each.uncertainty is None or each.name not in left:
        return each
    return _with_line(each, Contribution("voltage left unexplained", "B", left[each.name]))


def _by_ripple(each: Measurement, known: Known) -> Measurement:
    """Return an estimate; an inductance is undefined with a law that modulates, whose ripple tells it not."""
    if each.name not in _OF_RIPPLE or known.vector_A > 0.0 or not math.isfinite(each.value):
        return each
    reason = f"the ripple of the law {known.law} is too small to tell it: the step inductance does"
    return Measurement.undefined(each.name, each.unit, each.definition, reason, each.basis)


def _with_flux(each: Measurement, known: Known) -> Measurement:
    """Return an estimate; an inertia with the uncertainty of the rotor flux, which makes the torque."""
    psi_r = known.estimates.get("psi_r")
    if each.name != "motion_balance_J" or psi_r is None or psi_r.uncertainty is None:
        return each
    return _with_line(each, psi_r.uncertainty.line("rotor flux of its own step", each.value / psi_r.value))


def _with_line(each: Measurement, line: Contribution) -> Measurement:
    if each.uncertainty is None:
        return each
    return replace(each, uncertainty=each.uncertainty.with_instruments([line]))


def _beside_harmonics(each: Measurement, known: Known) -> Measurement:
    """Return an estimate; a friction is undefined where the rotor flux has harmonics, which drive currents
    that brake the shaft."""
    if each.name not in _BRAKED or not math.isfinite(each.value) or not any(known.flux_harmonics_told):
        return each
    reason = "harmonics of the rotor flux brake the shaft, which this balance takes for friction"
    return Measurement.undefined(each.name, each.unit, each.definition, reason, each.basis)


def _beside(found: Mapping[str, Measurement], known: Known) -> tuple[Deviation, ...]:
    """Return the estimates of the balances beside those of the steps; the angle of the encoder, which the
    drive corrects, is to be 0. An inertia that no step told is the nameplate's, and not compared.

    Inductances are told by the ripple of the current. That of a law which modulates is too small: they came
    out 5 % off and more, with an uncertainty of less.
    """
    motor = known.identified
    believed = {
        "R_s": motor.R_s_ohm,
        "L_d": motor.L_d_H,
        "L_q": motor.L_q_H,
        "psi_r": motor.psi_r_Wb,
        "J": motor.J_kgm2,
    }
    names = {f"flux_balance_{name}" for name in _ELECTRICAL}
    if math.isfinite(known.value("J", math.nan)):
        names.add("motion_balance_J")
    told = [each for name, each in found.items() if name in names]
    return deviations(told, believed, motor, known.u_dc_V)


def _near_zero(name: str, known: Known, current_A: float, omega_m_rad_s: float) -> float:
    """Return by how much dead time, near zero current, makes a balance differ that takes all of it there: a
    resistance too large at the rms current of the swing, or what is across the rotor flux at its speed."""
    if name == "R_s":
        return _NEAR_ZERO * abs(known.drop_fundamental_V) / current_A
    if name == "psi_r":
        return ACROSS * abs(known.drop_fundamental_V) / (known.pole_pairs * omega_m_rad_s)
    return 0.0


def _combined(each: Deviation, known: Known, current_A: float) -> Uncertainty | None:
    """Return the uncertainty of the difference of the two estimates of one quantity, from a swing of some rms
    current.

    An inertia may be off by what the mean current within a period differs from the samples at its ends, with
    dead time that acts near one of them.
    """
    motor = known.identified
    L_H = 0.5 * (motor.L_d_H + motor.L_q_H)
    moved_A = _MOVED * abs(known.drop_V) * known.control_period_s / L_H
    left_out = moved_A / current_A * abs(each.estimate.value) if each.name == "J" else 0.0
    return of_two(each.estimate, known.estimates.get(each.name), left_out)
