"""The analyses of a plan applied to a recording, as far as the data allow."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

from benchtool.analysis import (
    Analysis,
    Excitation,
    Findings,
    Window,
    catalogue,
    measure,
    require_unbroken,
)
from benchtool.block import Block
from benchtool.document import Section
from benchtool.errors import AnalysisError
from benchtool.plan import Analyses, OperatingPoint, Plan
from benchtool.profile import Motor


@dataclass(frozen=True)
class Planned:
    """An analysis with its settings, the window that it is made of, and why it cannot be, if it cannot."""

    analysis: Analysis[Any]
    settings: Section
    window: Window
    refusal: str = ""

    @property
    def missing(self) -> tuple[str, ...]:
        """The channels that it needs and that the window does not have."""
        return self.analysis.missing(frozenset(self.window.block.names), self.settings)

    @property
    def lacking(self) -> bool:
        """Whether a channel or the transducer is not there, so that there is nothing to be measured."""
        return bool(self.missing) or (self.analysis.transducer and self.window.transducer is None)

    @property
    def possible(self) -> bool:
        """Whether the window allows it; requested analyses raise an error otherwise."""
        block, transducer = self.window.block, self.window.transducer is not None
        channels = frozenset(block.names)
        return not self.analysis.of_steady_state or self.analysis.possible(
            channels, self.settings, transducer=transducer, stride=block.stride
        )

    @property
    def too_far_apart(self) -> str:
        """Why it is not possible though nothing is lacking."""
        return f"every control tick is needed, these rows are {self.window.block.stride} ticks apart"


def planned(analyses: Analyses, steady: Window | None, whole: Window | None) -> Iterator[Planned]:
    """Yield the analyses of a plan, in the order of the catalogue.

    Args:
        steady: the part in steady state, if there is one.
        whole: the whole capture, for the requested analyses; None to leave them out.
    """
    for analysis in catalogue().analyses:
        window = steady if analysis.of_steady_state else whole
        settings = analyses.settings(analysis)
        if window is not None and settings is not None:
            yield Planned(analysis, settings, window)


def measure_all(todo: Sequence[Planned]) -> dict[str, Findings]:
    """Return the findings of every analysis that lacks nothing, by name; made in parallel threads.

    The numbers of one that needs every tick are undefined where rows are further apart.

    Raises:
        AnalysisError: as the analyses: a gap, a dead signal, a speed that is not steady.
        PlugInError: an analysis of another package fails.
    """
    for each in todo:
        if each.analysis.of_steady_state:
            require_unbroken(each.window.block)
            break  # they have one window
    return _in_threads([each for each in todo if not each.lacking], _found_of_rows)


def measure_each(todo: Sequence[Planned]) -> dict[str, Findings]:
    """As `measure_all`, each analysis for itself: the numbers of one that is refused are undefined, with the
    reason.

    Raises:
        PlugInError: an analysis of another package fails.
    """
    return _in_threads([each for each in todo if not each.lacking], _found_or_undefined)


def _in_threads(todo: Sequence[Planned], find: Callable[[Planned], Findings]) -> dict[str, Findings]:
    # analyses of the same channels share what the window computes once
    groups = [tuple(group) for _, group in groupby(todo, key=lambda each: each.analysis.channels)]
    with ThreadPoolExecutor(thread_name_prefix="benchtool-analysis") as pool:
        tasks = [
            pool.submit(lambda group: {each.analysis.name: find(each) for each in group}, group)
            for group in groups
        ]
        return {name: found for task in tasks for name, found in task.result().items()}


def _found(each: Planned) -> Findings:
    return measure(each.analysis, each.window, each.settings)


def _found_of_rows(each: Planned) -> Findings:
    return _found(each) if each.possible else _undefined(each, each.too_far_apart)


def _found_or_undefined(each: Planned) -> Findings:
    try:
        if each.refusal:
            raise AnalysisError(each.refusal)
        if not each.possible:
            raise AnalysisError(each.too_far_apart)
        if each.analysis.of_steady_state:
            require_unbroken(each.window.block)
        return _found(each)
    except AnalysisError as refused:
        return _undefined(each, str(refused))


def _undefined(each: Planned, reason: str) -> Findings:
    return each.analysis.undefined(each.window.block, each.settings, reason)


def with_numbers(findings: Mapping[str, Findings]) -> dict[str, Findings]:
    """Return the findings of the analyses that found a number, or have none: what figures can draw."""
    return {
        name: found
        for name, found in findings.items()
        if not found.measurements or any(math.isfinite(each.value) for each in found.measurements)
    }


def without_channels(todo: Iterable[Planned]) -> dict[str, tuple[str, ...]]:
    """Return the titles of the analyses that lack channels, each with these."""
    return {
        each.analysis.title: each.missing
        for each in todo
        if each.missing and (each.window.transducer is not None or not each.analysis.transducer)
    }


def of_plan(
    plan: Plan, point: OperatingPoint, motor: Motor, capture: Block, transducer: Block | None
) -> tuple[Planned, ...]:
    """Return the analyses of a plan at an operating point, each with the part of the capture that it is made
    of.

    Raises:
        AnalysisError: the capture ends before the steady state was to begin.
    """
    steady = None
    if plan.analyses.steady:
        steady = Window.of(_from(capture, plan.analyses.steady_from_s), motor, transducer)
    whole = Window.of(capture, motor, transducer, _excitation(plan, point, capture))
    return tuple(planned(plan.analyses, steady, whole))


def _excitation(plan: Plan, point: OperatingPoint, capture: Block) -> Excitation:
    """Return where the stimulus plays, and what it is added to; of a repeated one after its first period, a
    transient."""
    if plan.stimulus is None:
        return Excitation(0, len(capture.data))
    begin, period = round(plan.record.pretrigger_s * capture.sample_rate_Hz), None
    ticks = plan.stimulus.ticks(capture.tick_s)
    end = min(len(capture.data), begin + ticks * plan.stimulus.repetitions // capture.stride)
    if plan.stimulus.repetitions > 1 and ticks % capture.stride == 0:
        period = ticks // capture.stride
        begin += period
    return Excitation(begin, end, period, point.setpoint_of(plan.stimulus.quantity))


def _from(block: Block, start_s: float) -> Block:
    """Return the part of a block from `start_s` on."""
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
