"""The Bode figure and that of the switching states: what they show."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.patches import Rectangle
from scipy import signal

from benchtool.analysis.responses.bode import Bode, analyze_response
from benchtool.analysis.switching import switching_states
from benchtool.block import Block, Channel
from benchtool.report.figures.bode import draw_bode
from benchtool.report.figures.switching import draw_switching_states


def _bode(delay_rows: int) -> Bode:
    x = np.tile(2.0 * signal.max_len_seq(8)[0] - 1.0, 6)
    y = np.roll(x, delay_rows)
    channels = (Channel("stimulus", "rad/s"), Channel("torque", "Nm"))
    block = Block(channels, 0, 1, 1e-4, np.column_stack([x, y]))
    return analyze_response(block, "stimulus", "torque", period_rows=255)


def test_every_case_has_its_curves_on_shared_axes_with_units() -> None:
    figure = draw_bode({"two": _bode(2), "five": _bode(5)}, "a title")
    gain, phase, coherence = figure.axes
    assert gain.get_legend_handles_labels()[1] == ["two", "five"]
    assert gain.get_ylabel() == "gain (dB re 1 Nm/(rad/s))"
    assert phase.get_ylabel() == "phase (°)"
    assert coherence.get_xlabel() == "frequency $f$ (Hz)"
    assert coherence.get_xscale() == "log"
    lines = {line.get_label(): line for line in phase.lines}
    frequency_Hz = np.asarray(lines["five"].get_xdata(), dtype=np.float64)
    np.testing.assert_allclose(np.asarray(lines["five"].get_ydata()), -360.0 * frequency_Hz * 5e-4, atol=1e-6)


def test_switching_states_are_bars_of_time_and_of_periods() -> None:
    channels = (Channel("u_alpha", "V"), Channel("u_beta", "V"), Channel("u_dc", "V"))
    data = np.array([[100.0, 0.0, 300.0], [0.0, 0.0, 300.0]])
    (table,) = switching_states(Block(channels, 0, 1, 1e-4, data)).tables
    (axes,) = draw_switching_states(table, title="a title").axes
    heights = [patch.get_height() for patch in axes.patches if isinstance(patch, Rectangle)]
    assert heights[:2] == pytest.approx([75.0, 25.0])
    assert heights[7:9] == pytest.approx([100.0, 50.0])
    assert [label.get_text() for label in axes.get_xticklabels()][:2] == ["0, 7", "1\n0°"]
    assert axes.get_ylabel() == "share (%)"
