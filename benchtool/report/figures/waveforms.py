"""Waveforms of a steady state: the whole capture by its extremes, and beside it two electrical periods."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchtool.analysis import Panel, SteadyState, crop_to, raw
from benchtool.block import Block
from benchtool.report.figures.envelope import band, trace
from benchtool.report.figures.labels import channel_label, with_unit
from benchtool.report.figures.limits import draw_limits, stated_with_limit
from benchtool.report.figures.style import (
    BLUE,
    LIGHT,
    PHASES,
    REFERENCE,
    add_legend,
    dress,
    new_figure,
)

_PANEL_IN = 1.45
_STRETCHES = 320  # of the whole capture
_DETAIL_STRETCHES = 300  # up to four times as many rows are drawn one by one
_FINE_STRETCHES = 400  # of channels sampled faster than the drive
_DETAIL_PERIODS = 2.0
_DETAIL_S = 0.2  # without a current that defines the periods
_MOST_PERIODS = 12.0  # whose fundamentals can be told apart in the whole capture
_OF_RATIO = {
    "torque_ripple_percent_of_mean": "torque_ripple_pp",
    "torque_ripple_percent_of_rated": "torque_ripple_pp",
}


@dataclass(frozen=True)
class _View:
    """The capture, the part of it that is shown in detail, and the transducer over the whole of it.

    `begin_s` is where the detail begins, in seconds from the first row of the capture.
    """

    whole: Block
    detail: Block
    begin_s: float
    transducer: Block | None
    fundamental_Hz: float | None


def draw_waveforms(panel: Panel, title: str) -> Figure:
    """Return the torque, phase currents and stator flux, as far as recorded; each as the band of its extremes
    over the whole capture, and as a trace over the last two electrical periods.

    Where torque is judged the limits are drawn: those of its ripple about the middle of what was measured.

    Raises:
        AnalysisError: the transducer does not cover the capture.
    """
    steady = panel.steady
    assert steady is not None  # one of its analyses was made
    view = _view(panel, steady)
    signals: dict[str, Callable[[Axes, Axes], None]] = {
        "torque": lambda whole, detail: _draw_torque(whole, detail, view, panel, steady),
        "currents": lambda whole, detail: _draw_currents(whole, detail, view),
        "psi_s": lambda whole, detail: _draw_flux(whole, detail, view, panel, steady),
    }
    recorded = {*view.whole.names, *(["currents"] if set(PHASES) & set(view.whole.names) else [])}
    drawn = [draw for name, draw in signals.items() if name in recorded]
    figure = new_figure(_PANEL_IN * len(drawn) + 0.7, title, _in_words(panel, steady))
    grid = figure.subplots(len(drawn), 2, sharex="col", sharey="row", squeeze=False, width_ratios=(3.0, 2.0))
    for (whole, detail), draw in zip(grid, drawn, strict=True):
        draw(whole, detail)
        whole.axvspan(view.begin_s, _end_s(view.whole), color=LIGHT, alpha=0.35, linewidth=0, zorder=0.5)
        rows = add_legend(whole, at_left=True)
        whole.get_legend().set_in_layout(False)  # it may reach over the detail beside it,
        whole.set_title("\n".join([" "] * rows), fontsize=9, y=1.0)  # and has its room by this
        detail.tick_params(labelleft=False)
    whole, detail = grid[-1]
    dress(whole, "time $t$ (s), whole capture", whole.get_ylabel())
    dress(detail, f"time $t$ (s), last {_in_periods(view)}", "")
    whole.set_xlim(0.0, _end_s(view.whole))
    detail.set_xlim(view.begin_s, _end_s(view.whole))
    return figure


def last_periods(block: Block, fundamental_Hz: float | None) -> Block:
    """Return the last two electrical periods, or the last fifth of a second; after the last gap, if there is
    one."""
    shown_s = _DETAIL_S if fundamental_Hz is None else _DETAIL_PERIODS / fundamental_Hz
    rows = int(np.ceil(shown_s * block.sample_rate_Hz)) + 1
    first = max(0, len(block.data) - rows, *(gap.row for gap in block.gaps))
    tick = int(block.ticks()[first])
    return replace(block, first_tick=tick, data=block.data[first:], gaps=())


def _view(panel: Panel, steady: SteadyState) -> _View:
    whole = panel.capture
    fundamental_Hz = None if steady.spectrum is None else steady.fundamental_Hz
    detail = last_periods(whole, fundamental_Hz)
    begin_s = (detail.first_tick - whole.first_tick) * whole.tick_s
    transducer = None if panel.transducer is None else crop_to(panel.transducer, whole)
    return _View(whole, detail, begin_s, transducer, fundamental_Hz)


def _end_s(block: Block) -> float:
    return float(block.ticks()[-1] - block.first_tick) * block.tick_s


def _in_periods(view: _View) -> str:
    if view.fundamental_Hz is None:
        return f"{raw(_end_s(view.detail), 3)} s"
    return f"{raw(_end_s(view.detail) * view.fundamental_Hz, 2)} periods"


def _in_words(panel: Panel, steady: SteadyState) -> str:
    """Return what the figure's numbers are and, where they are judged, by which limits."""
    told = {
        "torque_mean": "torque {}",
        "torque_ripple_pp": "ripple of its estimate {} peak to peak",
    }
    found = ((name, text) for name, text in told.items() if name in steady.names)
    judged = [name for name in panel.limits if name in steady.names and name not in told]
    parts = [text.format(stated_with_limit(steady[name], panel)) for name, text in found]
    return ", ".join([*parts, *(f"{name} {stated_with_limit(steady[name], panel)}" for name in judged[:2])])


def _draw_torque(whole: Axes, detail: Axes, view: _View, panel: Panel, steady: SteadyState) -> None:
    if view.transducer is not None:
        for axes, block, stretches in (
            (whole, view.transducer, _STRETCHES),
            (detail, crop_to(view.transducer, view.detail), _FINE_STRETCHES),
        ):
            begin_s = block.first_tick * block.tick_s - view.whole.first_tick * view.whole.tick_s
            _draw_band(axes, block, "torque_transducer", stretches, LIGHT, "shaft transducer", begin_s)
    _draw_band(whole, view.whole, "torque", _STRETCHES, BLUE, "estimate")
    _draw_trace(detail, view, "torque", color=BLUE, linewidth=0.7)
    if "torque_reference" in view.whole.names:
        whole.plot(*trace(view.whole, "torque_reference"), zorder=2.6, label="reference", **REFERENCE)
        _draw_trace(detail, view, "torque_reference", **REFERENCE)
    levels = tuple(_torque_limits(view.whole, panel, steady))
    for axes in (whole, detail):
        draw_limits(axes, levels)
    dress(whole, "", channel_label("torque", "Nm"))
    dress(detail, "", "")


def _torque_limits(block: Block, panel: Panel, steady: SteadyState) -> Iterator[tuple[float, str]]:
    """Yield the levels of torque that the plan judges by: of the mean, and of the ripple, peak to peak."""
    if "torque_mean" not in steady.names:
        return
    for bound in panel.limits.get("torque_mean", ()):
        if bound is not None:
            yield bound, "limit of the mean"
    ripple_Nm = steady["torque_ripple_pp"].value
    torque = block.column("torque")
    middle_Nm = 0.5 * float(np.nanmax(torque) + np.nanmin(torque))
    if not np.isclose(float(np.ptp(torque)), ripple_Nm):  # a part of the capture was measured
        middle_Nm = steady["torque_mean"].value
    for name in ("torque_ripple_pp", *_OF_RATIO):
        _, greatest = panel.limits.get(name, (None, None))
        if greatest is None or name not in steady.names or steady[name].value == 0.0:
            continue
        width_Nm = greatest * ripple_Nm / steady[name].value  # of a share: what it comes to in Nm
        for level_Nm in (middle_Nm - 0.5 * width_Nm, middle_Nm + 0.5 * width_Nm):
            yield level_Nm, "limit of the ripple, peak to peak"


def _draw_currents(whole: Axes, detail: Axes, view: _View) -> None:
    names = [name for name in PHASES if name in view.whole.names]
    f_1 = view.fundamental_Hz
    few = f_1 is not None and _end_s(view.whole) * f_1 <= _MOST_PERIODS
    for name in names:
        color = PHASES[name]
        _draw_band(whole, view.whole, name, _STRETCHES, color, "" if few else f"${name}$", alpha=0.22)
        _draw_trace(detail, view, name, color=color, linewidth=0.4, alpha=0.3)
        if f_1 is None:
            continue
        time_s, current_A = fundamental(view.detail, name, f_1)
        detail.plot(view.begin_s + time_s, current_A, color=color, linewidth=1.6, zorder=2.7)
        if few:
            label = f"${name}$, fundamental"
            whole.plot(
                *fundamental(view.whole, name, f_1), color=color, linewidth=1.4, zorder=2.7, label=label
            )
    only = names[0] if len(names) == 1 else ""
    dress(whole, "", channel_label(only, "A") if only else "phase current $i$ (A)")
    dress(detail, "", "")


def fundamental(
    block: Block, name: str, fundamental_Hz: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the mean and fundamental of a channel, fitted by least squares at a stated frequency: time since
    the first row in s, and values."""
    time_s = (block.ticks() - block.first_tick) * block.tick_s
    values = block.column(name)
    phase = 2.0 * np.pi * fundamental_Hz * time_s
    parts = np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)])
    known = np.isfinite(values)
    weights, *_ = np.linalg.lstsq(parts[known], values[known], rcond=None)
    step = max(1, len(time_s) // 400)
    return np.asarray(time_s[::step], dtype=np.float64), np.asarray((parts @ weights)[::step])


def _draw_flux(whole: Axes, detail: Axes, view: _View, panel: Panel, steady: SteadyState) -> None:
    _draw_band(whole, view.whole, "psi_s", _STRETCHES, BLUE, "estimate")
    _draw_trace(detail, view, "psi_s", color=BLUE, linewidth=0.7)
    if "psi_s_reference" in view.whole.names:
        whole.plot(*trace(view.whole, "psi_s_reference"), label="reference", **REFERENCE)
        _draw_trace(detail, view, "psi_s_reference", **REFERENCE)
    _, greatest = panel.limits.get("flux_ripple_pp", (None, None))
    if greatest is not None and "flux_ripple_pp" in steady.names:
        psi_s = view.whole.column("psi_s")
        middle_Wb = 0.5 * float(np.nanmax(psi_s) + np.nanmin(psi_s))
        text = "limit of the ripple, peak to peak"
        for axes in (whole, detail):
            draw_limits(axes, ((middle_Wb - 0.5 * greatest, text), (middle_Wb + 0.5 * greatest, text)))
    dress(whole, "", with_unit(r"stator flux $\psi_s$", "Wb"))
    dress(detail, "", "")


def _draw_trace(axes: Axes, view: _View, name: str, **look: object) -> None:
    time_s, values = trace(view.detail, name, columns=_DETAIL_STRETCHES)
    axes.plot(view.begin_s + time_s, values, **look)  # type: ignore[arg-type]


def _draw_band(
    axes: Axes,
    block: Block,
    name: str,
    stretches: int,
    color: str,
    label: str,
    begin_s: float = 0.0,
    alpha: float = 0.6,
) -> None:
    """The least and the greatest value of each stretch, with what is between."""
    time_s, least, greatest = band(block, name, stretches)
    look: Mapping[str, object] = {"label": label} if label else {}
    axes.fill_between(
        begin_s + time_s,
        least,
        greatest,
        facecolor=color,
        edgecolor=color,
        alpha=alpha,
        linewidth=0.3,
        **look,  # type: ignore[arg-type]
    )
