"""A slice beside its contour: deviations by sector, the waves that it is made of, and where it is among all."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from plotly.graph_objects import Bar, Figure, Scatter

from dashboard import numbers
from dashboard.content.harmonics import ORDERS, Harmonic
from dashboard.content.ring import Ring
from dashboard.figures.azimuth import compass_axis
from dashboard.figures.frame import frame
from dashboard.figures.words import plain
from dashboard.theme import BLUE, DIVERGING, FAINT, NO_DATA, SOFT, VERMILION
from storage.records import SliceRow

INWARD: Final = DIVERGING[0][1]
OUTWARD: Final = DIVERGING[-1][1]


def rose_figure(rose: Ring) -> Figure:
    """Draw what each sector of 10 degrees is off the circle, in mm; grey where there are no points."""
    seen = rose.seen
    figure = Figure(
        Bar(
            x=rose.azimuth_deg[seen],
            y=1e3 * rose.deviation_m[seen],
            width=0.86 * rose.sector_deg,
            marker={"color": np.where(rose.deviation_m[seen] < 0.0, INWARD, OUTWARD), "line": {"width": 0}},
            error_y={
                "type": "data",
                "array": 1e3 * numbers.COVERAGE * rose.sigma_m[seen],
                "color": SOFT,
                "thickness": 1,
                "width": 2,
            },
            customdata=np.column_stack([rose.azimuth_deg[seen] - rose.sector_deg / 2, rose.n_points[seen]]),
            hovertemplate="%{customdata[0]:.0f}° to +" + f"{rose.sector_deg:.0f}°"
            "<br>%{y:+.1f} mm, %{customdata[1]:,} points<extra></extra>",
            showlegend=False,
        )
    )
    for gap in rose.gaps:
        for low, high in _within_circle(gap.from_deg, gap.to_deg):
            figure.add_vrect(x0=low, x1=high, fillcolor=NO_DATA, line_width=0, layer="below")
    figure.add_hline(y=0.0, line={"color": SOFT, "width": 1})
    frame(figure, 250)
    compass_axis(figure)
    figure.update_yaxes(title_text="deviation, mm", tickformat="+.0f" if _spans_mm(rose, 4.0) else "+.1f")
    return figure


def harmonics_figure(harmonics: Sequence[Harmonic]) -> Figure:
    """Draw the amplitudes of waves 2 to 6 with k = 2, in mm; ``--`` where gaps do not let one be told."""
    told = [(h.order, h.amplitude_m, h.sigma_m, h.azimuth_deg) for h in harmonics]
    known = [(n, m, s, a) for n, m, s, a in told if m is not None and s is not None and a is not None]
    figure = Figure(
        Bar(
            x=[n for n, _m, _s, _a in known],
            y=[1e3 * m for _n, m, _s, _a in known],
            width=0.55,
            marker={"color": [BLUE if m > numbers.COVERAGE * s else FAINT for _n, m, s, _a in known]},
            error_y={
                "type": "data",
                "symmetric": False,
                "array": [1e3 * numbers.COVERAGE * s for _n, _m, s, _a in known],
                # an amplitude is not below 0
                "arrayminus": [1e3 * min(numbers.COVERAGE * s, m) for _n, m, s, _a in known],
                "color": SOFT,
                "thickness": 1,
                "width": 4,
            },
            customdata=[f"{numbers.mm_with_u(m, s)}, largest at {a:.0f}°" for _n, m, s, a in known],
            hovertemplate="n = %{x}: %{customdata}<extra></extra>",
            showlegend=False,
        )
    )
    for n, m, _s, _a in told:
        if m is None:
            figure.add_annotation(
                x=n, y=0, yshift=9, text=numbers.MISSING, showarrow=False, font={"color": SOFT}
            )
    frame(figure, 250)
    figure.update_xaxes(
        title_text="waves around the circumference (2: oval)",
        tickvals=list(ORDERS),
        ticktext=[f"n = {n}" for n in ORDERS],
        range=[ORDERS[0] - 0.6, ORDERS[-1] + 0.6],
    )
    figure.update_yaxes(title_text="amplitude, mm", rangemode="tozero")
    return figure


def heights_figure(slices: Sequence[SliceRow], shown: int, opens: Callable[[int], str]) -> Figure:
    """Draw how far points are off the fitted contour of every slice, over its height; a click opens it.

    A slice that failed is a cross on the axis.
    """
    figure = Figure([_fitted(slices, shown, opens), _failed(slices, shown, opens)])
    frame(figure, 460)
    figure.update_xaxes(title_text="RMS off the contour, mm", rangemode="tozero")
    figure.update_yaxes(title_text="height z, m")
    return figure


def _fitted(slices: Sequence[SliceRow], shown: int, opens: Callable[[int], str]) -> Scatter:
    rows = [(row, 1e3 * row.rmse_m) for row in slices if row.rmse_m is not None]
    return Scatter(
        x=[rmse_mm for _row, rmse_mm in rows],
        y=[row.z_m for row, _rmse in rows],
        mode="markers",
        marker={
            "size": [11 if row.slice_index == shown else 6 for row, _rmse in rows],
            "color": [VERMILION if row.slice_index == shown else BLUE for row, _rmse in rows],
            "line": {"width": 0},
            "opacity": 1.0,
        },
        customdata=[[f"slice {row.slice_index}", opens(row.slice_index)] for row, _rmse in rows],
        hovertemplate="%{customdata[0]}, z %{y:.2f} m: %{x:.2f} mm<extra></extra>",
        showlegend=False,
    )


def _failed(slices: Sequence[SliceRow], shown: int, opens: Callable[[int], str]) -> Scatter:
    rows = [row for row in slices if row.rmse_m is None]
    told = [f"slice {row.slice_index} failed: {plain(row.reason or numbers.MISSING)}" for row in rows]
    return Scatter(
        x=[0.0] * len(rows),
        y=[row.z_m for row in rows],
        mode="markers",
        marker={
            "symbol": "x-thin",
            "size": 8,
            "line": {
                "width": [3 if row.slice_index == shown else 1.4 for row in rows],
                "color": [VERMILION if row.slice_index == shown else SOFT for row in rows],
            },
        },
        cliponaxis=False,
        customdata=[[text, opens(row.slice_index)] for text, row in zip(told, rows, strict=True)],
        hovertemplate="z %{y:.2f} m, %{customdata[0]}<extra></extra>",
        showlegend=False,
    )


def _within_circle(low_deg: float, high_deg: float) -> list[tuple[float, float]]:
    """An arc in one piece, or in two where it goes over north."""
    return [(low_deg, high_deg)] if high_deg <= 360.0 else [(low_deg, 360.0), (0.0, high_deg - 360.0)]


def _spans_mm(ring: Ring, least_mm: float) -> bool:
    return bool(ring.seen.any()) and 1e3 * float(np.nanmax(np.abs(ring.deviation_m))) >= least_mm
