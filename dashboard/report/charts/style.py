"""How charts of the report look: fonts that are shipped, thin lines, no date, ids that do not depend on chance."""

import io
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import RLock
from typing import Any, Final

import matplotlib as mpl
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.style.core import STYLE_BLACKLIST

from dashboard import theme

FONTS: Final = Path(__file__).resolve().parents[1] / "fonts"

LATIN: Final = "Tiltwatch Inter"
CHINESE: Final = "Tiltwatch Noto SC"

DRAWING: Final = RLock()
"""Held while matplotlib draws."""

FULL_WIDTH_MM: Final = 178.0
"""Width of the text on A4."""

STYLE: Final[dict[str, Any]] = {
    "svg.hashsalt": "tiltwatch",
    "svg.fonttype": "path",
    "font.family": [LATIN, CHINESE],
    "font.size": 7.5,
    "axes.titlesize": 8.0,
    "axes.titleweight": "semibold",
    "axes.labelsize": 7.5,
    "axes.edgecolor": theme.SOFT,
    "axes.labelcolor": theme.INK,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.unicode_minus": True,
    "grid.color": "#e4e8ec",
    "grid.linewidth": 0.5,
    "xtick.color": theme.SOFT,
    "ytick.color": theme.SOFT,
    "xtick.labelcolor": theme.INK,
    "ytick.labelcolor": theme.INK,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "text.color": theme.INK,
    "text.parse_math": False,
    "legend.frameon": False,
    "legend.fontsize": 7.0,
    "lines.linewidth": 1.0,
    "timezone": "UTC",
    "path.simplify": False,
}

_COMMENTS: Final = re.compile("<!--.*?-->\n?", re.DOTALL)
_IDS: Final = re.compile(r'(\bid="|url\(#|href="#)')


def draw(name: str, size_mm: tuple[float, float], plot: Callable[[Figure], None]) -> str:
    """Draw a chart and return it as an SVG element.

    Parameters
    ----------
    name : str
        Goes before every id, so that charts can stand in one web page.
    size_mm : (2,) floats
        Width and height.
    plot : callable
        Draws on the figure; text in it is never taken for markup.
    """
    _register_fonts()
    # the settings of matplotlib are those of the whole process: two threads would draw with each other's
    with DRAWING, mpl.rc_context(_settings()):
        figure = Figure(figsize=(size_mm[0] / 25.4, size_mm[1] / 25.4), layout=_layout())
        FigureCanvasSVG(figure)
        plot(figure)
        file = io.StringIO()
        figure.savefig(
            file, format="svg", metadata={"Date": None, "Creator": None, "Type": None, "Format": None}
        )
    text = file.getvalue()
    text = _COMMENTS.sub("", text[text.index("<svg") :])
    return _IDS.sub(lambda match: f"{match.group(1)}{name}-", text)


def _settings() -> dict[Any, Any]:
    """All settings of matplotlib, so that a file of the user's changes nothing; the backend is not one of drawing."""
    kept = {name: value for name, value in mpl.rcParamsDefault.items() if name not in STYLE_BLACKLIST}
    return {**kept, **STYLE}


def _layout() -> ConstrainedLayoutEngine:
    return ConstrainedLayoutEngine(w_pad=0.02, h_pad=0.02, wspace=0.04, hspace=0.04)


@cache
def _register_fonts() -> None:
    for path in sorted(FONTS.glob("*.otf")):
        font_manager.fontManager.addfont(str(path))


def bare(axes: Axes) -> None:
    """Take frame, ticks and grid away."""
    axes.set_axis_off()


def padded(low: float, high: float, share: float = 0.08) -> tuple[float, float]:
    """Widen a range by a share of its length on both sides; a range without length by 1."""
    if high <= low:
        return low - 1.0, high + 1.0
    return low - share * (high - low), high + share * (high - low)


def north_arrow(axes: Axes, x: float = 0.955, y: float = 0.86, length: float = 0.1) -> None:
    """Draw a north arrow in axes fractions."""
    axes.annotate(
        "N",
        xy=(x, y + length),
        xytext=(x, y - 0.02),
        xycoords="axes fraction",
        textcoords="axes fraction",
        ha="center",
        va="center",
        fontsize=8,
        fontweight="semibold",
        arrowprops={"arrowstyle": "-|>", "color": theme.INK, "lw": 1.0, "shrinkA": 6, "shrinkB": 0},
    )
