"""Where a plan comes from, for messages that name the place of a fault."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from benchtool.document import line_of
from benchtool.misfits import Path_
from benchtool.plan.model import Plan


@dataclass(frozen=True)
class Source:
    """The file of a plan and its text, or a plan that was made in Python; `document` is what it states."""

    name: str
    text: str
    document: Mapping[str, Any]

    @classmethod
    def of(cls, plan: Plan, path: Path | None) -> Self:
        """Of the plan that was read from `path`, or made without a file."""
        if path is None:
            document = plan.model_dump(mode="json", exclude_unset=True)
            return cls(f"plan '{plan.title}'", "", document)
        text = path.read_text(encoding="utf-8")
        return cls(str(path), text, tomllib.loads(text))

    def place(self, location: Path_) -> str:
        """Return the file and line, or plan and key, of what stands at a location."""
        if self.text:
            return f"{self.name}{line_of(self.text, location)}"
        key = ".".join(str(part) for part in location)
        return f"{self.name}, {key}" if key else self.name
