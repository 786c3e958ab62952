"""Profiles: a motor, its drive and the bench they stand on, as one validated TOML file.

A number's key ends in its unit. `[drive.parameters]` uses the dictionary's names with the unit appended
(`u_s_V`, `omega_observer_rad_s`). Motor quantities are amplitude-invariant (peak) and per phase.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationError, model_validator

from benchtool.document import Array, Section, document_path, explain, load_document
from benchtool.errors import ProfileError
from benchtool.shipped import shipped

Number = float | int
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]


class Motor(Section):
    """Rating and equivalent circuit, as the host and the drive's control believe them."""

    pole_pairs: Annotated[int, Field(gt=0, le=50)]
    R_s_ohm: NotNegative
    L_d_H: Positive
    L_q_H: Positive
    psi_r_Wb: Positive
    J_kgm2: Positive
    T_N_Nm: Positive
    omega_m_N_rad_s: Positive
    I_N_A_rms: Positive
    slots: Annotated[int, Field(gt=0)] | None = None


class Drive(Section):
    """The drive: where it answers, which dictionary it speaks and what it is set to."""

    node_id: Annotated[int, Field(ge=1, le=126)] = 1
    eds: str = "drive.eds"
    parameters: dict[str, float | str] = Field(default_factory=dict)


class TrueMotor(Section):
    """The machine as it really is on the emulated bench; what is left out is as in `[motor]`."""

    R_s_ohm: NotNegative | None = None
    L_d_H: Positive | None = None
    L_q_H: Positive | None = None
    psi_r_Wb: Positive | None = None
    J_kgm2: Positive | None = None
    friction_Nms: NotNegative = 0.0
    coulomb_Nm: NotNegative = 0.0
    cogging_Nm: NotNegative = 0.0
    cogging_order: Annotated[int, Field(ge=0)] = 0


class Inverter(Section):
    """The emulated power stage."""

    u_dc_V: Positive
    dc_link_R_ohm: NotNegative = 0.0
    dead_time_s: NotNegative = 0.0
    device_drop_V: NotNegative = 0.0


class Sensors(Section):
    """The emulated current, voltage and position measurement."""

    adc_bits: Annotated[int, Field(ge=4, le=24)] = 10
    i_full_scale_A: Positive
    u_full_scale_V: Positive
    current_noise_A_rms: NotNegative = 0.0
    encoder_lines: Annotated[int, Field(gt=0)] = 2500
    encoder_offset_rad: float = 0.0

    def full_scales(self) -> Mapping[str, float]:
        """Ends of the converter's ranges, by the keys of the objects that tell of them."""
        return {"i_full_scale_A": self.i_full_scale_A, "u_dc_full_scale_V": self.u_full_scale_V}


class Emulator(Section):
    """The emulated bench: true values, which control never sees."""

    motor: TrueMotor = TrueMotor()
    inverter: Inverter
    sensors: Sensors


class Choice(Section):
    """Where a source leaves something open or contradicts itself: what was chosen and why."""

    about: str
    choice: str
    reason: str
    effect: str


class Reference(Section):
    """A measured number; what is left out is as in the comparison that refers to it."""

    plan: str = ""
    case: str = ""
    measurement: str = ""


class Comparison(Section):
    """A measured number against `times` a value or another measured one; near: within that factor of it."""

    plan: str
    case: str
    measurement: str
    relation: Literal["below", "above", "near"]
    value: float | None = None
    other: Reference | None = None
    times: Positive = 1.0

    @model_validator(mode="after")
    def _has_one_partner(self) -> Comparison:
        if (self.value is None) == (self.other is None):
            raise ValueError("a comparison is with value or with other: give one of the two")
        return self


class Claim(Section):
    """What a source claims of its results, and the comparisons that all hold where it is right."""

    claim: str
    source: str
    comparisons: Annotated[Array[Comparison], Field(min_length=1)]


class Profile(Section):
    """Everything that is known of one motor on one drive."""

    title: str
    motor: Motor
    drive: Drive
    emulator: Emulator | None = None
    choices: Array[Choice] = ()
    claims: Array[Claim] = ()

    @property
    def stated_parameters(self) -> dict[str, float | str]:
        """What the drive is to hold, by TOML key: the motor, and `[drive.parameters]`."""
        motor = self.motor.model_dump(exclude={"I_N_A_rms", "slots"})  # slots are for the host alone
        return {**motor, "motor_rated_current_A": self.motor.I_N_A_rms, **self.drive.parameters}

    def commissioned(self) -> Mapping[str, float | str]:
        """What a drive of this profile is set to: what the profile states and, on an emulated bench, the
        encoder."""
        encoder = {"encoder_lines", "encoder_offset_rad"}
        sensors = self.emulator.sensors.model_dump(include=encoder) if self.emulator else {}
        return {**sensors, **self.stated_parameters}


def profile_path(name: str) -> Path:
    """File of a shipped profile's name, or of a path.

    Raises:
        ProfileError: neither exists.
    """
    path = shipped("profiles") / name / "profile.toml"
    place = path if path.is_relative_to(shipped("profiles")) else None
    return document_path(name, place, "profile", _names, ProfileError)


def load_profile(name: str) -> Profile:
    """The profile of a name or of a file.

    Raises:
        ProfileError: unknown, unreadable, or a key is wrong.
    """
    return load_document(profile_path(name), Profile, ProfileError)


def altered(profile: Profile, emulator: Mapping[str, Number]) -> Profile:
    """The profile with another emulated bench; `emulator` names what differs, such as `inverter.u_dc_V`.

    Raises:
        ProfileError: it has no emulated bench, or a key or value does not fit.
    """
    if not emulator:
        return profile
    if profile.emulator is None:
        raise ProfileError(
            f"'{next(iter(emulator))}' would alter the emulated bench, and '{profile.title}' has none: "
            f"run it with a profile that has an [emulator] section"
        )
    content = profile.emulator.model_dump(exclude_none=True)
    for key, value in emulator.items():
        section, _, name = key.partition(".")
        content.setdefault(section, {})[name] = value
    try:
        bench = Emulator.model_validate(content)
    except ValidationError as failed:
        raise ProfileError(f"emulated bench: {explain(Emulator, failed)}") from None
    return profile.model_copy(update={"emulator": bench})


def eds_path(profile: Profile, source: Path) -> Path:
    """The profile's EDS: beside the profile if it is there, else one that ships with the package.

    Raises:
        ProfileError: there is none.
    """
    for folder in (source.parent, shipped("firmware_protocol")):
        if (candidate := folder / profile.drive.eds).is_file():
            return candidate
    raise ProfileError(
        f"{source}: drive.eds names '{profile.drive.eds}', which is neither beside the profile nor shipped: "
        f"put the EDS beside the profile"
    )


def _names() -> list[str]:
    return sorted(path.parent.name for path in shipped("profiles").glob("*/profile.toml"))
