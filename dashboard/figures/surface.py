"""The skin of a shaft, unrolled: azimuth across, height up, deviation as colour about 0."""

from collections.abc import Callable, Sequence
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from plotly.graph_objects import Figure, Heatmap, Scatter

from dashboard import numbers
from dashboard.content.surface import SkinChange, SkinGrid, SkinMap, StationMark
from dashboard.figures.azimuth import compass_axis
from dashboard.figures.frame import frame
from dashboard.figures.words import plain
from dashboard.theme import DIVERGING, SOFT

UNSEEN: Final = "#c6ccd3"
"""Where there are no points: darker than any piece that is near 0."""

PALE: Final = "rgba(250,250,250,0.78)"
"""Over a piece that is within its level of detection."""

LONGEST_NAME: Final = 10

Opens: TypeAlias = Callable[[float], str]
"""The address that a click on a piece at a height opens."""


def map_figure(skin: SkinMap, range_mm: float, stations: Sequence[StationMark], opens: Opens) -> Figure:
    """Draw what every piece is off a straight shaft, in mm, with the same colours for every epoch."""
    told = [
        [
            f"{numbers.signed_mm(_or_none(skin.deviation_m[b, s]))}"
            f" ± {numbers.mm(_or_none(numbers.COVERAGE * skin.sigma_m[b, s]))} (k=2)"
            f"<br>{skin.n_points[b, s]:,} points, mean radius of the band {skin.radius_m[b]:.3f} m"
            if skin.n_points[b, s]
            else "-- no points"
            for s in range(len(skin.grid.azimuth_deg))
        ]
        for b in range(len(skin.grid.z_m))
    ]
    figure = Figure(_heat(skin.grid, 1e3 * skin.deviation_m, range_mm, told, opens))
    return _skin_frame(figure, skin.grid, stations)


def change_figure(
    change: SkinChange, range_mm: float, stations: Sequence[StationMark], opens: Opens
) -> Figure:
    """Draw what every piece moved since the reference epoch, in mm; within its level of detection it is pale."""
    told = [
        [
            f"{numbers.signed_mm(_or_none(change.change_m[b, s]))},"
            f" level of detection {numbers.mm(_or_none(change.lod_m[b, s]))}"
            f"<br>{'beyond it' if change.significant[b, s] else 'within it: no change can be told'}"
            if np.isfinite(change.change_m[b, s])
            else "-- not seen in both epochs"
            for s in range(len(change.grid.azimuth_deg))
        ]
        for b in range(len(change.grid.z_m))
    ]
    figure = Figure(_heat(change.grid, 1e3 * change.change_m, range_mm, told, opens))
    within = np.where(np.isfinite(change.change_m) & ~change.significant, 1.0, np.nan)
    figure.add_trace(
        Heatmap(
            x=change.grid.azimuth_edges_deg,
            y=change.grid.z_edges_m,
            z=within,
            colorscale=[[0.0, PALE], [1.0, PALE]],
            showscale=False,
            hoverinfo="skip",
        )
    )
    return _skin_frame(figure, change.grid, stations)


def _heat(
    grid: SkinGrid,
    values_mm: NDArray[np.float64],
    range_mm: float,
    told: list[list[str]],
    opens: Opens,
) -> Heatmap:
    return Heatmap(
        x=grid.azimuth_edges_deg,
        y=grid.z_edges_m,
        z=values_mm,
        zmin=-range_mm,
        zmax=range_mm,
        zmid=0.0,
        colorscale=[list(stop) for stop in DIVERGING],
        hoverongaps=True,
        # a list in each piece would not reach the page that a click opens
        customdata=[[opens(float(z_m))] * len(grid.azimuth_deg) for z_m in grid.z_m],
        text=told,
        hovertemplate="%{x:.0f}°, %{y:.1f} m<br>%{text}<extra></extra>",
        colorbar={
            "title": {"text": "mm", "font": {"size": 11, "color": SOFT}},
            "thickness": 12,
            "outlinewidth": 0,
            "len": 0.9,
            "tickfont": {"size": 11, "color": SOFT},
            "tickvals": [-range_mm, -range_mm / 2, 0.0, range_mm / 2, range_mm],
            "ticktext": [
                f"≤ {numbers.number(-range_mm, 0)}",
                numbers.number(-range_mm / 2, 1 if range_mm % 2 else 0),
                "0",
                f"+{numbers.number(range_mm / 2, 1 if range_mm % 2 else 0)}",
                f"≥ +{numbers.number(range_mm, 0)}",
            ],
        },
    )


def _skin_frame(figure: Figure, grid: SkinGrid, stations: Sequence[StationMark]) -> Figure:
    low, high = float(grid.z_edges_m[0]), float(grid.z_edges_m[-1])
    above = high + 0.035 * (high - low)
    if stations:
        figure.add_trace(
            Scatter(
                x=[mark.azimuth_deg for mark in stations],
                y=[above] * len(stations),
                mode="markers+text",
                marker={"symbol": "triangle-down", "size": 9, "color": SOFT},
                text=[_short(mark.station) for mark in stations],
                textposition="top center",
                textfont={"size": 10, "color": SOFT},
                cliponaxis=False,
                customdata=[f"{plain(mark.station)}, {mark.distance_m:.0f} m away" for mark in stations],
                hovertemplate="%{customdata}, at %{x:.0f}°<extra></extra>",
                showlegend=False,
            )
        )
    frame(figure, 520)
    compass_axis(figure)
    figure.update_layout(plot_bgcolor=UNSEEN)
    figure.update_xaxes(showgrid=False, zeroline=False)
    figure.update_yaxes(
        title_text="height z, m", showgrid=False, zeroline=False, range=[low, high + 0.085 * (high - low)]
    )
    # the strip with the stations is none of the shaft
    figure.add_hrect(y0=high, y1=high + 0.2 * (high - low), fillcolor="#ffffff", line_width=0, layer="below")
    return figure


def _or_none(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _short(name: str) -> str:
    return plain(name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…")
