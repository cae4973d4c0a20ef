"""The stages of a run as bars over its time."""

from collections.abc import Sequence
from typing import Final

from plotly.graph_objects import Bar as Beam
from plotly.graph_objects import Figure, Scatter

from dashboard import numbers
from dashboard.content.runs import Bar
from dashboard.figures.frame import frame
from dashboard.figures.words import folded, plain
from dashboard.theme import BLUE, GREEN, ORANGE, OTHER_SCHEME, PURPLE, SKY, SOFT, VERMILION

KINDS: Final = {
    "ingest": SKY,
    "registration": BLUE,
    "preprocessing": GREEN,
    "slicing": ORANGE,
    "surface": PURPLE,
    "axis": OTHER_SCHEME,
}


def timeline(bars: Sequence[Bar]) -> Figure:
    """Draw each stage where it ran; what came from the cache is a hollow mark, what was refused or failed a cross."""
    figure = Figure()
    # a stage's name may come twice, its place does not
    places = {id(bar): place for place, bar in enumerate(bars)}
    for kind in dict.fromkeys(bar.kind for bar in bars):
        ours = [bar for bar in bars if bar.kind == kind and bar.seconds is not None]
        if ours:
            figure.add_trace(
                Beam(
                    x=[bar.seconds for bar in ours],
                    base=[bar.from_s for bar in ours],
                    y=[places[id(bar)] for bar in ours],
                    orientation="h",
                    marker={
                        "color": KINDS.get(kind, SOFT),
                        "line": {"color": KINDS.get(kind, SOFT), "width": 1},
                    },
                    width=0.7,
                    name=plain(kind),
                    customdata=[[_told(bar)] for bar in ours],
                    hovertemplate="%{customdata[0]}<extra></extra>",
                )
            )
    _marks(figure, [b for b in bars if b.seconds is None], places, "circle-open", SOFT, "from the cache")
    bad = [b for b in bars if b.row.outcome != "ok"]
    _marks(figure, bad, places, "x", VERMILION, "refused or failed")
    frame(figure, 110 + 15 * len(bars))
    figure.update_layout(barmode="overlay", bargap=0.2)
    figure.update_xaxes(title_text="seconds since the first stage was asked for", rangemode="tozero")
    figure.update_yaxes(
        tickvals=list(range(len(bars))),
        ticktext=[plain(bar.stage if len(bar.stage) <= 28 else f"{bar.stage[:27]}…") for bar in bars],
        range=[len(bars) - 0.4, -0.6],
        showgrid=False,
        zeroline=False,
        tickfont={"size": 10},
    )
    return figure


def _marks(
    figure: Figure, bars: Sequence[Bar], places: dict[int, int], symbol: str, colour: str, name: str
) -> None:
    if not bars:
        return
    figure.add_trace(
        Scatter(
            x=[bar.from_s + (bar.seconds or 0.0) for bar in bars],
            y=[places[id(bar)] for bar in bars],
            mode="markers",
            name=name,
            marker={"symbol": symbol, "size": 9, "color": colour, "line": {"width": 1.4}},
            customdata=[[_told(bar)] for bar in bars],
            hovertemplate="%{customdata[0]}<extra></extra>",
        )
    )


def _told(bar: Bar) -> str:
    row = bar.row
    took = "from the cache" if bar.seconds is None else numbers.number(bar.seconds, 3, "s")
    lines = [f"<b>{plain(bar.stage)}</b>", took, f"{numbers.count(row.points)} points"]
    if row.outcome != "ok":
        lines.append(f"{plain(row.outcome)}: {folded(plain(row.reason or 'no reason is stored'))}")
    return "<br>".join(lines)
