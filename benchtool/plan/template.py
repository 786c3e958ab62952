"""A plan as a TOML file that a person goes on with: every key of a first day, with unit and meaning."""

from __future__ import annotations

import math
from typing import Final

from benchtool.document import commented_table
from benchtool.profile import Profile

_PERIODS = 10.0  # electrical ones in the record
_SHORTEST_S, _LONGEST_S = 0.1, 5.0
_INTERPOLATION_S = 0.01  # what interpolation needs at both ends, generously
_SETTLED = 30.0  # over the bandwidth of the speed loop, whose poles are at half of it
_CHANNELS: Final = (
    *("i_a", "i_b", "i_c", "torque", "torque_reference", "psi_s", "psi_alpha", "psi_beta"),
    *("theta_m", "omega_m", "u_dc", "switching_count", "law_clipped", "adc_saturated"),
)
_HEAD: Final = """\
# A test plan: what to set up, where to run, what to record, what to measure, and the limits.
# Numbers are in SI units; each key ends in its unit. What stands behind a # may be left out.
#
#   benchtool run THIS-FILE --dry-run                      what would be sent and recorded; nothing is
#   benchtool run THIS-FILE                                on the emulated bench
#   benchtool run THIS-FILE --set omega_m=500rpm           with a value changed for this run
"""
_REST: Final = """
# [case_limits.foc]                         # limits of one case, by its name
# torque_ripple_pp_Nm = { max = 0.1 }
#
# [sweep.operating_point]                   # every combination is a case
# load_torque_Nm = [0.0, 0.1]
#
# [sweep.setup]
# law = ["tpc", "foc"]
#
# [[variants]]                              # departures from the plan, each a case
# name = "warm"
# setup = { R_s_ohm = 0.17 }                # restored afterwards
#
# [emulator]                                # what differs on an emulated bench
# "inverter.dead_time_s" = 1e-6
#
# [stimulus]                                # the drive plays it and starts the record with it
# quantity = "torque"                       # torque, speed, d_current or voltage
# shape = "constant"                        # constant, step, staircase, ramp, sine, chirp_..., prbs
# amplitude_Nm = 0.1                        # in the unit of the quantity
# duration_s = 0.1                          # s
#
# [analyses]
# steady_from_s = 0.05                      # s: the steady state begins here
# step = true                               # 'benchtool analyze --list' has them all
"""


def plan_text(title: str, profile_name: str, profile: Profile) -> str:
    """Return a plan that measures the torque ripple of a profile's motor, at half its rated speed and torque.

    Args:
        title: of the plan.
        profile_name: as the plan states it: a shipped one's name, or a file relative to the plan's.
        profile: the same, as it was read.
    """
    motor = profile.motor
    omega_m = _rounded(0.5 * motor.omega_m_N_rad_s)
    period_s = 2.0 * math.pi / (motor.pole_pairs * omega_m)
    duration_s = min(max(_PERIODS * period_s, _SHORTEST_S), _LONGEST_S) + _INTERPOLATION_S
    sections = (
        commented_table(
            "",
            [
                ("title", title, ""),
                ("profile", profile_name, "name of a shipped one, or a TOML file relative to this one"),
                ("case", "ripple", "name of the only case"),
                ("#repetitions", 3, "of every case"),
                ("#judge", "mean", "what limits hold for: each repetition, their mean, the worst"),
            ],
        ),
        commented_table(
            "setup",
            [("#law", "foc", "parameters of the drive, see 'benchtool params list'; restored afterwards")],
        ),
        commented_table(
            "operating_point",
            [
                ("mode", "velocity", "or torque, with torque_Nm and the speed that the load machine holds"),
                ("omega_m_rad_s", omega_m, f"rad/s, mechanical: {omega_m * 30.0 / math.pi:.4g} rpm"),
                ("load_torque_Nm", _rounded(0.5 * motor.T_N_Nm), "Nm: load on the shaft"),
                ("#torque_Nm", _rounded(0.5 * motor.T_N_Nm), "Nm: setpoint of torque mode"),
                ("#hold_speed_rad_s", omega_m, "rad/s: speed of the shaft in torque mode"),
                ("settle_s", _settling_s(profile), "s: from the setpoint to the record"),
            ],
        ),
        commented_table(
            "record",
            [
                (
                    "duration_s",
                    _rounded(duration_s),
                    f"s: an electrical period is {period_s:.3g} s, five tell every uncertainty",
                ),
                ("#stride", 1, "control periods per row"),
                ("#pretrigger_s", 0.01, "s: what is kept before a stimulus"),
                ("channels", _CHANNELS, ""),
            ],
        ),
        commented_table(
            "limits",
            [
                ("#torque_ripple_pp_Nm", {"max": 0.1}, 'or { min = 0.0, max = 0.1, margin = "U" }'),
                ("capture_rows_missing", {"max": 0}, "of the quality of the data"),
            ],
        ),
    )  # fmt: skip
    return f"{_HEAD}\n{chr(10).join(sections)}{_REST}"


def _settling_s(profile: Profile) -> float:
    """Return the time for the speed loop, and for half of the rated torque to bring the shaft to half its
    speed."""
    motor, gain = profile.motor, profile.drive.parameters.get("K_p_speed_Nms_rad")
    started_s = motor.J_kgm2 * motor.omega_m_N_rad_s / motor.T_N_Nm
    if not isinstance(gain, int | float) or gain <= 0.0:
        return _rounded(max(1.0, 2.0 * started_s))
    return _rounded(max(0.2, 2.0 * started_s + _SETTLED * motor.J_kgm2 / gain))


def _rounded(value: float) -> float:
    """Return the to three digits, as a person would write it."""
    return float(f"{value:.3g}")
