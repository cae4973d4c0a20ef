"""The frame that every drawing for the web has: font, grid, margins, what a click opens."""

from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import Final

from plotly.graph_objects import Figure

from dashboard.theme import FAINT, INK, PAPER, SOFT

FONT: Final = "Inter, 'Source Sans 3', 'Segoe UI', 'Noto Sans', sans-serif"

_QUARTER: Final = timedelta(days=91)

_AXIS: Final = {
    "gridcolor": "#eceff2",
    "linecolor": FAINT,
    "zerolinecolor": FAINT,
    "zerolinewidth": 1,
    "ticks": "outside",
    "ticklen": 4,
    "tickcolor": FAINT,
    "showline": True,
    "automargin": True,
    "title": {"font": {"size": 12, "color": SOFT}, "standoff": 6},
    "tickfont": {"size": 11, "color": SOFT},
}


def frame(figure: Figure, height_px: int = 320) -> Figure:
    """Give a figure the look of the house; what is in it stays.

    The last item of a point's ``customdata``, where it begins with a slash, is the address that a click opens.
    """
    figure.update_layout(
        template=None,
        height=height_px,
        margin={"l": 56, "r": 16, "t": 12, "b": 44},
        paper_bgcolor=PAPER,
        plot_bgcolor=PAPER,
        font={"family": FONT, "size": 12, "color": INK},
        hoverlabel={
            "bgcolor": PAPER,
            "bordercolor": FAINT,
            "font": {"family": FONT, "size": 12, "color": INK},
        },
        legend={
            "orientation": "h",
            "yanchor": "bottom",
            "y": 1.0,
            "x": 0.0,
            "font": {"size": 11, "color": SOFT},
            "itemsizing": "constant",
        },
        hovermode="closest",
        uirevision="kept",
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": FAINT, "activecolor": INK},
    )
    figure.update_xaxes(**_AXIS)
    figure.update_yaxes(**_AXIS)
    return figure


def over_time(figure: Figure, times: Sequence[datetime]) -> Figure:
    """Write an axis of time in days; a single epoch stands in the middle of half a year."""
    figure.update_xaxes(type="date", hoverformat="%Y-%m-%d")
    if times and min(times) == max(times):
        figure.update_xaxes(range=[times[0] - _QUARTER, times[0] + _QUARTER], tickformat="%b %Y")
    return figure


def square(figure: Figure) -> Figure:
    """Give both axes of a plan the same scale."""
    figure.update_yaxes(scaleanchor="x", scaleratio=1.0)
    return figure


def north_arrow(figure: Figure) -> Figure:
    """Draw an arrow to grid north, which is up, into the upper right corner."""
    figure.add_annotation(
        x=0.975,
        y=0.97,
        ax=0,
        ay=34,
        xref="paper",
        yref="paper",
        text="N",
        showarrow=True,
        arrowhead=2,
        arrowwidth=1.4,
        arrowcolor=INK,
        font={"size": 12, "color": INK},
        xanchor="center",
        yanchor="bottom",
    )
    return figure
