"""Equipment of the emulated bench that needs no wire: load machine, torque transducer and dc supply."""

from __future__ import annotations

from typing import Any

from benchtool.block import Block
from benchtool.emulator.core.core import Core
from benchtool.emulator.machine.transducer import MAX_TICKS


class EmulatedLoad:
    """The load machine of an emulated bench."""

    def __init__(self, core: Core) -> None:
        self._load = core.load

    def apply(self, torque_Nm: float) -> None:
        """Load the shaft; positive torque opposes positive speed. Its speed is free again."""
        self._load.torque_Nm = torque_Nm
        self._load.held = 0

    def hold(self, omega_m_rad_s: float) -> None:
        """Hold the shaft at this speed, as far as the load machine can."""
        self._load.omega_m_rad_s = omega_m_rad_s
        self._load.held = 1


class EmulatedTransducer:
    """The torque transducer of an emulated bench, 20 samples per drive tick: at the flange, or of the air-gap
    torque where the profile states none there."""

    def __init__(self, core: Core) -> None:
        self._core = core

    @property
    def longest_s(self) -> float:
        """The longest time that it records."""
        return MAX_TICKS * float(self._core.memory["control_period"][0])

    @property
    def late_s(self) -> float:
        """Zero: it is sampled with the drive."""
        return 0.0

    def require_alive(self) -> None:
        """It always measures."""

    def start(self, duration_s: float) -> None:
        """Record for `duration_s` from now."""
        self._core.transducer.start(round(duration_s / float(self._core.memory["control_period"][0])))

    def block(self, clock: object = None) -> Block:
        """Return what was recorded, as channel `torque_transducer`, and of one at the flange `torque_airgap`;
        its ticks are the drive's, without a `clock`."""
        return self._core.transducer.block()

    def facts(self) -> dict[str, Any]:
        """Return the bench's energy accounts since power-up, where it keeps them; no sample is lost."""
        energies = self._core.energies.now_J()
        return {"energies_J": energies} if any(energies.values()) else {}


class EmulatedEnergyMeter:
    """The energy accounts of an emulated bench, a row per control period."""

    def __init__(self, core: Core) -> None:
        self._core = core

    @property
    def longest_s(self) -> float:
        """The longest time that it records."""
        return MAX_TICKS * self._core.control_period_s

    def start(self, duration_s: float) -> None:
        """Record for `duration_s` from now."""
        self._core.energies.start(round(duration_s / self._core.control_period_s))

    def block(self) -> Block:
        """Return what was recorded, channels `energy_supply` to `energy_load` since power-up in J."""
        return self._core.energies.block()


class EmulatedSupply:
    """The supply of an emulated bench's dc link."""

    def __init__(self, core: Core) -> None:
        self._core = core

    def set_voltage(self, u_dc_V: float) -> None:
        """Supply another voltage from the next tick on.

        Raises:
            ValueRefused: it is not positive.
        """
        self._core.set_dc_link(u_dc_V)

    @property
    def u_dc_V(self) -> float:
        """Voltage of the dc link, behind the supply's resistance, at the last tick."""
        return float(self._core.shaft.u_dc)

    @property
    def i_dc_A(self) -> None:
        """The emulated supply does not measure its current."""
