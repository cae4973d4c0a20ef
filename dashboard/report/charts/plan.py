"""The top in the plan: all of it from the plumb line on, and the movement at its own scale."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from dashboard import theme
from dashboard.content.plan import Top, ellipse
from dashboard.report.charts.style import draw, north_arrow
from dashboard.report.legible import label
from dashboard.report.words import Words

SIZE_MM: Final = (178.0, 86.0)


def chart(tops: Sequence[Top], allowable_m: float | None, words: Words) -> str:
    """Draw both panels; the newest epoch is the darkest."""

    def plot(figure: Figure) -> None:
        whole, near = figure.subplots(1, 2)
        _whole(whole, tops, allowable_m, words)
        _near(near, tops, words)
        for axes in (whole, near):
            axes.set_aspect("equal", adjustable="box")
            axes.set_xlabel(words("chart.east_mm"))
            axes.set_ylabel(words("chart.north_mm"))
            north_arrow(axes)

    return draw("plan", SIZE_MM, plot)


def _whole(axes: Axes, tops: Sequence[Top], allowable_m: float | None, words: Words) -> None:
    axes.set_title(words("chart.plan_whole"), loc="left")
    points = 1e3 * np.array([top.east_north_m for top in tops])
    if allowable_m is not None:
        limit = 1e3 * allowable_m
        axes.add_patch(Circle((0, 0), limit, fc="none", ec=theme.VERMILION, lw=1.1, ls=(0, (5, 2))))
        axes.annotate(
            words("chart.limit"),
            (0, limit),
            (0, 2),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=6.8,
            color=theme.VERMILION,
        )
    axes.plot([0], [0], "+", ms=9, mew=1.2, color=theme.SOFT)
    axes.annotate(
        "",
        points[-1],
        (0, 0),
        arrowprops={"arrowstyle": "-|>", "color": theme.INK, "lw": 1.2, "shrinkA": 0, "shrinkB": 0},
    )
    axes.plot(points[:, 0], points[:, 1], "o", ms=3, color=theme.BLUE)
    reach = 1.12 * max(float(np.abs(points).max()), 1e3 * (allowable_m or 0.0), 1.0)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)


def _near(axes: Axes, tops: Sequence[Top], words: Words) -> None:
    axes.set_title(words("chart.plan_near"), loc="left")
    points = 1e3 * np.array([top.east_north_m for top in tops])
    axes.plot(points[:, 0], points[:, 1], "-", lw=0.6, color=theme.FAINT, zorder=1)
    lines = [points]
    for place, top in enumerate(tops):
        shade = 0.25 + 0.75 * (place + 1) / len(tops)
        if top.covariance_m2 is not None:
            line = 1e3 * ellipse(top.east_north_m, top.covariance_m2)
            lines.append(line)
            axes.add_patch(
                Polygon(line, closed=True, fc=theme.SKY, ec=theme.BLUE, lw=0.9, alpha=0.75 * shade, zorder=2)
            )
        axes.plot(*points[place], "o", ms=2.6, color=theme.INK, alpha=shade, zorder=3)
    _labels(axes, tops, points)
    everything = np.vstack(lines)
    middle = (everything.min(axis=0) + everything.max(axis=0)) / 2.0
    reach = max(0.66 * float((everything.max(axis=0) - everything.min(axis=0)).max()), 0.5)
    axes.set_xlim(middle[0] - reach, middle[0] + reach)
    axes.set_ylim(middle[1] - reach, middle[1] + reach)


def _labels(axes: Axes, tops: Sequence[Top], points: np.ndarray) -> None:
    """Name the first and the last epoch; those between would lie over each other."""
    for place in {0, len(tops) - 1}:
        newest = place == len(tops) - 1
        axes.annotate(
            label(tops[place].epoch), points[place], (0, -9 if newest else 9), textcoords="offset points", ha="center",
            va="top" if newest else "bottom", fontsize=6.8, fontweight="semibold" if newest else "normal", zorder=5,
        )  # fmt: skip
