"""The shaft unrolled: how densely it was seen, or from how many stations; what nobody saw is grey."""

from typing import Any

import numpy as np
from plotly.graph_objects import Figure, Heatmap

from dashboard.content.coverage import CoverageGrid
from dashboard.figures.frame import frame
from dashboard.figures.words import plain
from dashboard.theme import NO_DATA

BLUES = [[0.0, "#dcebf7"], [0.5, "#4f9bcb"], [1.0, "#08306b"]]
COMPASS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW", "N")


def coverage_strip(grid: CoverageGrid, by_stations: bool = False) -> Figure:
    """Draw the grid, in colour by points (logarithmic) or by the stations that saw a piece."""
    seen = np.where(grid.points > 0, grid.points, np.nan)
    values = np.where(grid.points > 0, grid.stations, np.nan) if by_stations else np.log10(seen)
    figure = Figure(
        Heatmap(
            x=grid.azimuths_deg,
            y=grid.heights_m,
            z=_listed(values),
            text=_told(grid),
            hovertemplate="%{text}<extra></extra>",
            colorscale=BLUES,
            xgap=0.5,
            ygap=0.5,
            hoverongaps=False,
            colorbar=_bar(values, by_stations),
        )
    )
    frame(figure, 420)
    # the ground shows where there is no point
    figure.update_layout(plot_bgcolor=NO_DATA)
    ticks = list(range(0, 361, 45))
    figure.update_xaxes(
        title_text="azimuth, clockwise from grid north",
        range=[0, 360],
        showgrid=False,
        tickvals=ticks,
        ticktext=[f"{name}<br>{tick}°" for tick, name in zip(ticks, COMPASS, strict=True)],
    )
    figure.update_yaxes(
        title_text="height, m", range=[grid.heights_m[0], grid.heights_m[-1]], showgrid=False, zeroline=False
    )
    return figure


def _bar(values: np.ndarray[Any, Any], by_stations: bool) -> dict[str, Any]:
    title = "stations" if by_stations else "points"
    bar: dict[str, Any] = {"title": {"text": title, "font": {"size": 11}}, "thickness": 10}
    known = values[np.isfinite(values)]
    if known.size and not by_stations:
        steps = np.unique(np.round(np.linspace(known.min(), known.max(), 5), 1))
        bar |= {"tickvals": steps.tolist(), "ticktext": [f"{_rounded(10.0**step):,.0f}" for step in steps]}
    elif known.size:
        bar |= {"dtick": 1}
    return bar


def _rounded(value: float) -> float:
    """Two figures are enough beside a colour."""
    unit = 10.0 ** max(np.floor(np.log10(value)) - 1.0, 0.0)
    return float(round(value / unit) * unit)


def _listed(values: np.ndarray[Any, Any]) -> list[list[float | None]]:
    return [[None if np.isnan(v) else float(v) for v in row] for row in values]


def _told(grid: CoverageGrid) -> list[list[str]]:
    return [
        [
            f"{grid.heights_m[i]:.1f} to {grid.heights_m[i + 1]:.1f} m, "
            f"{grid.azimuths_deg[j]:.0f} to {grid.azimuths_deg[j + 1]:.0f}°<br>"
            + (
                f"{grid.points[i, j]:.0f} points from {grid.stations[i, j]:.0f} stations, "
                f"most from {plain(str(grid.first[i, j]))}"
                if grid.points[i, j] > 0
                else "no point"
            )
            for j in range(grid.points.shape[1])
        ]
        for i in range(grid.points.shape[0])
    ]
