"""Figures 3 to 6 of the paper from any workspace: one figure a file, found by its ``NUMBER``."""

from dashboard.paper_figures.drawing import draw_figure, figure_names
from dashboard.paper_figures.subject import Subject

__all__ = ["Subject", "draw_figure", "figure_names"]
