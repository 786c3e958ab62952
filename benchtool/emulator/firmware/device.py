"""The firmware of the emulated drive: states, faults, setpoints and supervision around the control core."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

from benchtool.emulator.core.core import Core, Trip
from benchtool.emulator.firmware.calibration_objects import CalibrationObjects
from benchtool.emulator.firmware.capture_objects import CaptureObjects
from benchtool.emulator.firmware.objects import ObjectStore, Refused
from benchtool.emulator.firmware.stimulus_objects import StimulusObjects
from benchtool.emulator.firmware.supervision import LONGEST_TIMEOUT_MS, LinkState, LinkSupervision
from benchtool.protocol import Mode, State, statusword, transition
from benchtool.protocol.canopen import Abort, Emergency, ErrorCode, error_register
from benchtool.protocol.dictionary import Number, ObjectTable

_SAVE = 0x65766173
_LOAD = 0x64616F6C
_FAULT_RESET_BIT = 0x80
_HALT_BIT = 0x100
_POLL_S = 1e-3
_REACTION_TICKS = 3  # the period under way, the one that the stage is off for, and its currents' end
_HOLDING_OPTIONS = (5, 6)
_INDEX = 1  # of `encoder_reference`
_TARGETS = ("torque_command", "omega_m_command", "target_torque", "target_velocity")

_ERROR_OF_TRIP = {
    Trip.OVERCURRENT: ErrorCode.OVERCURRENT,
    Trip.OVERSPEED: ErrorCode.OVERSPEED,
    Trip.UNDERVOLTAGE: ErrorCode.DC_LINK_UNDERVOLTAGE,
    Trip.OVERVOLTAGE: ErrorCode.DC_LINK_OVERVOLTAGE,
    Trip.OVERLOAD: ErrorCode.OVERLOAD,
}


class Firmware:
    """A drive behind its dictionary; servers handle the frames.

    Args:
        table: its objects.
        core: machine, power stage and control.
        node_id: of the objects that contain it.
        stored: raw values of parameters as an earlier `store_parameters` kept them.
        emit: takes every emergency, the moment it arises.

    Attributes:
        hung: communication and supervision stand still, while control runs on with its last command.
        encoder_connected: what the receiver of the encoder's signals tells.
        thermal_switch_closed: of the switch in the motor's winding.
    """

    def __init__(
        self,
        table: ObjectTable,
        core: Core,
        node_id: int,
        stored: Mapping[str, Number],
        emit: Callable[[Emergency], None],
    ) -> None:
        self.core = core
        self.supervision = LinkSupervision(_REACTION_TICKS * core.control_period_s)
        self.objects = ObjectStore(table, core.memory, lambda: self.state.power_stage_on)
        self.state = State.SWITCH_ON_DISABLED
        self.hung = False
        self.encoder_connected = self.thermal_switch_closed = True
        self._node_id = node_id
        self._stored = dict(stored)
        self._emit = emit
        self._controlword = 0
        self._history: list[int] = []
        self.period_s = core.control_period_s
        self._capture = CaptureObjects(self.objects, core)
        self._stimulus = StimulusObjects(self.objects, core)
        self._calibration = CalibrationObjects(self.objects, core)
        self._wire_objects()
        self.reset()

    @property
    def now_s(self) -> float:
        """Drive time: ticks since power-up times the control period."""
        return (self.core.tick - self.core.first_tick) * self.period_s

    def reset(self) -> None:
        """Start afresh, as after NMT reset node: power stage off, stored parameters in force."""
        self._enter(State.SWITCH_ON_DISABLED)
        self._controlword = self.core.command.halt = 0
        self.hung = False
        for entry in self.objects.table:
            if entry.role != "signal" and isinstance(entry.default, int | float):
                offset = self._node_id if entry.add_node_id else 0
                self.objects[entry.name] = entry.default + offset
        self.objects["dictionary_hash"] = self.objects.table.hash
        self.objects["i_full_scale"] = self.core.sensors.i_full_scale_A
        self.objects["u_dc_full_scale"] = self.core.sensors.u_full_scale_V
        self.objects["control_period"] = self.period_s
        self.objects["pwm_period"] = self.core.inverter.pwm_period_s(self.period_s)
        self._history.clear()
        self._capture.abort()
        self._calibration.stop()
        self.core.command.trip = 0
        self.core.restart_counter()
        self.supervision.configure(0)
        parameters_accepted = self._load_parameters()
        self._set_mode(self.objects["mode_of_operation"])
        if not parameters_accepted:
            self._fault(ErrorCode.PARAMETER)

    def _load_parameters(self) -> bool:
        """Put the stored parameters in force. Returns whether the drive accepts them all.

        What is beyond its limits, such as the trip level of a larger converter, stays at its default.
        """
        for name, raw in self._stored.items():
            self.objects[name] = raw
        refused = [name for name in self._stored if not self.objects.is_acceptable(name)]
        every = [entry.name for entry in self.objects.table if entry.role == "parameter"]
        for _ in range(2):  # what was cut may limit another
            for name in (*refused, *(name for name in every if name not in self._stored)):
                self.objects.load(name)
        return not refused

    def feed_link(self) -> None:
        """The host was heard: its heartbeat or a setpoint frame."""
        self.supervision.feed(self.now_s)

    def stop(self) -> None:
        """Switch the power stage off without a fault and clear the targets, as NMT stop does."""
        if self.state.power_stage_on:
            self._enter(State.SWITCH_ON_DISABLED)
        self._clear_targets()

    def advance_to(self, tick: int) -> None:
        """Run control and machine up to a drive tick, counted on past 2**32."""
        while (present := self.core.tick) < tick:
            ahead = tick - present
            if self.hung:
                self.core.run(ahead)
                continue
            if self.state is State.QUICK_STOP_ACTIVE or self._failed_input() is not None:
                ahead = min(ahead, math.ceil(_POLL_S / self.period_s))
            if (left_s := self.supervision.deadline_s() - self.now_s) < math.inf:
                ahead = min(ahead, max(1, round(left_s / self.period_s)))
            self.core.run(ahead)
            self.objects["winding_temperature"] = self.core.winding_degC
            self._supervise()

    # ---- after every run of the core -------------------------------------------------------------------

    def _supervise(self) -> None:
        if self.core.command.trip and self.state is not State.FAULT:
            trips = int(self.core.command.trip)
            first = next(trip for trip in Trip if trips & trip)
            self._fault(_ERROR_OF_TRIP[first])
        if (failed := self._failed_input()) is not None:
            self._fault(failed)
        if self._at_the_end_of_a_quick_stop() and self.core.command.off_at_standstill:
            self._enter(State.SWITCH_ON_DISABLED)
        if self.supervision.expire(self.now_s + 0.5 * self.period_s):
            self._lose_link()
        if self.objects["parameter_trial"] and self.supervision.state is LinkState.LOST:
            self._end_trial()

    def _end_trial(self) -> None:
        """Put the stored parameters in force, whose host tried others and is gone."""
        if not self.state.power_stage_on:
            self.objects["parameter_trial"] = 0
            self._load_parameters()

    def _check_trial(self, raw: Number) -> None:
        if raw and self.supervision.state is not LinkState.ALIVE:
            raise Refused(Abort.DEVICE_STATE)

    def _failed_input(self) -> ErrorCode | None:
        """Return the error of an input that has opened; None while the drive is in fault already."""
        if self.state is State.FAULT:
            return None
        if not self.encoder_connected:
            return ErrorCode.ENCODER
        cool = self.objects["winding_temperature"] <= self.objects["temperature_trip"]
        return None if cool and self.thermal_switch_closed else ErrorCode.TEMPERATURE

    def _fault(self, code: ErrorCode) -> None:
        self.report(code)
        self._enter(State.FAULT)
        self._clear_targets()

    def report(self, code: ErrorCode) -> None:
        """Report an error, or that there is none any more; the state stays."""
        self.objects["error_code"] = int(code)
        if code is not ErrorCode.NO_ERROR:
            self._history = [int(code), *self._history][:8]
        self.objects["error_register"] = error_register(code)
        self._emit(Emergency(int(code), error_register(code)))

    def _lose_link(self) -> None:
        action = int(self.objects["abort_connection_option"])
        if action == 1:
            self._fault(ErrorCode.HEARTBEAT)
            return
        self.report(ErrorCode.HEARTBEAT)
        self._clear_targets()
        if action == 2:
            self.stop()
        elif action == 3 and self.state.power_stage_on:
            self._quick_stop(hold=False)  # no host is left that could end a hold

    def _clear_targets(self) -> None:
        """Clear the targets, so that the next start waits for a new command."""
        for name in _TARGETS:
            self.objects[name] = 0

    # ---- state machine ---------------------------------------------------------------------------------

    def _control(self, raw: Number) -> None:
        word = int(raw)
        before, self._controlword = self._controlword, word
        reset_edge = bool(word & _FAULT_RESET_BIT and not before & _FAULT_RESET_BIT)
        if reset_edge and self.supervision.state is LinkState.LOST:
            self.supervision.rearm()
            if self.state is not State.FAULT:
                self.report(ErrorCode.NO_ERROR)
        self._set_halt(bool(word & _HALT_BIT))
        after = transition(self.state, word, before)
        if after is self.state:
            return
        if self.state is State.FAULT:
            self.core.command.trip = 0
            self.report(ErrorCode.NO_ERROR)
        if after is State.QUICK_STOP_ACTIVE:
            self._quick_stop()
        else:
            self._enter(after)

    def _check_control(self, raw: Number) -> None:
        after = transition(self.state, int(raw), self._controlword)
        if after is not State.OPERATION_ENABLED or self.state is after:
            return
        if not self.supervision.may_enable or self._lacks_angle(self.core.command.mode):
            raise Refused(Abort.DEVICE_STATE)

    def _angle_known(self) -> bool:
        return self.objects["encoder_reference"] != _INDEX or self.core.index_passed

    def _lacks_angle(self, mode: int) -> bool:
        return Mode(mode).needs_rotor_angle and not self._angle_known()

    def _check_mode(self, raw: Number) -> None:
        if self.state.power_stage_on and self._lacks_angle(int(raw)):
            raise Refused(Abort.DEVICE_STATE)

    def _set_halt(self, halted: bool) -> None:
        self.core.command.halt = halted
        if halted:
            self._stimulus.stop()

    def _quick_stop(self, *, hold: bool = True) -> None:
        """Brake to standstill, and hold it if the option says so and `hold` permits."""
        option = self.objects["quick_stop_option"]
        if option == 0 or not self._angle_known():  # it would brake against the wrong angle
            self._enter(State.SWITCH_ON_DISABLED)
            return
        self._stimulus.stop()
        self.core.command.off_at_standstill = not (hold and option in _HOLDING_OPTIONS)
        self.core.command.standstill = 0  # the standstill of a halt does not end a quick stop
        self.core.command.quick_stop = 1
        self.state = State.QUICK_STOP_ACTIVE

    def _at_the_end_of_a_quick_stop(self) -> bool:
        return self.state is State.QUICK_STOP_ACTIVE and bool(self.core.command.standstill)

    def _enter(self, state: State) -> None:
        """Take a state; a stimulus does not outlive the power stage, targets do."""
        self.state = state
        self.core.command.pwm_enabled = state is State.OPERATION_ENABLED
        self.core.command.quick_stop = self.core.command.standstill = 0
        if state is not State.OPERATION_ENABLED:
            self._stimulus.stop()

    def _statusword(self) -> int:
        limited = abs(self.objects["torque_reference"]) >= self.objects["torque_limit"] > 0
        return statusword(
            self.state,
            voltage_enabled=self.objects["u_dc"] > self.objects["u_dc_min"],
            warning=self.supervision.state is LinkState.LOST,
            target_reached=self._is_at_standstill(),
            internal_limit=self.state.power_stage_on and bool(limited),
        )

    def _is_at_standstill(self) -> bool:
        """Return whether a halt or a quick stop that holds has brought the axis to standstill."""
        command = self.core.command
        halted = self.state is State.OPERATION_ENABLED and bool(command.halt)
        return bool(command.standstill) and (halted or self.state is State.QUICK_STOP_ACTIVE)

    # ---- objects with a meaning beyond their value -------------------------------------------------------

    def _wire_objects(self) -> None:
        objects = self.objects
        objects.check("controlword", self._check_control)
        objects.on_write("controlword", self._control)
        objects.compute("statusword", self._statusword)
        objects.check("mode_of_operation", self._check_mode)
        objects.on_write("mode_of_operation", self._set_mode)
        objects.compute("angle_known", lambda: int(self._angle_known()))
        objects.check("host_heartbeat", _sane_timeout)
        objects.on_write("host_heartbeat", lambda raw: self.supervision.configure(int(raw)))
        for name in ("encoder_lines", "encoder_offset", "encoder_direction"):
            objects.on_write(name, lambda _: self.core.begin_observer())
        objects.compute("link_state", lambda: int(self.supervision.state))
        objects.compute("link_losses", lambda: self.supervision.losses)
        objects.check("parameter_trial", self._check_trial)
        objects.compute("error_history_count", lambda: len(self._history))
        objects.check("error_history_count", _only_zero)
        objects.on_write("error_history_count", lambda _: self._history.clear())
        for position in range(8):
            objects.compute(f"error_{position + 1}", partial(self._past_error, position))
        objects.compute("store_all", lambda: 1)
        objects.compute("restore_all", lambda: 1)
        objects.check("store_all", _only(_SAVE))
        objects.on_write("store_all", lambda _: self._store())
        objects.check("restore_all", _only(_LOAD))
        objects.on_write("restore_all", lambda _: self._restore())
        self._wire_402()

    def _wire_402(self) -> None:
        objects = self.objects
        rated_torque_Nm = self._rated_torque_Nm
        objects.on_write(
            "target_torque", self._set("torque_command", lambda raw: raw / 1e3 * rated_torque_Nm())
        )
        objects.on_write("max_torque", self._set("torque_limit", lambda raw: raw / 1e3 * rated_torque_Nm()))
        objects.on_write("target_velocity", self._set("omega_m_command", lambda raw: raw / 1e3))
        objects.compute("motor_rated_torque", lambda: round(rated_torque_Nm() * 1e3))
        objects.compute("torque_actual", lambda: _i16(objects["torque"] / rated_torque_Nm() * 1e3))
        objects.compute("velocity_actual", lambda: round(objects["omega_m"] * 1e3))
        objects.compute("dc_link_voltage", lambda: round(max(0.0, objects["u_dc"]) * 1e3))
        objects.compute(
            "current_actual",
            lambda: _i16(objects["i_q"] / math.sqrt(2.0) / objects["motor_rated_current"] * 1e6),
        )

    def _rated_torque_Nm(self) -> float:
        return float(self.objects["T_N"])

    def _set(self, name: str, value: Callable[[Number], float]) -> Callable[[Number], None]:
        def effect(raw: Number) -> None:
            self.objects[name] = value(raw)

        return effect

    def _set_mode(self, raw: Number) -> None:
        mode = Mode(int(raw))
        if mode != self.core.command.mode:
            self._stimulus.stop()  # it was started for the mode that ends
            self._clear_targets()
        self.core.command.mode = int(mode)
        self.objects["mode_of_operation_display"] = int(mode)

    def _past_error(self, place: int) -> int:
        if place >= len(self._history):
            raise Refused(Abort.NO_DATA)
        return self._history[place]

    def _store(self) -> None:
        self._stored = dict(self.objects.parameters())

    def _restore(self) -> None:
        self._stored = {}


def _i16(value: float) -> int:
    return max(-32768, min(32767, round(value)))


def _only(signature: int) -> Callable[[Number], None]:
    def check(raw: Number) -> None:
        if raw != signature:
            raise Refused(Abort.NOT_STORED)

    return check


def _sane_timeout(raw: Number) -> None:
    if int(raw) & 0xFFFF > LONGEST_TIMEOUT_MS:
        raise Refused(Abort.VALUE_HIGH)


def _only_zero(raw: Number) -> None:
    if raw != 0:
        raise Refused(Abort.VALUE)
