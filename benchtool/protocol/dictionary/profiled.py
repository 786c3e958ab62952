"""The dictionary of the drive that a profile describes: its EDS, and the roles that the profile redirects."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path, PurePath

from benchtool.document import line_of
from benchtool.errors import ProfileError, ValueRefused
from benchtool.profile import Profile, RoleObject, eds_path
from benchtool.protocol.dictionary.dictionary import Dictionary
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.quantity import spellings
from benchtool.protocol.dictionary.roles import Role
from benchtool.protocol.dictionary.variable import Variable


def profiled_dictionary(profile: Profile, source: Path, node_id: int) -> Dictionary:
    """Return the dictionary of the drive of `profile`, which was read from `source`.

    Raises:
        ProfileError: it names no EDS, an unknown role, or an object that the EDS has not.
        DictionaryError: the EDS cannot be read.
    """
    dictionary = Dictionary.from_eds(eds_path(profile, source), node_id)
    redirected: dict[Role, Variable] = {}
    for title, stated in profile.roles.items():
        try:
            role = Role.named(title)
            redirected[role] = _redirected(dictionary, role, stated)
        except ValueRefused as refused:
            line = line_of(source.read_text(encoding="utf-8"), ("roles", title))
            raise ProfileError(f"{source}{line}: key 'roles.{title}': {refused}") from None
    return replace(dictionary, redirected=redirected)


def _redirected(dictionary: Dictionary, role: Role, stated: RoleObject) -> Variable:
    """Return the object that has a role, in the unit that the profile states."""
    variable = dictionary[stated.object]
    if (variable.type is DataType.STRING) is not role.is_text or variable.type is DataType.DOMAIN:
        expected = "text" if role.is_text else "a number"
        raise ValueRefused(
            f"'{stated.object}' in {PurePath(dictionary.source).name} is of type {variable.type}, {expected} "
            f"is expected: name another object"
        )
    if role is Role.CONSUMER_HEARTBEAT and variable.index != role.key[0]:
        raise ValueRefused(
            f"'{stated.object}' is 0x{variable.index:04X}, an entry of 0x{role.key[0]:04X} is expected, the "
            f"only object by which CiA 301 has a node watch its host: leave the key out, and see "
            f"allow_unsupervised under [drive] if the drive has none"
        )
    if not stated.unit:
        return variable
    if not role.unit:
        raise ValueRefused(
            f"unit is '{stated.unit}', and a {role.title} is no quantity: leave unit and factor out"
        )
    if stated.unit not in _units(role):
        raise ValueRefused(f"unit is '{stated.unit}', and one of {', '.join(_units(role))} is expected")
    return replace(variable, unit=stated.unit, factor=stated.factor)


def _units(role: Role) -> tuple[str, ...]:
    """Return the units that a profile may state for the object of a role."""
    rated = {"Nm": ("T_N",), "A": ("I_N",)}.get(role.unit, ())
    return (*spellings(role.unit), *rated)
