"""A profile as one validated TOML file, and where it is found."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, Field, ValidationError, model_validator

from benchtool.document import (
    Array,
    Section,
    defaults,
    document_path,
    load_document,
    parse_document,
    read_document,
)
from benchtool.errors import ProfileError
from benchtool.file_kinds import FileKind, kind_of, mistaken
from benchtool.misfits import explain
from benchtool.profile.bench import Bench
from benchtool.profile.claims import Choice, Claim
from benchtool.profile.drive import CONTROL_PERIOD_S, Drive, RoleObject, rate_fault
from benchtool.profile.emulator import Emulator
from benchtool.profile.limits import Limits
from benchtool.profile.motor import Motor
from benchtool.shipped import shipped

Number = float | int


class Profile(Section):
    """Everything known about one motor on one drive.

    `roles` has the objects for which this drive departs from CiA 301 and CiA 402, by role.
    """

    title: str
    """One line that names motor and drive in reports."""
    motor: Motor
    """Rating and equivalent circuit, as the host and the drive's control assume them."""
    nameplate: Motor | None = None
    """What `[motor]` stated before a commissioning replaced it; an emulated machine is as this states it."""
    drive: Drive
    """Where the drive answers, which dictionary it speaks, what it is set to."""
    bench: Bench = defaults(Bench)
    """What stands beside the drive, and how well it measures."""
    limits: Limits = defaults(Limits)
    """What the host supervises while the drive is enabled, beside the drive's own trip levels."""
    roles: dict[str, RoleObject] = Field(default_factory=dict)
    """Objects of this drive that differ from CiA 301 and CiA 402, by role."""
    emulator: Emulator | None = None
    """The emulated bench; a profile without it runs on real links only."""
    choices: Array[Choice] = ()
    """What a published source leaves open, and how it is read here."""
    claims: Array[Claim] = ()
    """What a published source claims of its results."""

    @model_validator(mode="after")
    def _can_be_emulated(self) -> Profile:
        if self.emulator is not None:
            fault = rate_fault(self.drive.pwm_period_s or self.control_period_s)
            if fault:
                raise ValueError(f"drive.control_period_s: {fault}")
        return self

    @property
    def control_period_s(self) -> float:
        """T_s that the drive is expected to have, and that an emulated one has: whole nanoseconds."""
        return round((self.drive.control_period_s or CONTROL_PERIOD_S) * 1e9) * 1e-9

    @property
    def series_ohm(self) -> float | None:
        """What is stated to be in series with `motor.R_s_ohm`; 0 where a commissioning measured both."""
        return self.drive.on_resistance_ohm if self.nameplate is None else 0.0

    @property
    def stated_parameters(self) -> dict[str, float | str]:
        """What the drive is to hold, by TOML key: the motor, and `[drive.parameters]`."""
        return {**self.motor.parameters, **self.drive.parameters}


class _BenchOfDocument(Section):
    """`[bench]` of a document, whatever else that holds."""

    model_config = ConfigDict(extra="ignore")

    bench: Bench = defaults(Bench)


def profile_path(name: str) -> Path:
    """Return the file of a shipped profile's name, or of a path.

    Raises:
        ProfileError: neither exists.
    """
    path = shipped("profiles") / name / "profile.toml"
    place = path if path.is_relative_to(shipped("profiles")) else None
    return document_path(name, place, FileKind.PROFILE, shipped_profiles, ProfileError)


def load_profile(name: str) -> Profile:
    """Return the profile of a name or of a file.

    Raises:
        ProfileError: unknown, unreadable, or a key is wrong.
    """
    path = profile_path(name)
    return _parsed(read_document(path, ProfileError), path)


@lru_cache(maxsize=8)
def _parsed(text: str, path: Path) -> Profile:
    """Return the profile that a file has; a run asks for the same one several times."""
    return parse_document(text, path, Profile, ProfileError, kind=FileKind.PROFILE)


def bench_of(content: dict[str, Any]) -> Bench:
    """`[bench]` of a profile's content, whether or not this version understands the rest of it.

    Raises:
        ValidationError: the section is wrong.
    """
    return _BenchOfDocument.model_validate(content).bench


def load_bench(name: str) -> Bench:
    """`[bench]` of a profile, or of a file that need not hold anything else.

    Raises:
        ProfileError: there is no such file, or its section is missing or wrong.
    """
    path = profile_path(name)
    found = load_document(path, _BenchOfDocument, ProfileError, kind=FileKind.BENCH)
    if "bench" not in found.model_fields_set:
        missing = f"{path} has no section [bench]: state the sensors there, [bench.channels.NAME]"
        is_profile = kind_of(path) is FileKind.PROFILE
        raise ProfileError(missing if is_profile else mistaken(path, FileKind.BENCH) or missing)
    return found.bench


def altered(profile: Profile, emulator: Mapping[str, Number]) -> Profile:
    """Return profile with another emulated bench; `emulator` names what differs, such as `inverter.u_dc_V`.

    What is true or false is 1 or 0.

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
        *sections, name = key.split(".")
        table = content
        for section in sections:
            if not isinstance(table.get(section), dict):
                table[section] = {}
            table = table[section]
        is_flag = isinstance(table.get(name), bool) and value in (0, 1)
        table[name] = bool(value) if is_flag else value
    try:
        bench = Emulator.model_validate(content)
    except ValidationError as failed:
        raise ProfileError(f"emulated bench: {explain(Emulator, failed)}") from None
    return profile.model_copy(update={"emulator": bench})


def eds_path(profile: Profile, source: Path) -> Path:
    """Return the profile's EDS: beside the profile if it is there, else one that ships with the package.

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


def shipped_profiles() -> list[str]:
    """Return the names of the profiles that ship."""
    root = shipped("profiles")
    return sorted(path.parent.relative_to(root).as_posix() for path in root.rglob("profile.toml"))
