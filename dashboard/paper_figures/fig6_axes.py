"""Figure 6: the central axis of each scheme beside plumb, and how far the centres are off it."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from dashboard import numbers, theme
from dashboard.paper_figures.schemes_shown import SchemeShown, SchemesShown, left_out_told, schemes_of
from dashboard.paper_figures.style import WIDTH_MM, axes_in_mm, say_missing, write_remarks
from dashboard.paper_figures.subject import Subject
from storage.records import SliceRow, TiltRow
from storage.workspace import Workspace

NUMBER: Final = 6
NAME: Final = "figure-6-axes"
TITLE: Final = "Central axis under each scheme"
SIZE_MM: Final = (WIDTH_MM, 152.0)

LEFT_MM: Final = 13.0
HIGH_MM: Final = 46.0
WILD: Final = 3.0
"""An axis that goes so many times farther than the median of all goes out of its panel, which says so."""

Offsets = NDArray[np.float64]


def read(ws: Workspace, subject: Subject) -> SchemesShown:
    """Read axes and centres."""
    return schemes_of(ws, subject)


def plot(figure: Figure, schemes: SchemesShown) -> None:
    """Draw a column a scheme: axis and centres beside plumb, and below what the centres are off the axis."""
    if not schemes.shown:
        say_missing(axes_in_mm(figure, LEFT_MM, 40.0, 150.0, 60.0), schemes.nothing, 90)
        return
    wide = (WIDTH_MM - LEFT_MM - 3.0) / len(schemes.shown)
    axis_reach, rest_reach = _axis_reach(schemes), _rest_reach(schemes)
    for place, shown in enumerate(schemes.shown):
        left = LEFT_MM + place * wide
        upper = axes_in_mm(figure, left, 80.0, wide - 2.2, HIGH_MM)
        lower = axes_in_mm(figure, left, 22.0, wide - 2.2, HIGH_MM)
        _draw_axis(upper, shown, schemes, axis_reach)
        _draw_rest(lower, shown, schemes, rest_reach)
        for axes in (upper, lower):
            axes.set_ylim(-0.02 * schemes.height_m, 1.06 * schemes.height_m)
            axes.tick_params(axis="x", labelsize=6.2)
            axes.tick_params(labelleft=place == 0)
            if place == 0:
                axes.set_ylabel("height (m)", labelpad=1)
        upper.set_xlabel("off plumb (mm)", fontsize=6.4, labelpad=1)
        lower.set_xlabel("off the axis (mm)", fontsize=6.4, labelpad=1)
    write_remarks(
        figure,
        [
            f"Above: axis and centres along azimuth {schemes.along_deg:.1f}° from plumb through the foot of the primary "
            "axis; deviation ± U (k = 2) and azimuth (-- below 3 sigma); red: the limit, where there is one. Below: centres "
            f"off their axis, ● along, ○ across, bars ± 2 sigma of the points.{left_out_told(schemes)}"
        ],
    )


def _centres(shown: SchemeShown) -> list[SliceRow]:
    return [row for row in shown.slices if row.center_east_m is not None]


def _along(shown: SchemeShown, schemes: SchemesShown) -> Offsets:
    """Centres along the lean from plumb [mm]."""
    rows = _centres(shown)
    if not rows:
        return np.empty(0)
    east, north = (
        np.array([getattr(row, name) for row in rows]) for name in ("center_east_m", "center_north_m")
    )
    return 1e3 * schemes.turned(east, north)[:, 0]


def _line(axis: TiltRow, schemes: SchemesShown) -> Offsets:
    """The axis at z = 0 and at the height of the verdict, along the lean from plumb [mm]."""
    z = np.array([0.0, schemes.height_m])
    east, north = axis.base_east_m + z * axis.lean_east, axis.base_north_m + z * axis.lean_north
    return 1e3 * schemes.turned(east, north)[:, 0]


def _axis_reach(schemes: SchemesShown) -> tuple[float, float]:
    """From where to where the axes go, with plumb and the limit in range; a wild one does not flatten the others."""
    ends = [_ends_of(shown, schemes) for shown in schemes.shown if shown.axis is not None]
    usual = float(np.median([np.abs(pair).max() for pair in ends])) if ends else 1.0
    limits = [
        1e3 * shown.axis.allowable_m for shown in schemes.shown if shown.axis and shown.axis.allowable_m
    ]
    told = [float(end) for pair in ends if np.abs(pair).max() <= WILD * usual for end in pair]
    return _widened([0.0, *told, *limits])


def _ends_of(shown: SchemeShown, schemes: SchemesShown) -> Offsets:
    return np.zeros(1) if shown.axis is None else _line(shown.axis, schemes)


def _rest_reach(schemes: SchemesShown) -> tuple[float, float]:
    rest = [
        np.abs(_rest(row, schemes))
        for shown in schemes.shown
        for row in _centres(shown)
        if row.offset_east_m is not None
    ]
    # one wild centre of one scheme must not flatten all others
    most = float(np.quantile(np.concatenate(rest), 0.995)) if rest else 1.0
    return -1.25 * max(most, 0.5), 1.25 * max(most, 0.5)


def _widened(ends: Sequence[float]) -> tuple[float, float]:
    low, high = min(ends), max(ends)
    gap = 0.1 * max(high - low, 1.0)
    return low - gap, high + gap


def _rest(row: SliceRow, schemes: SchemesShown) -> Offsets:
    """What a centre is off its axis along and across the lean [mm]."""
    sine, cosine = np.sin(np.radians(schemes.along_deg)), np.cos(np.radians(schemes.along_deg))
    east, north = row.offset_east_m or 0.0, row.offset_north_m or 0.0
    return 1e3 * np.array([east * sine + north * cosine, north * sine - east * cosine])


def _draw_axis(axes: Axes, shown: SchemeShown, schemes: SchemesShown, reach: tuple[float, float]) -> None:
    color = theme.scheme_colour(shown.scheme)
    axes.set_xlim(*reach)
    axes.set_title(shown.label, fontsize=8.5, fontweight=600, color=color, pad=21)
    if shown.axis is None:
        say_missing(axes, shown.reason or "no axis")
        return
    axes.axvline(0.0, color=theme.SOFT, lw=0.6, ls=(0, (5, 2)), zorder=1)
    rows = _centres(shown)
    line, heights = _line(shown.axis, schemes), [row.z_m for row in rows]
    axes.plot(line, [0.0, schemes.height_m], color=color, lw=1.2, zorder=2)
    dot = 1.6 if len(rows) > 40 else 3.2
    axes.plot(_along(shown, schemes), heights, "o", ms=dot, color=color, mec="white", mew=0.2, zorder=3)
    if np.ptp([*line, *reach]) > np.ptp(reach):
        axes.text(
            0.5, 0.04, "goes beyond", transform=axes.transAxes, fontsize=6.0, color=theme.SOFT, ha="center"
        )
    _draw_limit(axes, shown.axis, schemes.height_m)
    deviation = numbers.mm_with_u(shown.axis.deviation_m, shown.axis.deviation_sigma_m)
    _write_above(axes, f"{deviation}\n{_towards(shown.axis)}")


def _draw_limit(axes: Axes, axis: TiltRow, height_m: float) -> None:
    if axis.allowable_m is None:
        return
    limit, low = 1e3 * axis.allowable_m, 0.94 * height_m
    axes.plot([limit, limit], [low, 1.04 * height_m], color=theme.VERMILION, lw=1.4, zorder=4)
    axes.annotate(
        "limit", (limit, low), (1.5, -6), textcoords="offset points", fontsize=5.4, color=theme.VERMILION
    )


def _write_above(axes: Axes, text: str) -> None:
    where: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points", "ha": "center"}
    axes.annotate(text, (0.5, 1.0), (0, 2.5), fontsize=6.2, linespacing=1.2, **where)


def _towards(axis: TiltRow) -> str:
    return "azimuth --" if axis.azimuth_deg is None else f"{axis.azimuth_deg:.2f}°"


def _draw_rest(axes: Axes, shown: SchemeShown, schemes: SchemesShown, reach: tuple[float, float]) -> None:
    color = theme.scheme_colour(shown.scheme)
    axes.set_xlim(*reach)
    rows = [row for row in _centres(shown) if row.offset_east_m is not None]
    if not rows:
        say_missing(axes, "no residuals")
        return
    axes.axvline(0.0, color=color, lw=1.0, zorder=1)
    rest = np.array([_rest(row, schemes) for row in rows])
    z = np.array([row.z_m for row in rows])
    dot = 1.8 if len(rows) > 40 else 3.2
    known = np.array([row.sigma_center_m is not None for row in rows])
    bars = 2e3 * np.array([row.sigma_center_m or 0.0 for row in rows])
    axes.hlines(
        z[known],
        (rest[:, 0] - bars)[known],
        (rest[:, 0] + bars)[known],
        color=color,
        lw=0.4,
        alpha=0.6,
        zorder=2,
    )
    axes.plot(rest[:, 1], z, "o", ms=dot, mfc="white", mec=color, mew=0.5, zorder=3)
    axes.plot(rest[:, 0], z, "o", ms=dot, color=color, mec="none", zorder=4)
    beyond = int((np.abs(rest) > reach[1]).any(axis=1).sum())
    told = (
        f"rmse {numbers.mm(shown.axis.rmse_m, 2)}"
        if shown.axis and shown.axis.rmse_m is not None
        else "direct line"
    )
    more = f", {beyond} beyond" if beyond else ""
    _write_above(axes, f"{told}{more}")
