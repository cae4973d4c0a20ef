"""The contour of a slice in the plan, its deviations drawn larger."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from plotly.graph_objects import Figure, Scatterpolar

from dashboard import numbers
from dashboard.content.ring import Ring
from dashboard.content.section import Section
from dashboard.figures.azimuth import COMPASS
from dashboard.figures.frame import frame
from dashboard.theme import BLUE, FAINT, INK, PAPER, SOFT, VERMILION

_STEPS_MM: Final = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
_LABELS_DEG: Final = 75.0
_TICK_SHARE: Final = 0.17
"""Circles of equal deviation are so far apart, as a share of the radius, or a little further."""


def contour_figure(section: Section, times: int) -> Figure:
    """Draw the contour of a slice in the plan, north up, its deviations from the circle ``times`` as large as they are.

    The contour is drawn where there are points alone; where there are none the circle is a grey arc.
    """
    figure = Figure()
    _points(figure, section, times)
    _fitted(figure, section, times)
    _contour(figure, section.contour, times)
    _gaps(figure, section.contour)
    _centre(figure, section, times)
    _polar_frame(figure, section, times)
    return figure


def _drawn(radial_m: NDArray[np.float64], section: Section, times: int) -> NDArray[np.float64]:
    """Where a distance from the centre is drawn, metres."""
    radius_m = section.contour.radius_m
    return np.asarray(np.maximum(radius_m + times * (radial_m - radius_m), 0.0))


def _reach_m(section: Section, times: int) -> float:
    """Radius of the drawing: the contour is within it, and a margin."""
    return max(
        1.3 * section.contour.radius_m,
        1.12 * float(np.nanmax(_drawn(section.contour.radial_m, section, times))),
    )


def _points(figure: Figure, section: Section, times: int) -> None:
    drawn = _drawn(section.points.radial_m, section, times)
    inside = drawn < _reach_m(section, times)
    figure.add_trace(
        Scatterpolar(
            r=drawn[inside],
            theta=section.points.azimuth_deg[inside],
            mode="markers",
            marker={"size": 2.6, "color": "#9db4c8", "opacity": 0.65},
            hoverinfo="skip",
            name="points",
        )
    )


def _fitted(figure: Figure, section: Section, times: int) -> None:
    row = section.row
    if row.radius_m is None or section.is_flat:
        return
    azimuth = np.linspace(0.0, 360.0, 361)
    radial_m = np.full(361, row.radius_m)
    if row.ovality_m is not None and row.ovality_azimuth_deg is not None:
        radial_m += row.ovality_m * np.cos(2.0 * np.radians(azimuth - row.ovality_azimuth_deg))
    figure.add_trace(
        Scatterpolar(
            r=_drawn(radial_m, section, times),
            theta=azimuth,
            mode="lines",
            line={"color": INK, "width": 1.2, "dash": "dot"},
            hoverinfo="skip",
            name="fitted circle" if row.ovality_m is None else "fitted oval",
        )
    )


def _contour(figure: Figure, ring: Ring, times: int) -> None:
    # closed over north where both sides of it have points: a sector without any breaks the line
    order = np.append(np.arange(len(ring.radial_m)), 0)
    drawn = np.maximum(ring.radius_m + times * ring.deviation_m, 0.0)[order]
    figure.add_trace(
        Scatterpolar(
            r=drawn,
            theta=ring.azimuth_deg[order],
            mode="lines+markers",
            line={"color": BLUE, "width": 1.8},
            marker={"size": 4, "color": BLUE},
            connectgaps=False,
            customdata=np.column_stack([1e3 * ring.deviation_m, ring.radial_m, ring.n_points])[order],
            hovertemplate="azimuth %{theta:.0f}°<br>%{customdata[0]:+.1f} mm off the circle"
            "<br>radius %{customdata[1]:.4f} m, %{customdata[2]:,} points<extra></extra>",
            name=f"contour, median per {ring.sector_deg:.0f}°",
        )
    )


def _gaps(figure: Figure, ring: Ring) -> None:
    theta: list[float | None] = []
    for gap in ring.gaps:
        theta += [*np.linspace(gap.from_deg, gap.to_deg, max(2, int(gap.width_deg) + 1)).tolist(), None]
    if theta:
        figure.add_trace(
            Scatterpolar(
                r=[None if angle is None else ring.radius_m for angle in theta],
                theta=theta,
                mode="lines",
                line={"color": "#aab3bd", "width": 7},
                hoverinfo="skip",
                name="no points",
            )
        )


def _centre(figure: Figure, section: Section, times: int) -> None:
    figure.add_trace(
        Scatterpolar(
            r=[0.0],
            theta=[0.0],
            mode="markers",
            marker={"symbol": "cross-thin", "size": 13, "line": {"color": INK, "width": 1.6}},
            hovertemplate=f"{'centre' if section.has_centre else 'axis; the slice has no centre'}<br>"
            f"east {section.centre_m[0]:.4f} m, north {section.centre_m[1]:.4f} m<extra></extra>",
            name="centre" if section.has_centre else "axis (no centre)",
        )
    )
    if section.axis_m is None or not section.has_centre:
        return
    off_m, azimuth = np.hypot(*section.axis_m), np.degrees(np.arctan2(*section.axis_m)) % 360.0
    figure.add_trace(
        Scatterpolar(
            r=[min(times * off_m, 0.9 * section.contour.radius_m)],
            theta=[azimuth],
            mode="markers",
            marker={"symbol": "diamond-open", "size": 9, "color": VERMILION, "line": {"width": 1.6}},
            hovertemplate=f"axis, {numbers.mm(float(off_m))} from the centre towards {azimuth:.0f}°<extra></extra>",
            name="axis",
        )
    )


def _polar_frame(figure: Figure, section: Section, times: int) -> None:
    radius_m = section.contour.radius_m
    reach_m = _reach_m(section, times)
    offs_mm = _tick_offs_mm(radius_m, times, reach_m)
    frame(figure, 460)
    figure.update_layout(
        margin={"l": 28, "r": 28, "t": 46, "b": 30},
        legend={"y": -0.1, "yanchor": "top", "x": 0.5, "xanchor": "center"},
        polar={
            "bgcolor": PAPER,
            "angularaxis": {
                "direction": "clockwise",
                "rotation": 90,
                "tickvals": list(range(0, 360, 30)),
                "ticktext": [f"<b>{COMPASS[t]}</b>" if t in COMPASS else f"{t}°" for t in range(0, 360, 30)],
                "gridcolor": "#f1f3f5",
                "linecolor": FAINT,
                "tickfont": {"size": 11, "color": SOFT},
            },
            "radialaxis": {
                "range": [0.0, reach_m],
                "tickvals": [radius_m + times * 1e-3 * off for off in offs_mm],
                "showticklabels": False,
                "gridcolor": "#e4e8ec",
                "showline": False,
                "ticks": "",
            },
        },
    )
    _ring_labels(figure, section, times, offs_mm)
    _scale_label(figure, radius_m, times)


def _scale_label(figure: Figure, radius_m: float, times: int) -> None:
    """Write how many times larger deviations are drawn."""
    scale = f"<b>radial ×{times}</b>" if times > 1 else "<b>true to scale</b>"
    figure.add_annotation(
        text=f"{scale}  <span style='color:{SOFT};font-size:11px'>about r = {radius_m:.4f} m</span>",
        x=0.0,
        y=1.0,
        xref="paper",
        yref="paper",
        xanchor="left",
        yanchor="bottom",
        yshift=16,
        showarrow=False,
        font={"size": 13, "color": VERMILION},
    )


def _tick_offs_mm(radius_m: float, times: int, reach_m: float) -> list[float]:
    """Deviations at which circles are drawn, mm."""
    wanted_mm = 1e3 * _TICK_SHARE * radius_m / times
    step = next((step for step in _STEPS_MM if step >= wanted_mm), _STEPS_MM[-1])
    outer = int((reach_m - radius_m) / (1e-3 * step * times))
    return [step * n for n in range(-min(outer, 2), outer + 1)]


def _ring_labels(figure: Figure, section: Section, times: int, offs_mm: Sequence[float]) -> None:
    """Write beside the circles of equal deviation which they are."""
    named = [off for off in offs_mm if off]
    figure.add_trace(
        Scatterpolar(
            r=_drawn(section.contour.radius_m + 1e-3 * np.array(named), section, times),
            theta=[_LABELS_DEG] * len(named),
            mode="text",
            text=[numbers.signed_mm(1e-3 * off, 1 if off % 1.0 else 0) for off in named],
            textfont={"size": 10, "color": SOFT},
            hoverinfo="skip",
            showlegend=False,
        )
    )
