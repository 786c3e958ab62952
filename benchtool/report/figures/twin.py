"""A run and its twin: measured signals, and what two simulations of them leave."""

from __future__ import annotations

from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchtool.analysis import number
from benchtool.report.figures.envelope import envelope
from benchtool.report.figures.style import BLACK, BLUE, GREY, ORANGE, add_legend, dress, new_figure
from benchtool.results import Signal, Twin

_PANEL_IN: Final = 1.6
_LINE: Final = 0.6
_SYMBOLS: Final = {"i_d": "$i_d$", "i_q": "$i_q$", "omega_m": r"$\omega_m$"}


def draw_twin(twin: Twin) -> Figure:
    """Return each signal as measured and, on axes below it, simulated less measured: with the parameters that
    were believed, and with those that the run tells."""
    wrong = "; ".join(str(each) for each in twin.wrong) or "nothing that the run tells is contradicted"
    figure = new_figure(0.6 + 2.0 * _PANEL_IN * len(twin.signals), f"{twin.case} and its twin", wrong)
    panels = figure.subplots(2 * len(twin.signals), 1, sharex=True)
    for place, signal in enumerate(twin.signals):
        _measured(panels[2 * place], twin, signal)
        _residuals(panels[2 * place + 1], twin, signal)
    figure.align_ylabels(panels)
    panels[-1].set_xlabel("time $t$ (s)", fontsize=9)
    return figure


def _measured(axes: Axes, twin: Twin, signal: Signal) -> None:
    axes.plot(*envelope(twin.time_s, signal.measured), color=BLACK, linewidth=_LINE)
    dress(axes, "", f"{_SYMBOLS[signal.name]} ({signal.unit})")


def _residuals(axes: Axes, twin: Twin, signal: Signal) -> None:
    for values, rms, name, color in (
        (signal.believed, signal.believed_rms, "as believed", ORANGE),
        (signal.estimated, signal.estimated_rms, "as estimated", BLUE),
    ):
        label = f"{name}, {number(rms, 3)} {signal.unit} rms"
        axes.plot(*envelope(twin.time_s, signal.residual(values)), color=color, linewidth=_LINE, label=label)
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    dress(axes, "", f"residual ({signal.unit})")
    add_legend(axes)
