"""What a step may rest on: the nameplate, the drive as it is found, and what earlier steps have estimated."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Measurement, sure_of
from benchtool.commission.estimators.circuit import Circuit
from benchtool.commission.estimators.flux_linkage import HARMONICS
from benchtool.commission.nameplate import IN_SERIES_OHM, KEYS
from benchtool.drive import RemoteDrive
from benchtool.errors import ValueRefused
from benchtool.profile import Motor, Profile
from benchtool.protocol.dictionary import Value, Variable

_SAMPLED_S = 0.01
_MOST_DEAD_TIME_S = 2e-5  # that a drive compensates
_OF_THE_SWING = 0.7
_SLOWEST_RAD_S = 30.0  # so that a level of some tenths of a second settles
_READ = ("law", "encoder_lines", "encoder_direction", "u_s", "T_k_ratio", "i_trip", "torque_limit")
_FRICTION_SHARE = 0.02  # of the rated torque, until friction is known
_FLUX = 1.3  # times what was seen of it, from which on the nameplate's rotor flux is not believed
_LEAST_FLUX = 0.02  # of the nameplate's
_LEAST_L = 0.1  # of the nameplate's
_AS_STATED = (0.65, 1.5)  # resistance of a winding over what a nameplate states of it
SERIES_AS_STATED = (0.5, 2.0)  # of a device, by its temperature, and of a cable
_CODES = 2.0**10  # of a converter of the dc link, at the least
_NONE: Mapping[str, Measurement] = MappingProxyType({})


@dataclass(frozen=True)
class Known:
    """The host's knowledge of motor and drive; nothing of it is the truth of an emulated bench.

    `motor` is the nameplate, `series_ohm` what is stated to be in series with a phase, None where nothing is;
    `variables` are the parameters of the drive that can be set, `held` what it
    holds while steps are run, and `estimates` what was estimated, by its names. `encoder_lines` are
    those that the drive counts by, `travel_rad` is how far the shaft may turn from where it stands.
    """

    motor: Motor
    control_period_s: float
    u_dc_V: float
    u_dc_full_scale_V: float = 0.0
    encoder_lines: int = 2500
    travel_rad: float = math.inf
    pwm_period_s: float = 0.0
    series_ohm: float | None = None
    variables: Mapping[str, Variable] = field(default_factory=lambda: MappingProxyType({}))
    held: Mapping[str, Value] = field(default_factory=lambda: MappingProxyType({}))
    estimates: Mapping[str, Measurement] = field(default_factory=lambda: _NONE)

    @property
    def link_step_V(self) -> float:
        """Step of the converter of the dc link: of an unknown one ten bits are assumed."""
        return self.u_dc_full_scale_V / _CODES

    @classmethod
    def of(cls, drive: RemoteDrive, profile: Profile, stated: Mapping[str, Value] | None = None) -> Self:
        """Return what is known before the first step.

        Args:
            drive: connected.
            profile: of it, with the nameplate.
            stated: what the drive is to hold meanwhile, by name; the rest as it holds it now.

        Raises:
            NoAnswer, SdoAbort: the drive does not answer, or refused.
            ValueRefused: it reads no dc link.
        """
        drive.clock.wait(_SAMPLED_S)  # a fault over limits that the drive came with is none of a plan's
        u_dc_V = drive.number("u_dc")
        if not u_dc_V > 0.0:
            raise ValueRefused(f"the drive reads a dc link of {u_dc_V:g} V: power it; nothing was sent")
        period_s = round(drive.number("control_period") * 1e9) * 1e-9  # the drive has it as a float32
        pwm_s = round(drive.number("pwm_period") * 1e9) * 1e-9
        variables = {
            each.name: each for each in drive.dictionary if each.role == "parameter" and each.writable
        }
        held = {name: drive.read(name) for name in _READ if name in drive.dictionary} | dict(stated or {})
        return cls(
            profile.motor,
            period_s,
            u_dc_V,
            drive.number("u_dc_full_scale"),
            encoder_lines=int(held.get("encoder_lines", cls.encoder_lines)),
            pwm_period_s=pwm_s,
            series_ohm=profile.series_ohm,
            variables=variables,
            held=held,
        )

    def with_estimates(self, found: Mapping[str, Measurement]) -> Self:
        """Return this with more estimates; those without a value are left out."""
        defined = {name: each for name, each in found.items() if math.isfinite(each.value)}
        return replace(self, estimates=MappingProxyType({**self.estimates, **defined}))

    def with_drop(self, drop_V: float) -> Self:
        """Return this with the voltage that dead time and devices take of a phase."""
        return self.with_estimates({"dead_time_voltage": Measurement("dead_time_voltage", drop_V, "V", "")})

    def value(self, name: str, nameplate: float) -> float:
        """Return the estimate of a parameter, or what the nameplate says."""
        found = self.estimates.get(name)
        return nameplate if found is None else found.value

    @property
    def circuit(self) -> Circuit:
        """What is known of winding and inverter, as the estimators take it."""
        noise = [self.value(f"current_noise_{phase}", 0.0) for phase in "abc"]
        return Circuit(
            self.control_period_s,
            self.R_s_ohm,
            self.drop_V,
            self.u_dc_V,
            double_update=self.pwm_period_s > 1.5 * self.control_period_s,
            gains=self.gains,
            noise_A=math.sqrt(sum(each**2 for each in noise) / 3.0),
        )

    @property
    def in_force(self) -> dict[str, Value]:
        """What was estimated, as the drive's parameters have it; what is no parameter of it is left out.

        The drive compensates dead time and drop by a time: that in which the dc link makes the voltage they
        take.
        """
        found = {name: each.value for name, each in self.estimates.items()}
        if (drop := self.estimates.get("dead_time_voltage")) is not None:
            seen = drop.value > sure_of(drop.uncertainty)
            found["dead_time_compensation"] = self.compensation_s if seen else 0.0
        return {
            name: _as_held(self.variables[name], value)
            for name, value in found.items()
            if name in self.variables
        }

    @property
    def least_L_H(self) -> float:
        """Inductance for which a voltage is chosen: the nameplate's, or what was seen of it if that is
        less."""
        stated = min(self.motor.L_d_H, self.motor.L_q_H)
        return max(min(stated, self.value("inductance_seen", stated)), _LEAST_L * stated)

    @property
    def law(self) -> str:
        """Control law that the drive is to run with."""
        return str(self.held.get("law", ""))

    @property
    def vector_A(self) -> float:
        """By how much one voltage vector of a law of fixed voltage changes the current; 0 for another law."""
        if self.law not in ("tpc", "tpc_stator"):
            return 0.0
        motor = self.identified
        volt_seconds = float(self.held["u_s"]) * float(self.held["T_k_ratio"]) * self.control_period_s
        return volt_seconds / min(motor.L_d_H, motor.L_q_H)

    @property
    def friction_Nm(self) -> Callable[[float], float]:
        """Torque of friction at a speed in rad/s; where its parts could not be told, their sum at the highest
        speed at which it was measured, and until then a share of the rated torque."""
        whole = self.value("friction_torque", _FRICTION_SHARE * self.motor.T_N_Nm)
        coulomb, viscous = self.value("coulomb", whole), self.value("friction", 0.0)
        return lambda omega_m: max(0.0, coulomb) + viscous * abs(omega_m)

    @property
    def torque_per_A(self) -> float:
        """Torque per ampere of i_q, peak: 3/2 p psi_r."""
        return 1.5 * self.identified.pole_pairs * self.identified.psi_r_Wb

    @property
    def pole_pairs(self) -> int:
        """Pole pairs, as found or as stated."""
        return round(self.value("pole_pairs", self.motor.pole_pairs))

    @property
    def I_N_A(self) -> float:
        """Rated current, peak."""
        return math.sqrt(2.0) * self.motor.I_N_A_rms

    @property
    def swing_rad_s(self) -> float:
        """Angular frequency at which the rotor swings about a standing vector of the rated current."""
        stiffness = 1.5 * self.motor.pole_pairs**2 * self.motor.psi_r_Wb * self.I_N_A
        return math.sqrt(stiffness / self.motor.J_kgm2)

    @property
    def damping_bandwidth_rad_s(self) -> float:
        """Bandwidth of the current loop with which the stator damps that swing best.

        Above it the current does not yield to the EMF, far below it only the resistance damps, which is
        little beside a large inductance.
        """
        return min(max(_OF_THE_SWING * self.swing_rad_s, _SLOWEST_RAD_S), 0.1 / self.control_period_s)

    @property
    def R_s_ohm(self) -> float:
        """Resistance per phase, with what is in series with it."""
        return self.value("R_s", self.motor.R_s_ohm + (self.series_ohm or 0.0))

    @property
    def R_s_range_ohm(self) -> tuple[float, float]:
        """The least and the most that it may be as long as it is only stated."""
        least, most = (share * self.motor.R_s_ohm for share in _AS_STATED)
        if self.series_ohm is None:
            return least, most + IN_SERIES_OHM
        of_least, of_most = SERIES_AS_STATED
        return least + of_least * self.series_ohm, most + of_most * self.series_ohm

    @property
    def drop_V(self) -> float:
        """Voltage that dead time and devices take of a phase; 0 as long as it was not estimated."""
        return self.value("dead_time_voltage", 0.0)

    @property
    def drop_fundamental_V(self) -> float:
        """The fundamental, peak, of what dead time and devices take of a phase whose current is a sine."""
        return 4.0 / math.pi * self.drop_V

    @property
    def identified(self) -> Motor:
        """The nameplate with what was estimated in its place."""
        found = {key: self.estimates[name].value for name, key in KEYS.items() if name in self.estimates}
        if "pole_pairs" in found:
            found["pole_pairs"] = round(found["pole_pairs"])
        seen_Wb = self.value("rotor_flux_seen", self.motor.psi_r_Wb)
        if "psi_r" not in self.estimates and not 1.0 / _FLUX < seen_Wb / self.motor.psi_r_Wb < _FLUX:
            found["psi_r_Wb"] = max(seen_Wb, _LEAST_FLUX * self.motor.psi_r_Wb)
        return self.motor.model_copy(update=found)

    @property
    def electrical(self) -> dict[str, Value]:
        """Parameters of the drive for its current loop, as far as estimated."""
        return {name: self.estimates[name].value for name in ("R_s", "L_d", "L_q") if name in self.estimates}

    @property
    def encoder(self) -> dict[str, Value]:
        """Parameters of the drive for the rotor's angle, as far as estimated."""
        found: dict[str, Value] = {}
        if "encoder_offset" in self.estimates:
            found["encoder_offset"] = self.estimates["encoder_offset"].value
            found["encoder_direction"] = (
                "forward" if self.value("encoder_direction", 1.0) > 0.0 else "reverse"
            )
            found["pole_pairs"] = self.identified.pole_pairs
        return found

    def without_eccentricity(self, theta_m_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mechanical angle of the shaft, shape (n,), from what an eccentric encoder shows."""
        shaft = np.array(theta_m_rad)
        for n, error in enumerate(self.eccentricity_rad, start=1):
            shaft -= error.real * np.cos(n * theta_m_rad) + error.imag * np.sin(n * theta_m_rad)
        return shaft

    @property
    def eccentricity_rad(self) -> tuple[complex, complex]:
        """Errors of an eccentric encoder once and twice in a revolution, the real part of each with
        cos(n theta_m); 0 of one that stays within its uncertainty, which a swing of the rotor may be."""
        once, twice = (self._told_wave(f"eccentricity_{n}") for n in (1, 2))
        return once, twice

    @property
    def eccentricity_left_rad(self) -> float:
        """Amplitude that was seen of an eccentric encoder and stays within its uncertainty."""
        seen = (self._wave(f"eccentricity_{n}")[0] for n in (1, 2))
        return math.hypot(*(abs(one - told) for one, told in zip(seen, self.eccentricity_rad, strict=True)))

    def _told_wave(self, name: str) -> complex:
        wave, U = self._wave(name)
        return wave if abs(wave) > U else 0j

    def _wave(self, name: str) -> tuple[complex, float]:
        """Return the complex amplitude of a cosine and a sine, and the larger expanded uncertainty; 0 of what
        was not found."""
        parts = [self.estimates.get(f"{name}_{part}") for part in ("cos", "sin")]
        known = [each.uncertainty for each in parts if each is not None and each.uncertainty is not None]
        wave = complex(*(0.0 if each is None else each.value for each in parts))
        return wave, max((each.expanded for each in known), default=0.0)

    @property
    def flux_harmonics(self) -> dict[int, complex]:
        """Harmonics of the rotor flux in stator coordinates by their order, complex Wb, as far as found."""
        return {order: self._wave(f"psi_{abs(order)}")[0] for order in HARMONICS}

    @property
    def flux_harmonics_told(self) -> tuple[int, ...]:
        """Orders of the harmonics of the rotor flux that are beyond their uncertainty."""
        return tuple(order for order in HARMONICS if self._told_wave(f"psi_{abs(order)}"))

    @property
    def cogging_orders(self) -> tuple[int, ...]:
        """How often in a revolution the parts of the cogging torque come that were found."""
        orders = (each.basis.order for each in self.estimates.values())
        return tuple(round(order) for order in orders if order is not None)

    @property
    def compensation_s(self) -> float:
        """Dead time by which the drive takes off what dead time and devices take of a phase, as far as
        estimated."""
        period_s = self.pwm_period_s or self.control_period_s
        return min(max(0.0, self.drop_V / self.u_dc_V * period_s), _MOST_DEAD_TIME_S)

    @property
    def offsets(self) -> dict[str, Value]:
        """Parameters of the drive that take the offsets of the current sensors off, as far as estimated."""
        names = [f"current_offset_{phase}" for phase in "abc"]
        return {name: self.estimates[name].value for name in names if name in self.estimates}

    @property
    def sensor_gains(self) -> dict[str, Value]:
        """Parameters of the drive that make its current sensors agree, as far as estimated."""
        names = [f"current_gain_{phase}" for phase in "abc"]
        return {name: self.estimates[name].value for name in names if name in self.estimates}

    @property
    def gains(self) -> NDArray[np.float64]:
        """Corrections of the gains of the current sensors, shape (3,)."""
        return np.array([self.value(f"current_gain_{phase}", 1.0) for phase in "abc"])


def _as_held(variable: Variable, value: float) -> Value:
    """Return a number as a drive reads it back: rounded to its type, an enumeration by name."""
    if variable.values is not None:
        return next(name for name, number in variable.values.items() if number == round(value))
    whole = variable.type.numpy is not None and np.issubdtype(variable.type.numpy, np.integer)
    return variable.decode(variable.encode(round(value) if whole and variable.factor == 1.0 else value))
