"""An axis of azimuths: clockwise from grid north, with the letters of the compass."""

from typing import Final

from plotly.graph_objects import Figure

COMPASS: Final = {0: "N", 90: "E", 180: "S", 270: "W"}


def compass_axis(figure: Figure) -> None:
    """Let the horizontal axis be the azimuth, clockwise from grid north."""
    ticks = range(0, 361, 45)
    figure.update_xaxes(
        title_text="azimuth, clockwise from grid north",
        range=[0, 360],
        tickvals=list(ticks),
        ticktext=[f"<b>{COMPASS[t % 360]}</b>" if t % 360 in COMPASS else f"{t}°" for t in ticks],
    )
