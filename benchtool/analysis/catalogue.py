"""The catalogue: every kind of analysis, in the order in which the numbers are printed.

To add a kind of analysis, write a module that ends with its declaration (`benchtool.analysis.declaration`)
and add a line here. Analyses of other packages are found by entry points of the group `benchtool.analyses`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from typing import Any, Final

from benchtool.analysis.balances.flux_measurements import FLUX_BALANCE
from benchtool.analysis.balances.motion_balance import MOTION_BALANCE
from benchtool.analysis.declaration import (
    Analysis,
    Drawing,
    Findings,
    Quantity,
)
from benchtool.analysis.flux.ripple import FLUX_RIPPLE
from benchtool.analysis.flux.trajectory import FLUX_TRAJECTORY
from benchtool.analysis.lines.lines import TORQUE_LINES
from benchtool.analysis.orders.orders import SPEED_ORDERS, TORQUE_ORDERS
from benchtool.analysis.plug_ins import GROUP, guarded, load, require_declared, require_distinct
from benchtool.analysis.responses.bode import FREQUENCY_RESPONSE
from benchtool.analysis.spectra.current import CURRENT_SPECTRUM
from benchtool.analysis.spectra.unbalance import CURRENT_UNBALANCE
from benchtool.analysis.steps.step import STEP
from benchtool.analysis.switching import SWITCHING_FREQUENCY, SWITCHING_STATES
from benchtool.analysis.torque.residual import RESIDUAL, TRANSDUCER_RESIDUAL
from benchtool.analysis.torque.torque import TORQUE_ERROR, TORQUE_RIPPLE, TRANSDUCER_TORQUE_RIPPLE
from benchtool.analysis.window import Window
from benchtool.document import Section

CORE: Final[tuple[Analysis[Any], ...]] = (
    TORQUE_RIPPLE,
    TRANSDUCER_TORQUE_RIPPLE,
    TORQUE_ERROR,
    FLUX_RIPPLE,
    CURRENT_SPECTRUM,
    SWITCHING_FREQUENCY,
)
"""What `analyze_steady_state` measures."""

BUILT_IN: Final[tuple[Analysis[Any], ...]] = (
    *CORE,
    FLUX_TRAJECTORY,
    SWITCHING_STATES,
    RESIDUAL,
    TRANSDUCER_RESIDUAL,
    TORQUE_ORDERS,
    SPEED_ORDERS,
    TORQUE_LINES,
    CURRENT_UNBALANCE,
    STEP,
    FREQUENCY_RESPONSE,
    FLUX_BALANCE,
    MOTION_BALANCE,
)
"""Every kind of analysis that comes with benchtool."""


@dataclass(frozen=True)
class Catalogue:
    """Kinds of analysis, those of a steady state first."""

    analyses: tuple[Analysis[Any], ...]

    @property
    def steady(self) -> tuple[Analysis[Any], ...]:
        """The analyses that measure a steady state."""
        return tuple(each for each in self.analyses if each.of_steady_state)

    @property
    def on_request(self) -> tuple[Analysis[Any], ...]:
        """The analyses that are made only if a plan requests them."""
        return tuple(each for each in self.analyses if not each.of_steady_state)

    def named(self, name: str) -> Analysis[Any] | None:
        """Return the analysis of that name."""
        return next((each for each in self.analyses if each.name == name), None)

    def measuring(self, name: str) -> Analysis[Any] | None:
        """Return the analysis that gives the measurement of that name."""
        return next((each for each in self.analyses if each.quantity(name) is not None), None)

    def quantity(self, name: str) -> Quantity | None:
        """Return the declaration of the measurement of that name."""
        found = (each.quantity(name) for each in self.analyses)
        return next((each for each in found if each is not None), None)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """All declared quantities, in the order of the analyses."""
        return tuple(quantity for each in self.analyses for quantity in each.quantities)

    @property
    def headline(self) -> tuple[str, ...]:
        """The measurements that a table of many cases shows."""
        return tuple(name for each in self.quantities if each.headline for name in each.names)

    @property
    def comparisons(self) -> dict[str, tuple[Drawing, tuple[Analysis[Any], ...]]]:
        """The figures of several cases side by side by name, each with the analyses that declare it."""
        found: dict[str, tuple[Drawing, tuple[Analysis[Any], ...]]] = {}
        for analysis in self.analyses:
            for drawing in analysis.comparisons:
                _, others = found.get(drawing.name, (drawing, ()))
                found[drawing.name] = drawing, (*others, analysis)
        return found

    def stated_unit(self, key: str) -> tuple[str, str] | None:
        """Return the measurement and unit of a key that ends with a unit: `torque_mean_Nm`; None of any other
        key.

        The unit is as the key has it (`rad_s`), whether or not the measurement is in it.
        """
        parts = key.split("_")
        names = (("_".join(parts[:at]), "_".join(parts[at:])) for at in range(len(parts) - 1, 0, -1))
        known = ((name, unit) for name, unit in names if self.quantity(name) is not None)
        return None if self.quantity(key) is not None else next(known, None)


@cache
def catalogue() -> Catalogue:
    """Return the analyses of benchtool and of installed packages.

    Raises:
        PlugInError: an entry point of the group cannot be loaded, is no `Analysis`, or takes a name that is
            another's.
    """
    added = [load(entry) for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name)]
    analyses: list[Analysis[Any]] = list(BUILT_IN)
    for each in added:
        require_distinct(each, analyses)
        analyses.append(each)
    return Catalogue(tuple(sorted(analyses, key=lambda each: not each.of_steady_state)))


def measure(analysis: Analysis[Any], window: Window, settings: Section) -> Findings:
    """Return the findings of an analysis; those of another package's are checked against its declaration.

    A measurement that has to be measured again with other errors of its sensors says of which channels.

    Raises:
        AnalysisError: the data do not allow it.
        PlugInError: an analysis of another package fails otherwise, or returns what it does not declare.
    """
    if not analysis.source:
        return analysis.with_channels(analysis.measure(window, settings), settings)
    with guarded(analysis, "measure"):
        found = analysis.measure(window, settings)
        require_declared(analysis, found)
    return analysis.with_channels(found, settings)
