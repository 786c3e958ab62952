"""Figures of a steady-state run, as matplotlib figures without pyplot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchtool.analysis import SteadyState, cut_to_span, largest_low_component
from benchtool.block import Block
from benchtool.recording.failures import writing
from benchtool.recording.files import replacing
from benchtool.report.figures.envelope import envelope, trace
from benchtool.report.figures.style import (
    BLACK,
    BLUE,
    GREY,
    LIGHT,
    ORANGE,
    PHASES,
    REFERENCE,
    add_legend,
    annotate_point,
    dress,
    new_figure,
)

_SHOWN_PERIODS = 2.0
_SHOWN_S = 0.2  # where no current tells the periods
_LOW_ORDER = 10
_FLOOR = 1e-5  # of the fundamental: where the logarithmic axis of a spectrum begins


def draw_steady_state(
    block: Block, steady: SteadyState, transducer: Block | None = None, *, title: str
) -> dict[str, Figure]:
    """Figures of a capture and its analysis, by name, as far as its channels go.

    "waveforms": torque, phase currents and stator flux over the first two electrical periods, or the first
    fifth of a second without i_a; "current_spectrum": phase current a up to ten times the fundamental and
    over the whole band; "flux_trajectory": stator flux in the plane. Channels i_b, i_c, torque_reference and
    psi_s_reference are drawn where they were recorded.

    Raises:
        AnalysisError: the transducer does not cover the capture.
    """
    names = set(block.names)
    figures = {}
    if names & {"torque", *PHASES, "psi_s"}:
        figures["waveforms"] = draw_waveforms(block, steady, transducer, title)
    if steady.spectrum is not None:
        figures["current_spectrum"] = draw_current_spectrum(steady, title)
    if {"psi_alpha", "psi_beta"} <= names:
        figures["flux_trajectory"] = draw_flux_trajectory(block, steady, title)
    return figures


def save_figures(figures: Mapping[str, Figure], folder: Path) -> tuple[Path, ...]:
    """Write each figure as NAME.png into `folder`, which is made if need be.

    Raises:
        RecordingError: the folder or a file cannot be written.
    """
    paths = []
    for name, figure in figures.items():
        path = folder / f"{name}.png"
        with writing(path):
            folder.mkdir(parents=True, exist_ok=True)
        with replacing(path) as part:
            figure.savefig(part)
        paths.append(path)
    return tuple(paths)


def draw_waveforms(block: Block, steady: SteadyState, transducer: Block | None, title: str) -> Figure:
    """Torque, phase currents and stator flux over the first two electrical periods, as far as recorded.

    Raises:
        AnalysisError: the transducer does not cover the capture.
    """
    shown = replace(block, data=block.data[: _shown_rows(block, steady)])
    figure = new_figure(6.0, title, _torque_in_words(steady))
    drawn: dict[str, Callable[[Axes], None]] = {
        "torque": lambda axes: _draw_torque(axes, shown, steady, transducer),
        "currents": lambda axes: _draw_currents(axes, shown),
        "psi_s": lambda axes: _draw_flux(axes, shown),
    }
    recorded = {*block.names, *(["currents"] if set(PHASES) & set(block.names) else [])}
    panels = [draw for name, draw in drawn.items() if name in recorded]
    column = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, draw in zip(column, panels, strict=True):
        draw(axes)
        add_legend(axes)
    column[-1].set_xlabel("time (s)", fontsize=9)
    column[-1].set_xlim(0.0, (len(shown.data) - 1) / shown.sample_rate_Hz)
    return figure


def _torque_in_words(steady: SteadyState) -> str:
    if "torque_mean" not in steady.names:
        return ""
    mean_Nm, peak_to_peak_Nm = steady["torque_mean"].value, steady["torque_ripple_pp"].value
    return f"torque {mean_Nm:.4g} Nm, ripple of its estimate {peak_to_peak_Nm:.3g} Nm peak to peak"


def _draw_torque(axes: Axes, shown: Block, steady: SteadyState, transducer: Block | None) -> None:
    if transducer is not None:
        _draw_true_torque(axes, cut_to_span(transducer, shown), shown)
    mean_Nm, rms_Nm = steady["torque_mean"].value, steady["torque_ripple_rms"].value
    axes.plot(*trace(shown, "torque"), color=BLUE, linewidth=0.8, zorder=2.4, label="estimate")
    # over the trace, which would hide it: a band of light with an edge
    axes.axhspan(
        mean_Nm - rms_Nm,
        mean_Nm + rms_Nm,
        label="mean ± rms ripple",
        facecolor=(1.0, 1.0, 1.0, 0.35),
        edgecolor=ORANGE,
        linewidth=1.0,
        zorder=2.5,
    )
    if "torque_reference" in shown.names:
        axes.plot(*trace(shown, "torque_reference"), zorder=2.6, label="reference", **REFERENCE)
    dress(axes, "", "torque (Nm)")


def _draw_currents(axes: Axes, shown: Block) -> None:
    for name, color in PHASES.items():
        if name in shown.names:
            # thin and not quite opaque: a law that switches at every sample fills the area of its ripple
            axes.plot(*trace(shown, name), color=color, linewidth=0.5, alpha=0.6, label=f"${name}$")
    dress(axes, "", "phase current (A)")


def _draw_flux(axes: Axes, shown: Block) -> None:
    axes.plot(*trace(shown, "psi_s"), color=BLUE, linewidth=0.8, label="estimate")
    if "psi_s_reference" in shown.names:
        axes.plot(*trace(shown, "psi_s_reference"), label="reference", **REFERENCE)
    dress(axes, "", "stator flux, peak (Wb)")


def _draw_true_torque(axes: Axes, transducer: Block, shown: Block) -> None:
    begin_s = transducer.first_tick * transducer.tick_s - shown.first_tick * shown.tick_s
    time_s, torque_Nm = trace(transducer, "torque_transducer")
    axes.plot(begin_s + time_s, torque_Nm, color=LIGHT, linewidth=0.7, label="shaft transducer")


def draw_current_spectrum(steady: SteadyState, title: str) -> Figure:
    """Amplitude of phase current a up to ten times the fundamental, and over the whole band."""
    spectrum, f_1 = steady.current_spectrum, steady.fundamental_Hz
    fundamental_A = steady["current_fundamental"].value
    floor_A = _FLOOR * fundamental_A
    frequency_Hz, amplitude_A = spectrum.frequency_Hz[1:], np.maximum(spectrum.amplitude[1:], floor_A)
    summary = f"fundamental {fundamental_A:.4g} A peak at {f_1:.5g} Hz, {steady.periods} periods"
    figure = new_figure(4.4, title, summary)
    low, full = figure.subplots(2, 1, sharey=True)

    bins = slice(_LOW_ORDER * steady.periods - 1)
    at_Hz, height_A = envelope(frequency_Hz[bins], amplitude_A[bins])
    low.vlines(at_Hz, floor_A, height_A, color=BLUE, linewidth=1.4)
    low.set_xlim(0.0, _LOW_ORDER * f_1)
    annotate_point(low, f"fundamental {fundamental_A:.4g} A", f_1, fundamental_A, BLACK)
    largest = largest_low_component(spectrum, _LOW_ORDER)
    text = f"largest other {largest.amplitude:.3g} A at {largest.frequency_Hz:.4g} Hz"
    annotate_point(low, text, largest.frequency_Hz, max(largest.amplitude, floor_A), ORANGE)
    low.set_yscale("log")
    low.set_ylim(floor_A, 4.0 * fundamental_A)
    dress(low, "", "$i_a$, peak (A)")

    full.plot(*envelope(frequency_Hz, amplitude_A), color=BLUE, linewidth=0.6)
    full.axvline(_LOW_ORDER * f_1, color=GREY, linewidth=0.8, linestyle=(0, (2, 2)))
    full.set_xlim(0.0, float(frequency_Hz[-1]))
    dress(full, "frequency (Hz)", "$i_a$, peak (A)")
    return figure


def draw_flux_trajectory(block: Block, steady: SteadyState, title: str) -> Figure:
    """Stator flux in the plane over the first two electrical periods, and the circle that it is to keep."""
    rows = _shown_rows(block, steady)
    summary = ""
    if "flux_ripple_pp" in steady.names:
        summary = f"ripple {steady['flux_ripple_pp'].value:.3g} Wb peak to peak"
    figure = new_figure(4.2, title, summary, width_in=4.2)
    axes = figure.subplots()
    psi_alpha, psi_beta = block.column("psi_alpha")[:rows], block.column("psi_beta")[:rows]
    axes.plot(psi_alpha, psi_beta, color=BLUE, linewidth=2.0, alpha=0.7, label="estimate")
    if "psi_s_reference" in block.names:
        radius, label = float(np.mean(block.column("psi_s_reference"))), "reference"
    else:
        length = np.hypot(block.column("psi_alpha"), block.column("psi_beta"))
        radius, label = float(np.mean(length)), "mean"
    angle = np.linspace(0.0, 2 * np.pi, 361)
    axes.plot(radius * np.cos(angle), radius * np.sin(angle), label=label, **REFERENCE)
    axes.set_aspect("equal")
    dress(axes, r"$\psi_\alpha$, peak (Wb)", r"$\psi_\beta$, peak (Wb)")
    add_legend(axes)
    return figure


def _shown_rows(block: Block, steady: SteadyState) -> int:
    shown_s = _SHOWN_S if steady.spectrum is None else _SHOWN_PERIODS / steady.fundamental_Hz
    return int(np.ceil(shown_s * block.sample_rate_Hz)) + 1
