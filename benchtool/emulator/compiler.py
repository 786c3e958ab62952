"""The compiler: entries with all that they call, by numba."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from types import FunctionType
from typing import Any

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba.core.caching import FunctionCache
from numba.core.typing.templates import infer_global
from numba.extending import register_jitable

from benchtool.emulator import in_place_types  # noqa: F401 # how records in place are compiled
from benchtool.emulator.jit import PARTS, Manner, Part, fingerprint
from benchtool.emulator.lowering import PartCompiler
from benchtool.emulator.machine_code import DOOR, Objects

# Of fast arithmetic there is one thing: a product and a sum may be rounded once in place of twice, where the
# processor can. The numpy error model spares a branch at every division.
# Compiled code creates no arrays and keeps none. Without `nrt`, numba's runtime, references to them are not
# counted, which is an atomic operation wherever one is passed on: 50 ns in a tick with a capture.
# Python calls none of the functions as numba would have it called, which is with arguments in objects.
_OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "_nrt": False,
    "fastmath": {"contract"},
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}

_entered: list[Part] = []  # with the dispatchers of `_SEPARATE`, which numba holds by weak references only
_SEPARATE: list[Any] = []


def compile_entry(function: Callable[..., Any], name: str, arguments: tuple[Any, ...]) -> Objects:
    """Compile a plain function for arguments like these, under a name of its own."""
    _enter_parts()
    types = tuple(numba.typeof(each) for each in arguments)
    dispatcher = numba.njit(**_OPTIONS)(_named(function, name))
    dispatcher.compile(types)
    compiled = dispatcher.overloads[types]
    descriptor = compiled.fndesc
    signature = compiled.target_context.call_conv.get_function_type(descriptor.restype, descriptor.argtypes)
    return Objects(
        compiled.library.serialize_using_object_code()[2][0],
        _door(descriptor.llvm_func_name, signature),
        "".join(_letter(each) for each in signature.args[2:]),
        _letter(signature.args[0].pointee),
    )


def _letter(kind: ir.Type) -> str:
    return "P" if isinstance(kind, ir.PointerType) else {"double": "d", "i64": "q", "i8": "b"}[str(kind)]


def _door(symbol: str, signature: Any) -> bytes:
    """Return the object file of a function that calls `symbol` with the numbers in a block of memory."""
    module = ir.Module()
    word = ir.IntType(64)
    function = ir.Function(module, signature, symbol)
    pointers = [*signature.args[:2], word.as_pointer()]
    door = ir.Function(module, ir.FunctionType(signature.return_type, pointers), DOOR)
    builder = ir.IRBuilder(door.append_basic_block())
    result, failure, block = door.args
    numbers = []
    for place, kind in enumerate(signature.args[2:]):
        number = builder.load(builder.gep(block, [ir.Constant(word, place)]))
        match _letter(kind):
            case "d":
                number = builder.bitcast(number, kind)
            case "b":
                number = builder.trunc(number, kind)
            case "P":
                number = builder.inttoptr(number, kind)
        numbers.append(number)
    builder.ret(builder.call(function, [result, failure, *numbers]))
    target = llvm.Target.from_triple(llvm.get_process_triple())
    emitted: bytes = target.create_target_machine(codemodel="large").emit_object(
        llvm.parse_assembly(str(module))
    )
    return emitted


def _enter_parts() -> None:
    """Tell numba of the functions that compiled functions call, as far as it does not know them."""
    for part in PARTS[len(_entered) :]:
        _entered.append(part)
        function = part.function
        if part.manner is Manner.SEPARATE:
            named = _named(function, f"{function.__name__}_{fingerprint():08x}")
            dispatcher = numba.njit(**_OPTIONS)(named)
            with suppress(RuntimeError, OSError):  # numba found no place to write to
                dispatcher._cache = FunctionCache(named)
            _SEPARATE.append(dispatcher)
            infer_global(function, numba.types.Dispatcher(dispatcher))
            continue
        # `forceinline` is stated either way: a function that leaves it open takes it over from what calls it
        inlined = part.manner is Manner.INLINED
        register_jitable(forceinline=inlined, pipeline_class=PartCompiler, **_OPTIONS)(function)


def _named(function: Callable[..., Any], name: str) -> Any:
    """Return the function under another name, by which numba keeps what it compiles."""
    named = FunctionType(
        function.__code__,
        function.__globals__,
        function.__name__,
        function.__defaults__,
        function.__closure__,
    )
    named.__qualname__ = name
    named.__doc__, named.__module__ = function.__doc__, function.__module__
    return named
