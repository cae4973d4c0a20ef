"""Figure 5: the contours that each scheme found, over the height, and one slice of each with its points."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from dashboard import numbers, theme
from dashboard.paper_figures.schemes_shown import SchemeShown, SchemesShown, left_out_told, schemes_of
from dashboard.paper_figures.style import WIDTH_MM, axes_in_mm, say_missing, write_remarks
from dashboard.paper_figures.subject import Subject
from storage.errors import StorageError
from storage.records import SliceRow
from storage.views.shaft_points import ShaftPoints, shaft_points
from storage.workspace import Workspace

NUMBER: Final = 5
NAME: Final = "figure-5-contours"
TITLE: Final = "Slices and their contours under each scheme"
SIZE_MM: Final = (WIDTH_MM, 152.0)

STACK_MM: Final = 76.0
LEFT_MM: Final = 13.0
FLATNESS: Final = 0.28
"""Of a ring in the picture: its height as a share of its width."""
FLATTEST: Final = 0.03
"""Half of the height of a ring is at most this share of that of the picture."""
SCATTER_SHARE: Final = 0.12
"""Of the radius: about so far off their circle the points of the slices below are drawn."""
MOST_POINTS: Final = 4_000
ANGLES: Final = np.radians(np.arange(0.0, 361.0, 3.0))


@dataclass(frozen=True, slots=True)
class Content:
    """Schemes side by side; points of the shaft, or why there are none."""

    schemes: SchemesShown
    shaft: ShaftPoints | None


def read(ws: Workspace, subject: Subject) -> Content:
    """Read slices and points."""
    try:
        shaft = shaft_points(ws, subject.epoch.structure, subject.epoch.epoch)
    except StorageError:
        shaft = None
    return Content(schemes_of(ws, subject), shaft)


def plot(figure: Figure, content: Content) -> None:
    """Draw a column a scheme: its rings over the height, and its uppermost slice in plan."""
    schemes = content.schemes
    if not schemes.shown:
        say_missing(axes_in_mm(figure, LEFT_MM, 40.0, 150.0, 60.0), schemes.nothing, 90)
        return
    wide = (WIDTH_MM - LEFT_MM - 3.0) / len(schemes.shown)
    factor = _factor(schemes)
    reach = _reach(schemes)
    for place, shown in enumerate(schemes.shown):
        left = LEFT_MM + place * wide
        stack = axes_in_mm(figure, left, 54.0, wide - 1.5, STACK_MM)
        _draw_stack(stack, shown, schemes, reach, (wide - 1.5) / STACK_MM)
        if place:
            stack.tick_params(labelleft=False)
        else:
            stack.set_ylabel("height (m)", labelpad=1)
        _draw_slice(axes_in_mm(figure, left, 22.0, wide - 1.5, min(22.0, wide - 1.5)), shown, content, factor)
    write_remarks(
        figure,
        [
            f"Above: rings at their heights, widths in one scale, seen across the lean (azimuth {schemes.along_deg:.1f}° is "
            "to the right); dashed: plumb through the foot; × no contour. Below: the uppermost slice in plan, north up, "
            f"its points {factor:g} times as far off its circle as they are.{left_out_told(schemes)}"
        ],
    )


def _with_ring(slices: Sequence[SliceRow]) -> list[SliceRow]:
    return [row for row in slices if row.center_east_m is not None and row.radius_m is not None]


def _reach(schemes: SchemesShown) -> tuple[float, float]:
    """From where to where the rings go along the lean, the same for all schemes."""
    edges = [
        float(schemes.turned(np.array([row.center_east_m]), np.array([row.center_north_m]))[0, 0])
        + side * (row.radius_m or 0.0)
        for shown in schemes.shown
        for row in _with_ring(shown.slices)
        for side in (-1.0, 1.0)
    ]
    low, high = (min(edges), max(edges)) if edges else (-1.0, 1.0)
    return low - 0.06 * (high - low), high + 0.06 * (high - low)


def _draw_stack(
    axes: Axes, shown: SchemeShown, schemes: SchemesShown, reach: tuple[float, float], proportion: float
) -> None:
    rings = _with_ring(shown.slices)
    color = theme.scheme_colour(shown.scheme)
    low, high = -0.03 * schemes.height_m, 1.06 * schemes.height_m
    widest = max([row.radius_m or 0.0 for row in rings], default=1.0)
    flat = min(FLATNESS * proportion / (reach[1] - reach[0]), FLATTEST / widest) * (high - low)
    axes.set_xlim(*reach)
    axes.set_ylim(low, high)
    if rings:
        axes.axvline(0.0, color=theme.SOFT, lw=0.6, ls=(0, (5, 2)), zorder=1)
    for row in rings:
        along, up, middle = _ring(row, schemes, flat)
        axes.plot(along, up, color=color, lw=0.45 if len(rings) > 40 else 0.9, zorder=2)
        axes.plot(
            middle, row.z_m, "o", ms=1.4 if len(rings) > 40 else 2.6, color=theme.INK, mec="none", zorder=3
        )
    failed = [row.z_m for row in shown.slices if row.center_east_m is None]
    axes.plot(np.zeros(len(failed)), failed, "x", ms=4.0, color=theme.VERMILION, mew=1.0, zorder=4)
    axes.tick_params(axis="x", labelsize=6.2)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5, integer=True, prune="both"))
    axes.set_xlabel("along the lean (m)", labelpad=1, fontsize=6.4)
    told = f"{len(rings)} of {len(shown.slices)} slices" if failed else f"{len(rings)} slices"
    axes.set_title(shown.label, fontsize=8.5, fontweight=600, color=color, pad=12)
    axes.annotate(
        told,
        (0.5, 1.0),
        (0, 3),
        xycoords="axes fraction",
        textcoords="offset points",
        ha="center",
        fontsize=6.6,
    )
    if not rings:
        say_missing(axes, shown.reason or "no contours")


def _ring(
    row: SliceRow, schemes: SchemesShown, flat: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """A ring as it is seen from a little above: along the lean, in the picture upwards, and where its middle is."""
    middle = schemes.turned(np.array([row.center_east_m]), np.array([row.center_north_m]))[0]
    radius = row.radius_m or 0.0
    return middle[0] + radius * np.cos(ANGLES), row.z_m + flat * radius * np.sin(ANGLES), float(middle[0])


def _factor(schemes: SchemesShown) -> float:
    """How many times the distances of the points from their circle are drawn: 1, 2 or 5 times a power of ten."""
    wanted = [
        SCATTER_SHARE * (row.radius_m or 0.0) / row.rmse_m
        for shown in schemes.shown
        for row in _with_ring(shown.slices)[-1:]
        if row.rmse_m
    ]
    if not wanted:
        return 1.0
    size = max(float(np.median(wanted)), 1.0)
    power = 10.0 ** np.floor(np.log10(size))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= size))


def _draw_slice(axes: Axes, shown: SchemeShown, content: Content, factor: float) -> None:
    axes.set_axis_off()
    axes.set_aspect("equal")
    rings = _with_ring(shown.slices)
    if not rings:
        return
    row = rings[-1]
    radius = row.radius_m or 1.0
    color = theme.scheme_colour(shown.scheme)
    if content.shaft is not None:
        points = _about_the_circle(content.shaft, row, shown, factor)
        axes.scatter(points[:, 0], points[:, 1], s=0.9, color="#8b95a1", lw=0, rasterized=True, zorder=1)
    axes.plot(radius * np.cos(ANGLES), radius * np.sin(ANGLES), color=color, lw=1.1, zorder=2)
    axes.plot(0.0, 0.0, "+", ms=5.0, color=theme.INK, mew=0.8, zorder=3)
    axes.set_xlim(-1.3 * radius, 1.3 * radius)
    axes.set_ylim(-1.3 * radius, 1.3 * radius)
    told = f"{row.z_m:.2f} m, {numbers.count(row.n_points)} points\nrmse {numbers.mm(row.rmse_m)}"
    axes.text(0.0, -1.35 * radius, told, ha="center", va="top", fontsize=6.0, linespacing=1.3, zorder=4)
    if content.shaft is None:
        axes.text(0.0, 0.3 * radius, "points\nswept", ha="center", fontsize=6.0, color=theme.SOFT)


def _about_the_circle(
    shaft: ShaftPoints, row: SliceRow, shown: SchemeShown, factor: float
) -> NDArray[np.float64]:
    """Points of a slice about its centre, with their distances from its circle enlarged; lean and taper are taken off."""
    points_m = np.array(shaft.of_slice(row.z_m, row.thickness_m).thinned(MOST_POINTS).points_m)
    above = points_m[:, 2] - row.z_m
    lean = (shown.axis.lean_east, shown.axis.lean_north) if shown.axis else (0.0, 0.0)
    off = (
        points_m[:, :2]
        - (row.center_east_m or 0.0, row.center_north_m or 0.0)
        - above[:, None] * np.array(lean)
    )
    away = np.hypot(off[:, 0], off[:, 1])
    at_height = (row.radius_m or 0.0) + _taper(shown.slices) * above
    drawn = (row.radius_m or 0.0) + factor * (away - at_height)
    return np.asarray(off / np.maximum(away, 1e-9)[:, None] * drawn[:, None])


def _taper(slices: Sequence[SliceRow]) -> float:
    """Change of the radius with height."""
    rings = _with_ring(slices)
    if len(rings) < 2:
        return 0.0
    low, high = rings[-2], rings[-1]
    return ((high.radius_m or 0.0) - (low.radius_m or 0.0)) / (high.z_m - low.z_m)
