"""How the figures look: the fonts and thin lines of the report, heading on top, remarks below, panels with letters."""

from collections.abc import Sequence
from functools import cache
from textwrap import wrap
from typing import Any, Final

from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dashboard import theme
from dashboard.report.charts import style as report_style

WIDTH_MM: Final = 180.0
SIGNS_A_LINE: Final = 160

STYLE: Final[dict[str, Any]] = {**report_style.STYLE, "svg.fonttype": "path", "axes.grid": False}

STATION_COLORS: Final = (
    theme.BLUE,
    theme.ORANGE,
    theme.GREEN,
    theme.PURPLE,
    theme.SKY,
    theme.VERMILION,
    "#8f8300",
    "#5b4a8a",
)
"""After so many stations they begin again; a station's name stands beside its cloud."""


@cache
def register_fonts() -> None:
    """Make the shipped fonts known, once a process."""
    for path in sorted(report_style.FONTS.glob("*.otf")):
        font_manager.fontManager.addfont(str(path))


def station_color(number: int) -> str:
    """Colour of a station by its place among the stations of the epoch."""
    return STATION_COLORS[number % len(STATION_COLORS)]


def write_heading(figure: Figure, title: str, line: str) -> None:
    """Write the title and, below it, what the figure is of, at the upper left."""
    height_mm = 25.4 * figure.get_figheight()
    left = 4.0 / WIDTH_MM
    figure.text(left, 1.0 - 3.6 / height_mm, title, fontsize=10.5, fontweight=600, va="top")
    figure.text(left, 1.0 - 9.0 / height_mm, line, fontsize=7.5, color=theme.SOFT, va="top")


def write_remarks(figure: Figure, remarks: Sequence[str]) -> None:
    """Write sentences at the lower left, broken into lines of the figure's width."""
    height_mm = 25.4 * figure.get_figheight()
    lines = [line for remark in remarks for line in wrap(remark, SIGNS_A_LINE, max_lines=3)]
    figure.text(
        4.0 / WIDTH_MM,
        2.6 / height_mm,
        "\n".join(lines),
        fontsize=6.6,
        color=theme.SOFT,
        va="bottom",
        linespacing=1.4,
    )


def axes_in_mm(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place in millimetres from the lower left corner of the figure."""
    wide, high = 25.4 * figure.get_figwidth(), 25.4 * figure.get_figheight()
    return figure.add_axes((left / wide, bottom / high, width / wide, height / high))


def letter(axes: Axes, text: str, gap_points: float = 4.0) -> None:
    """Write the letter and words of a panel above its left edge."""
    axes.annotate(
        text,
        (0.0, 1.0),
        (0, gap_points),
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=8.0,
        fontweight=600,
    )


def north_arrow(axes: Axes, x: float = 0.95, y: float = 0.84, length: float = 0.1) -> None:
    """Draw an arrow to grid north, in fractions of the axes."""
    report_style.north_arrow(axes, x, y, length)


def say_missing(axes: Axes, reason: str, signs_a_line: int = 20) -> None:
    """Say in the middle of a panel why there is nothing in it, in place of its axes."""
    axes.set_axis_off()
    told = "\n".join(["--", *wrap(reason, signs_a_line, max_lines=10, placeholder=" ...")])
    axes.text(
        0.5,
        0.5,
        told,
        transform=axes.transAxes,
        ha="center",
        va="center",
        fontsize=7.0,
        color=theme.SOFT,
        linespacing=1.3,
    )
