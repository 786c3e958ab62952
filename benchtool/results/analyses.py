"""What a plan has measured of a recording: the analyses that it leaves on or asks for, as the data allow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

from benchtool.analysis.catalogue import catalogue, measure
from benchtool.analysis.declaration import Analysis, Findings
from benchtool.analysis.validity import require_unbroken
from benchtool.analysis.window import Excitation, Window
from benchtool.block import Block
from benchtool.document import Section
from benchtool.errors import AnalysisError
from benchtool.plan.analyses import Analyses
from benchtool.plan.model import Plan
from benchtool.profile import Motor


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


def of_plan(plan: Plan, motor: Motor, capture: Block, transducer: Block | None) -> tuple[Planned, ...]:
    """The analyses of a plan, each with the part of the capture that it is made of.

    Raises:
        AnalysisError: the capture ends before the steady state was to begin.
    """
    steady = None
    if plan.analyses.steady:
        steady = Window.of(_from(capture, plan.analyses.steady_from_s), motor, transducer)
    whole = Window.of(capture, motor, transducer, _excitation(plan, capture))
    return tuple(planned(plan.analyses, steady, whole))


def _excitation(plan: Plan, capture: Block) -> Excitation:
    """Where the stimulus plays; of a repeated one after its first period, a transient."""
    if plan.stimulus is None:
        return Excitation(0, len(capture.data))
    begin, period = round(plan.record.pretrigger_s * capture.sample_rate_Hz), None
    ticks = plan.stimulus.ticks(capture.tick_s)
    end = min(len(capture.data), begin + ticks * plan.stimulus.repetitions // capture.stride)
    if plan.stimulus.repetitions > 1 and ticks % capture.stride == 0:
        period = ticks // capture.stride
        begin += period
    return Excitation(begin, end, period)


def _from(block: Block, start_s: float) -> Block:
    """What a block holds from `start_s` on."""
    if start_s == 0.0:
        return block
    block.require_uniform()
    row = round(start_s * block.sample_rate_Hz)
    if row >= len(block.data):
        raise AnalysisError(
            f"the capture lasts {len(block.data) / block.sample_rate_Hz:g} s, its steady state was to begin "
            f"at {start_s:g} s: record longer or begin earlier"
        )
    return replace(block, first_tick=block.first_tick + row * block.stride, data=block.data[row:])
