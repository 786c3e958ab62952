"""Figures that set the cases of one plan side by side, laid out as the papers of the field do."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchtool.analysis import SteadyState
from benchtool.block import Block
from benchtool.report.style import (
    BLUE,
    GREEN,
    ORANGE,
    REFERENCE,
    SERIES,
    WIDTH_IN,
    add_legend,
    dress,
    new_figure,
)

_LOW_ORDER = 10


@dataclass(frozen=True)
class Panel:
    """One case: its name, its capture and, where it ran in steady state, the analysis of that."""

    label: str
    capture: Block
    steady: SteadyState | None = None


def draw_torque_traces(panels: Sequence[Panel], title: str) -> Figure:
    """Torque and its reference against time, one case below the other on the same axes; speed beside it where
    it was recorded and moves.

    Raises:
        AnalysisError: a capture has no torque.
    """
    figure = new_figure(2.1 * len(panels) + 0.5, title, "")
    rows = np.atleast_1d(figure.subplots(len(panels), 1, sharex=True, sharey=True))
    for axes, panel in zip(rows, panels, strict=True):
        _torque(axes, panel)
        _speed(axes, panel)
        _name(axes, panel.label)
    rows[-1].set_xlabel("time (s)")
    add_legend(rows[0])
    return figure


def draw_steady_traces(panels: Sequence[Panel], title: str, shown_s: float) -> Figure:
    """Torque, phase current a and stator flux over the first `shown_s`, one case a column.

    Raises:
        AnalysisError: a capture lacks one of the three.
    """
    figure = new_figure(5.6, title, "", width_in=WIDTH_IN * max(1.0, 0.5 * len(panels)))
    columns = figure.subplots(3, len(panels), sharex=True, sharey="row", squeeze=False)
    for number, (column, panel) in enumerate(zip(columns.T, panels, strict=True)):
        block = panel.capture
        rows = min(len(block.data), round(shown_s * block.sample_rate_Hz))
        time_s = block.time_s()[:rows]
        for axes, name, text, color in (
            (column[0], "torque", "torque (Nm)", BLUE),
            (column[1], "i_a", "phase current a (A)", ORANGE),
            (column[2], "psi_s", "stator flux, peak (Wb)", GREEN),
        ):
            axes.plot(time_s, block.column(name)[:rows], color=color, linewidth=0.7)
            dress(axes, "", text if number == 0 else "")
        _name(column[0], panel.label)
        column[-1].set_xlabel("time (s)")
    return figure


def draw_spectra(panels: Sequence[Panel], title: str) -> Figure:
    """Amplitude of phase current a up to ten times the fundamental, one case below the other, dc left out.

    Panels without a steady-state analysis are left out.
    """
    shown = [(panel, panel.steady) for panel in panels if panel.steady is not None]
    figure = new_figure(2.1 * len(shown) + 0.5, title, "")
    rows = np.atleast_1d(figure.subplots(len(shown), 1, sharex=True, sharey=True))
    for axes, (panel, steady) in zip(rows, shown, strict=True):
        spectrum = steady.spectrum
        low = (spectrum.frequency_Hz > 0.0) & (spectrum.frequency_Hz <= _LOW_ORDER * steady.fundamental_Hz)
        axes.vlines(spectrum.frequency_Hz[low], 0.0, spectrum.amplitude[low], color=BLUE, linewidth=1.6)
        largest = steady["current_max_low_harmonic"].value
        fundamental = steady["current_fundamental"].value
        dress(axes, "", "$i_a$, peak (A)")
        case = panel.label.partition(":")[0]
        _name(axes, f"{case}: fundamental {fundamental:.4g} A, largest other {largest:.2g} A")
    rows[-1].set_xlabel("frequency (Hz)")
    return figure


def draw_against(
    series: Mapping[str, Sequence[tuple[float, float]]], title: str, x_label: str, y_label: str
) -> Figure:
    """One line for each named series of points (x, y), on a logarithmic scale of y."""
    figure = new_figure(4.2, title, "")
    axes = figure.subplots()
    markers = itertools.cycle("os^vDPX")
    for (name, points), color in zip(series.items(), itertools.cycle(SERIES)):
        x, y = zip(*sorted(points), strict=True)
        axes.plot(x, y, marker=next(markers), markersize=4, color=color, linewidth=1.0, label=name)
    axes.set_yscale("log")
    dress(axes, x_label, y_label)
    add_legend(axes)
    return figure


def _torque(axes: Axes, panel: Panel) -> None:
    block = panel.capture
    time_s = block.time_s()
    axes.plot(time_s, block.column("torque"), color=BLUE, linewidth=0.7, label="torque")
    if "torque_reference" in block.names:
        axes.plot(time_s, block.column("torque_reference"), label="reference", **REFERENCE)
    dress(axes, "", "torque (Nm)")


def _speed(axes: Axes, panel: Panel) -> None:
    block = panel.capture
    if "omega_m" not in block.names or np.ptp(block.column("omega_m")) < 5.0:
        return
    beside = axes.twinx()
    beside.plot(block.time_s(), block.column("omega_m"), color=GREEN, linewidth=0.8)
    beside.set_ylabel("speed (rad/s)", color=GREEN, fontsize=9)
    beside.tick_params(labelsize=8, labelcolor=GREEN)
    for side in ("top", "left"):
        beside.spines[side].set_visible(False)


def _name(axes: Axes, label: str) -> None:
    axes.set_title(label, loc="left", fontsize=9)
