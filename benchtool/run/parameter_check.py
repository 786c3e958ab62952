"""Check of the drive's parameters against the profile, before it is enabled."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from benchtool.drive import RemoteDrive
from benchtool.drive.parameters import Difference, default_of
from benchtool.errors import ParameterMismatch, ProfileError, ValueRefused
from benchtool.profile import Profile
from benchtool.protocol.dictionary import Dictionary, Value, Variable, setting_of, toml_key, variable_of

PERIODS: Final = frozenset({"control_period_s", "pwm_period_s"})
"""Keys of `[drive]` that a drive tells, and that nothing sets."""

_SHOWN = 6


@dataclass(frozen=True)
class ParameterCheck:
    """Differences between profile (`a`) and drive (`b`) in what the plan does not set.

    `contradicted` are parameters that differ from the profile. `unstated` are parameters that the profile
    does not state and that differ from their defaults; a run continues with these. `absent` are keys of
    `[drive.parameters]` that the drive does not have, with what to do about each.
    """

    contradicted: tuple[Difference, ...]
    unstated: tuple[Difference, ...]
    absent: Mapping[str, str]

    def require_known(self) -> None:
        """Refuse a profile that states parameters which the drive does not have.

        Raises:
            ProfileError: there is such a parameter.
        """
        if self.absent:
            raise ProfileError(f"[drive.parameters]: {'; '.join(self.absent.values())}")

    def require_equal(self) -> None:
        """Refuse a drive that contradicts the profile.

        Raises:
            ParameterMismatch: a parameter differs.
        """
        if periods := [each for each in self.contradicted if each.key in PERIODS]:
            raise ParameterMismatch(
                f"the drive has {_listed(tuple(periods), 'the profile states')}, which nothing can set: "
                f"state that of the drive in [drive] of the profile, name the drive's profile, or give "
                f"--allow-different; the drive was not enabled"
            )
        if self.contradicted:
            raise ParameterMismatch(
                f"the drive holds {_listed(self.contradicted, 'the profile states')}: set these on the drive "
                f"('benchtool params set'), in the profile or in a plan's [setup], name the drive's profile, "
                f"or give --allow-different; the drive was not enabled"
            )

    def lines(self) -> Iterator[str]:
        """Yield warnings for the user, if there are any."""
        if self.absent:
            yield f"stated by the profile, not in the drive: {', '.join(self.absent)}"
        if self.contradicted:
            yield f"different from the profile: {_listed(self.contradicted, 'the profile states')}"
        if self.unstated:
            yield f"set on the drive, not stated by the profile: {_listed(self.unstated, 'default')}"

    def to_json(self) -> dict[str, dict[str, dict[str, Value | None]]]:
        """Return the fields for the manifest."""
        return {
            "contradicted": {each.key: {"profile": each.a, "drive": each.b} for each in self.contradicted},
            "unstated": {each.key: {"default": each.a, "drive": each.b} for each in self.unstated},
        }


def check_parameters(drive: RemoteDrive, profile: Profile, set_by_plan: Collection[str]) -> ParameterCheck:
    """Compare what a drive holds with what the profile states, as the drive rounds it.

    Args:
        drive: connected.
        profile: its motor and its `[drive.parameters]`.
        set_by_plan: TOML keys that the plan sets, whatever the drive holds.

    Raises:
        ProfileError: the profile states a value that the drive's parameter cannot have.
    """
    stated = _stated(profile, drive.dictionary)
    contradicted = [
        Difference(key, held, now)
        for key, (variable, held) in stated.items()
        if key not in set_by_plan and (now := _read(drive, variable)) != held
    ]
    expected = _expected(drive.dictionary)
    unstated = [
        Difference(key, held, now)
        for key, (variable, held) in expected.items()
        if key not in set_by_plan and key not in stated and (now := _read(drive, variable)) != held
    ]
    return ParameterCheck(tuple(contradicted), tuple(unstated), _absent(profile, drive.dictionary))


def _stated(profile: Profile, dictionary: Dictionary) -> dict[str, tuple[Variable, int | float | str]]:
    """Return what the profile states of the parameters that the drive has."""
    found = {}
    names = {toml_key(variable) for variable in dictionary}
    for key, value in {**profile.drive.periods, **profile.stated_parameters}.items():
        if key not in names:
            continue  # a drive of another vendor has its own names of the motor's parameters
        try:
            variable = variable_of(dictionary, key) if key in PERIODS else setting_of(dictionary, key, value)
            held = variable.decode(variable.encode(value))
        except ValueRefused as refused:
            raise ProfileError(f"profile '{profile.title}': {refused}") from None
        if variable.readable and not isinstance(held, bytes):
            found[toml_key(variable)] = variable, held
    return found


def _absent(profile: Profile, dictionary: Dictionary) -> dict[str, str]:
    found = {}
    for key in profile.drive.parameters:
        try:
            variable_of(dictionary, key)
        except ValueRefused as refused:
            found[key] = str(refused)
    return found


def _expected(dictionary: Dictionary) -> Mapping[str, tuple[Variable, int | float | str]]:
    """Return the values of parameters that were not set: the defaults."""
    found = {}
    for variable in dictionary:
        if variable.role != "parameter" or not variable.readable:
            continue
        value = default_of(variable)
        if value is not None and not isinstance(value, bytes):
            found[toml_key(variable)] = variable, value
    return found


def _read(drive: RemoteDrive, variable: Variable) -> int | float | str:
    value = drive.read(variable.name)
    return value.hex() if isinstance(value, bytes) else value


def _listed(differences: tuple[Difference, ...], other: str) -> str:
    shown = [f"{each.key} = {_text(each.b)} ({other} {_text(each.a)})" for each in differences[:_SHOWN]]
    more = len(differences) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")


def _text(value: Value | None) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
