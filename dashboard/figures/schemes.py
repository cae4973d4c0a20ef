"""The deviation of every scheme and method with its uncertainty, and how far each is from another over the epochs."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from plotly.graph_objects import Figure, Scatter
from plotly.subplots import make_subplots

from dashboard import numbers
from dashboard.content.scheme_differences import Difference
from dashboard.content.schemes import Mark, near_range
from dashboard.figures.frame import frame
from dashboard.figures.words import plain
from dashboard.theme import GREEN, INK, METHOD_MARKS, SOFT, VERMILION, scheme_colour

_K_MM: Final = 1e3 * numbers.COVERAGE


def deviations(marks: Sequence[Mark], allowable_m: float | None) -> Figure:
    """Draw all beside each other: on the left over the whole range with the limit, on the right near the primary."""
    figure = make_subplots(1, 2, shared_yaxes=True, horizontal_spacing=0.03, column_widths=[0.4, 0.6])
    for column in (1, 2):
        for mark in marks:
            figure.add_trace(_mark(mark), 1, column)
    if allowable_m is not None:
        figure.add_vline(
            x=1e3 * allowable_m,
            line={"color": VERMILION, "width": 1.6, "dash": "dash"},
            annotation={"text": f"limit {numbers.mm(allowable_m)}", "font": {"size": 11, "color": VERMILION}},
            annotation_position="top right",
            row=1,
            col=1,
        )
    frame(figure, 90 + 24 * len(marks))
    figure.update_layout(margin={"t": 34}, showlegend=False)
    figure.update_yaxes(autorange="reversed", type="category", showgrid=False)
    figure.update_xaxes(title_text="deviation, mm: all", range=_whole(marks, allowable_m), row=1, col=1)
    middle = _middle(marks)
    title = f"near {plain(middle.label)}, mm"
    figure.update_xaxes(title_text=title, range=_near(marks, middle.value_m), row=1, col=2)
    return figure


def _mark(mark: Mark) -> Scatter:
    colour = GREEN if mark.scheme is None else scheme_colour(mark.scheme)
    u_mm = None if mark.sigma_m is None else _K_MM * mark.sigma_m
    told = numbers.mm_with_u(mark.value_m, mark.sigma_m)
    return Scatter(
        x=[1e3 * mark.value_m],
        y=[plain(mark.label) + (" *" if mark.is_primary else "")],
        error_x={"type": "data", "array": [u_mm or 0.0], "color": colour, "thickness": 1.6, "width": 4},
        mode="markers",
        marker={
            "symbol": "star" if mark.scheme is None else METHOD_MARKS.get(mark.method or "", "circle"),
            "size": 10 if mark.is_primary else 8,
            "color": colour,
            "line": {"color": INK, "width": 2 if mark.is_primary else 0}
            if mark.method != "paper"
            else {"color": colour, "width": 1.6},
        },
        hovertemplate=f"<b>{plain(mark.label)}</b><br>{told} (k = 2)<extra></extra>",
    )


def _whole(marks: Sequence[Mark], allowable_m: float | None) -> list[float]:
    ends = [0.0] if allowable_m is None else [0.0, 1e3 * allowable_m]
    for mark in marks:
        u_mm = _K_MM * (mark.sigma_m or 0.0)
        ends += [1e3 * mark.value_m - u_mm, 1e3 * mark.value_m + u_mm]
    room = 0.04 * (max(ends) - min(ends)) or 1.0
    return [min(ends) - room, max(ends) + room]


def _middle(marks: Sequence[Mark]) -> Mark:
    """What is looked at closely: the primary, else the first that there is."""
    return next((mark for mark in marks if mark.is_primary), marks[0])


def _near(marks: Sequence[Mark], middle: float) -> list[float]:
    reach = near_range([(m.value_m, numbers.COVERAGE * (m.sigma_m or 0.0)) for m in marks], middle)
    reach_mm = 1150.0 * max(reach, 0.001)
    return [1e3 * middle - reach_mm, 1e3 * middle + reach_mm]


def over_epochs(found: Mapping[str, Sequence[Difference]], against: str, epochs: Sequence[str]) -> Figure:
    """Draw each scheme minus another over the epochs; a wild one runs out of the drawing rather than flatten the rest."""
    figure = Figure()
    values = [d for series in found.values() for d in series]
    for place, series in enumerate(found.values()):
        figure.add_trace(_series(series, (place - (len(found) - 1) / 2.0) * 0.8 / len(found), epochs))
    figure.add_hline(y=0.0, line={"color": SOFT, "width": 1})
    frame(figure, 360)
    reach_mm = 1150.0 * max(
        near_range([(d.value_m, numbers.COVERAGE * (d.sigma_m or 0.0)) for d in values], 0.0, 0.8), 0.0005
    )
    figure.update_yaxes(title_text=f"minus {plain(against)}, mm", range=[-reach_mm, reach_mm])
    figure.update_xaxes(
        tickvals=list(range(len(epochs))), ticktext=[plain(epoch) for epoch in epochs], title_text="epoch"
    )
    figure.update_xaxes(range=[-0.5, len(epochs) - 0.5], showgrid=False, zeroline=False)
    return figure


def _series(series: Sequence[Difference], aside: float, epochs: Sequence[str]) -> Scatter:
    first = series[0]
    colour = scheme_colour(first.scheme)
    bars: dict[str, Any] = {"type": "data", "color": colour, "thickness": 1.2, "width": 2}
    return Scatter(
        x=[epochs.index(d.epoch) + aside for d in series],
        y=[1e3 * d.value_m for d in series],
        error_y={**bars, "array": [_K_MM * (d.sigma_m or 0.0) for d in series]},
        mode="markers",
        name=plain(first.label),
        marker={
            "symbol": METHOD_MARKS.get(first.method, "circle"),
            "color": colour,
            "size": 8,
            "line": {
                "color": colour if first.method == "paper" else INK,
                "width": [1.6 if first.method == "paper" else 1.4 * (d.significant is True) for d in series],
            },
        },
        customdata=[[_told(d)] for d in series],
        hovertemplate="%{customdata[0]}<extra></extra>",
    )


def _told(d: Difference) -> str:
    word = {True: "significant", False: "not significant", None: "not tested"}[d.significant]
    value = numbers.signed_mm(d.value_m, 2)
    u = numbers.mm(None if d.sigma_m is None else numbers.COVERAGE * d.sigma_m, 2)
    return f"<b>{plain(d.label)}</b>, {plain(d.epoch)}<br>{value} ± {u} (k = 2)<br>{word}"
