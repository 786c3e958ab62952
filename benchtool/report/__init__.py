"""Figures from blocks and analysis results."""

from benchtool.report.figures import draw_steady_state, save_figures

__all__ = ["draw_steady_state", "save_figures"]
