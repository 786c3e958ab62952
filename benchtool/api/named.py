"""Mappings whose items are fetched by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar, overload

Item = TypeVar("Item")
Default = TypeVar("Default")


class Named(Mapping[str, Item]):
    """A mapping of which `[name]` raises an error of benchtool's tree, which names the nearest, no KeyError.

    Its names complete in IPython.
    """

    def __contains__(self, name: object) -> bool:
        return any(name == each for each in self)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    @overload
    def get(self, key: str) -> Item | None: ...
    @overload
    def get(self, key: str, default: Item | Default) -> Item | Default: ...
    def get(self, key: str, default: Item | Default | None = None) -> Item | Default | None:
        """Return the item of a name; the default where there is none."""
        known = key in self
        return self[key] if known else default

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)
