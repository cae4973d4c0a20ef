"""Finds the figures, draws one and gives its bytes: the same for the same results."""

import importlib
import io
import pkgutil
from collections.abc import Callable, Mapping
from functools import cache
from types import ModuleType
from typing import Any, Final, cast

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from dashboard.paper_figures.style import STYLE, register_fonts, write_heading
from dashboard.paper_figures.subject import Subject
from dashboard.report.charts.style import DRAWING
from storage.errors import UsageError
from storage.workspace import Workspace

FORMATS: Final = ("png", "svg")
DPI: Final = 200


def figure_names() -> Mapping[int, str]:
    """Number of each figure to the name of its file."""
    return {number: str(module.NAME) for number, module in _figures().items()}


def draw_figure(ws: Workspace, subject: Subject, number: int, file_format: str) -> bytes:
    """Draw a figure of the paper from what the workspace holds.

    Raises
    ------
    UsageError
        If there is no such figure or format.
    StorageError
        If the catalog cannot be read.
    """
    known = _figures()
    if number not in known:
        raise UsageError(f"unknown figure {number}; known: {', '.join(map(str, known))}, all")
    if file_format not in FORMATS:
        raise UsageError(f"a figure cannot be written as {file_format!r}; known: {', '.join(FORMATS)}")
    module = known[number]
    content = module.read(ws, subject)
    register_fonts()
    look: Any = {**dict(mpl.rcParamsDefault), **STYLE}  # whatever a user's matplotlibrc says
    with DRAWING, mpl.rc_context(look):
        return _drawn(module, subject, content, file_format)


def _drawn(module: ModuleType, subject: Subject, content: Any, file_format: str) -> bytes:
    figure = Figure(figsize=tuple(side / 25.4 for side in module.SIZE_MM))
    (FigureCanvasAgg if file_format == "png" else FigureCanvasSVG)(figure)
    write_heading(figure, f"Figure {module.NUMBER}   {module.TITLE}", subject.line)
    cast("Callable[[Figure, Any], None]", module.plot)(figure, content)
    file = io.BytesIO()
    # neither date nor version, which would change the bytes
    nothing = {"png": {"Software": None}, "svg": {"Date": None, "Creator": None}}
    figure.savefig(file, format=file_format, dpi=DPI, metadata=nothing[file_format])
    return file.getvalue()


@cache
def _figures() -> Mapping[int, ModuleType]:
    home = importlib.import_module("dashboard.paper_figures")
    modules = [
        importlib.import_module(f"dashboard.paper_figures.{info.name}")
        for info in pkgutil.iter_modules(home.__path__)
    ]
    numbered = {int(module.NUMBER): module for module in modules if hasattr(module, "NUMBER")}
    return dict(sorted(numbered.items()))
