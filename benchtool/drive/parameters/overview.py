"""Parameters as a person looks at them: value, unit, limits, default, description."""

from __future__ import annotations

import fnmatch
from dataclasses import dataclass
from typing import Any, Self

from benchtool.drive.parameters.file import about
from benchtool.drive.parameters.transaction import default_of, parameters
from benchtool.drive.remote import RemoteDrive
from benchtool.errors import ValueRefused
from benchtool.protocol.dictionary import Value, Variable, plain, shown


@dataclass(frozen=True, repr=False)
class Parameter:
    """One parameter and what the drive holds."""

    variable: Variable
    value: Value

    @classmethod
    def of(cls, drive: RemoteDrive, variable: Variable) -> Self:
        """Return a parameter as it is read now."""
        return cls(variable, drive.read(variable.name))

    @property
    def name(self) -> str:
        return self.variable.name

    @property
    def unit(self) -> str:
        return self.variable.unit

    @property
    def minimum(self) -> float | None:
        return self.variable.minimum

    @property
    def maximum(self) -> float | None:
        return self.variable.maximum

    @property
    def default(self) -> Value | None:
        """As the drive would hold it; None without one."""
        return default_of(self.variable)

    @property
    def differs(self) -> bool:
        """Whether the value is not the default."""
        return self.default is not None and self.value != self.default

    @property
    def description(self) -> str:
        return self.variable.description

    @property
    def about(self) -> str:
        """Description and limits on one line."""
        return about(self.variable)

    @property
    def access(self) -> str:
        """`ro`, `rw`, or `rw if off` of what can be written with the power stage off only."""
        variable = self.variable
        return variable.access if variable.enabled_write else f"{variable.access} if off"

    @property
    def shown(self) -> str:
        """The value for people."""
        return shown(self.value)

    def __repr__(self) -> str:
        return f"<Parameter {self}; {self.about}>"

    def __str__(self) -> str:
        return f"{self.name} = {self.shown} {self.unit}".rstrip()

    def to_json(self) -> dict[str, Any]:
        """As `benchtool params list --json` has it."""
        variable, default = self.variable, self.default
        return {
            "name": variable.name,
            "index": variable.label,
            "value": plain(self.value),
            "unit": variable.unit,
            "minimum": variable.minimum,
            "maximum": variable.maximum,
            "values": list(variable.values) if variable.values is not None else None,
            "default": None if default is None else plain(default),
            "differs": self.differs,
            "access": variable.access,
            "enabled_write": variable.enabled_write,
            "description": variable.description,
        }


def overview(drive: RemoteDrive, pattern: str = "") -> tuple[Parameter, ...]:
    """Return the parameters of a drive whose names match: contain `pattern`, or fit it if it has * and ?.

    Raises:
        ValueRefused: there is none.
    """
    chosen = [each for each in parameters(drive.dictionary) if _matches(each.name, pattern)]
    if not chosen:
        raise ValueRefused(f"no parameter matches '{pattern}': see benchtool params list")
    return tuple(Parameter.of(drive, variable) for variable in chosen)


def _matches(name: str, pattern: str) -> bool:
    wanted = pattern.lower()
    return fnmatch.fnmatchcase(name.lower(), wanted) if set(wanted) & set("*?[") else wanted in name.lower()
