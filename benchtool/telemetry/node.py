"""What the stream asks of a drive: a `RemoteDrive` has it all."""

from __future__ import annotations

from typing import Protocol

from benchtool.clock import Clock
from benchtool.link import Link
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.variable import Value


class Node(Protocol):
    """A drive by the names of its dictionary; see `RemoteDrive` for what its methods raise."""

    @property
    def link(self) -> Link: ...
    @property
    def dictionary(self) -> Dictionary: ...
    @property
    def clock(self) -> Clock: ...

    def tick_now(self) -> int | None: ...
    def number(self, name: str) -> float: ...
    def write(self, name: str, value: Value) -> None: ...
