"""A profile as a TOML file that a person goes on with: every key of a first day, with unit and meaning."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from benchtool.document import commented_table
from benchtool.profile.derivation import Derived, Given
from benchtool.profile.motor import Motor

_ADC_BITS = 12
_HEADROOM = 1.05  # of the converter's range over the trip level
_HEAD: Final = """\
# A profile: a motor, its drive, and the bench they stand on.
# Numbers are in SI units; each key ends in its unit. What stands behind a # may be left out.
#
#   benchtool plan new ripple.toml --profile THIS-FILE     a first test of it
#   benchtool run ripple.toml                              on the emulated bench
#   benchtool run ripple.toml --link can:socketcan:can0    on the drive
"""
_SENSORS: Final = """
# [emulator.sensors.i_a]      # what is wrong with the sensor of a phase; of the others likewise: i_b, i_c
# gain = 1.01
# offset_A = 0.02             # A
# bandwidth_Hz = 100e3        # Hz: 3 dB
# delay_s = 1e-6              # s
#
# [emulator.sensors.u_dc]     # of the dc link
# gain = 0.99
#
# [emulator.sensors.encoder]  # of the encoder
# relative = true             # it counts from zero at power-up,
# index = true                # and from the zero of its disc once that has passed
# eccentricity_1_rad = 1e-3   # rad: error of its position once in a revolution
#
# [emulator.sensors.temperature]
# lag_s = 20.0                # s: time constant of the thermometers
"""
_HEAT: Final = {
    "C_winding_J_K": 100.0,
    "C_body_J_K": 800.0,
    "R_winding_body_K_W": 0.5,
    "R_body_ambient_K_W": 1.5,
}
_BENCH: Final = """
# What stands beside the drive. What is left out is emulated on an emulated bench, and absent on a real one.
#
# [bench.load]
# kind = "operator"           # asked to load the shaft before the drive is enabled; or "emulated"
#
# [bench.channels.i_a]        # the sensor of a channel, which enters the uncertainty of measurements
# gain_limit_percent = 0.5    # %: limits of error of a data sheet; gain_U_percent of a certificate
# offset_limit_A = 0.02       # A
# resolution_A = 0.005        # A: a step of the converter
# bandwidth_Hz = 50e3         # Hz: 3 dB
#
# [bench.channels.u_dc]       # at rest it reads the same in every sample, which does not show its step:
# resolution_V = RESOLUTION   # V: range / 2^bits, here of the emulated converter; u_dc has no ± without
"""


def _flux_linkages(motor: Motor) -> dict[str, tuple[float, ...] | tuple[tuple[float, ...], ...]]:
    """Return the smallest table of flux linkages, of a machine that does not saturate."""
    currents = tuple(each * math.sqrt(2.0) * motor.I_N_A_rms for each in (-1.0, -0.5, 0.0, 0.5, 1.0))
    return {
        "i_d_A": currents,
        "i_q_A": currents,
        "psi_d_Wb": tuple(tuple(motor.psi_r_Wb + motor.L_d_H * i_d for _ in currents) for i_d in currents),
        "psi_q_Wb": tuple(tuple(motor.L_q_H * i_q for i_q in currents) for _ in currents),
    }


def profile_text(title: str, motor: Motor, given: Given, derived: Iterable[Derived]) -> str:
    """Return a profile of this motor, whose drive has the derived parameters, with an emulated bench to suit.

    The emulated machine is as `[motor]` states it, its sensors reach beyond the trip levels.
    """
    parameters = tuple(derived)
    i_trip_A = next(float(each.value) for each in parameters if each.key == "i_trip_A")
    u_dc_max_V = next(float(each.value) for each in parameters if each.key == "u_dc_max_V")
    i_full_scale_A, u_full_scale_V = _HEADROOM * i_trip_A, _HEADROOM * u_dc_max_V
    bench = _BENCH.replace("RESOLUTION", f"{u_full_scale_V / 2**_ADC_BITS:.6g}")
    p = motor.pole_pairs
    psi_q_Wb = motor.L_q_H * math.sqrt(2.0) * motor.I_N_A_rms
    saturation = {"a_qq": 0.1 / (motor.L_q_H * psi_q_Wb), "T": 1}
    f_e_Hz = p * motor.omega_m_N_rad_s / (2.0 * math.pi)
    sections = (
        commented_table("", [("title", title, "what a report calls the motor and its bench")]),
        commented_table(
            "motor",
            [
                ("pole_pairs", p, "p, half of the number of magnets"),
                ("R_s_ohm", motor.R_s_ohm, "ohm: stator resistance per phase, half of that of two terminals"),
                ("L_d_H", motor.L_d_H, "H: inductance in the direct axis, per phase"),
                ("L_q_H", motor.L_q_H, "H: in the quadrature axis; as L_d for surface magnets"),
                ("psi_r_Wb", motor.psi_r_Wb, "Wb: flux linkage of the magnets, peak: e = p omega_m psi_r"),
                ("J_kgm2", motor.J_kgm2, "kgm2: moment of inertia of the rotor and what is coupled to it"),
                ("T_N_Nm", motor.T_N_Nm, "Nm: rated torque; setpoints beyond it are refused"),
                (
                    "omega_m_N_rad_s",
                    motor.omega_m_N_rad_s,
                    f"rad/s: rated mechanical speed, {motor.omega_m_N_rad_s * 30.0 / math.pi:.4g} rpm, "
                    f"{f_e_Hz:.4g} Hz electrical",
                ),
                ("I_N_A_rms", motor.I_N_A_rms, "A: rated phase current, rms"),
                ("#slots", 12, "stator slots, which name orders of cogging torque"),
            ],
        ),
        commented_table(
            "drive",
            [
                ("node_id", 1, "CANopen node id, 1 to 126"),
                ("eds", "drive.eds", "object dictionary: a file beside this one, or one that ships"),
                ("#allow_unsupervised", False, "true: enable a drive that cannot supervise its link"),
                ("#link_timeout_s", 0.5, "s: without a heartbeat of the host, in which the torque is to end"),
                ("#prove_watchdog", False, "true: have the drive show that it notices a silent host"),
                ("#index_search_A", 1.0, "turn the shaft until the encoder's index passed, before enabling"),
                (
                    "control_period_s",
                    given.control_period_s,
                    f"s: T_s of its control, {1e-3 / given.control_period_s:.4g} kHz",
                ),
                ("#on_resistance_ohm", 0.002, "ohm: of a conducting device by its data sheet, with cable"),
                (
                    "pwm_period_s" if given.double_update else "#pwm_period_s",
                    2.0 * given.control_period_s,
                    "s: of the PWM, if that is not T_s but twice as long (double update)",
                ),
            ],
        ),
        commented_table("drive.parameters", [(each.key, each.value, each.rule) for each in parameters]),
        commented_table(
            "emulator.motor",
            [
                ("#R_s_ohm", motor.R_s_ohm * 1.2, "ohm: the true machine, where it differs from [motor]"),
                ("friction_Nms", 0.0, "Nms/rad: viscous friction"),
                ("coulomb_Nm", 0.0, "Nm: dry friction of the turning shaft"),
                ("#breakaway_Nm", 0.0, "Nm: torque up to which a shaft at rest stays at rest"),
                ("#stribeck_rad_s", 0.0, "rad/s: over which friction falls from the one to the other"),
                ("cogging_Nm", 0.0, "Nm: peak of the cogging torque"),
                ("cogging_order", 0, "its periods per revolution: lcm of slots and 2 p"),
                ("cogging_phase_rad", 0.0, "its phase; several orders: arrays of all three"),
                ("#psi_5_Wb", 1e-3 * motor.psi_r_Wb, "Wb: fifth harmonic of the rotor flux of phase a"),
                ("#psi_7_Wb", -1e-3 * motor.psi_r_Wb, "Wb: seventh"),
                ("#psi_11_Wb", 2e-4 * motor.psi_r_Wb, "Wb: eleventh"),
                ("#psi_13_Wb", 1e-4 * motor.psi_r_Wb, "Wb: thirteenth"),
                ("#psi_of_phase", (1.0, 1.01, 0.99), "of a, b, c: how they link the rotor flux"),
                ("#series_R_ohm", (0.0, 0.05 * motor.R_s_ohm, 0.0), "ohm: in series with a, b, c"),
                ("#series_L_H", (0.0, 0.01 * motor.L_d_H, 0.0), "H: in series with a, b, c"),
                ("#R_fe_ohm", 1e3 * motor.R_s_ohm, "ohm: across the EMF, for the iron loss"),
                ("#heat", _HEAT, "of winding and magnets"),
                ("#saturation", saturation, "currents over flux linkages: a tenth more i_q at I_N"),
                ("#flux_linkages", _flux_linkages(motor), "the same as a table, instead: rows are of i_d"),
                ("#power_up_angle_rad", 0.5, "rad: mechanical angle of the shaft at power-up"),
            ],
        ),
        commented_table(
            "emulator.inverter",
            [
                ("u_dc_V", given.u_dc_V, "V: voltage of the dc link"),
                ("dc_link_R_ohm", 0.0, "ohm: resistance it stands behind"),
                ("dead_time_s", given.dead_time_s, "s: between the switches of a leg"),
                ("device_drop_V", 0.0, "V: forward voltage of a conducting device"),
                ("on_resistance_ohm", 0.0, "ohm: resistance of a conducting device"),
                ("#timer_Hz", 100e6, "Hz: clock of the PWM timer, whose steps the duties have"),
                ("#dc_link_C_F", 1e-3, "F: capacitor of the dc link, which braking pumps up"),
                ("#supply_ripple_V", 0.0, "V: amplitude of the supply's ripple"),
                ("#supply_ripple_Hz", 300.0, "Hz: its frequency"),
                ("#chopper_R_ohm", 20.0, "ohm: brake chopper across the capacitor"),
                ("#chopper_on_V", 1.2 * given.u_dc_V, "V: where it switches on"),
                ("#chopper_off_V", 1.15 * given.u_dc_V, "V: where it switches off"),
            ],
        ),
        commented_table(
            "emulator.sensors",
            [
                ("adc_bits", _ADC_BITS, "bits of the converters"),
                ("i_full_scale_A", i_full_scale_A, "A: end of the range of the phase currents, above i_trip"),
                ("u_full_scale_V", u_full_scale_V, "V: end of the range of u_dc, above u_dc_max"),
                (
                    "current_noise_A_rms",
                    2.0 * i_full_scale_A / 2**_ADC_BITS,
                    "A: noise of a phase current, rms; here one step of the converter",
                ),
                ("encoder_lines", given.encoder_lines, "lines per revolution, four counts each"),
                ("encoder_offset_rad", 0.0, "rad: mechanical angle of its zero to the rotor flux"),
                ("#sampling_point", 1.0, "of the PWM period: where the currents are sampled"),
                ("#shunt_settling_s", 1e-6, "s: of shunts in the lower legs, after their switches"),
                ("#warm_up_K", 20.0, "K: by which the current sensors warm up, for their drifts"),
                ("#warm_up_s", 600.0, "s: time constant of that"),
            ],
        ),
    )
    return f"{_HEAD}\n{chr(10).join(sections)}{_SENSORS}{bench}"
