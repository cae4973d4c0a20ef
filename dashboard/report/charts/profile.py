"""The axis from foot to top along and across the lean, and what is left of the centres beside a straight line."""

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from dashboard import numbers, theme
from dashboard.content.profile import Profile
from dashboard.report.charts.style import draw
from dashboard.report.words import Words

SIZE_MM: Final = (178.0, 92.0)


def chart(profile: Profile, words: Words) -> str:
    """Draw four panels that share the height: both positions, both residuals."""

    def plot(figure: Figure) -> None:
        panels = figure.subplots(1, 4, sharey=True, width_ratios=(1.25, 1.0, 1.0, 1.0))
        sides = ("along", "across") if profile.direction.is_lean else ("north", "east")
        for side in (0, 1):
            azimuth = (profile.direction.azimuth_deg + 90.0 * side) % 360.0
            title = words(f"chart.{sides[side]}", azimuth=f"{azimuth:.0f}")
            _position(panels[side], profile, side)
            panels[side].set_title(title, loc="left")
            panels[side].set_xlabel(words("chart.from_plumb_mm"))
            _residual(panels[2 + side], profile, side)
            panels[2 + side].set_title(
                words("chart.residual_of", side=words(f"chart.{sides[side]}_short")), loc="left"
            )
            panels[2 + side].set_xlabel(words("chart.from_line_mm"))
        panels[0].set_ylabel(words("chart.height_m"))
        panels[0].set_ylim(0.0, 1.03 * float(profile.line_z_m[-1]))

    return draw("profile", SIZE_MM, plot)


def _position(axes: Axes, profile: Profile, side: int) -> None:
    _ticks(axes)
    axes.axvline(0.0, color=theme.SOFT, lw=0.8, ls=(0, (5, 2, 1, 2)))
    axes.plot(1e3 * profile.line_m[:, side], profile.line_z_m, color=theme.BLUE, lw=1.0, zorder=2)
    axes.plot(1e3 * profile.centres_m[:, side], profile.z_m, "o", ms=2.4, color=theme.INK, zorder=3)
    low, high = axes.get_xlim()
    if high - low < 4.0:
        middle = (low + high) / 2.0
        axes.set_xlim(middle - 2.0, middle + 2.0)


def _residual(axes: Axes, profile: Profile, side: int) -> None:
    """Signed distances from the straight axis: an absolute one would hide a bow."""
    axes.axvline(0.0, color=theme.BLUE, lw=1.0)
    told = np.isfinite(profile.residuals_m[:, side])
    if not told.any():
        axes.set_xticks([])
        axes.text(0.5, 0.5, numbers.MISSING, transform=axes.transAxes, ha="center", color=theme.SOFT)
        return
    _ticks(axes)
    values, heights = 1e3 * profile.residuals_m[told, side], profile.z_m[told]
    bars = 2e3 * np.nan_to_num(profile.sigmas_m[told, side])
    axes.errorbar(
        values, heights, xerr=bars, fmt="o", ms=2.4, color=theme.INK, elinewidth=0.7, capsize=0, zorder=3
    )
    if profile.curve_m is not None:
        bend = 1e3 * (profile.curve_m[:, side] - profile.line_m[:, side])
        axes.plot(bend, profile.line_z_m, color=theme.VERMILION, lw=1.1, zorder=2)
    reach = 1.15 * max(float(np.abs(np.concatenate([values - bars, values + bars])).max()), 0.5)
    axes.set_xlim(-reach, reach)


def _ticks(axes: Axes) -> None:
    """Few ticks, none at the ends: panels stand close."""
    axes.xaxis.set_major_locator(MaxNLocator(4, prune="both", steps=[1, 2, 5, 10]))
