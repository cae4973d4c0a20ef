"""Three cross sections with their distance from round exaggerated; the factor is written on each."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from dashboard import theme
from dashboard.report.charts.style import bare, draw
from dashboard.report.words import Words

SIZE_MM: Final = (178.0, 70.0)
FACTORS: Final = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
MOST_OF_RADIUS: Final = 0.28
"""The largest deviation is drawn as at most this share of the radius."""


@dataclass(frozen=True, slots=True)
class Ring:
    """A cross section: the mean distance of its sectors from the straight shaft, metres, NaN where nobody looked.

    ``offset_m`` is where its centre lies beside the straight axis, east and north; None where that is not known.
    """

    title: str
    radius_m: float
    azimuth_deg: NDArray[np.float64]
    deviation_m: NDArray[np.float64]
    offset_m: tuple[float, float] | None


def factor_of(rings: Sequence[Ring]) -> int:
    """Return the largest round factor with which all rings stay within their panels, one for all."""
    reach = max(
        (float(np.nanmax(np.abs(ring.deviation_m))) / ring.radius_m for ring in rings if _seen(ring)),
        default=0.0,
    )
    if reach <= 0.0:
        return 1
    return max((factor for factor in FACTORS if factor * reach <= MOST_OF_RADIUS), default=1)


def chart(rings: Sequence[Ring], words: Words) -> str:
    """Draw the sections side by side, north up."""
    factor = factor_of(rings)

    def plot(figure: Figure) -> None:
        panels = figure.subplots(1, 3, squeeze=False)[0]
        for axes in panels:
            bare(axes)
        for axes, ring in zip(panels, rings, strict=False):
            _ring(axes, ring, factor, words)

    return draw("slices", SIZE_MM, plot)


def _ring(axes: Axes, ring: Ring, factor: int, words: Words) -> None:
    axes.set_aspect("equal")
    axes.set_title(ring.title, fontweight="semibold", fontsize=8)
    circle = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(np.sin(circle), np.cos(circle), color=theme.SOFT, lw=0.7, ls=(0, (4, 2)))
    for run in _runs(ring):
        _wall(axes, run, factor / ring.radius_m)
    half = np.pi / max(len(ring.azimuth_deg), 1)
    for azimuth in np.radians(ring.azimuth_deg[~np.isfinite(ring.deviation_m)]):
        arc = np.linspace(azimuth - half, azimuth + half, 9)
        axes.plot(np.sin(arc), np.cos(arc), color="#b4bcc5", lw=4.5, solid_capstyle="butt", zorder=1)
    axes.plot([0], [0], "+", ms=7, mew=0.9, color=theme.SOFT)
    if ring.offset_m is not None:
        east, north = (factor * part / ring.radius_m for part in ring.offset_m)
        axes.plot([east], [north], "x", ms=5.5, mew=1.2, color=theme.INK, zorder=4)
    axes.annotate(
        "N", (0.0, 1.37), ha="center", va="center", fontsize=7, color=theme.SOFT, annotation_clip=False
    )
    label = words("chart.radial_factor", factor=factor, radius=f"{ring.radius_m:.3f}")
    axes.text(0.0, -1.40, label, ha="center", va="center", fontsize=6.8, color=theme.SOFT)
    axes.set_xlim(-1.45, 1.45)
    axes.set_ylim(-1.46, 1.44)


def _wall(axes: Axes, run: NDArray[np.float64], scale: float) -> None:
    """Draw the wall over a run of sectors that were seen: a line, filled towards the round shaft by its side of it."""
    azimuth, deviation = run
    for colour, side in (("#e8a06a", np.maximum(deviation, 0.0)), ("#6fa8d6", np.minimum(deviation, 0.0))):
        reach = 1.0 + scale * side
        axes.fill(
            np.concatenate([np.sin(azimuth), (reach * np.sin(azimuth))[::-1]]),
            np.concatenate([np.cos(azimuth), (reach * np.cos(azimuth))[::-1]]),
            color=colour,
            lw=0,
            zorder=2,
        )
    reach = 1.0 + scale * deviation
    axes.plot(reach * np.sin(azimuth), reach * np.cos(azimuth), color=theme.INK, lw=1.1, zorder=3)


def _runs(ring: Ring) -> list[NDArray[np.float64]]:
    """Azimuths (radians) and deviations of neighbouring sectors, (2, n) a run, closed where all were seen."""
    azimuth, deviation = np.radians(ring.azimuth_deg), ring.deviation_m
    seen = np.isfinite(deviation)
    if seen.all():
        whole = np.column_stack([np.r_[azimuth, azimuth[:1] + 2.0 * np.pi], np.r_[deviation, deviation[:1]]])
        return [_dense(whole.T)]
    first = int(np.argmin(seen))
    azimuth = np.r_[azimuth[first:], azimuth[:first] + 2.0 * np.pi]
    deviation, seen = np.roll(deviation, -first), np.roll(seen, -first)
    ends = np.flatnonzero(np.diff(np.r_[0, seen.astype(int), 0]))
    return [_dense(np.array([azimuth[low:high], deviation[low:high]])) for low, high in ends.reshape(-1, 2)]


def _dense(run: NDArray[np.float64]) -> NDArray[np.float64]:
    """Put points between the sectors, so that the line goes round."""
    azimuth = np.linspace(run[0, 0], run[0, -1], max(8 * (run.shape[1] - 1) + 1, 2))
    return np.array([azimuth, np.interp(azimuth, run[0], run[1])])


def _seen(ring: Ring) -> bool:
    return bool(np.isfinite(ring.deviation_m).any())
