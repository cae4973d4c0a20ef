"""Where the stations stood, how good their scans fit, and where one more would help most."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from dashboard import numbers, theme
from dashboard.report.charts.style import draw, north_arrow
from dashboard.report.legible import label
from dashboard.report.words import Words

SIZE_MM: Final = (84.0, 84.0)

STATES: Final = {"ok": (theme.BLUE, "o"), "suspect": (theme.ORANGE, "s"), "failed": (theme.VERMILION, "X")}


@dataclass(frozen=True, slots=True)
class Pin:
    """A station on the map, metres; ``state`` is ok, suspect or failed."""

    station: str
    east_m: float
    north_m: float
    state: str


@dataclass(frozen=True, slots=True)
class StationMap:
    """Stations about a structure; ``next_deg`` is where one more would help, clockwise from grid north."""

    pins: Sequence[Pin]
    foot_m: tuple[float, float]
    radius_m: float
    lean_deg: float | None
    next_deg: float | None


def chart(shown: StationMap, words: Words) -> str:
    """Draw the map, north up, one scale both ways."""

    def plot(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="box")
        reach = _reach(shown)
        for pin in shown.pins:
            _pin(axes, pin, shown.foot_m)
        axes.add_patch(Circle(shown.foot_m, shown.radius_m, fc="#d9dee4", ec=theme.INK, lw=0.9, zorder=3))
        _arrows(axes, shown, reach, words)
        east, north = shown.foot_m
        axes.set_xlim(east - 1.26 * reach, east + 1.26 * reach)
        axes.set_ylim(north - 1.26 * reach, north + 1.26 * reach)
        axes.set_xlabel(words("chart.east_m"))
        axes.set_ylabel(words("chart.north_m"))
        north_arrow(axes)

    return draw("stations", SIZE_MM, plot)


def _reach(shown: StationMap) -> float:
    east, north = shown.foot_m
    return max(
        [math.hypot(pin.east_m - east, pin.north_m - north) for pin in shown.pins] + [3.0 * shown.radius_m]
    )


def _pin(axes: Axes, pin: Pin, foot: tuple[float, float]) -> None:
    colour, mark = STATES.get(pin.state, STATES["failed"])
    axes.plot([foot[0], pin.east_m], [foot[1], pin.north_m], color=colour, lw=0.7, alpha=0.55, zorder=2)
    axes.plot([pin.east_m], [pin.north_m], mark, color=colour, ms=5.5, mec="white", mew=0.6, zorder=4)
    named = axes.annotate(
        label(pin.station, 12),
        (pin.east_m, pin.north_m),
        (0, 5),
        textcoords="offset points",
        ha="center",
        fontsize=6.8,
        zorder=5,
    )
    named.set_in_layout(False)


def _arrows(axes: Axes, shown: StationMap, reach: float, words: Words) -> None:
    east, north = shown.foot_m
    if shown.lean_deg is not None:
        sine, cosine = math.sin(math.radians(shown.lean_deg)), math.cos(math.radians(shown.lean_deg))
        end = (east + 0.34 * reach * sine, north + 0.34 * reach * cosine)
        axes.annotate(
            "", end, shown.foot_m, arrowprops={"arrowstyle": "-|>", "color": theme.INK, "lw": 1.3}, zorder=6
        )
        label_at = (east + 0.41 * reach * sine, north + 0.41 * reach * cosine)
        side = "left" if sine > 0.35 else "right" if sine < -0.35 else "center"
        axes.annotate(words("chart.lean"), label_at, ha=side, va="center", fontsize=6.8, zorder=6)
    if shown.next_deg is not None:
        sine, cosine = math.sin(math.radians(shown.next_deg)), math.cos(math.radians(shown.next_deg))
        place = (east + 0.8 * reach * sine, north + 0.8 * reach * cosine)
        axes.plot(*place, "o", ms=7, mfc="none", mec=theme.GREEN, mew=1.1, zorder=4)
        axes.plot(*place, "+", ms=5, color=theme.GREEN, mew=1.1, zorder=4)
        label = words("chart.next_station", azimuth=numbers.degrees(shown.next_deg, 0))
        axes.annotate(
            label,
            place,
            (0, -7),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=6.5,
            color=theme.GREEN,
            zorder=5,
        )
