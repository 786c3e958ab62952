"""Matplotlib figures drawn on a PDF canvas as vectors, their text as outlines."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.backend_bases import GraphicsContextBase, RendererBase
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, Transform
from PIL import Image
from reportlab.lib.utils import ImageReader

from benchtool.report.figures.files import lay_out

_PT_PER_IN = 72.0
_CAPS = {"butt": 0, "round": 1, "projecting": 2}
_JOINS = {"miter": 0, "round": 1, "bevel": 2}


def draw_figure(canvas: Any, figure: Figure, x_pt: float, y_pt: float, width_pt: float) -> None:
    """Draw `figure` with its lower left corner at (x, y), scaled to a width, in points."""
    lay_out(figure)
    dpi = figure.dpi
    figure.set_dpi(_PT_PER_IN)
    try:
        canvas.saveState()
        canvas.translate(x_pt, y_pt)
        scale = width_pt / (_PT_PER_IN * figure.get_figwidth())
        canvas.scale(scale, scale)
        figure.draw(_Renderer(canvas, figure))
        canvas.restoreState()
    finally:
        figure.set_dpi(dpi)


class _Renderer(RendererBase):
    """Draws one figure; one pixel is one point, so that lines and letters have their nominal sizes."""

    def __init__(self, canvas: Any, figure: Figure) -> None:
        super().__init__()
        self._canvas = canvas
        self._size = (_PT_PER_IN * figure.get_figwidth(), _PT_PER_IN * figure.get_figheight())

    def get_canvas_width_height(self) -> tuple[float, float]:
        return self._size

    def points_to_pixels(self, points: Any) -> Any:
        return points

    def option_image_nocomposite(self) -> bool:
        return True

    def draw_path(
        self, gc: GraphicsContextBase, path: Path, transform: Transform, rgbFace: Any = None
    ) -> None:
        stroked = gc.get_linewidth() > 0.0 and gc.get_rgb()[3:4] != (0.0,)
        if not stroked and rgbFace is None:
            return
        canvas = self._canvas
        canvas.saveState()
        self._clip(gc)
        if stroked:
            self._pen(gc)
        if rgbFace is not None:
            canvas.setFillColorRGB(*rgbFace[:3], alpha=_alpha(gc, rgbFace))
        # A line that leaves the page is cut there; a face would lose its shape.
        clip = (0.0, 0.0, *self._size) if rgbFace is None else None
        outline = self._outline(path, transform, clip, simplify=path.should_simplify and rgbFace is None)
        canvas.drawPath(outline, stroke=int(stroked), fill=int(rgbFace is not None))
        canvas.restoreState()

    def draw_image(self, gc: GraphicsContextBase, x: float, y: float, im: Any, transform: Any = None) -> None:
        height, width = im.shape[:2]
        if not height or not width:
            return
        canvas = self._canvas
        canvas.saveState()
        self._clip(gc)
        picture = ImageReader(Image.fromarray(np.ascontiguousarray(im[::-1])))
        canvas.translate(x, y)
        if transform is not None:
            canvas.transform(*Affine2D(transform.get_matrix()).to_values())
            width, height = 1, 1
        canvas.drawImage(picture, 0, 0, width, height, mask="auto")
        canvas.restoreState()

    def _pen(self, gc: GraphicsContextBase) -> None:
        canvas = self._canvas
        canvas.setStrokeColorRGB(*gc.get_rgb()[:3], alpha=_alpha(gc, gc.get_rgb()))
        canvas.setLineWidth(gc.get_linewidth())
        canvas.setLineCap(_CAPS[str(gc.get_capstyle())])
        canvas.setLineJoin(_JOINS[str(gc.get_joinstyle())])
        offset, dashes = gc.get_dashes()
        if dashes is not None:
            canvas.setDash(np.asarray(dashes, dtype=np.float64).tolist(), float(offset))

    def _clip(self, gc: GraphicsContextBase) -> None:
        bounds = gc.get_clip_rectangle()
        if bounds is not None:
            area = self._canvas.beginPath()
            area.rect(float(bounds.x0), float(bounds.y0), float(bounds.width), float(bounds.height))
            self._canvas.clipPath(area, stroke=0, fill=0)
        path, transform = gc.get_clip_path()
        if path is not None and transform is not None:
            self._canvas.clipPath(self._outline(path, transform), stroke=0, fill=0)

    def _outline(self, path: Any, transform: Transform, clip: Any = None, *, simplify: bool = False) -> Any:
        outline = self._canvas.beginPath()
        at = (0.0, 0.0)
        for points, code in path.iter_segments(transform, clip=clip, simplify=simplify):
            if code == Path.MOVETO:
                outline.moveTo(*points)
            elif code == Path.LINETO:
                outline.lineTo(*points)
            elif code == Path.CURVE3:
                outline.curveTo(*_cubic(at, points))
            elif code == Path.CURVE4:
                outline.curveTo(*points)
            elif code == Path.CLOSEPOLY:
                outline.close()
                continue
            at = (float(points[-2]), float(points[-1]))
        return outline


def _cubic(begin: tuple[float, float], points: Any) -> tuple[float, ...]:
    """Return a quadratic Bézier curve as a cubic one, which is all that PDF has."""
    (x_0, y_0), (x_1, y_1, x_2, y_2) = begin, points
    return (
        *((x_0 + 2 * x_1) / 3, (y_0 + 2 * y_1) / 3),
        *((x_2 + 2 * x_1) / 3, (y_2 + 2 * y_1) / 3),
        *(x_2, y_2),
    )


def _alpha(gc: GraphicsContextBase, color: Any) -> float:
    forced = gc.get_forced_alpha()
    alpha: float = gc.get_alpha() if forced or len(color) < 4 else color[3]
    return alpha
