"""Bode figures: gain, phase and coherence over frequency, one case alone or several on the same axes."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from benchtool.analysis.responses import Bode
from benchtool.report.figures.style import (
    DASHES,
    GREY,
    REFERENCE,
    SERIES,
    add_legend,
    dress,
    literal,
    new_figure,
)

_COVERAGE = 2.0  # standard uncertainties of the band about a curve
_NEPER_DB = 20.0 / np.log(10.0)


def draw_bode(responses: Mapping[str, Bode], title: str) -> Figure:
    """Return the gain in dB, phase in degrees and coherence of each named response over frequency.

    Gain and phase are drawn where they can be trusted, with a band of two standard uncertainties; coherence
    wherever the input has power.
    """
    first = next(iter(responses.values()))
    summary = f"{first.output} over {first.input}, bands of two standard uncertainties"
    figure = new_figure(6.4, title, summary)
    gain, phase, coherence = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 1.4))
    looks = zip(itertools.cycle(SERIES), itertools.cycle(DASHES))
    for name, bode in responses.items():
        color, dashes = next(looks)
        _curves(gain, phase, coherence, bode, {"color": color, "linestyle": dashes, "label": literal(name)})
    reference_dB = {**REFERENCE, "color": GREY}
    gain.axhline(-3.01, **reference_dB)
    phase.axhline(-90.0, **reference_dB)
    coherence.axhline(first.response.least_coherence, **reference_dB)
    coherence.set_ylim(0.0, 1.05)
    coherence.set_xscale("log")
    unit = f" re 1 {first.gain_unit}" if first.gain_unit else ""
    dress(gain, "", f"gain (dB{unit})")
    dress(phase, "", "phase (°)")
    phase.yaxis.set_major_locator(MultipleLocator(90.0))
    dress(coherence, "frequency $f$ (Hz)", "coherence")
    add_legend(gain)
    return figure


def _curves(gain: Axes, phase: Axes, coherence: Axes, bode: Bode, style: Mapping[str, Any]) -> None:
    found = bode.response
    used = found.trusted
    frequency_Hz, error = found.frequency_Hz[used], _COVERAGE * found.error[used]
    gain_dB, phase_deg = found.gain_dB[used], np.degrees(found.phase_rad[used])
    band = {"color": style["color"], "alpha": 0.2, "linewidth": 0}
    for axes, values, half in ((gain, gain_dB, _NEPER_DB * error), (phase, phase_deg, np.degrees(error))):
        axes.fill_between(frequency_Hz, values - half, values + half, **band)
        axes.plot(frequency_Hz, values, linewidth=1.1, **style)
    shown = found.excited
    coherence.plot(found.frequency_Hz[shown], found.coherence[shown], linewidth=0.8, **style)
