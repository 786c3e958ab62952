"""The emulated bench: a drive on any number of wires, and the equipment around it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import can
import numpy as np

from benchtool.clock import VirtualClock
from benchtool.emulator.core.core import Core, truth_of
from benchtool.emulator.core.kernels import kernel_is_cached
from benchtool.emulator.equipment import EmulatedEnergyMeter, EmulatedLoad, EmulatedSupply, EmulatedTransducer
from benchtool.emulator.faults import FaultInjector
from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.flux_table import fit_flux_linkages
from benchtool.emulator.instruments import CanInstrument, CanReadings, CanTorque, samples_apart
from benchtool.emulator.machine.heat import HeatTruth
from benchtool.emulator.machine.saturation import SaturationTruth
from benchtool.emulator.machine.sensor_truth import CurrentTruth, EncoderTruth, SensorTruth, VoltageTruth
from benchtool.emulator.machine.train_truth import (
    FlangeTruth,
    LoadMachineTruth,
    LoadTruth,
    ShaftTruth,
    TrainTruth,
)
from benchtool.emulator.machine.truth import InverterTruth, MotorTruth
from benchtool.emulator.servers.canopen import CanopenServer
from benchtool.emulator.servers.drive_node import DriveNode, OnGone, Server
from benchtool.emulator.thermometer import EmulatedThermometer
from benchtool.errors import ProfileError
from benchtool.link import PipePort, Port, pipe
from benchtool.link.canopen import VirtualTimeBus
from benchtool.profile import CanTransducer, EmulatedTemperature, Emulator, Profile, Sensors
from benchtool.protocol import DbcMessage
from benchtool.protocol.canopen import NmtState
from benchtool.protocol.dictionary import (
    Dictionary,
    Number,
    ObjectTable,
    Value,
    Variable,
    first_breach,
    load_table,
    setting_of,
)
from benchtool.shipped import shipped

if TYPE_CHECKING:
    from benchtool.emulator.servers.serial import SerialServer

_COMPILING = "compiling the emulated drive, once on this machine: a few seconds"
_channels = itertools.count(1)


@cache
def _objects() -> ObjectTable:
    """Return the objects of the drive, which every emulated one has."""
    return load_table(shipped("firmware_protocol") / "objects.toml")


class EmulatedBench:
    """A powered-up bench in virtual time.

    Args:
        profile: with an `[emulator]` section.
        channel: name of the virtual CAN bus; empty for one of its own.
        seed: of the sensors' noise.
        paced: hold virtual time to the wall clock.
        speed, step_s, catch_up_s: of a paced clock, as `VirtualClock` takes them.
        first_tick: the drive's tick at power-up, for a drive that is about to reach 2**32.
        has_bus: the drive is on the virtual CAN bus from power-up. Further wires can be added.
        note: called with a message before the drive is compiled, at the first tick that needs it.

    Raises:
        ProfileError: the profile describes no emulated bench, or a trip level beyond the range of its
        sensors.
        ValueRefused: it sets a parameter that the drive has not, or to a value that it cannot have.
    """

    def __init__(
        self,
        profile: Profile,
        channel: str = "",
        *,
        seed: int = 0,
        paced: bool = False,
        speed: float = 1.0,
        step_s: float = 0.02,
        catch_up_s: float = 1.0,
        first_tick: int = 0,
        has_bus: bool = True,
        note: Callable[[str], None] = lambda _: None,
    ) -> None:
        emulator = _emulator_of(profile)
        table = _objects()
        core = _core(table, profile, emulator, seed, first_tick, lambda: note(_COMPILING))
        stored = _stored_parameters(profile, emulator)
        node_id = profile.drive.node_id
        self.channel = channel or f"benchtool-{next(_channels)}"
        self.clock = VirtualClock(paced=paced, speed=speed, step_s=step_s, catch_up_s=catch_up_s)
        self.load = EmulatedLoad(core)
        self.transducer = EmulatedTransducer(core)
        self.supply = EmulatedSupply(core)
        self.energy_meter = EmulatedEnergyMeter(core) if core.keeps_accounts else None
        self._core = core
        self._seed = seed
        self._temperature_sensor = emulator.sensors.temperature
        self._thermometers: list[EmulatedThermometer] = []
        self._instruments: list[CanInstrument] = []
        self._node = DriveNode(node_id, lambda emit: Firmware(table, core, node_id, stored, emit), seed)
        self.faults = FaultInjector(self._node, core)
        if has_bus:
            # Frames bear the drive's time: the clock stands still while the drive runs up to it.
            bus = VirtualTimeBus(self.channel, clock=self.clock, preserve_timestamps=True)
            self.add_can(bus)
            self.clock.register(bus.settle)
        self.clock.follow(self._advance_to)
        self.clock.carry(self._node.is_under_way)

    def host_bus(self, channel: str = "") -> VirtualTimeBus:
        """Return a bus for the host, on this bench's channel or on another one, in its time."""
        bus = VirtualTimeBus(channel or self.channel, clock=self.clock)
        self.clock.register(bus.settle)
        return bus

    def add_torque(
        self, stated: CanTransducer, message: DbcMessage, factor: float, channel: str = ""
    ) -> None:
        """Have a transducer send the torque of the shaft on a CAN bus; `transducer` records nothing then.

        `factor` is Nm in a unit of its signals, `channel` names its bus if that is not the drive's.

        Raises:
            ProfileError: its sampling instants do not match those of the machine's torque.
        """
        samples_apart(self._core, stated.sample_rate_Hz)  # before there is a bus to be given back
        self._instruments.append(
            CanTorque(self._instrument_bus(channel), message, stated, factor, self._core)
        )

    def add_readings(
        self,
        message: DbcMessage,
        rate_Hz: float,
        values: Callable[[], Mapping[str, float]],
        channel: str = "",
    ) -> None:
        """Have an instrument send these values, in the units of its signals, `rate_Hz` times a second."""
        self._instruments.append(CanReadings(self._instrument_bus(channel), message, rate_Hz, values))

    def set_sensors(self, sensors: Sensors) -> None:
        """Have other sensors from the next tick on, as a channel that sticks or an encoder that slips.

        Raises:
            ValueRefused: they cannot be together.
        """
        with self._node.lock:
            self._core.set_sensors(_sensors(sensors))
            self._temperature_sensor = sensors.temperature
            for each in self._thermometers:
                each.sensor = sensors.temperature

    def add_thermometer(self, stated: EmulatedTemperature) -> EmulatedThermometer:
        """Return thermometers of winding and surroundings at the temperatures that a profile states."""
        made = EmulatedThermometer(self._core, stated, self._temperature_sensor, self._seed)
        self._thermometers.append(made)
        return made

    def _instrument_bus(self, channel: str) -> VirtualTimeBus:
        """Return a bus whose frames bear the moment at which they were due."""
        return VirtualTimeBus(channel or self.channel, clock=self.clock, preserve_timestamps=True)

    def host_port(self) -> PipePort:
        """Return host's end of a serial line to the drive, in the bench's time; every call makes another."""
        drive_end, host_end = pipe(self.clock)
        for end in (drive_end, host_end):
            self.clock.register(end.settle)
        self.add_serial(drive_end, buffered=False)
        return host_end

    def add_can(self, bus: can.BusABC, on_gone: OnGone = lambda _: None) -> None:
        """Connect the drive to a CAN bus, which is owned from now on.

        `on_gone` is called with the reason, in the thread that advances time, if the wire is lost; the drive
        runs on.
        """
        self._node.add(CanopenServer(bus, self._node), on_gone)

    def add_serial(
        self, port: Port, on_gone: OnGone = lambda _: None, *, buffered: bool = True
    ) -> SerialServer:
        """Connect the drive to a serial line, which is owned from now on; `on_gone` as in `add_can`.

        `buffered` is for every port that may block. What such a port does not take in time is lost, telemetry
        first; the drive never waits.
        """
        from benchtool.emulator.servers.serial import SerialServer  # with all of that protocol's messages

        server = SerialServer(port, self._node, buffered=buffered)
        self._node.add(server, on_gone)
        return server

    def add(self, make: Callable[[DriveNode], Server], on_gone: OnGone = lambda _: None) -> None:
        """Connect the drive to a wire of another kind, whose server is made for the drive; `on_gone` as in
        `add_can`."""
        self._node.add(make(self._node), on_gone)

    def warm_up(self) -> None:
        """Run the first tick, which may compile for some seconds, before the clock starts."""
        self._node.advance_to(self._node.firmware.period_s)

    def energies_J(self) -> Mapping[str, float]:
        """Return the energy accounts since power-up: `dc`, and what it went to; zeros where none are kept."""
        return self._core.energies.now_J()

    def temperatures_degC(self) -> Mapping[str, float]:
        """Return the true temperatures of `winding` and `magnet`; nothing where they are constants."""
        return self._core.temperatures_degC()

    @property
    def enabled(self) -> bool:
        """Whether the power stage is on."""
        return self._node.firmware.state.power_stage_on

    def status(self) -> DriveStatus:
        """Return the present, from any thread."""
        with self._node.lock:
            firmware = self._node.firmware
            return DriveStatus(
                drive_s=firmware.now_s,
                state=firmware.state.value,
                nmt_state=self._node.nmt_state,
                omega_m_rad_s=float(firmware.objects["omega_m"]),
                torque_Nm=float(firmware.objects["torque"]),
                late_s=self.clock.late_s,
            )

    def close(self) -> None:
        """Power off."""
        for each in self._instruments:
            each.close()
        self._node.close()

    def _advance_to(self, now_s: float) -> None:
        for each in self._instruments:
            each.prepare(now_s)
        self._node.advance_to(now_s)
        for thermometer in self._thermometers:
            thermometer.follow(now_s)
        for each in self._instruments:
            each.send_until(now_s)


@dataclass(frozen=True)
class DriveStatus:
    """State of an emulated drive; `late_s` is how far it fell behind the wall clock."""

    drive_s: float
    state: str
    nmt_state: NmtState
    omega_m_rad_s: float
    torque_Nm: float
    late_s: float


def is_compiled(profile: Profile) -> bool:
    """Return whether this machine holds the emulator compiled for what the profile's bench has.

    Raises:
        ProfileError: the profile describes no emulated bench.
        ValueRefused: one that cannot be computed.
    """
    emulator = _emulator_of(profile)
    truth = truth_of(*_truth(profile, emulator), _train(emulator), T_s=profile.control_period_s)
    return kernel_is_cached(truth)


def _emulator_of(profile: Profile) -> Emulator:
    if profile.emulator is None:
        raise ProfileError(
            f"profile '{profile.title}' has no [emulator] section, which an emulated bench is made of: "
            f"add one, or name the drive's link with --link"
        )
    return profile.emulator


def _core(
    table: ObjectTable,
    profile: Profile,
    emulator: Emulator,
    seed: int,
    first_tick: int,
    on_compiling: Callable[[], None],
) -> Core:
    return Core(
        table,
        *_truth(profile, emulator),
        seed=seed,
        first_tick=first_tick,
        train=_train(emulator),
        control_period_s=profile.control_period_s,
        on_compiling=on_compiling,
    )


def _truth(profile: Profile, emulator: Emulator) -> tuple[MotorTruth, InverterTruth, SensorTruth]:
    motor, true = profile.nameplate or profile.motor, emulator.motor
    believed = motor.model_dump(include={"pole_pairs", "R_s_ohm", "L_d_H", "L_q_H", "psi_r_Wb", "J_kgm2"})
    stated = true.model_dump(exclude_none=True, exclude={"saturation", "flux_linkages", "heat"})
    saturation = SaturationTruth(**true.saturation.model_dump()) if true.saturation else None
    if true.flux_linkages is not None:
        fitted = fit_flux_linkages(**true.flux_linkages.model_dump())
        saturation = fitted.saturation
        stated |= {"L_d_H": fitted.L_d_H, "L_q_H": fitted.L_q_H, "psi_r_Wb": fitted.psi_r_Wb}
    heat = HeatTruth(**true.heat.model_dump()) if true.heat else None
    return (
        MotorTruth(**{**believed, **stated, "saturation": saturation, "heat": heat}),
        InverterTruth(
            **emulator.inverter.model_dump(exclude_none=True),
            double_update=profile.drive.double_update,
            energy_accounts=emulator.energy_accounts,
        ),
        _sensors(emulator.sensors),
    )


def _sensors(stated: Sensors) -> SensorTruth:
    tables = {"i_a", "i_b", "i_c", "u_dc", "encoder", "temperature"}
    return SensorTruth(
        **stated.model_dump(exclude=tables),
        i_a=CurrentTruth(**stated.i_a.model_dump()),
        i_b=CurrentTruth(**stated.i_b.model_dump()),
        i_c=CurrentTruth(**stated.i_c.model_dump()),
        u_dc=VoltageTruth(**stated.u_dc.model_dump()),
        encoder=EncoderTruth(**stated.encoder.model_dump()),
    )


def _train(emulator: Emulator) -> TrainTruth:
    machine, flange = emulator.load_machine, emulator.flange
    return TrainTruth(
        shaft=ShaftTruth(**emulator.shaft.model_dump()),
        load=LoadTruth(**emulator.load.model_dump()),
        load_machine=None if machine is None else LoadMachineTruth(**machine.model_dump()),
        flange=None if flange is None else FlangeTruth(**flange.model_dump()),
    )


def _stored_parameters(profile: Profile, emulator: Emulator) -> dict[str, Number]:
    """Return the raw values of the parameters that the drive has stored; none of them comes from the
    truth."""
    given: Mapping[str, Value] = profile.stated_parameters if emulator.commissioned else {}
    dictionary = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", profile.drive.node_id)
    variables = {key: setting_of(dictionary, key, value) for key, value in given.items()}
    if breach := first_breach(dictionary, given, emulator.sensors.full_scales()):
        raise ProfileError(f"profile '{profile.title}': {breach}")
    return {variable.name: _raw(variable, given[key]) for key, variable in variables.items()}


def _raw(variable: Variable, value: Value) -> Number:
    raw: Number = np.frombuffer(variable.encode(value), dtype=variable.type.numpy)[0].item()
    return raw
