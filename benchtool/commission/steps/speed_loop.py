"""A motor held at a speed while it is identified: by field-oriented control and a gentle speed controller."""

from __future__ import annotations

from typing import Final

from benchtool.commission.known import Known
from benchtool.profile import Given, derived_parameters
from benchtool.protocol.dictionary import Value

FASTEST: Final = 0.4
"""Of the rated speed, at most; the drive trips at half of it."""

_TRIP = 0.5
_TORQUE = 0.5  # of the rated one
_GAINS = {
    "omega_current": "rad_s",
    "K_p_speed": "Nms_rad",
    "K_i_speed": "Nm_rad",
    "omega_observer": "rad_s",
}


def at_speed(known: Known) -> dict[str, Value]:
    """Return what the drive is to hold: what was estimated, the rules' gains for it, and limits."""
    motor = known.identified
    given = Given(known.u_dc_V, known.encoder_lines, known.control_period_s)
    derived = {each.key: each.value for each in derived_parameters(motor, given, "foc")}
    gains: dict[str, Value] = {key: derived[f"{key}_{unit}"] for key, unit in _GAINS.items()}
    return {
        "law": "foc",
        **gains,
        "psi_r": motor.psi_r_Wb,
        "J": motor.J_kgm2,
        "torque_limit": _TORQUE * known.motor.T_N_Nm,
        "omega_m_trip": _TRIP * known.motor.omega_m_N_rad_s,
        "dead_time_compensation": 0.0,
        **known.offsets,
        **known.sensor_gains,
        **known.electrical,
        **known.encoder,
    }


def settling_s(known: Known, omega_m_rad_s: float) -> float:
    """Return after which time the shaft holds a speed that it did not have, with room for a wrong inertia."""
    motor = known.identified
    gain = at_speed(known)["K_p_speed"]
    assert isinstance(gain, float)
    return 0.15 + 3.0 * motor.J_kgm2 * omega_m_rad_s / (_TORQUE * motor.T_N_Nm) + 14.0 * motor.J_kgm2 / gain
