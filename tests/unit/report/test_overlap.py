"""No text of a figure covers another or leaves the figure, however long the title."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from benchtool.report.figures.drawings import draw_of_case, draw_side_by_side
from benchtool.report.figures.trend import Point, Trend, draw_trend
from tests.at_length import at_length
from tests.unit.report.test_figures import capture, panel, transducer

TITLE = "Torque ripple at 0.1 of rated speed with 0.65 Nm, proposed TPC (operating point of Fig. 6)"
LIMITS = {
    "torque_mean": (0.6, 0.7),
    "torque_ripple_pp": (None, 0.06),
    "flux_ripple_pp": (None, 0.01),
    "current_max_low_harmonic": (None, 0.05),
}


def _outside_view(figure: Figure) -> Iterator[Text]:
    """Yield the labels of ticks that are not drawn."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            least, greatest = sorted(axis.get_view_interval())
            for tick in (*axis.majorTicks, *axis.minorTicks):
                if not axes.axison or not least <= tick.get_loc() <= greatest:
                    yield from (tick.label1, tick.label2)


def conflicts(figure: Figure) -> list[tuple[str, str]]:
    """Return the texts that cover each other by more than a pixel or are cut off by the edge."""
    figure.draw_without_rendering()
    assert isinstance(figure.canvas, FigureCanvasAgg)
    renderer = figure.canvas.get_renderer()  # type: ignore[no-untyped-call]
    hidden = set(map(id, _outside_view(figure)))
    shown = [
        (each.get_text(), each.get_window_extent(renderer))
        for each in figure.findobj(Text)
        if isinstance(each, Text)
        and id(each) not in hidden
        and each.get_visible()
        and each.get_text().strip()
    ]
    found = [
        (one, other)
        for (one, a), (other, b) in combinations(shown, 2)
        if min(a.x1, b.x1) - max(a.x0, b.x0) > 1.0 and min(a.y1, b.y1) - max(a.y0, b.y0) > 1.0
    ]
    edge = figure.bbox
    found += [
        (one, "the edge")
        for one, box in shown
        if box.x0 < -1.0 or box.y0 < -1.0 or box.x1 > edge.width + 1.0 or box.y1 > edge.height + 1.0
    ]
    return found


@pytest.mark.parametrize("title", [f"{TITLE} {TITLE}", *at_length(TITLE)])
def test_the_figures_of_a_case_with_every_limit(title: str) -> None:
    drawn = draw_of_case(panel(capture(), transducer(), **LIMITS), title)
    assert {name: found for name, figure in drawn.items() if (found := conflicts(figure))} == {}


def test_a_long_label_stays_clear_of_the_legend_beside_it() -> None:
    long = panel(capture())
    long = replace(long, label=f"a case of a long name: {TITLE}")
    assert conflicts(draw_side_by_side("torque", [long, long], TITLE)) == []


def test_a_legend_of_many_series_takes_more_rows() -> None:
    series = {f"a law with a long name, number {each}": (Point(1.0, 0.1 * each),) for each in range(1, 6)}
    assert conflicts(draw_trend(Trend("torque_ripple_pp", "Nm", "load_torque_Nm", series), TITLE)) == []
