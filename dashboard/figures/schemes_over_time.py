"""Every scheme and method over the epochs, in the fixed colours of schemes and marks of methods."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from plotly.graph_objects import Figure, Scatter

from dashboard import numbers
from dashboard.figures.frame import frame, over_time
from dashboard.figures.series import Marking
from dashboard.figures.words import plain
from dashboard.theme import METHOD_MARKS, scheme_colour
from storage.records import TiltRow

FAR: Final = 8.0
"""Median deviations from the median; of a normal distribution one in ten million is farther off."""


def schemes_over_time(tilts: Sequence[TiltRow], marking: Marking) -> Figure:
    """Draw the deviation of every scheme and method, mm; a click on the legend takes one away."""
    figure = Figure()
    for scheme, method in sorted({(row.scheme, row.method) for row in tilts}):
        rows = [row for row in tilts if (row.scheme, row.method) == (scheme, method)]
        colour = scheme_colour(scheme)
        figure.add_trace(
            Scatter(
                x=[row.epoch_time for row in rows],
                y=[1e3 * row.deviation_m for row in rows],
                mode="markers+lines",
                line={"color": colour, "width": 1, "dash": "dot" if method == "paper" else "solid"},
                marker={"color": colour, "size": 7, "symbol": METHOD_MARKS.get(method, "circle")},
                customdata=[[_told(row), marking.opens(row.epoch)] for row in rows],
                hovertemplate="%{customdata[0]}<extra></extra>",
                name=plain(f"{scheme}/{method}"),
            )
        )
    figure.update_yaxes(
        title_text="deviation, mm", range=usual_range([1e3 * row.deviation_m for row in tilts])
    )
    over_time(frame(figure, 360), [row.epoch_time for row in tilts])
    figure.update_layout(
        legend={"orientation": "v", "x": 1.01, "xanchor": "left", "y": 1.0, "yanchor": "top"}
    )
    return figure


def usual_range(values: Sequence[float]) -> list[float] | None:
    """The range of all values but those far off the others: one scheme gone wrong must not flatten all."""
    if not values:
        return None
    found = np.asarray(values)
    middle = float(np.median(found))
    spread = float(np.median(np.abs(found - middle)))
    near = found[np.abs(found - middle) <= max(FAR * spread, 1e-3 * abs(middle))]
    low, high = float(near.min()), float(near.max())
    margin = 0.08 * max(high - low, 1e-3 * abs(middle), 0.1)
    return [low - margin, high + margin]


def far_off(values: Sequence[float]) -> int:
    """How many values lie outside of that range."""
    limits = usual_range(values)
    return 0 if limits is None else sum(not limits[0] <= value <= limits[1] for value in values)


def _told(row: TiltRow) -> str:
    deviation = numbers.mm_with_u(row.deviation_m, row.deviation_sigma_m)
    return f"<b>{plain(row.scheme)}/{plain(row.method)}</b>, {plain(row.epoch)}<br>{deviation} (k=2)"
