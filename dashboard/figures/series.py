"""Quantities over time: points with bands, the limit always in range, no line across an epoch that is missing."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final, TypeAlias

import numpy as np
from plotly.graph_objects import Figure, Scatter

from dashboard import numbers
from dashboard.content.direction import Direction
from dashboard.content.movement import Movement
from dashboard.content.series import SeriesPoint
from dashboard.figures.frame import frame, over_time
from dashboard.figures.words import folded, plain
from dashboard.theme import BLUE, INK, NO_DATA, SOFT, VERMILION
from storage.records import TiltRow

YEAR_S: Final = 365.25 * 86400.0

Opens: TypeAlias = Callable[[str], str]
"""The address that a click on the point of an epoch opens."""


@dataclass(frozen=True, slots=True)
class Marking:
    """Which epoch is shown, what a click on one opens, and how many sigmas bands and bars have."""

    opens: Opens
    shown: str
    k: float = 2.0


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number of an axis with its sigma: how it is called, read and written."""

    title: str
    value: Callable[[TiltRow], tuple[float | None, float | None]]
    scale: float = 1.0
    digits: int = 3


@dataclass(frozen=True, slots=True)
class Trend:
    """A rate along the direction that is drawn, m/a, over the time that it holds for."""

    rate_m_per_year: float
    sigma_m_per_year: float | None
    since: datetime
    until: datetime


DEVIATION: Final = Quantity("deviation, mm", lambda t: (t.deviation_m, t.deviation_sigma_m), 1e3, 1)


def deviation_series(points: Sequence[SeriesPoint], marking: Marking) -> Figure:
    """Draw the deviation at H with its limit, in mm; epochs without an axis are crosses on the ground line."""
    figure = Figure()
    _band(figure, points, DEVIATION, marking.k)
    _limit(figure, points)
    _marks(figure, points, DEVIATION, marking)
    _missing(figure, points)
    figure.update_yaxes(title_text=DEVIATION.title, rangemode="tozero")
    return over_time(frame(figure), [p.time for p in points])


def quantity_series(points: Sequence[SeriesPoint], quantity: Quantity, marking: Marking) -> Figure:
    """Draw any quantity of the axis with its band; where it is NULL there is no point."""
    kept = [
        p if p.tilt is not None and quantity.value(p.tilt)[0] is not None else _without(p) for p in points
    ]
    figure = Figure()
    _band(figure, kept, quantity, marking.k)
    _marks(figure, kept, quantity, marking)
    figure.update_yaxes(title_text=quantity.title)
    return over_time(frame(figure, 240), [p.time for p in points])


def movement_series(
    movements: Sequence[Movement],
    direction: Direction,
    component: int,
    marking: Marking,
    reference: tuple[str, datetime] | None = None,
    trend: Trend | None = None,
) -> Figure:
    """Draw a component of the movement of the top, in mm, with the least movement that would be found shaded."""
    figure = Figure()
    _detectable(figure, movements)
    figure.add_hline(y=0.0, line={"color": SOFT, "width": 1})
    if trend is not None:
        _trend(figure, _with_origin(movements, direction, component, reference), trend)
    _moved(figure, movements, direction, component, marking)
    if reference is not None:
        _origin(figure, *reference)
    figure.update_yaxes(title_text=f"{direction.words[component]}, mm")
    times = [m.time for m in movements] + ([] if reference is None else [reference[1]])
    return over_time(frame(figure), times)


def _moved(
    figure: Figure, movements: Sequence[Movement], direction: Direction, component: int, marking: Marking
) -> None:
    sigmas = [m.sigmas_m(direction) for m in movements]
    errors = [None if s is None else 1e3 * marking.k * s[component] for s in sigmas]
    figure.add_trace(
        Scatter(
            x=[m.time for m in movements],
            y=[1e3 * m.turned(direction)[component] for m in movements],
            error_y={"type": "data", "array": errors, "color": SOFT, "thickness": 1.3, "width": 4},
            mode="markers",
            marker={
                "size": [12 if m.epoch == marking.shown else 9 for m in movements],
                "color": [VERMILION if m.significant else BLUE for m in movements],
                "symbol": ["diamond" if m.significant else "circle" for m in movements],
                "line": {"color": INK, "width": [2 if m.epoch == marking.shown else 0 for m in movements]},
            },
            customdata=[[_moved_told(m), marking.opens(m.epoch)] for m in movements],
            hovertemplate="%{customdata[0]}<extra></extra>",
            showlegend=False,
        )
    )


def _origin(figure: Figure, epoch: str, time: datetime) -> None:
    figure.add_trace(
        Scatter(
            x=[time],
            y=[0.0],
            mode="markers",
            marker={"size": 9, "symbol": "circle-open", "color": INK, "line": {"width": 1.6}},
            text=[f"{plain(epoch)}: changes are counted from here"],
            hovertemplate="%{text}<extra></extra>",
            showlegend=False,
        )
    )


def _with_origin(
    movements: Sequence[Movement],
    direction: Direction,
    component: int,
    reference: tuple[str, datetime] | None,
) -> list[tuple[datetime, float]]:
    """Times and movements, m, the reference with its 0 among them."""
    found = [(m.time, float(m.turned(direction)[component])) for m in movements]
    return found if reference is None else [*found, (reference[1], 0.0)]


def _trend(figure: Figure, points: Sequence[tuple[datetime, float]], trend: Trend) -> None:
    """Draw the rate through the mean of the epochs that it was found from; the catalog holds no intercept."""
    found = [(time.timestamp(), value) for time, value in points if trend.since <= time <= trend.until]
    if not found:
        return
    mean_s = sum(time for time, _value in found) / len(found)
    mean_m = sum(value for _time, value in found) / len(found)
    ends = (trend.since, trend.until)
    u = "" if trend.sigma_m_per_year is None else f" ± {2e3 * trend.sigma_m_per_year:.1f}"
    figure.add_trace(
        Scatter(
            x=list(ends),
            y=[1e3 * (mean_m + trend.rate_m_per_year * (t.timestamp() - mean_s) / YEAR_S) for t in ends],
            mode="lines",
            line={"color": SOFT, "width": 1.4, "dash": "dash"},
            name=f"trend {1e3 * trend.rate_m_per_year:+.1f}{u} mm/a (k=2)",
            hoverinfo="name",
        )
    )


def _band(
    figure: Figure,
    points: Sequence[SeriesPoint],
    quantity: Quantity,
    k: float,
) -> None:
    """Shade value +- k sigma over each run of epochs that have one."""
    scale = quantity.scale
    for run in _runs(points, quantity):
        times = [time for time, _v, _s in run]
        upper = [scale * (v + k * s) for _t, v, s in run]
        lower = [scale * (v - k * s) for _t, v, s in run]
        figure.add_trace(
            Scatter(
                x=[*times, *reversed(times)],
                y=[*upper, *reversed(lower)],
                mode="lines",
                fill="toself",
                fillcolor="rgba(0,114,178,0.14)",
                line={"width": 0},
                hoverinfo="skip",
                showlegend=False,
            )
        )
        figure.add_trace(
            Scatter(
                x=times,
                y=[scale * v for _t, v, _s in run],
                mode="lines",
                line={"color": BLUE, "width": 1.2},
                hoverinfo="skip",
                showlegend=False,
            )
        )


def _runs(points: Sequence[SeriesPoint], quantity: Quantity) -> list[list[tuple[datetime, float, float]]]:
    runs: list[list[tuple[datetime, float, float]]] = [[]]
    for point in points:
        v, s = (None, None) if point.tilt is None else quantity.value(point.tilt)
        if v is None or s is None:
            runs.append([])
        else:
            runs[-1].append((point.time, v, s))
    return [run for run in runs if len(run) > 1]


def _limit(figure: Figure, points: Sequence[SeriesPoint]) -> None:
    allowed = [
        (p.time, 1e3 * p.tilt.allowable_m) for p in points if p.tilt and p.tilt.allowable_m is not None
    ]
    if not allowed:
        return
    figure.add_hline(
        y=allowed[-1][1],
        line={"color": VERMILION, "width": 1.6, "dash": "dash"},
        annotation={
            "text": f"limit {allowed[-1][1]:.1f} mm",
            "font": {"color": VERMILION, "size": 11},
            "bgcolor": "rgba(255,255,255,0.8)",
        },
        annotation_position="top left",
    )
    # a line alone does not widen the range
    figure.add_trace(
        Scatter(
            x=[time for time, _v in allowed],
            y=[1.06 * v for _t, v in allowed],
            mode="markers",
            marker={"opacity": 0},
            hoverinfo="skip",
            showlegend=False,
        )
    )


def _marks(
    figure: Figure,
    points: Sequence[SeriesPoint],
    quantity: Quantity,
    marking: Marking,
) -> None:
    have = [(p, p.tilt) for p in points if p.tilt is not None]
    figure.add_trace(
        Scatter(
            x=[p.time for p, _t in have],
            y=[quantity.scale * (quantity.value(t)[0] or 0.0) for _p, t in have],
            mode="markers",
            marker={
                "size": [11 if p.epoch == marking.shown else 8 for p, _t in have],
                "color": BLUE,
                "symbol": ["x-open" if p.doubtful else "circle" for p, _t in have],
                "line": {
                    "color": INK,
                    "width": [2 if p.epoch == marking.shown or p.doubtful else 0 for p, _t in have],
                },
            },
            customdata=[
                [_told_of(p, _told(t, quantity, marking.k)), marking.opens(p.epoch)] for p, t in have
            ],
            hovertemplate="%{customdata[0]}<extra></extra>",
            showlegend=False,
        )
    )


def _missing(figure: Figure, points: Sequence[SeriesPoint]) -> None:
    """Mark epochs without an axis at the foot of the drawing: they were measured, and say why there is nothing."""
    gone = [p for p in points if p.tilt is None]
    if not gone:
        return
    figure.add_trace(
        Scatter(
            x=[p.time for p in gone],
            y=[0.0 for _p in gone],
            mode="markers",
            marker={"symbol": "x-thin", "size": 9, "line": {"color": SOFT, "width": 2}},
            customdata=[[_told_of(p, "no result")] for p in gone],
            hovertemplate="%{customdata[0]}<extra></extra>",
            name="no result",
        )
    )


def _detectable(figure: Figure, found: Sequence[Movement]) -> None:
    least = [1e3 * m.detectable_m for m in found if m.detectable_m is not None]
    if not least:
        return
    size = float(np.median(least))
    figure.add_hrect(y0=-size, y1=size, fillcolor=NO_DATA, opacity=0.6, line_width=0, layer="below")
    figure.add_annotation(
        xref="paper",
        x=0.0,
        y=-size,
        text=f" a movement below {size:.1f} mm may be missed",
        showarrow=False,
        xanchor="left",
        yanchor="top",
        font={"size": 11, "color": SOFT},
    )


def _without(point: SeriesPoint) -> SeriesPoint:
    return SeriesPoint(point.epoch, point.time, None, point.doubtful, point.reason)


def _told(tilt: TiltRow, quantity: Quantity, k: float) -> str:
    value, sigma = quantity.value(tilt)
    if value is None:
        return numbers.MISSING
    scale, digits = quantity.scale, quantity.digits
    u = numbers.MISSING if sigma is None else numbers.number(scale * k * sigma, digits)
    return f"{quantity.title}: {numbers.number(scale * value, digits)} ± {u} (k={k:g})"


def _told_of(point: SeriesPoint, what: str) -> str:
    text = f"<b>{plain(point.epoch)}</b>, {numbers.day(point.time)}<br>{what}"
    return text if not point.reason else f"{text}<br>{folded(plain(point.reason))}"


def _moved_told(movement: Movement) -> str:
    verdict = {True: "significant", False: "not significant", None: "significance not tested"}
    u = None if movement.sigma_m is None else movement.sigma_m
    return (
        f"<b>{plain(movement.epoch)}</b>, {numbers.day(movement.time)}<br>moved {numbers.mm_with_u(movement.size_m, u)}"
        f"<br>{verdict[movement.significant]}, {numbers.p_value(movement.p_value)}"
        f"<br>covariance: {plain(movement.basis)}"
    )
