from .bench import (
    Bench as Bench,
    Instrument as Instrument,
    ReferenceClock as ReferenceClock,
    Sensor as Sensor,
)
from .claims import (
    Choice as Choice,
    Claim as Claim,
    Comparison as Comparison,
    Reference as Reference,
)
from .derivation import (
    LAWS as LAWS,
    Derived as Derived,
    Given as Given,
    derived_parameters as derived_parameters,
)
from .drive import (
    CONTROL_PERIOD_S as CONTROL_PERIOD_S,
    Drive as Drive,
    RoleObject as RoleObject,
    rate_fault as rate_fault,
)
from .emulated_shaft import (
    DrivenLoad as DrivenLoad,
    EmulatedLoadMachine as EmulatedLoadMachine,
    FlangeTransducer as FlangeTransducer,
    Shaft as Shaft,
)
from .emulator import (
    Emulator as Emulator,
    Heat as Heat,
    Inverter as Inverter,
    Saturation as Saturation,
    TrueMotor as TrueMotor,
)
from .equipment import (
    DRIVES_BUS as DRIVES_BUS,
    Absent as Absent,
    CanFrames as CanFrames,
    CanSupply as CanSupply,
    CanTemperature as CanTemperature,
    CanTransducer as CanTransducer,
    Emulated as Emulated,
    EmulatedTemperature as EmulatedTemperature,
    Operator as Operator,
)
from .limits import Limits as Limits
from .motor import Motor as Motor
from .nameplate import (
    Amplitude as Amplitude,
    Nameplate as Nameplate,
    Voltage as Voltage,
    Winding as Winding,
    flux_of_ke as flux_of_ke,
    flux_of_kt as flux_of_kt,
    flux_of_kv as flux_of_kv,
)
from .profile import (
    Profile as Profile,
    altered as altered,
    bench_of as bench_of,
    eds_path as eds_path,
    load_bench as load_bench,
    load_profile as load_profile,
    profile_path as profile_path,
    shipped_profiles as shipped_profiles,
)
from .sensors import (
    CurrentSensor as CurrentSensor,
    Sensors as Sensors,
    TemperatureSensor as TemperatureSensor,
)
from .template import profile_text as profile_text
