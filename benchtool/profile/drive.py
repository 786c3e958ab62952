"""A drive: where it answers, which dictionary it speaks, what it is set to, and where its objects differ."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from benchtool.document import Section


class Drive(Section):
    """The drive: where it answers, which dictionary it speaks and what it is set to.

    With `allow_unsupervised` it may be enabled although nothing stops it when this host falls silent.
    """

    node_id: Annotated[int, Field(ge=1, le=126)] = 1
    """CANopen node id of the drive; `&node=` of a link overrides it."""
    eds: str = "drive.eds"
    """EDS or DCF of the drive, a file beside the profile; `drive.eds` is benchtool's own dictionary."""
    allow_unsupervised: bool = False
    """Enable a drive although nothing stops it when this host falls silent; reports then say so."""
    parameters: dict[str, float | str] = Field(default_factory=dict)
    """What the drive is set to: names of its dictionary with the unit appended, such as `u_s_V`."""


class RoleObject(Section):
    """The object that has a role on this drive, by name or as `0x3001:2`; in a profile that text alone does.

    Where the EDS does not say what its numbers are, `raw * factor` is the value in `unit`.
    """

    object: str
    """The object that has the role, by name or as `0x3001:02`."""
    unit: str = ""
    """Unit of `raw * factor`, where the EDS does not state it."""
    factor: float = 1.0
    """Value of one raw step in `unit`."""

    @model_validator(mode="before")
    @classmethod
    def _object_alone(cls, stated: Any) -> Any:
        if not isinstance(stated, str | dict):
            raise ValueError(
                "the object as text, '0x3001:2' or its name, or a table with 'object' is expected"
            )
        return {"object": stated} if isinstance(stated, str) else stated

    @model_validator(mode="after")
    def _has_a_scale(self) -> RoleObject:
        if self.factor == 0.0:
            raise ValueError("a factor of 0 makes every value 0: state that of one raw step")
        if self.factor != 1.0 and not self.unit:
            raise ValueError("a factor is of a unit: state both")
        return self
