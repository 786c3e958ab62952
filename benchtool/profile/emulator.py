"""The emulated bench as a profile states it. Every number is bounded: what is left can be computed."""

from __future__ import annotations

from typing import Annotated, TypeVar

from pydantic import BeforeValidator, Field, model_validator

from benchtool.document import Array, Item, Section, defaults
from benchtool.profile.emulated_shaft import DrivenLoad, EmulatedLoadMachine, FlangeTransducer, Shaft
from benchtool.profile.flux_linkages import FluxLinkages
from benchtool.profile.sensors import Sensors

Resistance = Annotated[float, Field(ge=0, le=1e4)]
Inductance = Annotated[float, Field(ge=1e-7, le=10)]
Inertia = Annotated[float, Field(ge=1e-9, le=1e4)]
Torque = Annotated[float, Field(ge=0, le=1e5)]
Voltage = Annotated[float, Field(ge=0.1, le=1e5)]
Linkage = Annotated[float, Field(ge=-100, le=100)]
Number = TypeVar("Number")
PerPhase = Annotated[tuple[Number, Number, Number], Field(strict=False)]

Phase = Annotated[float, Field(ge=-100, le=100)]


def _whole(value: object) -> object:
    """Take a whole number of a plan, where every value of the bench is a float, for the integer that it
    is."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _each(value: object) -> object:
    """Take one value for an array of one."""
    return (value,) if isinstance(value, int | float) else value


Order = Annotated[int, BeforeValidator(_whole), Field(ge=0, le=1000)]
Several = Annotated[Array[Item], BeforeValidator(_each), Field(max_length=16)]


class Saturation(Section):
    """Saturation and cross-coupling: currents as a polynomial of the flux linkages.

    `L_d_H`, `L_q_H` and `psi_r_Wb` are those without current; what is here is added with the flux linkages:
    i_d by (a_dd |psi_d|^S + a_dq / (V + 2) |psi_d|^U |psi_q|^(V + 2)) psi_d, and i_q by
    (a_qq |psi_q|^T + a_dq / (U + 2) |psi_d|^(U + 2) |psi_q|^V) psi_q, in A and Wb.
    """

    a_dd: Annotated[float, Field(ge=0, le=1e40)] = 0.0
    """Saturation along the rotor flux, in A/Wb^(S + 1)."""
    a_qq: Annotated[float, Field(ge=0, le=1e40)] = 0.0
    """Saturation across the rotor flux, in A/Wb^(T + 1)."""
    a_dq: Annotated[float, Field(ge=0, le=1e40)] = 0.0
    """Cross-coupling, in A/Wb^(U + V + 3)."""
    S: Annotated[int, Field(ge=1, le=12)] = 5
    """Exponent of the saturation along the rotor flux."""
    T: Annotated[int, Field(ge=1, le=12)] = 1
    """Exponent of the saturation across the rotor flux."""
    U: Annotated[int, Field(ge=0, le=12)] = 1
    """Exponent of the cross-coupling."""
    V: Annotated[int, Field(ge=0, le=12)] = 0
    """Exponent of the cross-coupling."""


Capacity = Annotated[float, Field(ge=1e-3, le=1e9)]
ThermalResistance = Annotated[float, Field(ge=1e-6, le=1e6)]


class Heat(Section):
    """Two thermal masses: the winding, and the body of the motor with its iron and magnets.

    The resistance and the rotor flux follow the temperatures once a control period. Without the table both
    are constants.
    """

    C_winding_J_K: Capacity
    """Heat capacity of the winding, in J/K."""
    C_body_J_K: Capacity
    """Heat capacity of iron, magnets and housing, in J/K."""
    R_winding_body_K_W: ThermalResistance
    """Thermal resistance between the winding and the body, in K/W."""
    R_body_ambient_K_W: ThermalResistance
    """Thermal resistance between the body and the surroundings, in K/W."""
    ambient_degC: Annotated[float, Field(ge=-60, le=200)] = 25.0
    """Temperature of the surroundings, and of the motor at power-up."""
    reference_degC: Annotated[float, Field(ge=-60, le=200)] = 25.0
    """Temperature at which `R_s_ohm` and `psi_r_Wb` hold."""
    alpha_R_1_K: Annotated[float, Field(ge=0, le=0.02)] = 0.00393
    """Change of the resistance per kelvin; by default that of copper."""
    alpha_psi_1_K: Annotated[float, Field(ge=-0.02, le=0)] = -0.0011
    """Change of the rotor flux per kelvin; by default that of NdFeB magnets."""


class TrueMotor(Section):
    """The true machine of the emulated bench; keys that are left out are as in `[motor]`."""

    pole_pairs: Annotated[int, Field(gt=0, le=50)] | None = None
    """True number of pole pairs."""
    R_s_ohm: Resistance | None = None
    """True stator resistance of one phase; `[motor]` has what control believes."""
    L_d_H: Inductance | None = None
    """True inductance along the rotor flux."""
    L_q_H: Inductance | None = None
    """True inductance across the rotor flux."""
    psi_r_Wb: Annotated[float, Field(gt=0, le=100)] | None = None
    """True rotor flux linkage, peak."""
    J_kgm2: Inertia | None = None
    """True moment of inertia."""
    friction_Nms: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Viscous friction: torque per mechanical speed."""
    coulomb_Nm: Torque = 0.0
    """Coulomb friction of the turning shaft, independent of the speed."""
    breakaway_Nm: Torque = 0.0
    """Torque up to which a shaft at rest stays at rest; at least `coulomb_Nm`."""
    stribeck_rad_s: Annotated[float, Field(ge=0, le=1e4)] = 0.0
    """Mechanical speed at which 1/e is left of what `breakaway_Nm` has above `coulomb_Nm`; 0: nothing."""
    psi_5_Wb: Linkage = 0.0
    """Fifth harmonic of the rotor flux linkage of phase a, as a cosine of five times the electrical angle."""
    psi_7_Wb: Linkage = 0.0
    """Seventh harmonic of the rotor flux linkage of phase a."""
    psi_11_Wb: Linkage = 0.0
    """Eleventh harmonic of the rotor flux linkage of phase a."""
    psi_13_Wb: Linkage = 0.0
    """Thirteenth harmonic of the rotor flux linkage of phase a."""
    psi_of_phase: PerPhase[Annotated[float, Field(ge=0, le=2)]] = (1.0, 1.0, 1.0)
    """Of the phases a, b and c: by what factor they link the fundamental of the rotor flux."""
    series_R_ohm: PerPhase[Resistance] = (0.0, 0.0, 0.0)
    """Of the phases a, b and c: resistance in series with `R_s_ohm`, such as that of a poor contact."""
    series_L_H: PerPhase[Annotated[float, Field(ge=0, le=10)]] = (0.0, 0.0, 0.0)
    """Of the phases a, b and c: inductance in series with `L_d_H` and `L_q_H`, such as that of a cable."""
    R_fe_ohm: Annotated[float, Field(ge=1e-3, le=1e9)] | None = None
    """Resistance across the EMF that takes the iron loss; without it there is none."""
    heat: Heat | None = None
    """How winding and magnets warm up; without it they stay as they are."""
    saturation: Saturation | None = None
    """How the machine saturates; without it the inductances are constants."""
    flux_linkages: FluxLinkages | None = None
    """The same as a table, in place of `saturation`, `L_d_H`, `L_q_H` and `psi_r_Wb`; the polynomial of
    `saturation` is fitted to it, within 3 % of the largest flux linkage."""
    cogging_Nm: Several[Torque] = ()
    """Amplitude of the cogging torque; an array of one for each order."""
    cogging_order: Several[Order] = ()
    """Periods of the cogging torque in a mechanical revolution; an array of one for each order."""
    cogging_phase_rad: Several[Phase] = ()
    """Phase of the cogging torque at mechanical angle 0, -T sin(order theta_m + phase); without it 0."""
    power_up_angle_rad: Annotated[float, Field(ge=-100, le=100)] = 0.0
    """Mechanical angle of the shaft at power-up; 0: the rotor flux on phase a."""

    @model_validator(mode="after")
    def _states_flux_once(self) -> TrueMotor:
        stated = [
            key for key in ("saturation", "L_d_H", "L_q_H", "psi_r_Wb") if getattr(self, key) is not None
        ]
        if self.flux_linkages is not None and stated:
            raise ValueError(f"flux_linkages tells {', '.join(stated)}: leave one of the two out")
        return self


class Inverter(Section):
    """The emulated power stage."""

    u_dc_V: Voltage
    """Voltage of the dc link without load."""
    dc_link_R_ohm: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Source resistance of the dc link."""
    dead_time_s: Annotated[float, Field(ge=0, le=1e-5)] = 0.0
    """Dead time of a bridge leg, after each change of it."""
    device_drop_V: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Forward drop of a switch or diode."""
    on_resistance_ohm: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Resistance of a conducting switch or diode."""
    timer_Hz: Annotated[float, Field(ge=0, le=1e10)] = 0.0
    """Clock of the timer that counts up and down in a PWM period; the duties have its steps. 0: no steps."""
    dc_link_C_F: Annotated[float, Field(ge=1e-5, le=100)] | None = None
    """Capacitor of the dc link. The supply then feeds it and takes nothing back: braking pumps it up."""
    supply_ripple_V: Annotated[float, Field(ge=0, le=1e4)] = 0.0
    """Amplitude of the ripple of the supply's voltage."""
    supply_ripple_Hz: Annotated[float, Field(ge=0, le=2000)] = 0.0
    """Frequency of the ripple of the supply's voltage."""
    chopper_R_ohm: Annotated[float, Field(ge=1e-3, le=1e5)] | None = None
    """Resistance of a brake chopper across the capacitor."""
    chopper_on_V: Annotated[float, Field(ge=0, le=1e5)] = 0.0
    """Voltage of the dc link above which the chopper switches on."""
    chopper_off_V: Annotated[float, Field(ge=0, le=1e5)] = 0.0
    """Voltage of the dc link below which the chopper switches off again; above `u_dc_V`."""


class Emulator(Section):
    """The emulated bench: true values, which neither control nor the host ever sees."""

    motor: TrueMotor = defaults(TrueMotor)
    """The machine as it really is, where it differs from `[motor]`."""
    inverter: Inverter
    """The power stage."""
    sensors: Sensors
    """What the drive measures with."""
    energy_accounts: bool = False
    """Keep accounts of where the energy goes, from the supply to the load, and record them with every run;
    with `motor.heat` they are kept anyway."""
    commissioned: bool = True
    """Whether the drive has stored what the profile states of it; false: it starts with the defaults of its
    dictionary, as it comes out of its box."""
    shaft: Shaft = defaults(Shaft)
    """Inertia and coupling of the load."""
    load: DrivenLoad = defaults(DrivenLoad)
    """The machine that is driven."""
    load_machine: EmulatedLoadMachine | None = None
    """A load machine that gives way; without it an ideal one."""
    flange: FlangeTransducer | None = None
    """A torque transducer at the flange; without it the air-gap torque is recorded."""
