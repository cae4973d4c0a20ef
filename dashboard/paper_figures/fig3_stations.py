"""Figure 3: where the stations stood, and what each of them saw."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import shorten
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray

from dashboard import numbers, theme
from dashboard.paper_figures.oblique import ObliqueView
from dashboard.paper_figures.style import (
    SIGNS_A_LINE,
    WIDTH_MM,
    axes_in_mm,
    letter,
    north_arrow,
    say_missing,
    station_color,
    write_remarks,
)
from dashboard.paper_figures.subject import Subject
from storage.records import StationRow, TiltRow
from storage.views import station_rows, tilt_rows
from storage.views.station_clouds import StationCloud, station_clouds
from storage.workspace import Workspace

NUMBER: Final = 3
NAME: Final = "figure-3-stations"
TITLE: Final = "Stations and their point clouds"
SIZE_MM: Final = (WIDTH_MM, 118.0)

MOST_POINTS: Final = 60_000
"""Of each station."""
VIEW: Final = ObliqueView(from_azimuth_deg=200.0, above_deg=24.0)
BEYOND: Final = 1.3
"""The site is shown this many times as far out as the farthest station."""
PLATE: Final = {"fc": "white", "ec": "none", "alpha": 0.75, "pad": 0.6}
"""Behind words that stand on points."""
SHARE_BELOW: Final = 0.001
"""Of the points; what is lower is a reflection or another mistake of the scanner, and not shown."""


@dataclass(frozen=True, slots=True)
class Content:
    """Stations with a position, their clouds, and the foot of the axis."""

    stations: Sequence[StationRow]
    clouds: Sequence[StationCloud]
    foot_m: tuple[float, float]
    height_m: float
    n_points: int


def read(ws: Workspace, subject: Subject) -> Content:
    """Read stations and clouds."""
    epoch = subject.epoch
    stations = station_rows(ws, epoch.structure, epoch.epoch)
    tilts = tilt_rows(ws, epoch.structure, epoch.epoch)
    return Content(
        stations,
        station_clouds(ws, epoch, MOST_POINTS),
        _foot(tilts, subject.primary),
        epoch.height_m,
        epoch.n_points_in,
    )


def plot(figure: Figure, content: Content) -> None:
    """Draw the plan at the left, the oblique view and what each station saw of the structure at the right."""
    reach = _reach(content)
    _draw_plan(axes_in_mm(figure, 12.0, 22.0, 76.0, 76.0), content, reach)
    _draw_view(axes_in_mm(figure, 95.0, 18.0, 82.0, 40.0), content, reach)
    _draw_strips(axes_in_mm(figure, 101.0, 66.0, 76.0, 32.0), content)
    shown = sum(len(cloud.points_m) for cloud in content.clouds if cloud.points_m is not None)
    missing = [f"{cloud.station} ({_in_short(cloud)})" for cloud in content.clouds if cloud.points_m is None]
    remarks = [
        f"{numbers.count(shown)} of {numbers.count(content.n_points)} points, evenly chosen, as registered, in the site "
        "frame. Points beyond the panels are left out, in (c) also the lowest 0.1 %."
    ]
    told = shorten(f"Without points here: {', '.join(missing)}", SIGNS_A_LINE, placeholder=" ...")
    write_remarks(figure, [*remarks, *([told] if missing else [])])


def _in_short(cloud: StationCloud) -> str:
    return "not used" if (cloud.reason or "").startswith("not used") else "its scan is not in this workspace"


def _foot(tilts: Sequence[TiltRow], primary: tuple[str, str]) -> tuple[float, float]:
    chosen = sorted(tilts, key=lambda row: (row.scheme, row.method) != primary)
    return (chosen[0].base_east_m, chosen[0].base_north_m) if chosen else (0.0, 0.0)


def _reach(content: Content) -> float:
    """Half of the side of the square that is shown about the foot."""
    away = [
        math.hypot(row.position_east_m - content.foot_m[0], row.position_north_m - content.foot_m[1])
        for row in content.stations
        if row.position_east_m is not None and row.position_north_m is not None
    ]
    return BEYOND * max([*away, content.height_m / 4])


def _draw_plan(axes: Axes, content: Content, reach: float) -> None:
    east, north = content.foot_m
    axes.set_aspect("equal")
    axes.set_xlim(east - reach, east + reach)
    axes.set_ylim(north - reach, north + reach)
    for number, cloud in enumerate(content.clouds):
        if cloud.points_m is not None:
            x, y = cloud.points_m[:, 0], cloud.points_m[:, 1]
            axes.scatter(
                x, y, s=0.25, color=station_color(number), alpha=0.35, lw=0, rasterized=True, zorder=1
            )
    for number, row in enumerate(content.stations):
        if row.position_east_m is not None and row.position_north_m is not None:
            _pin(axes, row, content.foot_m, station_color(number))
    axes.add_patch(Circle(content.foot_m, 0.02 * reach, fc=theme.INK, ec="white", lw=0.8, zorder=5))
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)", labelpad=1)
    north_arrow(axes)
    letter(axes, "(a)  Stations in plan")


def _pin(axes: Axes, row: StationRow, foot: tuple[float, float], color: str) -> None:
    place = (row.position_east_m or 0.0, row.position_north_m or 0.0)
    axes.plot([foot[0], place[0]], [foot[1], place[1]], color=theme.INK, lw=0.5, alpha=0.6, zorder=3)
    axes.plot(*place, "^", ms=6.5, color=color, mec=theme.INK, mew=0.7, zorder=5)
    away = math.hypot(place[0] - foot[0], place[1] - foot[1])
    axes.annotate(
        f"{row.station[:16]}\n{away:.0f} m",
        place,
        (6 if place[0] >= foot[0] else -6, 0),
        textcoords="offset points",
        ha="left" if place[0] >= foot[0] else "right",
        va="center",
        fontsize=6.4,
        zorder=6,
        bbox=PLATE,
    )


def _draw_view(axes: Axes, content: Content, reach: float) -> None:
    axes.set_axis_off()
    letter(axes, "(c)  All clouds together, coloured by station")
    there = [
        (number, cloud.points_m) for number, cloud in enumerate(content.clouds) if cloud.points_m is not None
    ]
    if not there:
        say_missing(axes, "no cloud of a station is in this workspace")
        return
    kept = [(number, _near(points, content, reach)) for number, points in there]
    seen = np.vstack([VIEW.seen(points) for _, points in kept])
    color = np.concatenate([np.full(len(points), number) for number, points in kept])
    order = np.argsort(seen[:, 2], kind="stable")
    palette = np.array([station_color(number) for number in range(len(content.clouds))])
    axes.scatter(
        seen[order, 0], seen[order, 1], s=0.3, c=palette[color[order]], lw=0, alpha=0.7, rasterized=True
    )
    axes.set_aspect("equal", anchor="S")
    axes.margins(0.01, 0.03)
    for number, _ in there:
        _pin_in_view(axes, content.stations[number], station_color(number))
    _scale_bar(axes, 100.0 if reach > 100 else 10.0)


def _draw_strips(axes: Axes, content: Content) -> None:
    """Draw the structure as each station saw it, side by side, every one seen from its station."""
    letter(axes, "(b)  The structure as each station saw it")
    there = [(number, row) for number, row in enumerate(content.stations) if row.position_east_m is not None]
    wide = max(0.3 * content.height_m, 4.0)
    for place, (number, row) in enumerate(there):
        points = content.clouds[number].points_m
        if points is not None:
            across, up = _from_station(points, row, content.foot_m, wide / 2)
            axes.scatter(place * wide + across, up, s=0.3, color=station_color(number), lw=0, rasterized=True)
    axes.set_aspect("equal", adjustable="box", anchor="SW")
    axes.set_xlim(-wide / 2, max(len(there), 1) * wide - wide / 2)
    axes.set_ylim(-0.03 * content.height_m, 1.12 * content.height_m)
    axes.set_xticks(
        [place * wide for place in range(len(there))], [row.station[:8] for _, row in there], fontsize=6.0
    )
    axes.tick_params(axis="x", length=0)
    axes.set_ylabel("height (m)", labelpad=1)


def _from_station(
    points_m: NDArray[np.float64], row: StationRow, foot: tuple[float, float], half_m: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Across the line of sight and up, of the points near the axis."""
    off = points_m[:, :2] - foot
    towards = np.array(foot) - ((row.position_east_m or 0.0), (row.position_north_m or 0.0))
    towards = towards / max(float(np.hypot(*towards)), 1e-9)
    across = off @ np.array([towards[1], -towards[0]])
    along = off @ towards
    near = (np.abs(across) < half_m) & (np.abs(along) < half_m)
    return across[near], points_m[near, 2]


def _near(points_m: NDArray[np.float64], content: Content, reach: float) -> NDArray[np.float64]:
    lowest = np.quantile(points_m[:, 2], SHARE_BELOW)
    away = np.hypot(points_m[:, 0] - content.foot_m[0], points_m[:, 1] - content.foot_m[1])
    return points_m[(away < reach) & (points_m[:, 2] >= lowest) & (points_m[:, 2] < 1.2 * content.height_m)]


def _pin_in_view(axes: Axes, row: StationRow, color: str) -> None:
    if row.position_east_m is None or row.position_north_m is None:
        return
    place = np.array([[row.position_east_m, row.position_north_m, row.position_up_m or 0.0]])
    x, y, _ = VIEW.seen(place)[0]
    axes.plot(x, y, "^", ms=5.5, color=color, mec=theme.INK, mew=0.7, zorder=5)
    axes.annotate(
        row.station[:16],
        (x, y),
        (0, -5),
        textcoords="offset points",
        ha="center",
        va="top",
        fontsize=6.0,
        zorder=6,
        bbox=PLATE,
    )


def _scale_bar(axes: Axes, length_m: float) -> None:
    left, low = axes.get_xlim()[0], axes.get_ylim()[0]
    axes.add_patch(
        Rectangle((left, low), length_m, 0.006 * np.ptp(axes.get_ylim()), color=theme.INK, clip_on=False)
    )
    axes.annotate(f"{length_m:g} m across", (left, low), (0, 4), textcoords="offset points", fontsize=6.4)
