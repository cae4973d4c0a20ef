"""The stations in the plan, with lines to the structure in the colour of how well their scans fit; north is up."""

import math
from collections.abc import Sequence
from typing import Final

from plotly.colors import sample_colorscale
from plotly.graph_objects import Figure, Scatter

from dashboard import numbers
from dashboard.content.stations import EastNorth, Pin, StationMap
from dashboard.figures.frame import frame, north_arrow, square
from dashboard.figures.words import folded, plain
from dashboard.theme import FAINT, GREEN, INK, NO_DATA, SOFT, VERMILION

FIT: Final = [[0.0, "#8fc1e3"], [0.5, "#2b7bba"], [1.0, "#08306b"]]
"""Darker is worse."""


def station_plan(shown: StationMap, height_px: int = 420) -> Figure:
    """Draw the map; suspect and failed stations are crosses, a short bar is the direction that is known least."""
    figure = Figure()
    ends = _ends(shown.pins)
    if shown.foot_m is not None:
        for pin in shown.pins:
            _sight(figure, pin, shown.foot_m, ends)
        _structure(figure, shown, shown.foot_m)
        _next(figure, shown, shown.foot_m)
    _weak(figure, shown)
    _pins(figure, shown, ends)
    figure.update_xaxes(title_text="east, m", zeroline=False, range=_east_range(shown))
    figure.update_yaxes(title_text="north, m", zeroline=False)
    return square(north_arrow(frame(figure, height_px)))


def _ends(pins: Sequence[Pin]) -> tuple[float, float]:
    known = [1e3 * pin.rmse_m for pin in pins if pin.rmse_m is not None]
    if not known:
        return 0.0, 1.0
    low, high = min(known), max(known)
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _east_range(shown: StationMap) -> list[float]:
    """From the westernmost to the easternmost, with room for names."""
    east = [pin.east_m for pin in shown.pins] + ([] if shown.foot_m is None else [shown.foot_m[0]])
    room = 0.25 * max(max(east) - min(east), 1.0)
    return [min(east) - room, max(east) + room]


def _colour(pin: Pin, ends: tuple[float, float]) -> str:
    if pin.rmse_m is None:
        return SOFT
    share = (1e3 * pin.rmse_m - ends[0]) / (ends[1] - ends[0])
    return str(sample_colorscale(FIT, [min(max(share, 0.0), 1.0)])[0])


def _sight(figure: Figure, pin: Pin, foot: EastNorth, ends: tuple[float, float]) -> None:
    figure.add_trace(
        Scatter(
            x=[foot[0], pin.east_m],
            y=[foot[1], pin.north_m],
            mode="lines",
            line={"color": _colour(pin, ends), "width": 2, "dash": "solid" if pin.state == "ok" else "dot"},
            hoverinfo="skip",
            showlegend=False,
        )
    )


def _structure(figure: Figure, shown: StationMap, foot: EastNorth) -> None:
    if shown.radius_m is not None:
        radius = shown.radius_m
        figure.add_shape(
            type="circle",
            x0=foot[0] - radius,
            x1=foot[0] + radius,
            y0=foot[1] - radius,
            y1=foot[1] + radius,
            fillcolor=NO_DATA,
            line={"color": INK, "width": 1.4},
        )
    figure.add_trace(
        Scatter(
            x=[foot[0]],
            y=[foot[1]],
            mode="markers",
            marker={"symbol": "circle", "size": 9, "color": INK},
            hovertemplate="foot of the axis<extra></extra>",
            showlegend=False,
        )
    )


def _next(figure: Figure, shown: StationMap, foot: EastNorth) -> None:
    if shown.next_deg is None or shown.reach_m == 0.0:
        return
    east, north = math.sin(math.radians(shown.next_deg)), math.cos(math.radians(shown.next_deg))
    figure.add_trace(
        Scatter(
            x=[foot[0] + 0.85 * shown.reach_m * east],
            y=[foot[1] + 0.85 * shown.reach_m * north],
            mode="markers",
            name=f"one more would help most at {shown.next_deg:.0f}°",
            marker={"symbol": "circle-cross-open", "size": 13, "color": GREEN, "line": {"width": 1.8}},
            hoverinfo="name",
        )
    )


def _weak(figure: Figure, shown: StationMap) -> None:
    half = 0.06 * max(shown.reach_m, 1.0)
    pins = [(pin, pin.weak) for pin in shown.pins if pin.weak is not None]
    if not pins:
        return
    figure.add_trace(
        Scatter(
            x=[x for pin, w in pins for x in (pin.east_m - half * w[0], pin.east_m + half * w[0], None)],
            y=[y for pin, w in pins for y in (pin.north_m - half * w[1], pin.north_m + half * w[1], None)],
            mode="lines",
            name="direction known least",
            line={"color": FAINT, "width": 5},
            hoverinfo="skip",
        )
    )


def _pins(figure: Figure, shown: StationMap, ends: tuple[float, float]) -> None:
    pins = shown.pins
    middle = shown.foot_m or (0.0, 0.0)
    figure.add_trace(
        Scatter(
            x=[pin.east_m for pin in pins],
            y=[pin.north_m for pin in pins],
            mode="markers+text",
            text=[plain(pin.station if len(pin.station) <= 14 else f"{pin.station[:13]}…") for pin in pins],
            textposition=["middle right" if pin.east_m >= middle[0] else "middle left" for pin in pins],
            textfont={"size": 11, "color": INK},
            cliponaxis=False,
            marker={
                "symbol": ["circle" if pin.state == "ok" else "x" for pin in pins],
                "size": 11,
                "color": [ends[0] if pin.rmse_m is None else 1e3 * pin.rmse_m for pin in pins],
                "cmin": ends[0],
                "cmax": ends[1],
                "colorscale": FIT,
                "line": {
                    "color": ["#ffffff" if pin.state == "ok" else VERMILION for pin in pins],
                    "width": 1.5,
                },
                "showscale": any(pin.rmse_m is not None for pin in pins),
                "colorbar": {"title": {"text": "RMS, mm", "font": {"size": 11}}, "thickness": 10, "len": 0.6},
            },
            customdata=[[_told(pin)] for pin in pins],
            hovertemplate="%{customdata[0]}<extra></extra>",
            showlegend=False,
        )
    )


def _told(pin: Pin) -> str:
    lines = [f"<b>{plain(pin.station)}</b>, {plain(pin.state)}", f"RMS {numbers.mm(pin.rmse_m)}"]
    if pin.distance_m is not None:
        lines.append(f"{pin.distance_m:.1f} m from the axis at {numbers.degrees(pin.azimuth_deg, 0)}")
    if pin.reason:
        lines.append(folded(plain(pin.reason)))
    return "<br>".join(lines)
