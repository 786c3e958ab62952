"""The stimulus objects in front of the core's stimulus: checked as a whole when it is started."""

from __future__ import annotations

import math

from benchtool.emulator.control.stimulus import Frame, Quantity, Shape, StimulusState, feedback, halt
from benchtool.emulator.core.core import Core
from benchtool.emulator.firmware.objects import ObjectStore, Refused
from benchtool.protocol import Mode
from benchtool.protocol.canopen import Abort
from benchtool.protocol.dictionary import Number

_START = 1
_MODES = {
    Quantity.TORQUE: (Mode.TORQUE,),
    Quantity.SPEED: (Mode.VELOCITY,),
    Quantity.D_CURRENT: (Mode.TORQUE, Mode.VELOCITY),
    Quantity.VOLTAGE: (Mode.VOLTAGE,),
    Quantity.CURRENT: (Mode.CURRENT,),
}


class StimulusObjects:
    """Object 0x2021 of one drive."""

    def __init__(self, objects: ObjectStore, core: Core) -> None:
        self._objects = objects
        self._core = core
        self._highest_Hz = (0.5 + 1e-6) / core.control_period_s
        objects.check("stimulus_control", self._check_control)
        objects.on_write("stimulus_control", self._control)
        objects.compute("stimulus_state", lambda: int(core.stimulus.state))
        objects.compute("stimulus_start_tick", lambda: int(core.stimulus.start_tick))

    def stop(self) -> None:
        """End what plays; the signal is zero from the next tick on."""
        halt(self._core.stimulus)

    def _control(self, raw: Number) -> None:
        if raw == _START:
            self._take_over()
        else:
            self.stop()

    def _check_control(self, raw: Number) -> None:
        if raw != _START:
            return
        command, objects = self._core.command, self._objects
        running = self._core.stimulus.state == StimulusState.RUNNING
        if running or not command.pwm_enabled or command.quick_stop or command.halt:
            raise Refused(Abort.DEVICE_STATE)
        quantity, shape = Quantity(int(objects["stimulus_quantity"])), Shape(int(objects["stimulus_shape"]))
        if Mode(int(command.mode)) not in _MODES[quantity] or not self._is_consistent(shape):
            raise Refused(Abort.PARAMETER_INCOMPATIBLE)
        if abs(objects["stimulus_offset"]) + abs(objects["stimulus_amplitude"]) > self._limit(quantity):
            raise Refused(Abort.VALUE_HIGH)

    def _limit(self, quantity: Quantity) -> float:
        """Return what the stimulus may reach; a speed adds to the setpoint."""
        objects = self._objects
        match quantity:
            case Quantity.TORQUE:
                return objects["torque_limit"]
            case Quantity.SPEED:
                return objects["omega_m_trip"] - abs(objects["omega_m_command"])
            case Quantity.D_CURRENT | Quantity.CURRENT:
                return objects["i_trip"]
            case Quantity.VOLTAGE:
                return objects["u_dc"] / math.sqrt(3.0)

    def _is_consistent(self, shape: Shape) -> bool:
        """Return whether the entries that this shape uses go together."""
        objects = self._objects
        frequencies = objects["stimulus_frequency_start"], objects["stimulus_frequency_end"]
        match shape:
            case Shape.SINE:
                return frequencies[0] <= self._highest_Hz
            case Shape.CHIRP_LINEAR:
                return max(frequencies) <= self._highest_Hz
            case Shape.CHIRP_LOGARITHMIC:
                return min(frequencies) > 0 and max(frequencies) <= self._highest_Hz
            case Shape.PRBS:
                return bool(int(objects["stimulus_seed"]) & (1 << int(objects["stimulus_prbs_length"])) - 1)
            case Shape.STAIRCASE:
                return objects["stimulus_steps"] <= objects["stimulus_ticks"]
        return True

    def _take_over(self) -> None:
        objects, stimulus = self._objects, self._core.stimulus
        length, angle = int(objects["stimulus_prbs_length"]), objects["stimulus_angle"]
        stimulus.quantity = objects["stimulus_quantity"]
        stimulus.kind = objects["stimulus_shape"]
        stimulus.amplitude, stimulus.offset = objects["stimulus_amplitude"], objects["stimulus_offset"]
        stimulus.ticks, stimulus.repetitions = objects["stimulus_ticks"], objects["stimulus_repetitions"]
        stimulus.f_start = objects["stimulus_frequency_start"]
        stimulus.f_end = objects["stimulus_frequency_end"]
        stimulus.T_s = self._core.control_period_s
        stimulus.steps = objects["stimulus_steps"]
        stimulus.clock = objects["stimulus_prbs_clock"]
        stimulus.length, stimulus.mask = length, feedback(length)
        stimulus.seed = int(objects["stimulus_seed"]) & (1 << length) - 1
        stimulus.in_rotor_frame = objects["stimulus_frame"] == Frame.ROTOR
        stimulus.cos_angle, stimulus.sin_angle = math.cos(angle), math.sin(angle)
        stimulus.angle = angle
        stimulus.turn = objects["stimulus_omega_e"] * self._core.control_period_s
        stimulus.turn_ticks = objects["stimulus_turn_ticks"]
        stimulus.k = stimulus.played = 0
        stimulus.state = StimulusState.RUNNING
