"""The numerical core as one object: true machine and power stage, sensors, control and their records."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.control.protection import Trip
from benchtool.emulator.core.capture_memory import CaptureRecorder
from benchtool.emulator.core.kernels import Truth, kernel_of
from benchtool.emulator.core.stream_ring import StreamRecorder
from benchtool.emulator.first_call import call_first
from benchtool.emulator.machine.bounds import machine_of_bench, require_computable, runaway
from benchtool.emulator.machine.energies import Accounts, EnergyRecorder
from benchtool.emulator.machine.inverter import phase_currents
from benchtool.emulator.machine.sensor_truth import SensorTruth, going_on
from benchtool.emulator.machine.sensors import Noise
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.train_truth import NOTHING, TrainTruth
from benchtool.emulator.machine.transducer import Transducer
from benchtool.emulator.machine.truth import InverterTruth, MotorTruth
from benchtool.emulator.memory import (
    COMMAND,
    CONTROL,
    LOAD,
    MEASUREMENT,
    SENSOR,
    SHAFT,
    STIMULUS,
    new_memory,
)
from benchtool.errors import ValueRefused
from benchtool.profile import CONTROL_PERIOD_S
from benchtool.protocol import Mode
from benchtool.protocol.dictionary import ObjectTable
from benchtool.ticks import wrap_tick

__all__ = ["Core", "Trip"]

_ROOM_degC = 25.0
_FINITE = ("i_d", "i_q", "omega_m", "theta_e", "u_dc", "omega_load", "twist", "load_torque")


def truth_of(
    motor: MotorTruth,
    inverter: InverterTruth,
    sensors: SensorTruth,
    train: TrainTruth = NOTHING,
    *,
    T_s: float = CONTROL_PERIOD_S,
) -> Truth:
    """Return the bench in the form that the kernel reads, for a control period of `T_s` seconds.

    Raises:
        ValueRefused: shunts in the lower legs, which see nothing at the peak of the carrier, with double
            update.
    """
    if inverter.double_update and sensors.shunt_settling_s is not None:
        raise ValueRefused(
            "sensors.shunt_settling_s with double update: at the peak of the carrier no lower switch is on, "
            "and shunts see nothing; leave it out, or state pwm_period_s = control_period_s"
        )
    R = inverter.on_resistance_ohm
    stage = inverter.power_stage(T_s, sensors.sampling(T_s))
    if motor.heat is not None:  # which needs what is lost
        stage = stage._replace(accounts=Accounts(R, inverter.device_drop_V), heat=motor.heat.heat(T_s, R))
    return Truth(machine_of_bench(motor, train, R), stage, sensors.sensing(T_s, inverter.dead_time_s))


class Core:
    """An emulated drive and bench below the firmware; drive tick n is at n control periods.

    Args:
        table: objects, whose numbers make up the drive's memory.
        motor, inverter, sensors, train: true values, which control never sees.
        first_tick: the drive's tick at power-up, which is 0 of a drive that was not on before.
        control_period_s: T_s, to whole nanoseconds.
        seed: of the measurement noise; the same seed and commands give the same bits, however the ticks are
            divided over calls of `run`.
        on_compiling: called before the first run, or one after a change of the truth, that compiles.

    Raises:
        ValueRefused: the machine has a process too fast to be computed.

    Attributes:
        memory: structured array of shape (1,), a field for every number of the table.
        command: record between firmware and control: `mode`, `pwm_enabled`, `quick_stop`,
            `off_at_standstill`, `halt`, `trip` (a mask of `Trip`), `standstill`.
        load: record of the other end of the shaft: `torque_Nm` against positive rotation, or, while `held` is
            not zero, the speed `omega_m_rad_s`.
        stimulus: record of the stimulus that plays, taken over from its table by the firmware.
        shaft: record of the machine's true state: `i_d`, `i_q`, `omega_m`, `theta_e`, `u_dc`, and of
            the load behind an elastic coupling `omega_load` and `twist`; with heat `T_winding` and
            `T_magnet` in degC.
        tick: the drive's tick, counted on past 2**32 where memory has it modulo that.
        capture, stream, transducer, energies: the recorders.
    """

    def __init__(
        self,
        table: ObjectTable,
        motor: MotorTruth,
        inverter: InverterTruth,
        sensors: SensorTruth,
        seed: int = 0,
        first_tick: int = 0,
        train: TrainTruth = NOTHING,
        control_period_s: float = CONTROL_PERIOD_S,
        on_compiling: Callable[[], None] = lambda: None,
    ) -> None:
        self._on_compiling = on_compiling
        self.motor, self.inverter, self.sensors = motor, inverter, sensors
        self._train = train
        self._mirrored = False
        self.memory = new_memory(table)
        self.memory["tick"] = wrap_tick(first_tick)
        self.first_tick = self.tick = first_tick
        self.control_period_s = control_period_s
        self.memory["control_period"] = control_period_s  # a float32, with which control computes
        self.memory["pwm_period"] = inverter.pwm_period_s(control_period_s)
        require_computable(motor, control_period_s, train)
        self._commands, self._controls, self._measurements, self._shafts, self._loads, self._stimuli = (
            np.zeros(1, dtype) for dtype in (COMMAND, CONTROL, MEASUREMENT, SHAFT, LOAD, STIMULUS)
        )
        self.command, self.load, self.shaft = self._commands[0], self._loads[0], self._shafts[0]
        self.stimulus = self._stimuli[0]
        self._sensors = np.zeros(1, SENSOR)
        self.command.mode = int(Mode.TORQUE)
        self.shaft.u_dc = self._sensors[0].u_dc = inverter.u_dc_V
        if motor.heat is not None:
            self.shaft.T_winding = self.shaft.T_magnet = motor.heat.ambient_degC
        self.turn_rotor(motor.pole_pairs * motor.power_up_angle_rad)
        self.capture = CaptureRecorder(self.memory)
        self.stream = StreamRecorder(self.memory, lambda: self.tick)
        flange = train.flange.error(seed) if train.flange is not None else None
        self.transducer = Transducer(lambda: self.tick, self.control_period_s, flange=flange)
        self.energies = EnergyRecorder(self.transducer.record[0], lambda: self.tick, self.control_period_s)
        self._truth = truth_of(motor, inverter, sensors, train, T_s=control_period_s)
        self._noise = Noise(sensors.noise_rms, seed)
        self._kernel: tuple[Truth, Callable[..., int]] | None = None
        self._finite = [self._shafts[name] for name in _FINITE]  # of the record itself, to be read at once
        self._trips = self._commands["trip"]

    def set_dc_link(self, u_dc_V: float) -> None:
        """Supply the dc link with another voltage, from the next tick on.

        Raises:
            ValueRefused: it is not positive.
        """
        self.inverter = replace(self.inverter, u_dc_V=u_dc_V)
        before = self._truth.stage
        stage = self.inverter.power_stage(self.control_period_s, before.sampling)
        self._truth = self._truth._replace(stage=stage._replace(accounts=before.accounts, heat=before.heat))

    @property
    def keeps_accounts(self) -> bool:
        """Whether energy accounts are kept."""
        return self._truth.stage.accounts is not None

    def temperatures_degC(self) -> dict[str, float]:
        """Return the temperatures of `winding` and `magnet`; nothing where the machine has no heat."""
        if self.motor.heat is None:
            return {}
        return {"winding": float(self.shaft.T_winding), "magnet": float(self.shaft.T_magnet)}

    @property
    def winding_degC(self) -> float:
        """What the sensor in the winding reads; that of a room where the machine has no heat."""
        return _ROOM_degC if self.motor.heat is None else float(self.shaft.T_winding)

    def set_sensors(self, sensors: SensorTruth) -> None:
        """Have other sensors from the next tick on, such as one that is stuck: the flaws of a run's course.

        Numbers alone change at once; a flaw that the bench did not have before may have to be compiled.

        Raises:
            ValueRefused: currents would be read more than two periods late.
        """
        before, T_s = self._truth, self.control_period_s
        sensing, sampling = sensors.sensing(T_s, self.inverter.dead_time_s), sensors.sampling(T_s)
        moved_rad = sensors.encoder_offset_rad - self.sensors.encoder_offset_rad
        if self._mirrored:
            moved_rad = -moved_rad
            sensing = sensing._replace(encoder=sensing.encoder._replace(edges=-sensing.encoder.edges))
        theta_m = float(self.shaft.theta_e) / self.motor.pole_pairs
        sensing = sensing._replace(
            encoder=going_on(before.sensing.encoder, sensing.encoder, theta_m, moved_rad)
        )
        if sampling is not None:
            present = phase_currents(place(self.shaft.i_d, self.shaft.i_q, 0.0, self.shaft.theta_e))
            sampling.begin(present, before.stage.sampling)
        if before.sensing.u_lag is None:
            self._sensors[0].u_dc = self.shaft.u_dc
        self.sensors = sensors
        self._noise.set_rms(sensors.noise_rms)
        self._truth = before._replace(stage=before.stage._replace(sampling=sampling), sensing=sensing)

    def set_motor(self, motor: MotorTruth) -> None:
        """Have another machine on the same shaft from the next tick on, such as one with a broken winding.

        Numbers alone change at once; a part that the machine did not have before may have to be compiled.

        Raises:
            ValueRefused: it has a process too fast to be computed.
        """
        self._truth = self._truth_with(motor)
        self.motor = motor

    def prepare_motor(self, motor: MotorTruth) -> None:
        """Compile what `set_motor` will need, so that the drive does not stand still then.

        Raises:
            ValueRefused: as there.
        """
        before, self._truth = self._truth, self._truth_with(motor)
        try:
            self.run(0)
        finally:
            self._truth = before

    def _truth_with(self, motor: MotorTruth) -> Truth:
        require_computable(motor, self.control_period_s, self._train)
        devices_ohm = self.inverter.on_resistance_ohm
        return self._truth._replace(machine=machine_of_bench(motor, self._train, devices_ohm))

    def swap_phases(self) -> None:
        """Swap the cables of phases b and c between motor and drive, whose currents end with it.

        To the drive the machine is its mirror image: angles, speed and torques of the shaft and of the load
        have the other sign from then on.
        """
        shaft, load = self.shaft, self.load
        shaft.i_d = shaft.i_q = 0.0
        shaft.psi_d, shaft.psi_q = self._truth.machine.psi_r, 0.0
        for name in ("omega_m", "theta_e", "sin_theta", "omega_load", "twist", "load_torque"):
            shaft[name] = -shaft[name]
        load.torque_Nm, load.omega_m_rad_s = -load.torque_Nm, -load.omega_m_rad_s
        encoder = self._truth.sensing.encoder
        self._mirrored = not self._mirrored
        mirrored = encoder._replace(edges=-encoder.edges, zero=-encoder.zero)
        self._truth = self._truth._replace(sensing=self._truth.sensing._replace(encoder=mirrored))

    @property
    def disc_rad(self) -> float:
        """Angle of the encoder's disc with the shaft at zero."""
        return self._truth.sensing.encoder.zero

    @disc_rad.setter
    def disc_rad(self, angle_rad: float) -> None:
        sensing = self._truth.sensing
        encoder = sensing.encoder._replace(zero=angle_rad)
        self._truth = self._truth._replace(sensing=sensing._replace(encoder=encoder))

    def restart_counter(self) -> None:
        """Have the encoder's counter begin again, as when the drive is switched on."""
        self._sensors[0].counting = self._sensors[0].travelled = self._sensors[0].index_passed = 0

    @property
    def index_passed(self) -> bool:
        """Whether the index of the encoder has passed since its counter began."""
        return bool(self._sensors[0].index_passed)

    def begin_observer(self) -> None:
        """Have the speed observer begin again: an encoder that is read in another way has not turned."""
        self._controls[0].angles = 0

    def turn_rotor(self, theta_e_rad: float) -> None:
        """Set the rotor to an electrical angle."""
        self.shaft.theta_e = theta_e_rad
        self.shaft.cos_theta, self.shaft.sin_theta = math.cos(theta_e_rad), math.sin(theta_e_rad)

    def run(self, ticks: int) -> int:
        """Run control and machine for up to `ticks` ticks.

        Returns how many were run: fewer than asked when one raised a new trip, in which the power stage is
        already off.

        Raises:
            EmulationError: the machine has run away, to where it cannot be computed any more.
        """
        return self.run_with(self._kernel_of_now(), ticks)

    def _kernel_of_now(self) -> Callable[..., int]:
        """Return the kernel for what the bench is, which is looked for only where that has changed."""
        truth = self._truth
        if self._kernel is None or self._kernel[0] is not truth:
            kernel = kernel_of(truth)
            nothing = self._arguments(0, self._noise.ahead())
            call_first(kernel, lambda: kernel(*nothing), on_compiling=self._on_compiling)
            self._kernel = truth, kernel
        return self._kernel[1]

    def run_with(self, kernel: Callable[..., int], ticks: int) -> int:
        """`run` with another form of the kernel: the plain function `run_ticks`, to compare with."""
        done, trips = 0, self._trips[0]
        while done < ticks and self._trips[0] == trips:
            noise = self._noise.ahead()
            asked = min(ticks - done, len(noise))
            ran = kernel(*self._arguments(asked, noise))
            self._noise.use(ran)
            self.tick += ran
            done += ran
            if self._ran_away(complete=ran == asked or self._trips[0] != trips):
                time_s = (self.tick - self.first_tick) * self.control_period_s
                raise runaway(self.shaft, self.load, self.motor, time_s)
        return done

    def _ran_away(self, *, complete: bool) -> bool:
        return not (complete and all(math.isfinite(state[0]) for state in self._finite))

    def _arguments(self, ticks: int, noise: NDArray[np.float32]) -> tuple[Any, ...]:
        capture, stream, transducer = self.capture, self.stream, self.transducer
        return (
            ticks,
            self.memory,
            capture.words,
            capture.floats,
            self._commands,
            self._controls,
            self._stimuli,
            self._measurements,
            self._shafts,
            self._loads,
            *self._truth,
            self._sensors,
            noise,
            capture.record,
            capture.channels,
            capture.buffer,
            stream.record,
            stream.channels,
            stream.ring,
            transducer.record,
            transducer.torque,
            self.energies.rows,
        )
