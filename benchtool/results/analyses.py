"""What a plan has measured of a recording: the analyses that it leaves on or asks for, as the data allow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from benchtool.analysis.catalogue import catalogue, measure
from benchtool.analysis.declaration import Analysis, Findings
from benchtool.analysis.validity import require_unbroken
from benchtool.analysis.window import Window
from benchtool.document import Section
from benchtool.plan.analyses import Analyses


@dataclass(frozen=True)
class Planned:
    """An analysis with its settings, and the window that it is made of."""

    analysis: Analysis[Any]
    settings: Section
    window: Window

    @property
    def missing(self) -> tuple[str, ...]:
        """The channels that it needs and that the window does not have."""
        return self.analysis.missing(frozenset(self.window.block.names), self.settings)

    @property
    def possible(self) -> bool:
        """Whether the window allows it; one that the plan asks for says itself why not."""
        block, transducer = self.window.block, self.window.transducer is not None
        channels = frozenset(block.names)
        return not self.analysis.of_steady_state or self.analysis.possible(
            channels, self.settings, transducer=transducer, stride=block.stride
        )


def planned(analyses: Analyses, steady: Window | None, whole: Window | None) -> Iterator[Planned]:
    """The analyses of a plan, in the order of the catalogue.

    Args:
        steady: the part in steady state, if there is one.
        whole: the whole capture, of which the analyses are made that a plan asks for; None for none of these.
    """
    for analysis in catalogue().analyses:
        window = steady if analysis.of_steady_state else whole
        settings = analyses.settings(analysis)
        if window is not None and settings is not None:
            yield Planned(analysis, settings, window)


def measure_all(todo: Sequence[Planned]) -> dict[str, Findings]:
    """What every analysis finds that its window allows, by name, side by side in threads.

    Raises:
        AnalysisError: as the analyses: a gap, a dead signal, a speed that is not steady.
        PlugInError: an analysis of another package fails.
    """
    for each in todo:
        if each.analysis.of_steady_state:
            require_unbroken(each.window.block)
            break  # they have one window
    # analyses of the same channels share what the window computes once
    groups = [tuple(group) for _, group in groupby(todo, key=lambda each: each.analysis.channels)]
    with ThreadPoolExecutor(thread_name_prefix="benchtool-analysis") as pool:
        tasks = [pool.submit(_measure, group) for group in groups]
        return {name: found for task in tasks for name, found in task.result().items()}


def without_channels(todo: Iterable[Planned]) -> dict[str, tuple[str, ...]]:
    """The titles of the analyses of a steady state that lack channels, each with these."""
    return {
        each.analysis.title: each.missing
        for each in todo
        if each.analysis.of_steady_state
        and each.missing
        and (each.window.transducer is not None or not each.analysis.transducer)
    }


def _measure(group: Iterable[Planned]) -> dict[str, Findings]:
    return {
        each.analysis.name: measure(each.analysis, each.window, each.settings)
        for each in group
        if each.possible
    }
