"""How what the rules look at went over the epochs, as multiples of their limits."""

from collections.abc import Mapping, Sequence
from typing import Final

from plotly.graph_objects import Figure, Scatter

from dashboard import numbers
from dashboard.content.alarms import Step, quantity
from dashboard.figures.frame import frame
from dashboard.figures.words import plain
from dashboard.theme import BLUE, GREEN, ORANGE, PURPLE, SKY, SOFT, VERMILION

_COLOURS: Final = (BLUE, ORANGE, GREEN, PURPLE, SKY, SOFT)
_MARKS: Final = ("circle", "square", "diamond", "triangle-up", "x", "cross")


def course_of_values(found: Mapping[str, Sequence[Step]], chosen: str | None) -> Figure:
    """Draw each alarm's value over its limit; above 1 the rule is broken, unless a smaller value is worse."""
    figure = Figure()
    drawn = {name: [(s, s.ratio) for s in steps if s.ratio] for name, steps in found.items()}
    for place, (name, steps) in enumerate(drawn.items()):
        if not steps:
            continue
        colour = _COLOURS[place % len(_COLOURS)]
        figure.add_trace(
            Scatter(
                x=[step.time for step, _ in steps],
                y=[ratio for _, ratio in steps],
                mode="markers+lines",
                name=plain(name),
                opacity=1.0 if chosen in (None, name) else 0.25,
                line={"color": colour, "width": 1.2},
                marker={"color": colour, "size": 8, "symbol": _MARKS[place % len(_MARKS)]},
                customdata=[[_told(name, step)] for step, _ in steps],
                hovertemplate="%{customdata[0]}<extra></extra>",
            )
        )
    figure.add_hline(y=1.0, line={"color": VERMILION, "width": 1.6, "dash": "dash"})
    frame(figure, 300)
    figure.update_yaxes(title_text="value over limit", type="log", dtick=1, exponentformat="none")
    figure.update_xaxes(title_text="time of the epoch")
    return figure


def _told(name: str, step: Step) -> str:
    value, limit = quantity(step.value, step.unit), quantity(step.limit_value, step.unit)
    return (
        f"<b>{plain(name)}</b>, {plain(step.epoch)}, {numbers.day(step.time)}<br>"
        f"{plain(value)}, limit {plain(limit)}<br>{plain(step.action)}"
    )
