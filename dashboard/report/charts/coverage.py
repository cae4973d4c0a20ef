"""Which parts of the shaft were seen, by height and azimuth, and how densely."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from dashboard import theme
from dashboard.report.charts.style import draw
from dashboard.report.words import Words
from storage.records import CoverageRow

SIZE_MM: Final = (178.0, 58.0)


def chart(rows: Sequence[CoverageRow], words: Words) -> str:
    """Draw the shaft unrolled; pieces without a point are hatched."""
    heights = sorted({row.z_low_m for row in rows} | {row.z_high_m for row in rows})
    sectors = sorted({row.azimuth_low_deg for row in rows} | {row.azimuth_high_deg for row in rows})
    grid = np.full((len(heights) - 1, len(sectors) - 1), np.nan)
    for row in rows:
        grid[heights.index(row.z_low_m), sectors.index(row.azimuth_low_deg)] = row.n_points or np.nan

    def plot(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.grid(visible=False)
        axes.set_facecolor(theme.NO_DATA)
        axes.patch.set_hatch("////")
        axes.patch.set_edgecolor("#b4bcc5")
        if np.isfinite(grid).any():
            high = max(float(np.nanmax(grid)), 10.0)
            mesh = axes.pcolormesh(
                sectors,
                heights,
                np.ma.masked_invalid(grid),
                cmap="Blues",
                vmin=0.0,
                vmax=high,
                edgecolors="face",
                linewidth=0.15,
            )
            bar = figure.colorbar(mesh, ax=axes, pad=0.01, fraction=0.03)
            bar.set_label(words("chart.points_per_piece"))
            bar.outline.set_linewidth(0.4)
        axes.set_xlim(0, 360)
        axes.set_ylim(heights[0], heights[-1])
        axes.set_xticks(
            range(0, 361, 45),
            [words(f"chart.{point}") for point in ("n", "ne", "e", "se", "s", "sw", "w", "nw", "n")],
        )
        axes.set_xlabel(words("chart.azimuth"))
        axes.set_ylabel(words("chart.height_m"))

    return draw("coverage", SIZE_MM, plot)
