"""Analyses of other packages, by entry points of the group `benchtool.analyses`: loaded, checked, guarded.

Any exception of such code is reported as one error that names the package.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.metadata import EntryPoint
from typing import Any, Final

from benchtool.analysis.declaration import Analysis, Drawing, Findings, Quantity
from benchtool.analysis.measurement import Measurement, Table
from benchtool.document import Section, unit_suffix
from benchtool.errors import BenchError, PlugInError

GROUP: Final = "benchtool.analyses"

_RESERVED: Final = frozenset({"steady", "steady_from_s"})  # keys of [analyses] that are not an analysis


def load(entry: EntryPoint) -> Analysis[Any]:
    """Return the analysis of an entry point, with the package that it is of as its `source`.

    Raises:
        PlugInError: it cannot be loaded, or is not a valid analysis.
    """
    source = f"package '{entry.dist.name}' {entry.dist.version}" if entry.dist is not None else "a package"
    where = f"analysis '{entry.name}' of {source} ({entry.value})"
    remedy = f"repair or uninstall that package (entry point group {GROUP})"
    try:
        found = entry.load()
    except (Exception, SystemExit) as failed:  # any exception: the code is of another package
        raise PlugInError(f"{where} cannot be loaded: {_told(failed)}; {remedy}") from failed
    if not isinstance(found, Analysis):
        raise PlugInError(
            f"{where} is of type {type(found).__name__}, benchtool.analysis.declaration.Analysis is "
            f"expected; {remedy}"
        )
    try:
        _require_sound(found)
    except Exception as failed:
        raise PlugInError(f"{where} cannot be used: {_told(failed)}; {remedy}") from failed
    return replace(found, source=source)


def _require_sound(analysis: Analysis[Any]) -> None:
    """Check that a declaration is consistent; raises TypeError, ValueError or an exception of its
    settings."""
    if not (isinstance(analysis.name, str) and re.fullmatch(r"[a-z][a-z0-9_]*", analysis.name)):
        raise ValueError(f"its name is {analysis.name!r}, small letters, digits and underscores are expected")
    if analysis.name in _RESERVED:
        raise ValueError(f"its name '{analysis.name}' is a key of [analyses] already")
    settings = analysis.settings()
    if not isinstance(settings, Section):
        raise TypeError("its settings are no benchtool.document.Section")
    if not analysis.quantities or not all(isinstance(each, Quantity) for each in analysis.quantities):
        raise TypeError("it declares no measurements, at least one Quantity is expected")
    if not all(isinstance(name, str) for name in (*analysis.needs(settings), *analysis.names)):
        raise TypeError("a channel or a measurement has a name that is no text")
    for drawing in _drawings(analysis):
        if drawing.draw is None:
            raise ValueError(f"its figure '{drawing.name}' has no draw")


def require_distinct(added: Analysis[Any], others: Sequence[Analysis[Any]]) -> None:
    """Check that an analysis takes no name of another.

    Raises:
        PlugInError: it does.
    """
    figures = {each.name for each in _drawings(added)}
    for other in others:
        whose = other.source or "benchtool"
        taken = [name for each in added.quantities for name in each.names if other.quantity(name) is not None]
        drawn = figures & {each.name for each in _drawings(other)}
        clash = (
            "is called as one"
            if added.name == other.name
            else f"measures '{taken[0]}' as '{other.name}'"
            if taken
            else f"has figure '{min(drawn)}' as '{other.name}'"
            if drawn
            else ""
        )
        if clash:
            raise PlugInError(
                f"analysis '{added.name}' of {added.source} {clash} of {whose}, names of its own are "
                f"expected: uninstall one"
            )


@contextmanager
def guarded(analysis: Analysis[Any], doing: str) -> Iterator[None]:
    """Convert any exception of another package's code to one error that names the package.

    Raises:
        PlugInError: an exception was raised.
    """
    try:
        yield
    except BenchError:
        raise
    except Exception as failed:
        if not analysis.source:
            raise
        raise PlugInError(
            f"analysis '{analysis.name}' of {analysis.source} cannot {doing}: {_told(failed)}; repair or "
            f"uninstall that package, or set analyses.{analysis.name} = false"
        ) from failed


def require_declared(analysis: Analysis[Any], found: object) -> None:
    """Check what an analysis found against what it declares; raises TypeError or ValueError."""
    if not isinstance(found, Findings):
        raise TypeError(f"it returns {type(found).__name__}, Findings are expected")
    kinds = ((found.measurements, Measurement), (found.tables, Table))
    if not all(isinstance(each, kind) for several, kind in kinds for each in several):
        raise TypeError("a measurement is no Measurement, or a table no Table, of benchtool.analysis")
    seen: set[str] = set()
    for each in found.measurements:
        quantity = analysis.quantity(each.name)
        if quantity is None or each.name in seen:
            raise ValueError(
                f"it measures '{each.name}' {'twice' if quantity else 'and does not declare that'}"
            )
        if isinstance(quantity.unit, str) and unit_suffix(quantity.unit) != unit_suffix(each.unit):
            raise ValueError(f"'{each.name}' is in '{each.unit}', declared is '{quantity.unit}'")
        seen.add(each.name)


def _drawings(analysis: Analysis[Any]) -> tuple[Drawing, ...]:
    return *analysis.figures, *analysis.comparisons


def _told(failed: BaseException) -> str:
    """Return an exception on one line."""
    return " ".join(f"{type(failed).__name__}: {failed}".rstrip(": ").split())
