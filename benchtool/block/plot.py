"""A block as a picture: channels against time, for the person who looks at it now."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchtool.block.block import Block

_WIDTH_IN, _PANEL_IN = 8.0, 2.2
_DPI = 110


@dataclass(frozen=True)
class Plot:
    """A figure that a notebook shows by itself; without pyplot, so that it need not be closed."""

    figure: Figure

    def save(self, path: str | Path) -> Path:
        """Write it to a file, whose ending says in which format; the path."""
        self.figure.savefig(path)
        return Path(path)

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.figure.savefig(buffer, format="png", dpi=_DPI)
        return buffer.getvalue()


def plot(block: Block, channels: Sequence[str] = (), figure: Figure | None = None) -> Plot:
    """See `Block.plot`."""
    names = channels or block.names
    time_s = block.time_s()
    for name in names:
        block.column(name)  # an unknown name is refused before anything is drawn
    units = list(dict.fromkeys(block.unit(name) for name in names))
    if figure is None:
        figure = Figure(figsize=(_WIDTH_IN, 0.6 + _PANEL_IN * len(units)), layout="constrained")
        FigureCanvasAgg(figure)
    panels = figure.subplots(len(units), 1, sharex=True, squeeze=False)[:, 0]
    rows = [gap.row for gap in block.gaps]
    for unit, panel in zip(units, panels, strict=True):
        shown = [name for name in names if block.unit(name) == unit]
        for name in shown:
            # no line leads over a gap
            panel.plot(
                np.insert(time_s, rows, np.nan),
                np.insert(block.column(name), rows, np.nan),
                label=name,
                lw=0.9,
            )
        _dress(panel, ", ".join(shown) if len(shown) < 4 else "", unit)
    panels[-1].set_xlabel("time in s")
    return Plot(figure)


def _dress(panel: Axes, quantity: str, unit: str) -> None:
    panel.set_ylabel(f"{quantity} in {unit}".lstrip() if unit else quantity)
    panel.grid(True, lw=0.4, alpha=0.6)
    panel.margins(x=0.01)
    panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
