"""True values of the emulated bench, which control never sees, and their form for the kernel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

from benchtool.emulator.machine.asymmetry import Asymmetry, sequences
from benchtool.emulator.machine.carrier import DoubleUpdate
from benchtool.emulator.machine.coefficients import Machine, machine_of
from benchtool.emulator.machine.cogging import Cogging, cogging_of
from benchtool.emulator.machine.dc_link import DcLink
from benchtool.emulator.machine.drive_train import DriveTrain
from benchtool.emulator.machine.energies import Accounts
from benchtool.emulator.machine.harmonics import Harmonics, Unbalance
from benchtool.emulator.machine.heat import HeatTruth
from benchtool.emulator.machine.inverter import DeadTime, Devices, PowerStage, Timer
from benchtool.emulator.machine.iron import Iron
from benchtool.emulator.machine.sampling import Sampling
from benchtool.emulator.machine.saturation import Saturation, SaturationTruth
from benchtool.emulator.machine.shaft import Friction, Stribeck
from benchtool.errors import ValueRefused

Number = TypeVar("Number", bound=float)


@dataclass(frozen=True, kw_only=True)
class MotorTruth:
    """A permanent-magnet machine, amplitude-invariant and per phase.

    `cogging_order` counts periods of the cogging torque per mechanical revolution, -cogging_Nm
    sin(cogging_order theta_m + cogging_phase_rad); several orders are a tuple of each. `psi_5_Wb` to
    `psi_13_Wb` are the harmonics of the rotor flux linkage of phase a, as cosines of 5 to 13 theta_e. Of the
    phases a, b and c, `psi_of_phase` is by what factor they link the rotor's fundamental, and `series_R_ohm`
    and `series_L_H` is what is in series with each.
    A shaft at rest sticks up to `breakaway_Nm`, which is the Coulomb torque where it is stated lower; while
    the shaft turns, what it has above the Coulomb torque fades out over `stribeck_rad_s`, or at once if that
    is 0. `power_up_angle_rad` is the shaft's mechanical angle when the drive is switched on.

    Raises:
        ValueRefused: a value is not finite, negative, or zero where the machine could not move.
    """

    pole_pairs: int
    R_s_ohm: float
    L_d_H: float
    L_q_H: float
    psi_r_Wb: float
    J_kgm2: float
    friction_Nms: float = 0.0
    coulomb_Nm: float = 0.0
    breakaway_Nm: float = 0.0
    stribeck_rad_s: float = 0.0
    cogging_Nm: float | tuple[float, ...] = ()
    cogging_order: int | tuple[int, ...] = ()
    cogging_phase_rad: float | tuple[float, ...] = ()
    psi_5_Wb: float = 0.0
    psi_7_Wb: float = 0.0
    psi_11_Wb: float = 0.0
    psi_13_Wb: float = 0.0
    psi_of_phase: tuple[float, float, float] = (1.0, 1.0, 1.0)
    series_R_ohm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    series_L_H: tuple[float, float, float] = (0.0, 0.0, 0.0)
    saturation: SaturationTruth | None = None
    R_fe_ohm: float = math.inf
    heat: HeatTruth | None = None
    power_up_angle_rad: float = 0.0

    def __post_init__(self) -> None:
        if self.R_fe_ohm < math.inf:
            positive(R_fe_ohm=self.R_fe_ohm)
        positive(pole_pairs=self.pole_pairs, L_d_H=self.L_d_H, L_q_H=self.L_q_H, J_kgm2=self.J_kgm2)
        not_negative(
            R_s_ohm=self.R_s_ohm,
            psi_r_Wb=self.psi_r_Wb,
            friction_Nms=self.friction_Nms,
            coulomb_Nm=self.coulomb_Nm,
            breakaway_Nm=self.breakaway_Nm,
            stribeck_rad_s=self.stribeck_rad_s,
        )
        self._require_cogging()
        finite(
            psi_5_Wb=self.psi_5_Wb,
            psi_7_Wb=self.psi_7_Wb,
            psi_11_Wb=self.psi_11_Wb,
            psi_13_Wb=self.psi_13_Wb,
            power_up_angle_rad=self.power_up_angle_rad,
        )
        for phase, psi, R, L in zip(
            "abc", self.psi_of_phase, self.series_R_ohm, self.series_L_H, strict=True
        ):
            not_negative(
                **{
                    f"psi_of_phase of phase {phase}": psi,
                    f"series_R_ohm of phase {phase}": R,
                    f"series_L_H of phase {phase}": L,
                }
            )

    def machine(
        self,
        speed_held: bool = False,
        devices_ohm: float = 0.0,
        J_load_kgm2: float = 0.0,
        train: DriveTrain | None = None,
    ) -> Machine:
        """Return the coefficients of the differential equations, with devices of this resistance in each
        phase, this inertia rigid on the rotor, and what else is beyond it."""
        psi_r = self.psi_r_Wb * sequences(*self.psi_of_phase)[0]
        return machine_of(
            float(self.pole_pairs),
            self.R_s_ohm + devices_ohm,
            self.L_d_H,
            self.L_q_H,
            psi_r,
            self.J_kgm2,
            self.friction_Nms,
            self._saturation(psi_r),
            self._harmonics(),
            self._asymmetry(),
            Iron(1.0 / self.R_fe_ohm) if self.R_fe_ohm < math.inf else None,
            self._cogging(),
            self._friction(),
            J_load_kgm2,
            train,
            speed_held,
            False,
        )

    def _saturation(self, psi_r_Wb: float) -> Saturation | None:
        if self.saturation is None:
            return None
        return self.saturation.coefficients(self.L_d_H, self.L_q_H, psi_r_Wb)

    def _harmonics(self) -> Harmonics | None:
        orders = (self.psi_5_Wb, self.psi_7_Wb, self.psi_11_Wb, self.psi_13_Wb)
        _, alpha, beta = sequences(*self.psi_of_phase)
        unbalance = None
        if alpha != 0.0 or beta != 0.0:
            unbalance = Unbalance(self.psi_r_Wb * alpha, self.psi_r_Wb * beta)
        if unbalance is None and not any(orders):
            return None
        return Harmonics(*orders, unbalance)

    def _asymmetry(self) -> Asymmetry | None:
        if not any(self.series_R_ohm) and not any(self.series_L_H):
            return None
        return Asymmetry(*sequences(*self.series_R_ohm), *sequences(*self.series_L_H))

    def _friction(self) -> Friction | None:
        breakaway = max(self.breakaway_Nm, self.coulomb_Nm)
        if breakaway == 0.0:
            return None
        excess = breakaway - self.coulomb_Nm
        stribeck = None
        if excess > 0.0 and self.stribeck_rad_s > 0.0:
            stribeck = Stribeck(excess, 1.0 / (self.pole_pairs * self.stribeck_rad_s))
        return Friction(self.coulomb_Nm, breakaway, stribeck)

    def _require_cogging(self) -> None:
        torques_Nm, orders, phases_rad = self._cogging_rows()
        if not len(torques_Nm) == len(orders) == len(phases_rad):
            raise ValueRefused(
                f"{len(torques_Nm)} of cogging_Nm, {len(orders)} of cogging_order and {len(phases_rad)} of "
                f"cogging_phase_rad: state each of them for every order"
            )
        for torque, order, phase in zip(torques_Nm, orders, phases_rad, strict=True):
            not_negative(cogging_Nm=torque, cogging_order=order)
            finite(cogging_phase_rad=phase)

    def _cogging(self) -> Cogging | None:
        return cogging_of(*self._cogging_rows(), self.pole_pairs)

    def _cogging_rows(self) -> tuple[tuple[float, ...], tuple[int, ...], tuple[float, ...]]:
        """Return torques, orders and phases; what is left out is zero for each order."""
        torques_Nm, orders, phases_rad = (
            _each(self.cogging_Nm),
            _each(self.cogging_order),
            _each(self.cogging_phase_rad),
        )
        count = max(len(torques_Nm), len(orders))
        return torques_Nm or (0.0,) * count, orders or (0,) * count, phases_rad or (0.0,) * count

    @property
    def cogging_stiffness_Nm(self) -> float:
        """Bound of the slope of the cogging torque over theta_m, in Nm/rad."""
        torques_Nm, orders, _ = self._cogging_rows()
        return sum(torque * order for torque, order in zip(torques_Nm, orders, strict=True))


@dataclass(frozen=True, kw_only=True)
class InverterTruth:
    """A two-level inverter on a dc link behind a resistance.

    Every conducting device, switch or diode, takes `device_drop_V` and `on_resistance_ohm` times its current.
    With `double_update` a PWM period is two control periods, whose duties it takes at either end. `timer_Hz`
    is the clock of the timer that counts up and down in a PWM period; 0 is as fine as you like.
    With `dc_link_C_F` the link is a capacitor that the supply feeds through `dc_link_R_ohm` and takes nothing
    back from; `supply_ripple_V` is the amplitude of the supply's ripple. `energy_accounts` keeps the accounts
    of the whole bench.

    Raises:
        ValueRefused: a value is not finite or out of its range.
    """

    u_dc_V: float
    double_update: bool = False
    dc_link_R_ohm: float = 0.0
    dead_time_s: float = 0.0
    device_drop_V: float = 0.0
    on_resistance_ohm: float = 0.0
    timer_Hz: float = 0.0
    dc_link_C_F: float = 0.0
    supply_ripple_V: float = 0.0
    supply_ripple_Hz: float = 0.0
    chopper_R_ohm: float = 0.0
    chopper_on_V: float = 0.0
    chopper_off_V: float = 0.0
    energy_accounts: bool = False

    def __post_init__(self) -> None:
        positive(u_dc_V=self.u_dc_V)
        not_negative(
            dc_link_R_ohm=self.dc_link_R_ohm,
            dead_time_s=self.dead_time_s,
            device_drop_V=self.device_drop_V,
            on_resistance_ohm=self.on_resistance_ohm,
            timer_Hz=self.timer_Hz,
            dc_link_C_F=self.dc_link_C_F,
            supply_ripple_V=self.supply_ripple_V,
            supply_ripple_Hz=self.supply_ripple_Hz,
            chopper_R_ohm=self.chopper_R_ohm,
            chopper_on_V=self.chopper_on_V,
            chopper_off_V=self.chopper_off_V,
        )
        if self.dc_link_C_F > 0.0 and self.dc_link_R_ohm == 0.0:
            raise ValueRefused(
                "dc_link_C_F without dc_link_R_ohm: a capacitor is charged through a resistance"
            )
        if self.dc_link_C_F == 0.0 and (self.supply_ripple_V > 0.0 or self.chopper_R_ohm > 0.0):
            raise ValueRefused("supply_ripple_V or chopper_R_ohm without dc_link_C_F: state the capacitor")
        if self.chopper_R_ohm > 0.0 and not self.chopper_on_V > self.chopper_off_V > self.u_dc_V:
            raise ValueRefused(
                f"chopper_on_V = {self.chopper_on_V:g} and chopper_off_V = {self.chopper_off_V:g} with "
                f"u_dc_V = {self.u_dc_V:g}: have the first above the second, and both above the supply"
            )

    def power_stage(self, T_s: float, sampling: Sampling | None = None) -> PowerStage:
        """Return the coefficients for a control period of `T_s` seconds, in which the currents are so
        sampled."""
        T_pwm = self.pwm_period_s(T_s)
        return PowerStage(
            T_s=T_s,
            u_dc=self.u_dc_V,
            R_dc=self.dc_link_R_ohm,
            metered=self.dc_link_R_ohm > 0.0,
            link=self._dc_link(),
            heat=None,
            accounts=Accounts(self.on_resistance_ohm, self.device_drop_V) if self.energy_accounts else None,
            double_update=DoubleUpdate(T_pwm) if self.double_update else None,
            dead_time=DeadTime(self.dead_time_s) if self.dead_time_s > 0.0 else None,
            timer=Timer(max(1.0, math.floor(0.5 * T_pwm * self.timer_Hz))) if self.timer_Hz > 0.0 else None,
            devices=Devices(self.device_drop_V) if self.device_drop_V > 0.0 else None,
            sampling=sampling,
        )

    def pwm_period_s(self, T_s: float) -> float:
        """Return the PWM period of a drive whose control period is `T_s` seconds."""
        return 2.0 * T_s if self.double_update else T_s

    def _dc_link(self) -> DcLink | None:
        if self.dc_link_C_F == 0.0:
            return None
        return DcLink(
            C=self.dc_link_C_F,
            ripple=self.supply_ripple_V,
            omega_ripple=2.0 * math.pi * self.supply_ripple_Hz,
            chopper_on=self.chopper_on_V,
            chopper_off=self.chopper_off_V,
            G_chopper=1.0 / self.chopper_R_ohm if self.chopper_R_ohm > 0.0 else 0.0,
        )


def _each(value: Number | tuple[Number, ...]) -> tuple[Number, ...]:
    return value if isinstance(value, tuple) else (value,)


def positive(**values: float) -> None:
    """Refuse what is not a finite number above zero."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueRefused(f"{name} = {value}, a finite number above 0 is needed: correct it")


def not_negative(**values: float) -> None:
    """Refuse what is not a finite number of zero or more."""
    for name, value in values.items():
        if not (math.isfinite(value) and value >= 0.0):
            raise ValueRefused(f"{name} = {value}, a finite number of 0 or more is needed: correct it")


def finite(**values: float) -> None:
    """Refuse infinities and what is not a number."""
    for name, value in values.items():
        if not math.isfinite(value):
            raise ValueRefused(f"{name} = {value}, a finite number is needed: correct it")
