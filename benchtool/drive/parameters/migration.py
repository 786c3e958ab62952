"""Migration of parameter values between versions of a dictionary, by stated rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

from pydantic import Field

from benchtool.document import Array, Section, load_document
from benchtool.errors import ParameterFileError
from benchtool.shipped import shipped

Hash = Annotated[int, Field(ge=0, le=0xFFFFFFFF)]
Number = int | float | str


class Migration(Section):
    """One change of the dictionary: renamed and rescaled parameters between two versions."""

    from_hash: Hash
    to_hash: Hash
    rename: dict[str, str] = Field(default_factory=dict)
    scale: dict[str, float] = Field(default_factory=dict)
    drop: Array[str] = ()

    def apply(self, values: Mapping[str, Number]) -> dict[str, Number]:
        """Return the values by key in the later dictionary.

        Raises:
            ParameterFileError: an old and its new key are both there, or a value to be scaled is not a
            number.
        """
        both = [f"'{old}' and '{new}'" for old, new in self.rename.items() if {old, new} <= values.keys()]
        if both:
            raise ParameterFileError(f"{both[0]} are the same parameter, one of them is expected: remove one")
        renamed = {self.rename.get(key, key): value for key, value in values.items() if key not in self.drop}
        return {key: self._scaled(key, value) for key, value in renamed.items()}

    def _scaled(self, key: str, value: Number) -> Number:
        if key not in self.scale:
            return value
        if isinstance(value, str):
            raise ParameterFileError(f"'{key}' is {value!r}, a number is expected: correct the file")
        return value * self.scale[key]


class Migrations(Section):
    """All rules of a dictionary."""

    migration: Array[Migration] = ()

    def path(self, from_hash: int, to_hash: int) -> Sequence[Migration] | None:
        """Return the shortest chain of rules between two versions; None if there is none."""
        chains: list[tuple[Migration, ...]] = [()]
        seen = {from_hash}
        for chain in chains:
            at = chain[-1].to_hash if chain else from_hash
            if at == to_hash:
                return chain
            onward = [rule for rule in self.migration if rule.from_hash == at and rule.to_hash not in seen]
            seen.update(rule.to_hash for rule in onward)
            chains.extend((*chain, rule) for rule in onward)
        return None


def shipped_migrations() -> Migrations:
    """Return the rules of the reference drive's dictionary."""
    return load_document(shipped("firmware_protocol") / "migrations.toml", Migrations, ParameterFileError)
