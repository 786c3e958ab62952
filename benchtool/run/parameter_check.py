"""The parameters that a drive holds, against those that the profile states, before it is enabled."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from benchtool.drive import RemoteDrive
from benchtool.drive.parameters.settings import Difference
from benchtool.drive.parameters.transaction import default_of
from benchtool.errors import ParameterMismatch, ProfileError, ValueRefused
from benchtool.profile import Profile
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.keys import setting_of, toml_key
from benchtool.protocol.dictionary.variable import Value, Variable

_SHOWN = 6


@dataclass(frozen=True)
class ParameterCheck:
    """Differences between profile (`a`) and drive (`b`) in what the plan does not set.

    `contradicted` are parameters that the profile states otherwise. `unstated` it does not state, and the
    drive does not hold their defaults either; a run goes on with these.
    """

    contradicted: tuple[Difference, ...]
    unstated: tuple[Difference, ...]

    def require_equal(self) -> None:
        """Refuse a drive that contradicts the profile.

        Raises:
            ParameterMismatch: it does.
        """
        if self.contradicted:
            raise ParameterMismatch(
                f"the drive holds {_listed(self.contradicted, 'the profile states')}: set these on the drive "
                f"('benchtool params set'), in the profile or in the plan's [setup], or give "
                f"--allow-different; the drive was not enabled"
            )

    def lines(self) -> Iterator[str]:
        """What a person should know, if anything."""
        if self.contradicted:
            yield f"different from the profile: {_listed(self.contradicted, 'the profile states')}"
        if self.unstated:
            yield f"set on the drive, not stated by the profile: {_listed(self.unstated, 'default')}"

    def to_json(self) -> dict[str, dict[str, dict[str, Value | None]]]:
        """As a manifest keeps it."""
        return {
            "contradicted": {each.key: {"profile": each.a, "drive": each.b} for each in self.contradicted},
            "unstated": {each.key: {"default": each.a, "drive": each.b} for each in self.unstated},
        }


def check_parameters(drive: RemoteDrive, profile: Profile, set_by_plan: Collection[str]) -> ParameterCheck:
    """Compare what a drive holds with what the profile states, as the drive rounds it.

    Args:
        drive: connected.
        profile: its motor and its `[drive.parameters]`; the sensors of its emulated bench are what an
            encoder's parameters are to be.
        set_by_plan: TOML keys that the plan sets, whatever the drive holds.

    Raises:
        ProfileError: the profile states a parameter that the drive has not, or a value that it cannot have.
    """
    stated = _stated(profile, drive.dictionary)
    contradicted = [
        Difference(key, held, now)
        for key, (variable, held) in stated.items()
        if key not in set_by_plan and (now := _read(drive, variable)) != held
    ]
    expected = _expected(profile, drive.dictionary)
    unstated = [
        Difference(key, held, now)
        for key, (variable, held) in expected.items()
        if key not in set_by_plan and key not in stated and (now := _read(drive, variable)) != held
    ]
    return ParameterCheck(tuple(contradicted), tuple(unstated))


def _stated(profile: Profile, dictionary: Dictionary) -> dict[str, tuple[Variable, int | float | str]]:
    """What the profile states of the parameters that the drive has."""
    found = {}
    for key, value in profile.stated_parameters.items():
        try:
            variable = setting_of(dictionary, key, value)
            held = variable.decode(variable.encode(value))
        except ValueRefused as refused:
            if key not in profile.drive.parameters and not _has(dictionary, key):
                continue  # another maker's drive may call the motor's parameters as it likes
            raise ProfileError(f"profile '{profile.title}': {refused}") from None
        if variable.readable and not isinstance(held, bytes):
            found[toml_key(variable)] = variable, held
    return found


def _has(dictionary: Dictionary, key: str) -> bool:
    return any(toml_key(variable) == key for variable in dictionary)


def _expected(profile: Profile, dictionary: Dictionary) -> Mapping[str, tuple[Variable, int | float | str]]:
    """What parameters are unless somebody has set them: defaults, and the encoder of the emulated bench."""
    sensors = {} if profile.emulator is None else profile.emulator.sensors.model_dump()
    found = {}
    for variable in dictionary:
        if variable.role != "parameter" or not variable.readable:
            continue
        key = toml_key(variable)
        value = variable.decode(variable.encode(sensors[key])) if key in sensors else default_of(variable)
        if value is not None and not isinstance(value, bytes):
            found[key] = variable, value
    return found


def _read(drive: RemoteDrive, variable: Variable) -> int | float | str:
    value = drive.read(variable.name)
    return value.hex() if isinstance(value, bytes) else value


def _listed(differences: tuple[Difference, ...], other: str) -> str:
    shown = [f"{each.key} = {_text(each.b)} ({other} {_text(each.a)})" for each in differences[:_SHOWN]]
    more = len(differences) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")


def _text(value: Value | None) -> str:
    return f"{value:.7g}" if isinstance(value, float) else str(value)
