"""Machine code of entries: kept on disk as an object file, loaded and called without the compiler.

To import numba takes longer than to load the kernel and run a short test on it. A compiled function needs
nothing of it: it takes its arguments as plain numbers and addresses, as numba lays them out for calls between
compiled functions. They are packed into one block of memory, 8 bytes each, which a few instructions beside
the function unpack. The compiler checks that layout against the one here whenever it compiles.
"""

from __future__ import annotations

import ctypes
import json
import os
import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NamedTuple

import llvmlite
import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray

_RESULTS: Final[dict[str, Any]] = {"d": ctypes.c_double, "q": ctypes.c_int64, "P": ctypes.c_void_p}
_RETURNED: Final = (0, -2)  # status: with a result, with nothing
_DOOR: Final = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)
DOOR: Final = "benchtool_door"
"""Symbol of the function that unpacks the arguments."""

Kinds = tuple[Any, ...]
"""What distinguishes arguments for the compiler: a letter, or the element type and dimensions of an array."""


class Objects(NamedTuple):
    """Object files of a compiled function, and what it takes and gives.

    Attributes:
        code: the function.
        door: what unpacks its arguments and calls it.
        arguments: a letter for each number of the arguments: d, q, b, and P of a pointer.
        returns: likewise of the result; P where there is none.
    """

    code: bytes
    door: bytes
    arguments: str
    returns: str


class Flat(NamedTuple):
    """An argument as compiled code has it, with what it was made of."""

    argument: object
    kinds: Kinds
    letters: str
    packed: bytes


_UNLIKE: Final = Flat(object(), (), "", b"")  # any argument


class Entry:
    """A compiled function that Python calls; compiled or loaded when it is called first.

    Other threads run while it does.

    Args:
        plain: gives the plain function.
        name: by which its machine code is kept.
        beside: folder of its source.
    """

    def __init__(self, plain: Callable[[], Callable[..., Any]], name: str, beside: Path) -> None:
        self.name = name
        self.folder = _folder_beside(beside)
        self.compilations = 0
        self._plain = plain
        self._loaded: dict[Kinds, _MachineCode] = {}
        self._last: list[Flat] = []

    def __call__(self, *arguments: Any) -> Any:
        last = self._last if len(self._last) == len(arguments) else [_UNLIKE] * len(arguments)
        flat = [
            before if before.argument is argument else _flat(argument)
            for before, argument in zip(last, arguments, strict=True)
        ]
        self._last = flat
        kinds = tuple([each.kinds for each in flat])
        code = self._loaded.get(kinds)
        if code is None:
            code = self._loaded[kinds] = self._load(flat) or self._compile(flat)
        return code.call(b"".join([each.packed for each in flat]))

    @property
    def loaded(self) -> bool:
        """Whether it is compiled or loaded in this process."""
        return bool(self._loaded)

    @property
    def cached(self) -> bool:
        """Whether it is compiled already, in this process or on disk.

        Judged by the names of files, so that machine code of another kind of processor counts as well.
        """
        return self.loaded or (self.folder is not None and any(self.folder.glob(f"{self.name}-*.o")))

    def _path(self, flat: list[Flat]) -> Path | None:
        if self.folder is None:
            return None
        crc = zlib.crc32(repr((_processor(), [each.kinds for each in flat])).encode())
        return self.folder / f"{self.name}-{crc:08x}.o"

    def _load(self, flat: list[Flat]) -> _MachineCode | None:
        path = self._path(flat)
        try:
            header, _, content = (path.read_bytes() if path is not None else b"").partition(b"\n")
            stated = json.loads(header)
            if zlib.crc32(content) != stated["crc32"]:
                return None
            code, door = content[: stated["code"]], content[stated["code"] :]
            return _MachineCode(Objects(code, door, stated["arguments"], stated["returns"]))
        except (OSError, ValueError, KeyError, TypeError):  # not there, or not whole
            return None
        except RuntimeError:  # refers to what is not there: another version of a library
            return None

    def _compile(self, flat: list[Flat]) -> _MachineCode:
        from benchtool.emulator.compiler import compile_entry

        objects = compile_entry(self._plain(), self.name, tuple(each.argument for each in flat))
        letters = "".join(each.letters for each in flat)
        if letters != objects.arguments:
            raise RuntimeError(
                f"{self.name} takes its arguments as {objects.arguments}, {letters} are expected: "
                f"this version of numba passes them in another way, install one that pyproject.toml names"
            )
        self.compilations += 1
        stated = {"arguments": letters, "returns": objects.returns}
        content = objects.code + objects.door
        header = json.dumps({**stated, "code": len(objects.code), "crc32": zlib.crc32(content)})
        if (path := self._path(flat)) is not None:
            beside = path.with_suffix(f".{os.getpid()}")
            with suppress(OSError):
                beside.write_bytes(b"\n".join((header.encode(), content)))
                beside.replace(path)
        return _MachineCode(objects)


class _MachineCode:
    """A compiled function in this process.

    Raises:
        RuntimeError: its objects refer to what is not there.
    """

    def __init__(self, objects: Objects) -> None:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        self._linker = llvm.create_lljit_compiler()
        builder = llvm.JITLibraryBuilder().add_object_img(objects.code).add_object_img(objects.door)
        self._library = builder.add_current_process().export_symbol(DOOR).link(self._linker, DOOR)
        self._door = _DOOR(self._library[DOOR])
        self._result: Any = _RESULTS[objects.returns]

    def call(self, packed: bytes) -> Any:
        result, failure = self._result(), ctypes.c_void_p()
        status = self._door(ctypes.byref(result), ctypes.byref(failure), packed)
        if status not in _RETURNED:
            raise RuntimeError(f"compiled code failed with status {status}")
        return result.value


def _flat(argument: object) -> Flat:
    match argument:
        case None:
            return Flat(None, ("none",), "P", bytes(8))
        case bool():
            return Flat(argument, ("b",), "b", struct.pack("q", argument))
        case float():
            return Flat(argument, ("d",), "d", struct.pack("d", argument))
        case int() | np.integer():
            return Flat(argument, ("q",), "q", struct.pack("q", argument))
        case np.ndarray():
            return _flat_array(argument)
        case tuple():
            parts = [_flat(each) for each in argument]
            kinds = (type(argument).__qualname__, *(each.kinds for each in parts))
            letters = "".join([each.letters for each in parts])
            return Flat(argument, kinds, letters, b"".join([each.packed for each in parts]))
    raise TypeError(f"compiled code takes no {type(argument).__name__}: {argument!r:.80}")


def _flat_array(given: NDArray[Any]) -> Flat:
    array = given.view(np.ndarray)  # records of numpy look at the names of fields first
    if not (array.flags.c_contiguous and array.flags.aligned and array.flags.writeable):
        raise TypeError("compiled code takes arrays that are contiguous, aligned and writable")
    unowned = 0, 0  # references to the array, which numba's runtime would count
    numbers = (*unowned, array.size, array.itemsize, array.ctypes.data, *array.shape, *array.strides)
    letters = "PPqqP" + "qq" * array.ndim
    return Flat(given, (array.dtype, array.ndim), letters, struct.pack(f"{len(numbers)}q", *numbers))


def is_cached(compiled: Callable[..., Any]) -> bool:
    """Return whether an entry is compiled already, in this process or on disk; a plain function is."""
    return getattr(compiled, "cached", True)


def _processor() -> tuple[str, ...]:
    """Return what machine code is made for."""
    stated = (os.environ.get(f"NUMBA_{name}", "") for name in ("CPU_NAME", "CPU_FEATURES"))
    features = llvm.get_host_cpu_features().flatten()
    return (llvmlite.__version__, llvm.get_process_triple(), llvm.get_host_cpu_name(), features, *stated)


def _folder_beside(sources: Path) -> Path | None:
    """Return where machine code is kept: beside the sources, else among the user's caches; None where neither
    can be written to."""
    for folder in _folders(sources):
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                return folder
    return None


def _folders(sources: Path) -> Iterator[Path]:
    if "NUMBA_CACHE_DIR" in os.environ:
        yield Path(os.environ["NUMBA_CACHE_DIR"])
    yield sources / "__pycache__"
    with suppress(RuntimeError):  # the user has no home
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "benchtool"
