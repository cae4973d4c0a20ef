"""How many points: of each slice over the height, and what was removed for which reason."""

from collections.abc import Sequence

from plotly.graph_objects import Bar, Figure, Scatter

from dashboard import numbers
from dashboard.figures.frame import frame
from dashboard.figures.words import folded, plain
from dashboard.theme import BLUE, GREEN, OTHER_SCHEME, VERMILION
from storage.records import RemovalRow, SliceRow


def points_of_slices(slices: Sequence[SliceRow]) -> Figure:
    """Draw the points of each slice over its height; slices that failed are crosses."""
    figure = Figure()
    for failed in (False, True):
        rows = [row for row in slices if (row.state != "ok") == failed]
        if not rows:
            continue
        figure.add_trace(
            Scatter(
                # a slice without a point stands at the edge, where a logarithm still exists
                x=[max(row.n_points, 0.8) for row in rows],
                y=[row.z_m for row in rows],
                mode="markers" if failed else "markers+lines",
                line={"color": "#b9cfe2", "width": 1},
                marker={
                    "symbol": "x" if failed else "circle",
                    "size": 8 if failed else 5,
                    "color": VERMILION if failed else BLUE,
                },
                name="failed" if failed else "ok",
                customdata=[[_told(row)] for row in rows],
                hovertemplate="%{customdata[0]}<extra></extra>",
                showlegend=failed,
            )
        )
    frame(figure, 420)
    figure.update_xaxes(title_text="points of the slice", type="log", **_ticks(slices))
    figure.update_yaxes(title_text="height, m")
    return figure


def _ticks(slices: Sequence[SliceRow]) -> dict[str, object]:
    """Numbers on a logarithmic axis: between the powers of ten, too, where there are few of these."""
    counts = [max(row.n_points, 0.8) for row in slices]
    low, high = min(counts), max(counts)
    steps = (1, 2, 3, 5) if high < 50.0 * low else (1,)
    values = [step * 10**power for power in range(9) for step in steps]
    shown = [value for value in values if low / 1.4 <= value <= 1.4 * high]
    return {"tickvals": shown, "ticktext": [numbers.count(value) for value in shown]}


def _told(row: SliceRow) -> str:
    text = f"{row.z_m:.1f} m: {numbers.count(row.n_points)} points, {numbers.degrees(row.arc_coverage_deg, 0)} seen"
    return text if row.state == "ok" else f"{text}<br>failed: {folded(plain(row.reason or ''))}"


def removal_bars(rows: Sequence[RemovalRow]) -> Figure:
    """Draw what each step removed, and what remained, with its share of all."""
    total = sum(row.n_points for row in rows)
    names = [plain(row.reason) for row in rows]
    shares = [f"{numbers.count(row.n_points)}  ({_share(row.n_points, total)})" for row in rows]
    figure = Figure(
        Bar(
            x=[row.n_points for row in rows],
            y=[folded(name, 30) for name in names],
            orientation="h",
            marker={"color": [GREEN if row.reason == "kept" else OTHER_SCHEME for row in rows]},
            text=shares,
            textposition="outside",
            cliponaxis=False,
            hovertemplate="%{y}: %{text}<extra></extra>",
        )
    )
    frame(figure, 80 + 34 * len(rows))
    figure.update_yaxes(autorange="reversed", showgrid=False, ticks="")
    figure.update_xaxes(title_text="points", range=[0, 1.7 * max((row.n_points for row in rows), default=1)])
    figure.update_layout(margin={"t": 6}, bargap=0.35)
    return figure


def _share(part: int, total: int) -> str:
    return numbers.MISSING if total == 0 else f"{100.0 * part / total:.1f} %"
