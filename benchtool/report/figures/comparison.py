"""Figures of the cases of one plan side by side, in the layout usual in publications."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchtool.analysis import Panel, raw
from benchtool.report.figures.envelope import envelope, trace
from benchtool.report.figures.labels import channel_label
from benchtool.report.figures.style import (
    ABOVE,
    BLUE,
    GREEN,
    ORANGE,
    REFERENCE,
    add_legend,
    dress,
    literal,
    new_figure,
)

_LOW_ORDER = 10
_FLOOR = 1e-5  # of the fundamental: where the logarithmic axis of a spectrum begins
_TALLEST_IN = 9.0  # of the height of an A4 page
_PANEL_IN = 2.1
_STACKED = 4  # panels one below the other; more stand in columns
_COLUMNS = 2000  # of dots across the figure
_BESIDE = 3  # columns of steady traces beside each other
_ACROSS = 96  # characters of a name above a panel as wide as the figure
_BESIDE_LEGEND = 66


def draw_torque_traces(panels: Sequence[Panel], title: str) -> Figure:
    """Return the torque and its reference against time, one case below the other on the same axes, many cases
    in columns; speed beside it where it was recorded and moves.

    Raises:
        AnalysisError: a capture has no torque.
    """
    figure, rows, used = _stack(len(panels), title)
    for axes, panel in zip(used, panels, strict=True):
        _torque(axes, panel)
        _speed(axes, panel)
        beside = axes is used[0] and rows.shape[1] == 1
        _name(axes, panel.label, columns=rows.shape[1], across=_BESIDE_LEGEND if beside else _ACROSS)
    _label_outside(rows, used, channel_label("torque", "Nm"), "time $t$ (s)")
    if rows.shape[1] == 1:
        add_legend(used[0])
    else:  # the names above the panels take the room
        free: Axes = rows[-1, -1]
        handles, labels = used[0].get_legend_handles_labels()
        free.legend(handles, labels, loc="lower right", frameon=False, fontsize=8)
    return figure


def draw_steady_traces(panels: Sequence[Panel], title: str) -> Figure:
    """Return the torque, phase current a and stator flux over the whole of each capture, one case a column;
    of many cases, some columns below others.

    Raises:
        AnalysisError: a capture lacks one of the three.
    """
    across = min(len(panels), _BESIDE)
    down = math.ceil(len(panels) / across)
    height_in = 5.6 if down == 1 else min(3.6 * down, _TALLEST_IN)
    figure = new_figure(height_in, title, "")
    grid = figure.subplots(3 * down, across, sharex=True, squeeze=False)
    signals = (
        ("torque", channel_label("torque", "Nm"), BLUE),
        ("i_a", "phase current $i_a$ (A)" if down == 1 else "$i_a$ (A)", ORANGE),
        ("psi_s", r"stator flux $\psi_s$ (Wb)" if down == 1 else r"$\psi_s$ (Wb)", GREEN),
    )
    for row in range(len(signals)):
        for axes in list(grid[row::3].flat)[1 : len(panels)]:
            axes.sharey(grid[row, 0])
            axes.tick_params(labelleft=axes in grid[:, 0])
    for number, panel in enumerate(panels):
        below, beside = divmod(number, across)
        column = grid[3 * below : 3 * below + 3, beside]
        for axes, (name, text, color) in zip(column, signals, strict=True):
            axes.plot(*trace(panel.capture, name, columns=_COLUMNS // across), color=color, linewidth=0.5)
            dress(axes, "", text if beside == 0 else "")
            axes.locator_params(axis="x", nbins=5)
        _name(column[0], panel.label, columns=across)
        if number + across >= len(panels):
            column[-1].set_xlabel("time $t$ (s)", fontsize=9)
            column[-1].tick_params(labelbottom=True)
    for axes in grid[-3:, len(panels) - across * (down - 1) :].flat:
        axes.set_axis_off()
    return figure


def draw_spectra(panels: Sequence[Panel], title: str) -> Figure:
    """Return the amplitude of phase current a up to ten times the fundamental, one case below the other, dc
    left out.

    Panels without a steady-state analysis, or without i_a in it, are left out.
    """
    analysed = [(panel, panel.steady) for panel in panels if panel.steady is not None]
    shown = [(panel, steady) for panel, steady in analysed if steady.spectrum is not None]
    figure, rows, used = _stack(len(shown), title)
    for axes, (panel, steady) in zip(used, shown, strict=True):
        spectrum = steady.current_spectrum
        largest = steady["current_max_low_harmonic"].value
        fundamental = steady["current_fundamental"].value
        low = (spectrum.frequency_Hz > 0.0) & (spectrum.frequency_Hz <= _LOW_ORDER * steady.fundamental_Hz)
        frequency_Hz, amplitude_A = envelope(spectrum.frequency_Hz[low], spectrum.amplitude[low])
        floor_A = _FLOOR * fundamental
        axes.vlines(frequency_Hz, floor_A, np.maximum(amplitude_A, floor_A), color=BLUE, linewidth=1.6)
        axes.set_yscale("log")
        axes.set_ylim(floor_A, 4.0 * fundamental)
        axes.set_xlim(left=0.0)
        dress(axes, "", "")
        case = panel.name or panel.label
        text = f"{case}: fundamental {raw(fundamental, 4)} A, largest other {raw(largest, 2)} A"
        _name(axes, text, columns=rows.shape[1])
    _label_outside(rows, used, "$i_a$, peak (A)", "frequency $f$ (Hz)")
    return figure


def _stack(count: int, title: str) -> tuple[Figure, NDArray[np.object_], list[Axes]]:
    """Return a figure with `count` panels on shared axes that fits a page: the grid of axes, and those in
    use."""
    across = 1 if count <= _STACKED else 2 if count <= 2 * _STACKED else 3
    down = math.ceil(count / across)
    figure = new_figure(min(_PANEL_IN * down + 0.5, _TALLEST_IN), title, "")
    grid = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    used = list(grid.flat)[:count]
    for axes in grid.flat:
        if axes not in used:
            axes.set_axis_off()
    return figure, grid, used


def _label_outside(grid: NDArray[np.object_], used: Sequence[Axes], y_label: str, x_label: str) -> None:
    """The labels of shared axes, at the left edge and below the last panel of each column."""
    for axes in grid[:, 0]:
        axes.set_ylabel(y_label, fontsize=9)
    for column in grid.T:
        lowest = [axes for axes in column if axes in used][-1]
        lowest.set_xlabel(x_label, fontsize=9)
        lowest.tick_params(labelbottom=True)


def _torque(axes: Axes, panel: Panel) -> None:
    block = panel.capture
    axes.plot(*trace(block, "torque"), color=BLUE, linewidth=0.7, label="torque")
    if "torque_reference" in block.names:
        axes.plot(*trace(block, "torque_reference"), label="reference", **REFERENCE)
    dress(axes, "", "")


def _speed(axes: Axes, panel: Panel) -> None:
    block = panel.capture
    if "omega_m" not in block.names or np.ptp(block.column("omega_m")) < 5.0:
        return
    beside = axes.twinx()
    beside.plot(*trace(block, "omega_m"), color=GREEN, linewidth=0.8)
    beside.set_ylabel(channel_label("omega_m", "rad/s"), color=GREEN, fontsize=9)
    beside.tick_params(labelsize=8, labelcolor=GREEN)
    for side in ("top", "left"):
        beside.spines[side].set_visible(False)


def _name(axes: Axes, label: str, columns: int = 1, across: int = _ACROSS) -> None:
    lines = textwrap.wrap(label, across // columns)
    axes.set_title(literal("\n".join(lines)), **ABOVE, fontsize=9 if columns == 1 else 8)
