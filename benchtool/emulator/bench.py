"""The emulated bench: a drive on a virtual CAN bus, a load machine and a torque transducer on its shaft."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np

from benchtool.block import Block
from benchtool.clock import VirtualClock
from benchtool.emulator.core import Core
from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.servers.canopen import CanopenNode
from benchtool.emulator.truth import InverterTruth, MotorTruth, SensorTruth
from benchtool.errors import ProfileError
from benchtool.link.virtual import VirtualTimeBus
from benchtool.profile import Emulator, Profile
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.keys import variable_of
from benchtool.protocol.objects import Number, ObjectTable, load_table
from benchtool.protocol.variable import Value, Variable
from benchtool.shipped import shipped

_channels = itertools.count(1)


class EmulatedBench:
    """A powered-up bench in virtual time.

    Args:
        profile: with an `[emulator]` section.
        channel: name of the virtual CAN bus; empty for one of its own.
        seed: of the sensors' noise.
        paced: let virtual time pass no faster than the wall clock.

    Raises:
        ProfileError: the profile describes no emulated bench.
        ValueRefused: it sets a parameter that the drive has not, or to a value that it cannot have.
    """

    def __init__(self, profile: Profile, channel: str = "", *, seed: int = 0, paced: bool = False) -> None:
        if profile.emulator is None:
            raise ProfileError(
                f"profile '{profile.title}' has no [emulator] section, which an emulated bench is made of: "
                f"add one, or name the drive's link with --link"
            )
        table = load_table(shipped("firmware_protocol") / "objects.toml")
        core = _core(table, profile, profile.emulator, seed)
        stored = _stored_parameters(profile, profile.emulator)
        node_id = profile.drive.node_id
        self.channel = channel or f"benchtool-{next(_channels)}"
        self.clock = VirtualClock(paced=paced)
        self.load = EmulatedLoad(core)
        self.transducer = EmulatedTransducer(core)
        # Frames bear the drive's time: the clock stands still while the drive runs up to it.
        self._bus = VirtualTimeBus(self.channel, clock=self.clock, preserve_timestamps=True)
        self._node = CanopenNode(
            self._bus, node_id, lambda emit: Firmware(table, core, node_id, stored, emit)
        )
        self.clock.settle_with(self._bus.settle)
        self.clock.follow(self._node.advance_to)

    def host_bus(self) -> VirtualTimeBus:
        """A bus for the host's link, on this bench's channel and in its time."""
        bus = VirtualTimeBus(self.channel, clock=self.clock)
        self.clock.settle_with(bus.settle)
        return bus

    def close(self) -> None:
        """Power off."""
        self._node.close()


class EmulatedLoad:
    """The load machine of an emulated bench."""

    def __init__(self, core: Core) -> None:
        self._load = core.load

    def apply(self, torque_Nm: float) -> None:
        """Load the shaft; positive torque opposes positive speed. It may turn as it likes again."""
        self._load.torque_Nm = torque_Nm
        self._load.held = 0

    def hold(self, omega_m_rad_s: float) -> None:
        """Turn the shaft at this speed, whatever torque that takes."""
        self._load.omega_m_rad_s = omega_m_rad_s
        self._load.held = 1


class EmulatedTransducer:
    """The torque transducer of an emulated bench: air-gap torque, 20 samples per drive tick."""

    def __init__(self, core: Core) -> None:
        self._core = core

    def start(self, duration_s: float) -> None:
        """Record for `duration_s` from now."""
        self._core.transducer.start(round(duration_s / float(self._core.memory["control_period"][0])))

    def block(self) -> Block:
        """What was recorded, as channel `torque_transducer`."""
        return self._core.transducer.block()


def _core(table: ObjectTable, profile: Profile, emulator: Emulator, seed: int) -> Core:
    motor, true = profile.motor, emulator.motor
    believed = motor.model_dump(include={"pole_pairs", "R_s_ohm", "L_d_H", "L_q_H", "psi_r_Wb", "J_kgm2"})
    return Core(
        table,
        MotorTruth(**{**believed, **true.model_dump(exclude_none=True)}),
        InverterTruth(**emulator.inverter.model_dump()),
        SensorTruth(**emulator.sensors.model_dump()),
        seed=seed,
    )


def _stored_parameters(profile: Profile, emulator: Emulator) -> dict[str, Number]:
    """Raw values that the drive was commissioned with: the believed motor, the encoder, the parameters."""
    motor = profile.motor.model_dump(exclude={"I_N_A_rms"})
    sensors = emulator.sensors.model_dump(include={"encoder_lines", "encoder_offset_rad"})
    rated = {"motor_rated_current_A": profile.motor.I_N_A_rms}
    given: Mapping[str, Value] = {**motor, **sensors, **rated, **profile.drive.parameters}
    dictionary = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", profile.drive.node_id)
    variables = {key: variable_of(dictionary, key) for key in given}
    return {variable.name: _raw(variable, given[key]) for key, variable in variables.items()}


def _raw(variable: Variable, value: Value) -> Number:
    raw: Number = np.frombuffer(variable.encode(value), dtype=variable.type.numpy)[0].item()
    return raw
