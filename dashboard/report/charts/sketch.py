"""A sketch of the structure as it leans, exaggerated so that one sees it, with the factor written on it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from dashboard import numbers, theme
from dashboard.report.charts.style import bare, draw
from dashboard.report.words import Words

SIZE_MM: Final = (58.0, 96.0)

WIDEST: Final = 0.30
"""The lean is drawn as at most this share of the height."""

NEAR: Final = 4.0
"""A limit of so many times the deviation is still drawn."""

FACTORS: Final = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)


@dataclass(frozen=True, slots=True)
class Leaning:
    """What the sketch shows, in metres; ``azimuth_deg`` is None where no direction is significant."""

    height_m: float
    shaft_z_m: tuple[float, float]
    radius_m: tuple[float, float]
    deviation_m: float
    deviation_sigma_m: float | None
    allowable_m: float | None
    azimuth_deg: float | None


def factor_of(leaning: Leaning) -> int:
    """Return the largest round factor with which the lean stays within the sketch."""
    reach = _reach_m(leaning)
    if reach <= 0.0:
        return 1
    most = WIDEST * leaning.height_m / reach
    return max((factor for factor in FACTORS if factor <= most), default=1)


def chart(leaning: Leaning, colour: str, words: Words) -> str:
    """Draw the structure from the side, so that it leans to the right."""

    def plot(figure: Figure) -> None:
        axes = figure.add_subplot()
        bare(axes)
        _draw(axes, leaning, colour, words)

    return draw("sketch", SIZE_MM, plot)


def _draw(axes: Axes, leaning: Leaning, colour: str, words: Words) -> None:
    height, factor = leaning.height_m, factor_of(leaning)
    top = factor * leaning.deviation_m
    half = height / 2.0 * SIZE_MM[0] / SIZE_MM[1] * 1.12
    middle = factor * _reach_m(leaning) / 2.0
    axes.add_patch(
        Polygon(_outline(leaning, 0.0), closed=True, fc="none", ec=theme.FAINT, lw=0.9, ls=(0, (4, 2)))
    )
    axes.add_patch(Polygon(_outline(leaning, top), closed=True, fc="#eef1f4", ec=theme.INK, lw=1.1))
    axes.plot([0.0, top], [0.0, height], color=theme.INK, lw=0.8)
    axes.plot([0.0, 0.0], [0.0, 1.10 * height], color=theme.SOFT, lw=0.8, ls=(0, (5, 2, 1, 2)))
    axes.plot([middle - half, middle + half], [0.0, 0.0], color=theme.INK, lw=1.2)
    level = 1.055 * height
    axes.annotate(
        "",
        (top, level),
        (0.0, level),
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0},
    )
    value = numbers.mm_with_u(leaning.deviation_m, leaning.deviation_sigma_m)
    axes.text(
        top / 2.0,
        1.125 * height,
        value,
        ha="center",
        va="bottom",
        fontsize=8.5,
        fontweight="semibold",
        color=colour,
    )
    _limit(axes, leaning, factor, words)
    _notes(axes, leaning, middle, factor, words)
    axes.set_xlim(middle - half, middle + half)
    axes.set_ylim(-0.21 * height, 1.22 * height)


def _reach_m(leaning: Leaning) -> float:
    """The larger of deviation and limit; a limit far beyond the deviation is not drawn."""
    limit = leaning.allowable_m
    return max(leaning.deviation_m, limit if limit is not None and _is_near(leaning, limit) else 0.0)


def _is_near(leaning: Leaning, limit_m: float) -> bool:
    return limit_m <= NEAR * leaning.deviation_m


def _outline(leaning: Leaning, top: float) -> np.ndarray:
    """The four corners of the shaft, leaning so that the axis at the height H is at ``top``."""
    low, high = 0.0, leaning.height_m
    (z_low, z_high), (wide, narrow) = leaning.shaft_z_m, leaning.radius_m
    slope = (narrow - wide) / (z_high - z_low)
    bottom, upper = wide + slope * (low - z_low), max(narrow + slope * (high - z_high), 0.2 * narrow)
    return np.array([[-bottom, low], [bottom, low], [top + upper, high], [top - upper, high]])


def _limit(axes: Axes, leaning: Leaning, factor: int, words: Words) -> None:
    """A tick at the limit, where it lies within the sketch."""
    if leaning.allowable_m is None or not _is_near(leaning, leaning.allowable_m):
        return
    place = factor * leaning.allowable_m
    low, high = 0.93 * leaning.height_m, 1.09 * leaning.height_m
    axes.plot([place, place], [low, high], color=theme.VERMILION, lw=1.4, ls=(0, (2, 1)))
    axes.text(
        place,
        low - 0.01 * leaning.height_m,
        words("chart.limit"),
        ha="center",
        va="top",
        fontsize=6.5,
        color=theme.VERMILION,
        bbox={"fc": "white", "ec": "none", "pad": 0.8, "alpha": 0.9},
    )


def _notes(axes: Axes, leaning: Leaning, middle: float, factor: int, words: Words) -> None:
    height = leaning.height_m
    towards = (
        words("chart.no_direction")
        if leaning.azimuth_deg is None
        else words("chart.towards", azimuth=numbers.degrees(leaning.azimuth_deg, 1))
    )
    exaggerated = words("chart.lean_drawn", factor=factor) if factor > 1 else words("chart.true_scale")
    for place, text in enumerate((towards, exaggerated, words("chart.plumb_line"))):
        axes.text(
            middle,
            -(0.035 + 0.055 * place) * height,
            text,
            ha="center",
            va="top",
            fontsize=6.8,
            color=theme.SOFT,
        )
