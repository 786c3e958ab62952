"""The flux vector in the alpha-beta plane, with its reference circle and the inverter's voltage hexagon.

The viewer's vertical axis points down: beta is drawn negated, so that it points up and vectors turn
anticlockwise at positive speed.
"""

from __future__ import annotations

import math

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from benchtool.block import Block
from benchtool.live import names
from benchtool.live.messages import Columns, StaticContent, TimeAxis, at

NEEDED = ("psi_alpha", "psi_beta")
_MOST_POINTS = 4000
_REACH = 1.4
_SAME = 0.005
_ABOVE = 50.0  # the vectors
_HEXAGON = 1.25  # radius of its vertices, of the circle's
_AMBER, _BLUE, _GREY = (230, 159, 0), (86, 180, 233), (110, 110, 110)
_GREEN = (0, 158, 115)
_LINE, _POINT = rr.Radius.ui_points(1.0), rr.Radius.ui_points(1.2)


def circle(radius: float) -> NDArray[np.float64]:
    """Return a closed circle about the origin, shape (points, 2), as it is drawn."""
    angle = np.linspace(0.0, 2.0 * math.pi, 181)
    return radius * np.column_stack((np.cos(angle), -np.sin(angle)))


def hexagon(radius: float) -> NDArray[np.float64]:
    """Return the closed hexagon of the six active voltage vectors, (points, 2), its first vertex on alpha."""
    angle = np.arange(7) * math.pi / 3.0
    return radius * np.column_stack((np.cos(angle), -np.sin(angle)))


def axes(psi_Wb: float) -> StaticContent:
    """Return the axes of a plane for vectors of about this magnitude."""
    reach = _REACH * psi_Wb
    lines = [[[-reach, 0.0], [reach, 0.0]], [[0.0, reach], [0.0, -reach]]]
    return StaticContent(
        f"{names.LOCUS}/axes",
        rr.LineStrips2D(lines, colors=_GREY, radii=_LINE, labels=["alpha", "beta"], show_labels=False),
    )


class ReferenceCircle:
    """The circle of the flux reference; of the motor's own flux if the drive does not report one.

    Args:
        psi_Wb: the motor's own, of its magnets.
    """

    def __init__(self, psi_Wb: float) -> None:
        self._own_Wb = psi_Wb
        self._drawn_Wb: float | None = None

    def messages(self, block: Block, axis: TimeAxis) -> list[Columns]:
        """Return the circle as of the block's first row, where it is another than before."""
        asked_Wb = self._own_Wb
        if "psi_s_reference" in block.names:
            told = block.column("psi_s_reference")
            asked_Wb = float(told[told > 0.0].mean()) if np.any(told > 0.0) else self._own_Wb
        if self._drawn_Wb is not None and abs(asked_Wb - self._drawn_Wb) < _SAME * self._own_Wb:
            return []
        self._drawn_Wb = asked_Wb
        columns = rr.LineStrips2D.columns(
            strips=[circle(asked_Wb).astype(np.float32)],
            colors=[rr.encodings.Rgba32(_GREEN).rgba],
            radii=np.array([_LINE], dtype=np.float32),
            labels=[f"reference {asked_Wb:.4g} Wb"],
            show_labels=[False],
            draw_order=[_ABOVE],
        )
        return [at(f"{names.LOCUS}/reference", axis, axis.tick(block, 0), columns)]


def voltages(psi_Wb: float, u_dc_V: float) -> list[StaticContent]:
    """Return the hexagon of a dc link, whose vertices are 2/3 u_dc.

    Volts and webers share the plane by a scale that puts the vertices at 1.25 times the circle; its label
    says what it is.
    """
    V_per_mWb = hexagon_V_per_mWb(psi_Wb, u_dc_V)
    scale = f"{u_dc_V:.4g} V dc: vertices {2.0 / 3.0 * u_dc_V:.4g} V, 1 mWb is {V_per_mWb:.3g} V"
    place = [[0.0, _REACH * psi_Wb]]
    return [
        StaticContent(
            f"{names.LOCUS}/hexagon",
            rr.LineStrips2D([hexagon(_HEXAGON * psi_Wb)], colors=_AMBER, radii=_LINE),
        ),
        StaticContent(
            f"{names.LOCUS}/scale",
            rr.Points2D(place, colors=_AMBER, radii=_LINE, labels=[scale], show_labels=True),
        ),
    ]


def hexagon_V_per_mWb(psi_Wb: float, u_dc_V: float) -> float:
    """Return the scale of the hexagon: volts that a milliweber of the plane stands for."""
    return 2.0 / 3.0 * u_dc_V / (_HEXAGON * psi_Wb * 1e3)


def trace(block: Block, axis: TimeAxis, source: str) -> list[Columns]:
    """Return the flux vectors of a block, as of its last row; of a long one every n-th, 4000 at most."""
    if not len(block.data) or not set(NEEDED) <= set(block.names):
        return []
    each = -(-len(block.data) // _MOST_POINTS)
    points = np.column_stack((block.column("psi_alpha")[::each], -block.column("psi_beta")[::each]))
    points = points[np.isfinite(points).all(axis=1)]
    colour = _AMBER if source == names.CAPTURE else _BLUE
    columns = rr.Points2D.columns(
        positions=points.astype(np.float32),
        colors=np.full(len(points), rr.encodings.Rgba32(colour).rgba, dtype=np.uint32),
        radii=np.full(len(points), _POINT, dtype=np.float32),
    ).partition([len(points)])
    return [at(f"{names.LOCUS}{source}", axis, int(block.ticks()[-1]), columns)]
