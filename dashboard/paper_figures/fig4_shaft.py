"""Figure 4: the shaft before and after everything else was taken away."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from dashboard import numbers, theme
from dashboard.paper_figures.style import WIDTH_MM, axes_in_mm, letter, say_missing, write_remarks
from dashboard.paper_figures.subject import Subject
from storage.errors import StorageError
from storage.records import RemovalRow, TiltRow
from storage.views import removal_rows, tilt_rows
from storage.views.shaft_points import shaft_points
from storage.views.station_clouds import station_clouds
from storage.workspace import Workspace

NUMBER: Final = 4
NAME: Final = "figure-4-shaft"
TITLE: Final = "Point cloud of the shaft, raw and isolated"
SIZE_MM: Final = (WIDTH_MM, 136.0)

MOST_POINTS: Final = 250_000
"""Of all raw points, and of the isolated ones."""
PANEL_MM: Final = (36.0, 93.0)
BELOW: Final = 0.03
ABOVE: Final = 1.14
"""Panels go from so much of the height of the structure below z = 0 to so much of it."""
SHARE_WIDE: Final = (BELOW + ABOVE) * PANEL_MM[0] / PANEL_MM[1]
"""Width of a panel in true proportion, as a share of the height of the structure."""
MOST_WIDENED: Final = 6.0
SIGNS_OF_A_REASON: Final = 36
GONE: Final = "the points are not in this workspace"

BLUES: Final = LinearSegmentedColormap.from_list("blues", ["#a9cdea", "#3f86bf", "#0b4a7f"])
GREYS: Final = LinearSegmentedColormap.from_list("greys", ["#c3c9d0", "#7d8691", "#38414d"])

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Content:
    """Raw points near the axis and isolated points, along the lean, across it and up; what was removed."""

    raw: Points | None
    isolated: Points | None
    missing: str
    removals: Sequence[RemovalRow]
    along_deg: float
    lean: float
    height_m: float


def read(ws: Workspace, subject: Subject) -> Content:
    """Read raw and isolated points and turn them so that the lean lies in the picture."""
    epoch = subject.epoch
    tilts = tilt_rows(ws, epoch.structure, epoch.epoch)
    axis = next(iter(sorted(tilts, key=lambda row: (row.scheme, row.method) != subject.primary)), None)
    clouds = [
        cloud.points_m for cloud in station_clouds(ws, epoch, MOST_POINTS) if cloud.points_m is not None
    ]
    isolated, missing = _isolated(ws, subject)
    along_deg = (
        90.0 if axis is None else float(np.degrees(np.arctan2(axis.lean_east, axis.lean_north))) % 360.0
    )
    return Content(
        raw=_near(_turned(np.vstack(clouds), axis, along_deg), epoch.height_m) if clouds else None,
        isolated=None if isolated is None else _turned(isolated, axis, along_deg),
        missing=missing,
        removals=removal_rows(ws, epoch.structure, epoch.epoch),
        along_deg=along_deg,
        lean=0.0 if axis is None else float(np.hypot(axis.lean_east, axis.lean_north)),
        height_m=epoch.height_m,
    )


def plot(figure: Figure, content: Content) -> None:
    """Draw raw and isolated points, the isolated ones once more widened, and what was removed."""
    wide, high = PANEL_MM
    places = [axes_in_mm(figure, 13.0 + number * (wide + 5.0), 22.0, wide, high) for number in range(3)]
    _panel(places[0], content.raw, GREYS, content, "(a)  Raw")
    _panel(places[1], content.isolated, BLUES, content, "(b)  Isolated")
    _widened(places[2], content)
    places[0].set_ylabel("height (m)", labelpad=1)
    for axes in places[1:]:
        axes.tick_params(labelleft=False)
    _draw_removals(axes_in_mm(figure, 13.0 + 3 * (wide + 5.0), 22.0, 44.0, high), content)
    lean = "the lean shows to the right" if content.lean else "no axis was found"
    write_remarks(
        figure,
        [
            f"Seen across the lean: to the right is azimuth {content.along_deg:.1f}° (clockwise from grid north), {lean}. "
            "(a) and (b) in true proportion; the nearer a point, the darker. Dashed: plumb through the foot of the axis."
        ],
    )


def _isolated(ws: Workspace, subject: Subject) -> tuple[Points | None, str]:
    try:
        found = shaft_points(ws, subject.epoch.structure, subject.epoch.epoch).thinned(MOST_POINTS)
    except StorageError as fault:
        return None, str(fault)
    return np.array(found.points_m), ""


def _turned(points_m: Points, axis: TiltRow | None, along_deg: float) -> Points:
    """Along the lean and across it from the foot of the axis, and up."""
    foot = (0.0, 0.0) if axis is None else (axis.base_east_m, axis.base_north_m)
    east, north = (points_m[:, :2] - foot).T
    sine, cosine = np.sin(np.radians(along_deg)), np.cos(np.radians(along_deg))
    return np.column_stack([east * sine + north * cosine, east * cosine - north * sine, points_m[:, 2]])


def _near(points_m: Points, height_m: float) -> Points:
    half = SHARE_WIDE / 2 * height_m
    near = (np.abs(points_m[:, :2]) < half).all(axis=1)
    inside = (points_m[:, 2] > -0.05 * height_m) & (points_m[:, 2] < 1.2 * height_m)
    found = points_m[near & inside]
    return found[:: max(1, -(-len(found) // MOST_POINTS))]


def _panel(axes: Axes, points: Points | None, colors: Colormap, content: Content, title: str) -> None:
    axes.set_xlim(-SHARE_WIDE / 2 * content.height_m, SHARE_WIDE / 2 * content.height_m)
    _lay_out(axes, content, title)
    if points is None or not len(points):
        say_missing(axes, GONE if points is None else "no points near the axis")
        return
    _dots(axes, points, colors)
    axes.set_xlabel("along the lean (m)")


def _widened(axes: Axes, content: Content) -> None:
    half = SHARE_WIDE / 2 * content.height_m / MOST_WIDENED
    middle = content.lean * content.height_m / 2
    reach = (
        half
        if content.isolated is None
        else max(half, 1.15 * float(np.abs(content.isolated[:, 0] - middle).max()))
    )
    axes.set_xlim(middle - reach, middle + reach)
    _lay_out(axes, content, f"(c)  Isolated, ×{SHARE_WIDE / 2 * content.height_m / reach:.2g} wide")
    if content.isolated is None:
        say_missing(axes, GONE)
        return
    _dots(axes, content.isolated, BLUES, 0.9)
    axes.set_xlabel("along the lean (m)")


def _lay_out(axes: Axes, content: Content, title: str) -> None:
    axes.set_ylim(-BELOW * content.height_m, ABOVE * content.height_m)
    letter(axes, title)


def _dots(axes: Axes, points: Points, colors: Colormap, area: float = 0.3) -> None:
    """Draw points, the nearer the darker, so that the round of the shaft shows, and plumb through the foot."""
    axes.axvline(0.0, color=theme.INK, lw=0.7, ls=(0, (5, 2)), zorder=3)
    near = points[:, 1] / max(float(np.quantile(np.abs(points[:, 1]), 0.98)), 1e-6)
    order = np.argsort(near, kind="stable")
    x, y, shade = points[order, 0], points[order, 2], near[order]
    axes.scatter(x, y, s=area, c=shade, cmap=colors, vmin=-1.0, vmax=1.0, lw=0, rasterized=True, zorder=2)


def _draw_removals(axes: Axes, content: Content) -> None:
    """Draw what became of the points as bars, in the order in which it did."""
    axes.set_axis_off()
    letter(axes, "(d)  What became of the points")
    rows = [row for row in content.removals if row.n_points > 0]
    total = sum(row.n_points for row in rows)
    if not total:
        say_missing(axes, "no points were counted")
        return
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(len(rows) + 0.4 if len(rows) > 6 else 7.0, -0.2)
    for place, row in enumerate(rows):
        share = row.n_points / total
        kept = row.reason == "kept"
        axes.barh(place + 0.62, share, height=0.26, color=theme.BLUE if kept else "#b9c1ca", left=0.0)
        axes.text(
            0.0,
            place + 0.40,
            _short(row.reason),
            fontsize=6.4,
            va="bottom",
            linespacing=1.05,
            fontweight=600 if kept else 400,
        )
        told = f"{numbers.count(row.n_points)}  ({_percent(share)})"
        axes.text(min(share + 0.02, 0.55), place + 0.62, told, fontsize=6.4, va="center", color=theme.INK)


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %" if share >= 0.001 else "< 0.1 %"


def _short(reason: str) -> str:
    return "\n".join(wrap(reason, SIGNS_OF_A_REASON, max_lines=2))
