"""Records shared by firmware, control and capture: the drive's memory and others.

Every record is a structured array of shape (1,); element 0 has its fields as attributes, in Python as in
compiled code, and writes go through to the array.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.protocol.dictionary import ObjectTable

Record = np.ndarray[Any, np.dtype[Any]]


def record_type(fields: list[tuple[str, Any]]) -> np.dtype[Any]:
    """Aligned structured type with attribute access."""
    return np.dtype((np.record, np.dtype(fields, align=True)))


def new_memory(table: ObjectTable) -> Record:
    """Return the drive's memory at power-up, shape (1,): a field for every number of the table, with its
    default."""
    entries = [(entry, entry.type.numpy) for entry in table if entry.type.numpy is not None]
    memory = np.zeros(1, record_type([(entry.name, dtype) for entry, dtype in entries]))
    for entry, _ in entries:
        if isinstance(entry.default, int | float):
            memory[entry.name] = entry.default
    return memory


def words(memory: Record) -> NDArray[np.uint32]:
    """Return the memory as 32-bit words, sharing storage; a four-byte field is the word at its offset / 4."""
    return memory.view(np.uint32)


def word_offset(memory: Record, name: str) -> int:
    """Return which word of `words(memory)` a four-byte field is."""
    fields = memory.dtype.fields
    assert fields is not None
    return int(fields[name][1]) // 4


# Commands of the firmware to control, and the replies of control.
COMMAND = record_type(
    [
        ("mode", "i4"),  # a `Mode`, as object 0x6060
        ("pwm_enabled", "u4"),
        ("quick_stop", "u4"),  # brake to standstill, whatever the setpoint
        ("off_at_standstill", "u4"),  # and switch the power stage off there, else hold it
        ("halt", "u4"),  # stand still, or make no torque, for as long as this is set
        ("trip", "u4"),  # mask of `Trip`, latched by control, cleared by the firmware
        ("standstill", "u4"),  # a quick stop or a halt has come to that
        ("calibration", "i4"),  # of the current sensors: a `CalibrationState`
        ("calibration_left", "i8"),  # ticks
        ("calibration_ticks", "i8"),
        ("sum_a", "f8"),  # of what the sensors read in them, in A
        ("sum_b", "f8"),
        ("sum_c", "f8"),
    ]
)

# A stimulus as it was taken over from its table, and how far it has come.
STIMULUS = record_type(
    [
        ("state", "i8"),  # a `StimulusState`
        ("quantity", "i8"),
        ("kind", "i8"),  # a `Shape`; a record's `shape` is something else
        ("amplitude", "f8"),
        ("offset", "f8"),
        ("ticks", "i8"),  # of one repetition
        ("repetitions", "i8"),
        ("f_start", "f8"),
        ("f_end", "f8"),
        ("T_s", "f8"),
        ("steps", "i8"),
        ("clock", "i8"),  # ticks per bit of a binary sequence
        ("mask", "i8"),  # of its feedback
        ("length", "i8"),
        ("seed", "i8"),
        ("in_rotor_frame", "i8"),
        ("cos_angle", "f8"),
        ("sin_angle", "f8"),
        ("angle", "f8"),  # at the start, against phase a
        ("turn", "f8"),  # electrical, per tick
        ("turn_ticks", "i8"),  # over which it comes up to that
        ("k", "i8"),  # tick within the repetition that is next
        ("played", "i8"),  # repetitions
        ("register", "i8"),
        ("began", "i8"),  # in this very tick
        ("start_tick", "i8"),
    ]
)

# State of the control from tick to tick. `*_next` waits in the PWM unit's shadow registers for a tick.
CONTROL = record_type(
    [
        ("angles", "i8"),  # that the observer has seen while it begins
        ("gated", "u4"),
        ("gated_next", "u4"),
        ("theta_m", "f8"),
        ("omega_m", "f8"),
        ("acceleration", "f8"),  # by disturbances: the load
        ("speed_integral", "f8"),
        ("heat", "f8"),  # of the winding, by I2t
        ("u_alpha", "f8"),
        ("u_beta", "f8"),
        ("u_alpha_next", "f8"),
        ("u_beta_next", "f8"),
        ("duty_a", "f8"),
        ("duty_b", "f8"),
        ("duty_c", "f8"),
        ("duty_a_next", "f8"),
        ("duty_b_next", "f8"),
        ("duty_c_next", "f8"),
        # Of a quick stop or a halt, see `braking`.
        ("braking", "i8"),  # ticks so far
        ("braking_theta", "f8"),
        ("braking_omega", "f8"),
        ("braking_sign", "f8"),  # of the speed that is braked
        ("torque_lag_1", "f8"),
        ("torque_lag_2", "f8"),
        ("load", "f8"),
        ("turned_ticks", "i8"),
        ("rest_ticks", "i8"),
        ("limited", "u4"),  # the voltage computed last was beyond the hexagon
        ("injecting", "u4"),  # the current mode ran last, no law
        # Of the laws, cleared while the power stage is off.
        ("torque_state", "i4"),
        ("flux_state", "i4"),
        ("flux_error_sum", "f8"),
        ("delta_integral", "f8"),
        ("u_d_integral", "f8"),
        ("u_q_integral", "f8"),
        ("u_alpha_asked", "f8"),
        ("u_beta_asked", "f8"),
    ]
)

# One set of samples, in the units control computes with; `count` is the encoder's position in a revolution.
MEASUREMENT = record_type(
    [
        ("i_a", "f8"),
        ("i_b", "f8"),
        ("i_c", "f8"),
        ("u_dc", "f8"),
        ("count", "i8"),
        ("saturated", "u4"),  # currents at either end of the range
        ("u_dc_saturated", "u4"),  # at its upper end
    ]
)

# The true state of the machine; control never sees it.
SHAFT = record_type(
    [
        ("i_d", "f8"),
        ("i_q", "f8"),
        ("psi_d", "f8"),  # of a machine that saturates
        ("psi_q", "f8"),
        ("omega_m", "f8"),
        ("theta_e", "f8"),  # never wrapped
        ("cos_theta", "f8"),
        ("sin_theta", "f8"),
        ("u_dc", "f8"),
        ("high_a", "u4"),  # leg left high at the end of the period
        ("high_b", "u4"),
        ("high_c", "u4"),
        ("blank_a", "f8"),  # dead time that the end of the period left over, in s
        ("blank_b", "f8"),
        ("blank_c", "f8"),
        ("chopper", "u4"),  # the brake chopper is on
        ("T_winding", "f8"),  # degC, once a tick
        ("T_magnet", "f8"),
        ("omega_load", "f8"),  # of the load behind an elastic coupling
        ("twist", "f8"),  # of that coupling, theta_m - theta_load
        ("load_torque", "f8"),  # of a load machine with a lag
    ]
)

# State of the sensors, as far as theirs have one.
SENSOR = record_type(
    [
        ("warm_K", "f8"),  # current sensors above the temperature of their gains and offsets
        ("u_dc", "f8"),  # as the sensor of the dc link follows it
        ("low_a", "f8"),  # how long the lower switch was told to be on when the period ended, in s
        ("low_b", "f8"),
        ("low_c", "f8"),
        ("counting", "i8"),  # the encoder's counter has started
        ("index_passed", "u4"),  # since that
        ("found", "i8"),  # counts by which the first of them has just moved the counter
        ("edge", "i8"),  # of the disc, counted on over the revolutions
        ("error", "i8"),  # of the counter against that
        ("travelled", "i8"),  # edges in either direction
    ]
)

# The load machine on the shaft; `cycle` is the part of the cycle of torques over time that has passed.
LOAD = record_type([("torque_Nm", "f8"), ("held", "u4"), ("omega_m_rad_s", "f8"), ("cycle", "f8")])
