"""Figures laid out once, and as files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from benchtool.recording import replacing, writing


def lay_out(figure: Figure, passes: int = 1) -> None:
    """Give axes and texts of a figure their places, for all that is drawn of it afterwards.

    A layout costs twice what drawing does, and a figure that is saved with its layout engine is laid out and
    drawn twice.
    """
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        for _ in range(passes):
            engine.execute(figure)
        figure.set_layout_engine("none")


def write_png(figure: Figure, file: Path | IO[bytes], **options: Any) -> None:
    """Draw a figure once, at its own resolution; `options` are those of `FigureCanvasAgg.print_png`."""
    lay_out(figure)
    FigureCanvasAgg(figure).print_png(file, **options)  # type: ignore[no-untyped-call]


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
            write_png(figure, part)
        paths.append(path)
    return tuple(paths)
