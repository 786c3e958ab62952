"""All that a steady state tells: the core of every run, and what its further channels give."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from itertools import groupby

from benchtool.analysis import SteadyState
from benchtool.analysis.catalogue import FURTHER, Analysis, Findings, Window
from benchtool.analysis.steady_state import steady_state_of
from benchtool.block import Block
from benchtool.profile import Motor


def assess_steady_state(
    block: Block, motor: Motor, transducer: Block | None = None
) -> tuple[SteadyState, Findings]:
    """Every analysis of a steady state that the channels of a window allow, side by side in threads.

    Raises:
        AnalysisError: as the analyses: a gap, a dead signal, a speed that is not steady.
    """
    window = Window.of(block, motor, transducer)
    with ThreadPoolExecutor(thread_name_prefix="benchtool-analysis") as pool:
        # analyses of the same channels share what the window computes once
        groups = [tuple(group) for _, group in groupby(FURTHER, key=lambda analysis: analysis.channels)]
        tasks = [pool.submit(_measure, group, window) for group in groups]
        steady = steady_state_of(window)
        found = [part for task in tasks for part in task.result()]
    return steady, Findings(
        tuple(each for part in found for each in part.measurements),
        tuple(each for part in found for each in part.tables),
    )


def _measure(analyses: Iterable[Analysis], window: Window) -> list[Findings]:
    channels, stride = frozenset(window.block.names), window.block.stride
    return [
        analysis.measure(window)
        for analysis in analyses
        if analysis.possible(channels, transducer=window.transducer is not None, stride=stride)
    ]
