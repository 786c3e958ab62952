"""What the report of runs and that of a comparison share: marks, captions, and streams already in memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from matplotlib.figure import Figure

from benchtool.block import Block
from benchtool.plan.limits import Verdict
from benchtool.report import content
from benchtool.report.content import Mark, Picture
from benchtool.report.figures.drawings import captions
from benchtool.results.assessment import Assessment

_OF_ALL_CASES: Final = {"cases": "All cases of the plan side by side, on the same axes."}


def mark(verdict: Verdict) -> Mark:
    """A verdict as the report marks it."""
    marks: dict[Verdict, Mark] = {
        Verdict.NONE: "none",
        Verdict.PASS: "pass",
        Verdict.MARGINAL: "marginal",
        Verdict.UNDECIDED: "undecided",
        Verdict.FAIL: "fail",
    }
    return marks[verdict]


def picture(name: str, figure: Figure) -> Picture:
    """A figure with its caption; one that is not known by name is described by its axes."""
    described = content.describe_figure(figure)
    return Picture(figure, {**captions(), **_OF_ALL_CASES}.get(name, described), described)


def read_already(result: Assessment | None) -> Mapping[str, Block]:
    """The streams that measuring has read."""
    if result is None:
        return {}
    transducer = {} if result.transducer is None else {"transducer": result.transducer}
    return {"capture": result.capture, **transducer}
