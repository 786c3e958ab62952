"""A drive: where it answers, which dictionary it speaks and what it is set to."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from benchtool.document import Section


class Drive(Section):
    """The drive: where it answers, which dictionary it speaks and what it is set to."""

    node_id: Annotated[int, Field(ge=1, le=126)] = 1
    eds: str = "drive.eds"
    parameters: dict[str, float | str] = Field(default_factory=dict)
