"""The top of the axis seen from above: its way over the epochs with 95 % ellipses, limit circle, and north."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from plotly.graph_objects import Figure, Scatter

from dashboard import numbers
from dashboard.content.movement import Movement
from dashboard.content.plan import ELLIPSE_95, Top, ellipse
from dashboard.figures.frame import frame, north_arrow, square
from dashboard.figures.series import Marking
from dashboard.figures.words import plain
from dashboard.theme import INK, SOFT, VERMILION

_RGB = "0,114,178"


def plan_of_tops(tops: Sequence[Top], marking: Marking, height_px: int = 360) -> Figure:
    """Draw where the top is against the plumb line through the foot, mm; older epochs are paler."""
    figure = Figure()
    _limit_circle(figure, tops)
    _plumb(figure)
    if tops:
        where = np.array([1e3 * top.east_north_m for top in tops])
        figure.add_trace(
            Scatter(
                x=[0.0, float(where[-1, 0])],
                y=[0.0, float(where[-1, 1])],
                mode="lines",
                line={"color": SOFT, "width": 1, "dash": "dot"},
                hoverinfo="skip",
                showlegend=False,
            )
        )
    _track(figure, tops, marking)
    figure.update_xaxes(title_text="east of the foot, mm")
    figure.update_yaxes(title_text="north of the foot, mm")
    return square(north_arrow(frame(figure, height_px)))


def plan_of_movements(
    movements: Mapping[str, Movement], reference: str, marking: Marking, height_px: int = 360
) -> Figure:
    """Draw how the top moved since the reference, mm, each with its 95 % ellipse; significant ones are diamonds."""
    figure = Figure()
    found = list(movements.values())
    ages = _ages(len(found))
    for movement, alpha in zip(found, ages, strict=True):
        if movement.covariance_m2 is not None:
            _ellipse(figure, 1e3 * movement.east_north_m, 1e6 * movement.covariance_m2, alpha)
    _origin(figure, reference)
    figure.add_trace(
        Scatter(
            x=[1e3 * m.east_north_m[0] for m in found],
            y=[1e3 * m.east_north_m[1] for m in found],
            mode="markers",
            marker={
                "size": [11 if m.epoch == marking.shown else 8 for m in found],
                "symbol": ["diamond" if m.significant else "circle" for m in found],
                "color": [
                    VERMILION if m.significant else f"rgba({_RGB},{alpha:.2f})"
                    for m, alpha in zip(found, ages, strict=True)
                ],
                "line": {"color": INK, "width": [2 if m.epoch == marking.shown else 0 for m in found]},
            },
            customdata=[[_told(m), marking.opens(m.epoch)] for m in found],
            hovertemplate="%{customdata[0]}<extra></extra>",
            showlegend=False,
        )
    )
    figure.update_xaxes(title_text="moved east, mm")
    figure.update_yaxes(title_text="moved north, mm")
    return square(north_arrow(frame(figure, height_px)))


def _origin(figure: Figure, reference: str) -> None:
    figure.add_trace(
        Scatter(
            x=[0.0],
            y=[0.0],
            mode="markers+text",
            text=[plain(reference)],
            textposition="bottom center",
            textfont={"size": 11, "color": SOFT},
            marker={"symbol": "circle-open", "size": 10, "color": INK, "line": {"width": 1.6}},
            hoverinfo="skip",
            showlegend=False,
        )
    )


def _track(figure: Figure, tops: Sequence[Top], marking: Marking) -> None:
    ages = _ages(len(tops))
    for top, alpha in zip(tops, ages, strict=True):
        if top.covariance_m2 is not None:
            _ellipse(figure, 1e3 * top.east_north_m, 1e6 * top.covariance_m2, alpha)
    figure.add_trace(
        Scatter(
            x=[1e3 * top.east_north_m[0] for top in tops],
            y=[1e3 * top.east_north_m[1] for top in tops],
            mode="markers",
            marker={
                "size": [11 if top.epoch == marking.shown else 7 for top in tops],
                "color": [f"rgba({_RGB},{alpha:.2f})" for alpha in ages],
                "line": {"color": INK, "width": [2 if top.epoch == marking.shown else 0 for top in tops]},
            },
            customdata=[[_top_told(top), marking.opens(top.epoch)] for top in tops],
            hovertemplate="%{customdata[0]}<extra></extra>",
            showlegend=False,
        )
    )


def _limit_circle(figure: Figure, tops: Sequence[Top]) -> None:
    allowed = [top.allowable_m for top in tops if top.allowable_m is not None]
    if not allowed:
        return
    angles = np.linspace(0.0, 2.0 * np.pi, 121)
    radius = 1e3 * allowed[-1]
    figure.add_trace(
        Scatter(
            x=radius * np.sin(angles),
            y=radius * np.cos(angles),
            mode="lines",
            line={"color": VERMILION, "width": 1.6, "dash": "dash"},
            name=f"limit {radius:.1f} mm",
            hoverinfo="name",
        )
    )


def _plumb(figure: Figure) -> None:
    figure.add_trace(
        Scatter(
            x=[0.0],
            y=[0.0],
            mode="markers",
            marker={"symbol": "cross-thin", "size": 13, "line": {"color": INK, "width": 1.6}},
            name="plumb line through the foot",
            hoverinfo="name",
        )
    )


def _ellipse(
    figure: Figure, centre: NDArray[np.float64], covariance: NDArray[np.float64], alpha: float
) -> None:
    line = ellipse(centre, covariance, ELLIPSE_95)
    figure.add_trace(
        Scatter(
            x=line[:, 0],
            y=line[:, 1],
            mode="lines",
            line={"color": f"rgba({_RGB},{alpha:.2f})", "width": 1},
            hoverinfo="skip",
            showlegend=False,
        )
    )


def _ages(n: int) -> list[float]:
    """How opaque each of n epochs is: the newest fully, the oldest a third."""
    return [1.0] if n == 1 else [0.3 + 0.7 * i / (n - 1) for i in range(n)]


def _top_told(top: Top) -> str:
    east, north = (numbers.signed_mm(float(v)) for v in top.east_north_m)
    return f"<b>{plain(top.epoch)}</b>, {numbers.day(top.time)}<br>{east} east, {north} north"


def _told(movement: Movement) -> str:
    east, north = (numbers.signed_mm(float(v), 2) for v in movement.east_north_m)
    word = {True: "significant", False: "not significant", None: "not tested"}[movement.significant]
    return f"<b>{plain(movement.epoch)}</b>, {numbers.day(movement.time)}<br>{east} east, {north} north<br>{word}"
