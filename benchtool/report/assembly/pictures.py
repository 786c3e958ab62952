"""Shared parts of reports of runs and comparisons: figures with their captions, and loaded streams."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from matplotlib.figure import Figure

from benchtool.block import Block
from benchtool.report import content
from benchtool.report.content import Picture
from benchtool.report.figures.drawings import captions
from benchtool.results import Assessment

_OF_ALL_CASES: Final = {"cases": "All cases of the plan side by side, on the same axes."}


def picture(name: str, figure: Figure) -> Picture:
    """Return a figure with its caption; one that is not known by name is described by its axes."""
    described = content.describe_figure(figure)
    return Picture(figure, {**captions(), **_OF_ALL_CASES}.get(name, described), described)


def read_already(result: Assessment | None) -> Mapping[str, Block]:
    """Return the streams that were loaded for the measurement."""
    if result is None:
        return {}
    transducer = {} if result.transducer is None else {"transducer": result.transducer}
    whole = result.capture if result.recorded is None else result.recorded.block
    return {result.stream: whole, **transducer}
