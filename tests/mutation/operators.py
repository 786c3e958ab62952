"""The mutants of a module: every small change of its syntax tree that a test should notice.

The operators are those of the field (Offutt et al., ACM Trans. Softw. Eng. Methodol. 5 (1996) no. 2, for
comparisons, arithmetic, constants and removed statements) and those that measurement code is prone to: a
dropped `abs` or limit, a neighbouring phase or axis, a lost sign, arguments in the wrong order.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass

_COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
_ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitOr,
}
_DROPPED_CALLS = frozenset(
    {"abs", "round", "sorted", "min", "max", "minimum", "maximum", "wrapped", "limited"}
)
_SYMMETRIC_CALLS = frozenset({"hypot", "gcd"})
_OTHER_CALLS = {"min": "max", "max": "min", "ceil": "floor", "floor": "ceil", "any": "all", "all": "any"}
_KIN = (
    *(("a", "b"), ("b", "c"), ("c", "a"), ("d", "q"), ("q", "d"), ("alpha", "beta"), ("beta", "alpha")),
    *(
        ("cos", "sin"),
        ("sin", "cos"),
        ("first", "last"),
        ("last", "first"),
        ("begin", "end"),
        ("start", "end"),
    ),
)


@dataclass(frozen=True)
class Mutant:
    """One change of one module.

    `path` is relative to the project. `function` is the qualified name of the function that is changed, or
    the name of a constant of the module. `line` is where the change begins, counted from 1, `lines` how many
    it spans.
    """

    path: str
    function: str
    line: int
    lines: int
    operator: str
    change: str
    mutated: str

    @property
    def identity(self) -> str:
        """What names it as long as its function reads the same: no line number."""
        return f"{self.path}::{self.function} {self.operator}: {self.change}"


@dataclass(frozen=True)
class _Edit:
    node: ast.expr | ast.stmt
    function: str
    operator: str
    text: str


def mutants_of(path: str, source: str) -> list[Mutant]:
    """Every mutant of a module, in the order of its source; each compiles and differs from it."""
    tree = ast.parse(source)
    collector = _Collector(
        {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        | {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    )
    collector.visit(tree)
    lines = source.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line.encode()))
    raw, found, seen = source.encode(), list[Mutant](), Counter[str]()
    for edit in collector.edits:
        node = edit.node
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        begin, end = (
            starts[node.lineno - 1] + node.col_offset,
            starts[node.end_lineno - 1] + node.end_col_offset,
        )
        mutated = (raw[:begin] + edit.text.encode() + raw[end:]).decode()
        if not _compiles(mutated):
            continue
        change = f"{_short(node)} -> {edit.text}"
        key = f"{edit.function} {edit.operator}: {change}"
        seen[key] += 1
        if seen[key] > 1:
            change += f" (no. {seen[key]})"
        span = node.end_lineno - node.lineno + 1
        found.append(Mutant(path, edit.function, node.lineno, span, edit.operator, change, mutated))
    return sorted(found, key=lambda mutant: mutant.line)


def functions_of(source: str) -> list[tuple[str, int, int]]:
    """Qualified name, first and last line of every function of a module, outer ones before inner ones."""
    found: list[tuple[str, int, int]] = []

    def walk(node: ast.AST, names: tuple[str, ...]) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                inner = (*names, child.name)
                if not isinstance(child, ast.ClassDef):
                    found.append((".".join(inner), child.lineno, child.end_lineno or child.lineno))
                walk(child, inner)
            else:
                walk(child, names)

    walk(ast.parse(source), ())
    return found


class _Collector(ast.NodeVisitor):
    """Walks a module and notes the edits; what no test could notice by value (texts, types) is left out."""

    def __init__(self, known: set[str]) -> None:
        self.edits: list[_Edit] = []
        self._known = known
        self._names: tuple[str, ...] = ()

    # ---- what is left out ------------------------------------------------------------------------------

    def visit_Import(self, node: ast.Import) -> None:
        pass

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        pass

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        pass  # wording; and its parts have no position of their own before Python 3.12

    def visit_Raise(self, node: ast.Raise) -> None:
        self._statement(node, "removed raise", "pass")

    def visit_Assert(self, node: ast.Assert) -> None:
        pass  # there for the type checker

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self._names = (*self._names, node.name)
        for default in (*node.args.defaults, *(each for each in node.args.kw_defaults if each is not None)):
            self.visit(default)
        for statement in node.body:
            self.visit(statement)
        self._names = self._names[:-1]

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self._names = (*self._names, node.name)
        for statement in node.body:
            self.visit(statement)
        self._names = self._names[:-1]

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self._value_of(node.target, node.value)

    # ---- statements ------------------------------------------------------------------------------------

    def visit_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant):
            return  # a docstring
        if isinstance(node.value, ast.Call):
            self._statement(node, "removed call", "pass")
        self.visit(node.value)

    def visit_Assign(self, node: ast.Assign) -> None:
        if all(isinstance(target, ast.Attribute | ast.Subscript) for target in node.targets):
            self._statement(node, "removed assignment", "pass")
        self._value_of(node.targets[0], node.value)

    def _value_of(self, target: ast.expr, value: ast.expr) -> None:
        """Visit a value; outside of functions, what is changed goes by the name of the constant."""
        before = self._names
        if not before and isinstance(target, ast.Name):
            self._names = (target.id,)
        self.visit(value)
        self._names = before

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self._statement(node, "removed assignment", "pass")
        other = _ARITHMETIC.get(type(node.op))
        if other is not None:
            changed = deepcopy(node)
            changed.op = other()
            self._statement(node, "arithmetic", ast.unparse(changed))
        self.visit(node.value)

    def visit_Continue(self, node: ast.Continue) -> None:
        self._statement(node, "removed jump", "pass")

    def visit_Break(self, node: ast.Break) -> None:
        self._statement(node, "removed jump", "pass")

    def visit_Return(self, node: ast.Return) -> None:
        value = node.value
        if value is None:
            return
        if isinstance(value, ast.Compare | ast.BoolOp) or (
            isinstance(value, ast.UnaryOp) and isinstance(value.op, ast.Not)
        ):
            for fixed in ("True", "False"):
                self._statement(node, "fixed return", f"return {fixed}")
        elif not isinstance(value, ast.Constant):  # those are changed as constants
            self._statement(node, "fixed return", "return None")
        self.visit(value)

    # ---- expressions -----------------------------------------------------------------------------------

    def visit_If(self, node: ast.If) -> None:
        self._expression(node.test, "negated condition", ast.UnaryOp(ast.Not(), node.test))
        self.generic_visit(node)

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self._expression(node.test, "negated condition", ast.UnaryOp(ast.Not(), node.test))
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for place, kind in enumerate(node.ops):
            for other in _COMPARISONS[type(kind)]:
                ops = [*node.ops[:place], other(), *node.ops[place + 1 :]]
                self._expression(node, "comparison", ast.Compare(node.left, ops, node.comparators))
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        self._expression(node, "boolean", ast.BoolOp(other, node.values))
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.USub):
            self._expression(node, "sign", node.operand)
        elif isinstance(node.op, ast.Not):
            self._expression(node, "negated condition", node.operand)
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        other = _ARITHMETIC.get(type(node.op))
        if other is not None and not _is_type(node):
            self._expression(node, "arithmetic", ast.BinOp(node.left, other(), node.right))
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        value = node.value
        if isinstance(value, bool):
            self._expression(node, "constant", ast.Constant(not value))
        elif isinstance(value, int):
            for other in (value + 1, value - 1):
                self._expression(node, "constant", ast.Constant(other))
        elif isinstance(value, float):
            for changed in (2.0 * value, 0.5 * value) if value else (1.0,):
                self._expression(node, "constant", ast.Constant(changed))

    def visit_Name(self, node: ast.Name) -> None:
        for name in self._kin(node.ctx, node.id):
            self._expression(node, "neighbouring name", ast.Name(name, node.ctx))

    def visit_Attribute(self, node: ast.Attribute) -> None:
        for name in self._kin(node.ctx, node.attr):
            self._expression(node, "neighbouring name", ast.Attribute(node.value, name, node.ctx))
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if name in _DROPPED_CALLS:
            for argument in node.args:
                if not isinstance(argument, ast.Starred | ast.GeneratorExp):
                    self._expression(node, "dropped call", argument)
        if name in _OTHER_CALLS and not node.keywords:
            called = deepcopy(node.func)
            setattr(called, "attr" if isinstance(called, ast.Attribute) else "id", _OTHER_CALLS[name])
            self._expression(node, "other call", ast.Call(called, node.args, []))
        elif name not in _DROPPED_CALLS | _SYMMETRIC_CALLS:
            self._swapped(node)
        self.generic_visit(node)

    def _swapped(self, node: ast.Call) -> None:
        for place in range(len(node.args) - 1):
            left, right = node.args[place], node.args[place + 1]
            if isinstance(left, ast.Starred) or isinstance(right, ast.Starred):
                continue
            arguments = [*node.args[:place], right, left, *node.args[place + 2 :]]
            self._expression(node, "swapped arguments", ast.Call(node.func, arguments, node.keywords))

    def _kin(self, context: ast.expr_context, name: str) -> Iterator[str]:
        """Names of the module that differ in one part of the name, such as the phase or the axis."""
        parts = name.split("_")
        for mine, other in _KIN:
            if isinstance(context, ast.Load) and mine in parts and (len(parts) > 1 or len(mine) > 1):
                renamed = "_".join(other if part == mine else part for part in parts)
                if renamed in self._known:
                    yield renamed

    # ---- notes -----------------------------------------------------------------------------------------

    def _expression(self, node: ast.expr, operator: str, changed: ast.expr) -> None:
        text = ast.unparse(ast.fix_missing_locations(deepcopy(changed)))
        if text == ast.unparse(node):
            return  # two equal arguments swapped
        plain = isinstance(changed, ast.Name | ast.Constant | ast.Attribute | ast.Call)
        self.edits.append(_Edit(node, self._function, operator, text if plain else f"({text})"))

    def _statement(self, node: ast.stmt, operator: str, text: str) -> None:
        self.edits.append(_Edit(node, self._function, operator, text))

    @property
    def _function(self) -> str:
        return ".".join(self._names)


def _is_type(node: ast.BinOp) -> bool:
    """Whether `A | B` is of types or of None, as `isinstance` takes it."""
    if not isinstance(node.op, ast.BitOr):
        return False
    return any(
        (
            isinstance(side, ast.Name)
            and (side.id in ("int", "float", "str", "bytes") or side.id[:1].isupper())
        )
        or (isinstance(side, ast.Constant) and side.value is None)
        for side in (node.left, node.right)
    )


def _compiles(source: str) -> bool:
    try:
        compile(source, "<mutant>", "exec", dont_inherit=True)
    except (SyntaxError, ValueError):
        return False
    return True


def _short(node: ast.AST) -> str:
    return " ".join(ast.unparse(node).split())
