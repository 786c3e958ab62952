"""The host's dictionary of a drive, built from an EDS or DCF of any vendor (CiA 306-1).

Names: an entry is called by its ParameterName where that is unique in the file, else `Object.Entry`, else
`Object.Entry 0x2000:1`. What a file leaves open is filled in cautiously (no access given: read-only; no known
type: raw bytes) and named in `warnings`.
"""

from __future__ import annotations

import difflib
import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

from benchtool.errors import DictionaryError, NoSuchDictionary, ValueRefused
from benchtool.file_kinds import FileKind, mistaken
from benchtool.protocol.dictionary.eds import read_eds
from benchtool.protocol.dictionary.eds_objects import EdsObjects, Identity
from benchtool.protocol.dictionary.roles import Role
from benchtool.protocol.dictionary.variable import Variable

_HASH = "dictionary_hash"
_INDEX = re.compile(r"0[xX]([0-9A-Fa-f]{4})(?::(\d{1,3}))?")


@dataclass(frozen=True)
class Dictionary:
    """Every variable of a drive, by name in the order of the file.

    `redirected` are the roles for which this drive has another object than that of the standard.
    """

    source: str
    identity: Identity
    variables: Mapping[str, Variable]
    warnings: tuple[str, ...]
    redirected: Mapping[Role, Variable] = field(default_factory=dict)

    @classmethod
    def from_eds(cls, path: Path | str, node_id: int) -> Dictionary:
        """Return the dictionary of the EDS or DCF at `path`, for a drive with this node id.

        Raises:
            NoSuchDictionary: it is not there, or no EDS.
            DictionaryError: it cannot be read.
        """
        try:
            data = Path(path).read_bytes()
        except OSError as reason:
            absent = isinstance(reason, FileNotFoundError | IsADirectoryError)
            kind = NoSuchDictionary if absent else DictionaryError
            raise kind(
                mistaken(Path(path), FileKind.EDS)
                or f"cannot read {path}: {reason.strerror or reason}; a readable EDS or DCF file "
                f"is expected: give its path"
            ) from None
        try:
            return cls.from_bytes(data, node_id, str(path))
        except DictionaryError as refused:
            raise NoSuchDictionary(mistaken(Path(path), FileKind.EDS) or str(refused)) from None

    @classmethod
    def from_bytes(cls, data: bytes, node_id: int, source: str) -> Dictionary:
        """Return the dictionary of an EDS's bytes; `source` names it in messages.

        Raises:
            DictionaryError: it is not an EDS.
        """
        return _parsed(data, node_id, source)

    @cached_property
    def by_key(self) -> Mapping[tuple[int, int], Variable]:
        """Variables by index and sub-index."""
        return {variable.key: variable for variable in self}

    @property
    def hash(self) -> int | None:
        """The hash of the object table the file was generated from; None in files of other vendors."""
        variable = self.variables.get(_HASH)
        default = variable.raw_default if variable else None
        return default if isinstance(default, int) else None

    def __getitem__(self, name: Role | str | tuple[int, int]) -> Variable:
        """Return the variable of a role, a name, an index and sub-index, or of these as text (`0x6041:0`,
        `0x6041`).

        Raises:
            ValueRefused: there is none.
        """
        variable = self.get(name)
        if variable is not None:
            return variable
        if isinstance(name, Role):
            raise ValueRefused(
                f"no object {name.label} in {self.source}: if the drive has it elsewhere, say so under "
                f"[roles] in its profile"
            )
        if not isinstance(name, str):
            raise ValueRefused(
                f"no object 0x{name[0]:04X}:{name[1]} in {self.source}: give one that is in it"
            )
        close = difflib.get_close_matches(name, self.variables, n=1, cutoff=0.5)
        hint = f"did you mean '{close[0]}'?" if close else "give a name or 0xINDEX:SUB from it"
        raise ValueRefused(f"no object '{name}' in {self.source}: {hint}")

    def __contains__(self, name: object) -> bool:
        return isinstance(name, Role | str | tuple) and self.get(name) is not None

    def __iter__(self) -> Iterator[Variable]:
        return iter(self.variables.values())

    def __len__(self) -> int:
        return len(self.variables)

    def get(self, name: Role | str | tuple[int, int]) -> Variable | None:
        """As `dictionary[name]`; None where there is none."""
        if isinstance(name, Role):
            return self.redirected.get(name) or self.by_key.get(name.key)
        if not isinstance(name, str):
            return self.by_key.get(name)
        if name in self.variables:
            return self.variables[name]
        match = _INDEX.fullmatch(name)
        return self.by_key.get((int(match[1], 16), int(match[2] or 0))) if match else None


@functools.lru_cache(maxsize=8)
def _parsed(data: bytes, node_id: int, source: str) -> Dictionary:
    """Return the dictionary of an EDS's bytes; a bench reads the same file several times."""
    objects = EdsObjects(read_eds(data, source), node_id)
    return Dictionary(source, objects.identity, MappingProxyType(objects.variables), tuple(objects.warnings))
