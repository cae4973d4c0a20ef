"""The axis from foot to top in three panels that share their height: along the lean, across it, residuals."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from plotly.graph_objects import Figure, Scatter
from plotly.subplots import make_subplots

from dashboard.content.profile import Profile
from dashboard.figures.frame import frame
from dashboard.theme import BLUE, FAINT, GREEN, INK, ORANGE, SOFT, VERMILION

OpensSlice: TypeAlias = Callable[[int], str]

_WEIGHTS = [[0.0, "#cfd6dd"], [0.5, "#6fa8d6"], [1.0, "#0b4a7f"]]


def axis_profile(profile: Profile, ghost: Profile | None, opens: OpensSlice, k: float = 2.0) -> Figure:
    """Draw an axis; ``ghost`` is the same of the reference epoch, turned into the same directions.

    The third panel has signed residuals: the distance alone would hide a bow.
    """
    figure = make_subplots(rows=1, cols=3, shared_yaxes=True, horizontal_spacing=0.035)
    for column in (0, 1):
        if ghost is not None:
            _dots(figure, ghost, column, ghost=True)
        _lines(figure, profile, column)
        _dots(figure, profile, column, ghost=False, opens=opens, k=k)
    _residuals(figure, profile, opens)
    along, across = profile.direction.words
    frame(figure, 520)
    for column, title in ((1, f"{along}, mm"), (2, f"{across}, mm"), (3, "off the straight axis, mm")):
        figure.update_xaxes(title_text=title, zeroline=True, zerolinecolor=FAINT, row=1, col=column)
    figure.update_yaxes(title_text="height, m", row=1, col=1)
    figure.update_yaxes(rangemode="tozero")
    return figure


def _lines(figure: Figure, profile: Profile, column: int) -> None:
    def line(values: NDArray[np.float64], name: str, look: dict[str, object]) -> None:
        figure.add_trace(
            Scatter(
                x=1e3 * values[:, column],
                y=profile.line_z_m,
                mode="lines",
                line=look,
                name=name,
                legendgroup=name,
                showlegend=column == 0,
                hoverinfo="skip",
            ),
            row=1,
            col=column + 1,
        )

    line(np.zeros_like(profile.line_m), "plumb line", {"color": SOFT, "width": 1, "dash": "dot"})
    line(profile.line_m, "straight axis", {"color": INK, "width": 1.6})
    if profile.curve_m is not None:
        line(profile.curve_m, "bent axis", {"color": VERMILION, "width": 1.4, "dash": "dash"})


def _dots(
    figure: Figure,
    profile: Profile,
    column: int,
    *,
    ghost: bool,
    opens: OpensSlice | None = None,
    k: float = 2.0,
) -> None:
    look = {"color": "#aeb7c0", "size": 5} if ghost else {"color": BLUE, "size": 6}
    errors = (
        None
        if ghost
        else {
            "type": "data",
            "array": _known(1e3 * k * profile.sigmas_m[:, column]),
            "thickness": 1,
            "width": 0,
        }
    )
    links = [[int(i), opens(int(i))] for i in profile.index] if opens else None
    name = "reference epoch" if ghost else "centres of slices"
    figure.add_trace(
        Scatter(
            x=1e3 * profile.centres_m[:, column],
            y=profile.z_m,
            error_x=errors,
            mode="markers",
            marker=look,
            customdata=links,
            hovertemplate="slice %{customdata[0]}, z %{y:.2f} m: %{x:.2f} mm<extra></extra>"
            if links
            else None,
            hoverinfo=None if links else "skip",
            name=name,
            legendgroup=name,
            showlegend=column == 0,
        ),
        row=1,
        col=column + 1,
    )


def _residuals(figure: Figure, profile: Profile, opens: OpensSlice) -> None:
    weights = np.nan_to_num(profile.weights, nan=0.0)
    for column, name, symbol, colour in (
        (0, "residual along", "circle", None),
        (1, "residual across", "cross-thin", ORANGE),
    ):
        marker: dict[str, object] = {"symbol": symbol, "size": 6}
        if colour is None:
            bar = {
                "title": {"text": "weight", "font": {"size": 11}},
                "thickness": 8,
                "len": 0.5,
                "outlinewidth": 0,
            }
            marker |= {"color": weights, "colorscale": _WEIGHTS, "cmin": 0.0, "cmax": 1.0, "colorbar": bar}
            marker["line"] = {"color": INK, "width": 0.5}
        else:
            marker["line"] = {"color": GREEN, "width": 1.2}
        figure.add_trace(
            Scatter(
                x=_known(1e3 * profile.residuals_m[:, column]),
                y=profile.z_m,
                mode="markers",
                marker=marker,
                customdata=[[int(i), opens(int(i))] for i in profile.index],
                hovertemplate=f"slice %{{customdata[0]}}, z %{{y:.2f}} m: {name} %{{x:.2f}} mm<extra></extra>",
                name=name,
            ),
            row=1,
            col=3,
        )


def _known(values: NDArray[np.float64]) -> list[float | None]:
    """NULL where there is no number, as plotly wants it."""
    return [float(value) if np.isfinite(value) else None for value in values]
