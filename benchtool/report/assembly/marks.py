"""What the report of runs and that of a comparison share: marks, captions, and streams already in memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from matplotlib.figure import Figure

from benchtool.block import Block
from benchtool.plan.limits import Verdict
from benchtool.report import content
from benchtool.report.content import Mark, Picture
from benchtool.results.assessment import Assessment

_CAPTIONS: Final = {
    "waveforms": "Torque, phase currents and stator flux over the first two electrical periods of the "
    "capture. The shaft transducer's torque is the true one; the ripple measured is that of the drive's "
    "estimate.",
    "current_spectrum": "Amplitude spectrum of phase current a over whole electrical periods: above, up to "
    "ten times the fundamental, below, the whole band. Where there are more lines than dots, the least and "
    "the greatest.",
    "flux_trajectory": "Stator flux in stator coordinates over the first two electrical periods.",
    "torque": "Torque and its reference over the whole capture.",
    "bode": "Frequency response: gain, phase and coherence.",
    "switching_states": "Share of time of the inverter's voltage vectors.",
    "steady": "Torque, phase current a and stator flux at the beginning of each capture, on the same axes.",
    "spectra": "Amplitude spectrum of phase current a up to ten times the fundamental, dc left out.",
    "cases": "All cases of the plan side by side, on the same axes.",
}


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
    return Picture(figure, _CAPTIONS.get(name, described), described)


def read_already(result: Assessment | None) -> Mapping[str, Block]:
    """The streams that measuring has read."""
    if result is None:
        return {}
    transducer = {} if result.transducer is None else {"transducer": result.transducer}
    return {"capture": result.capture, **transducer}
