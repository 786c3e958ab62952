"""A profile as one validated TOML file, and where it is found."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from benchtool.document import Array, Section, document_path, explain, load_document
from benchtool.errors import ProfileError
from benchtool.profile.bench import Bench
from benchtool.profile.claims import Choice, Claim
from benchtool.profile.drive import Drive
from benchtool.profile.emulator import Emulator
from benchtool.profile.motor import Motor
from benchtool.shipped import shipped

Number = float | int


class Profile(Section):
    """Everything that is known of one motor on one drive."""

    title: str
    motor: Motor
    drive: Drive
    bench: Bench = Bench()
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
