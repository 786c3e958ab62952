"""All that a steady state tells: every analysis of it that a plan leaves on and the channels allow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import groupby
from typing import Any

from benchtool.analysis.catalogue import catalogue, measure
from benchtool.analysis.declaration import Analysis, Findings
from benchtool.analysis.validity import require_unbroken
from benchtool.analysis.window import Window
from benchtool.document import Section
from benchtool.plan.analyses import Analyses

Chosen = tuple[Analysis[Any], Section]


def assess_steady_state(window: Window, analyses: Analyses | None = None) -> dict[str, Findings]:
    """Every analysis of a steady state that the channels of a window allow, by name, side by side in threads.

    Raises:
        AnalysisError: as the analyses: a gap, a dead signal, a speed that is not steady.
        PlugInError: an analysis of another package fails.
    """
    require_unbroken(window.block)
    asked = analyses or Analyses()
    known = ((each, asked.settings(each)) for each in catalogue().steady)
    made = [(each, settings) for each, settings in known if settings is not None]
    # analyses of the same channels share what the window computes once
    groups = [tuple(group) for _, group in groupby(made, key=lambda pair: pair[0].channels)]
    with ThreadPoolExecutor(thread_name_prefix="benchtool-analysis") as pool:
        tasks = [pool.submit(_measure, group, window) for group in groups]
        return {name: found for task in tasks for name, found in task.result().items()}


def without_channels(window: Window, analyses: Analyses) -> dict[str, tuple[str, ...]]:
    """The titles of the analyses of a steady state that lack channels, each with these."""
    channels = frozenset(window.block.names)
    lacking = (
        (each.title, each.missing(channels, settings))
        for each in catalogue().steady
        if (settings := analyses.settings(each)) is not None
        and (window.transducer is not None or not each.transducer)
    )
    return {title: missing for title, missing in lacking if missing}


def _measure(chosen: Iterable[Chosen], window: Window) -> Mapping[str, Findings]:
    channels, stride = frozenset(window.block.names), window.block.stride
    return {
        analysis.name: measure(analysis, window, settings)
        for analysis, settings in chosen
        if analysis.possible(channels, settings, transducer=window.transducer is not None, stride=stride)
    }
