"""How functions that compiled functions call are compiled: lowered once, and optimised with what calls them.

numba takes each function for one that Python may call. It optimises it and makes machine code of it, together
with all that it calls, and again as a part of each function that calls it. In a kernel of some 250 small
functions, five deep and more, that is most of the work, and none of it is used: what counts is the kernel,
which is optimised as a whole. So these functions are left as they are lowered, without machine code.
"""

from __future__ import annotations

import operator
from typing import Any, ClassVar, Final

from numba.core import cgutils, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.compiler_machinery import LoweringPass, PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import (
    NativeLowering,
    NoPythonBackend,
    NopythonTypeInference,
    PreLowerStripPhis,
)
from numba.core.untyped_passes import (
    DeadBranchPrune,
    FixupArgs,
    GenericRewrites,
    IRProcessing,
    ReconstructSSA,
    RewriteSemanticConstants,
    TranslateByteCode,
)

_OPERATORS: Final = frozenset(vars(operator)[name] for name in operator.__all__)


class PartCompiler(CompilerBase):
    """Compile a function that is a part of others.

    Of numba's passes there are those that plain arithmetic needs: no closures, no array expressions, no
    objects.
    """

    def define_pipelines(self) -> list[PassManager]:
        manager: Any = _Passes
        passes = manager("part")
        for each, what in (
            (TranslateByteCode, "analyzing bytecode"),
            (FixupArgs, "fix up args"),
            (IRProcessing, "processing IR"),
            (RewriteSemanticConstants, "rewrite semantic constants"),
            (DeadBranchPrune, "dead branch pruning"),
            (GenericRewrites, "nopython rewrites"),
            (ReconstructSSA, "ssa"),
            (DeadBranchPrune, "dead branch pruning"),
            (_PartTyping, "nopython frontend"),
            (PreLowerStripPhis, "remove phis nodes"),
            (_WithoutMachineCode, "to be lowered only"),
            (_PartLowering, "native lowering"),
            (_Registration, "for what calls it"),
            (NoPythonBackend, "nopython mode backend"),
        ):
            passes.add_pass(each, what)
        passes.finalize()
        return [passes]


class _Passes(PassManager):
    """Passes one after the other, without the records that numba keeps of each, which for records of a
    hundred fields take longer than most passes, and without analyses again of what a pass has left whole."""

    def _runPass(self, index: int, pss: Any, internal_state: Any) -> None:
        pss.analysis = self._analysis
        for run in (pss.run_initialization, pss.run_pass, pss.run_finalizer):
            run(internal_state)


class _Remembering:
    """A typing context of numba's that remembers what operators of numbers give.

    numba finds it again at each operator in the source, and asks first whether it is one of arrays, which
    takes a tenth of all the time that it compiles.
    """

    _found: ClassVar[dict[tuple[object, ...], Any]] = {}

    def __init__(self, context: Any) -> None:
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, arguments: Any, named: Any) -> Any:
        resolve = self._context.resolve_function_type
        if named or not all(isinstance(each, types.Number | types.Boolean) for each in arguments):
            return resolve(function, arguments, named)
        if getattr(function, "typing_key", None) not in _OPERATORS:
            return resolve(function, arguments, named)
        key = (function, *arguments)
        if key not in self._found:
            self._found[key] = resolve(function, arguments, named)
        return self._found[key]


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartTyping(NopythonTypeInference):
    _name = "benchtool_typing"

    def run_pass(self, state: Any) -> Any:
        state.typingctx = _Remembering(state.typingctx)
        return super().run_pass(state)  # type: ignore[no-untyped-call]


class _Lowered(JITCodeLibrary):
    """Code as it is lowered, with that of the functions that it calls; what links it optimises both."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Optimise what is defined in a module; numba goes through what is only declared as well."""
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager()
                passes.run(function, builder)

    def finalize(self) -> None:
        self._raise_if_finalized()  # type: ignore[no-untyped-call]
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


class _Lower(Lower):
    def alloca_lltype(self, name: str, lltype: Any, datamodel: Any = None) -> Any:
        """Return room for a variable, of which nothing is told to a debugger."""
        return cgutils.alloca_once(self.builder, lltype, name=name, zfill=False)


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(NativeLowering):
    _name = "benchtool_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        return _Lower


@register_pass(mutates_CFG=False, analysis_only=False)
class _WithoutMachineCode(LoweringPass):
    _name = "benchtool_without_machine_code"

    def __init__(self) -> None:
        LoweringPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        library: Any = _Lowered
        state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        return True


@register_pass(mutates_CFG=False, analysis_only=False)
class _Registration(LoweringPass):
    """Enter the function among those that others can call."""

    _name = "benchtool_registration"

    def __init__(self) -> None:
        LoweringPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        # numba keeps functions by what Python calls, a built-in function; this one is never called
        functions: list[None] = []
        key = functions.append
        state.targetctx.insert_user_function(key, state["cr"].fndesc, [state.library])
        state["cr"] = state["cr"]._replace(cfunc=key)
        return True
