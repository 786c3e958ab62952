"""Spectrum of the current and trajectory of the flux in steady state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchtool.analysis import Panel, SteadyState, largest_low_component, raw
from benchtool.report.figures.envelope import envelope
from benchtool.report.figures.files import lay_out
from benchtool.report.figures.labels import channel_label
from benchtool.report.figures.limits import draw_limits, stated_with_limit
from benchtool.report.figures.style import (
    BLACK,
    BLUE,
    GREY,
    LIMIT,
    ORANGE,
    REFERENCE,
    add_legend,
    annotate_point,
    dress,
    new_figure,
)
from benchtool.report.figures.waveforms import last_periods

_LOW_ORDER, _LARGEST = 10, "current_max_low_harmonic"
_FLUX_IN = 3.3
_PASSES = 5
_FLOOR = 1e-5  # of the fundamental: where the logarithmic axis of a spectrum begins


def draw_current_spectrum(panel: Panel, title: str) -> Figure:
    """Return the amplitude of phase current a up to ten times the fundamental, and over the whole band; the
    largest other component's limit where it has one."""
    steady = panel.steady
    assert steady is not None  # one of its analyses was made
    spectrum, f_1 = steady.current_spectrum, steady.fundamental_Hz
    fundamental_A = _defined(steady, "current_fundamental", spectrum.fundamental)
    floor_A = _FLOOR * fundamental_A
    frequency_Hz, amplitude_A = spectrum.frequency_Hz[1:], np.maximum(spectrum.amplitude[1:], floor_A)
    summary = f"fundamental {raw(fundamental_A, 4)} A peak at {raw(f_1, 5)} Hz, {steady.periods} periods"
    judged = [name for name in panel.limits if name.startswith("current_") and name in steady.names]
    stated = [f"{name} {stated_with_limit(steady[name], panel)}" for name in judged[:2]]
    figure = new_figure(3.4, title, ", ".join([summary, *stated]))
    low, full = figure.subplots(2, 1, sharey=True)

    bins = slice(_LOW_ORDER * steady.periods - 1)
    at_Hz, height_A = envelope(frequency_Hz[bins], amplitude_A[bins])
    low.vlines(at_Hz, floor_A, height_A, color=BLUE, linewidth=1.4)
    low.set_xlim(0.0, _LOW_ORDER * f_1)
    annotate_point(low, f"fundamental {raw(fundamental_A, 4)} A", f_1, fundamental_A, BLACK)
    largest = largest_low_component(spectrum, _LOW_ORDER)
    largest_A = _defined(steady, _LARGEST, largest.amplitude)
    largest_Hz = largest.frequency_Hz
    if _LARGEST in steady.names:
        largest_Hz = steady[_LARGEST].basis.frequency_Hz or largest_Hz
    text = f"largest other {raw(largest_A, 3)} A at {raw(largest_Hz, 4)} Hz"
    annotate_point(low, text, largest_Hz, max(largest_A, floor_A), ORANGE)
    _, greatest = panel.limits.get(_LARGEST, (None, None))
    if greatest is not None:
        draw_limits(low, [(greatest, "limit of the largest other component")])
        add_legend(low)
    low.set_yscale("log")
    low.set_ylim(floor_A, 4.0 * fundamental_A)
    dress(low, "", "$i_a$, peak (A)")

    full.plot(*envelope(frequency_Hz, amplitude_A), color=BLUE, linewidth=0.6)
    full.axvline(_LOW_ORDER * f_1, color=GREY, linewidth=0.8, linestyle=(0, (2, 2)))
    full.set_xlim(0.0, float(frequency_Hz[-1]))
    dress(full, "frequency $f$ (Hz)", "$i_a$, peak (A)")
    return figure


def _defined(steady: SteadyState, name: str, otherwise: float) -> float:
    """Return the value of a measurement; `otherwise` where it was not made, or is undefined."""
    value = steady[name].value if name in steady.names else math.nan
    return value if math.isfinite(value) else otherwise


def draw_flux_trajectory(panel: Panel, title: str) -> Figure:
    """Return the stator flux in the plane over the last two electrical periods, the circle that it is to
    keep, and the limits of its ripple where it has any."""
    steady, whole = panel.steady, panel.capture
    assert steady is not None  # one of its analyses was made
    judged = "flux_ripple_pp" in steady.names
    told = f"ripple {stated_with_limit(steady['flux_ripple_pp'], panel)} peak to peak" if judged else ""
    figure = new_figure(_FLUX_IN + 0.4, title, told, width_in=_FLUX_IN)
    axes = figure.subplots()
    block = last_periods(whole, None if steady.spectrum is None else steady.fundamental_Hz)
    axes.plot(
        block.column("psi_alpha"),
        block.column("psi_beta"),
        color=BLUE,
        linewidth=1.0,
        alpha=0.8,
        label="estimate",
    )
    length = np.hypot(whole.column("psi_alpha"), whole.column("psi_beta"))
    if "psi_s_reference" in whole.names:
        radius, label = float(np.mean(whole.column("psi_s_reference"))), "reference"
    else:
        radius, label = float(np.mean(length)), "mean"
    _circle(axes, radius, label, REFERENCE)
    _, greatest = panel.limits.get("flux_ripple_pp", (None, None))
    if greatest is not None:
        middle = 0.5 * float(np.max(length) + np.min(length))
        for radius, label in ((middle - 0.5 * greatest, "limit"), (middle + 0.5 * greatest, "_nolegend_")):
            _circle(axes, radius, label, LIMIT)
    axes.set_aspect("equal")
    dress(axes, channel_label("psi_alpha", "Wb"), channel_label("psi_beta", "Wb"))
    axes.locator_params(nbins=5)
    add_legend(axes)
    lay_out(figure, _PASSES)  # of equal scales it settles by and by
    return figure


def _circle(axes: Axes, radius: float, label: str, look: Mapping[str, Any]) -> None:
    angle = np.linspace(0.0, 2 * np.pi, 361)
    axes.plot(radius * np.cos(angle), radius * np.sin(angle), label=label, **look)
