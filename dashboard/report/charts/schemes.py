"""The deviation that every scheme and method finds, with its uncertainty and the limit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dashboard import theme
from dashboard.report.charts.style import draw, padded
from dashboard.report.words import Words

MARKS: Final = {"surface": "D", "robust": "o", "paper": "s"}


@dataclass(frozen=True, slots=True)
class Found:
    """What a scheme and method, or a measurement by other means, finds; metres."""

    label: str
    scheme: str
    method: str
    deviation_m: float
    sigma_m: float | None
    is_primary: bool


def chart(found: Sequence[Found], allowable_m: float | None, words: Words) -> str:
    """Draw all beside each other over the whole range, and again near the result that counts."""

    def plot(figure: Figure) -> None:
        whole, near = figure.subplots(1, 2, sharey=True)
        for axes in (whole, near):
            for place, each in enumerate(found):
                _dot(axes, len(found) - 1 - place, each)
            axes.set_xlabel(words("chart.deviation_mm"))
        whole.set_yticks(range(len(found)), [each.label for each in reversed(found)])
        whole.set_ylim(-0.7, len(found) - 0.3)
        whole.set_title(words("chart.schemes_whole"), loc="left")
        near.set_title(words("chart.schemes_near"), loc="left")
        _range(whole, found, allowable_m, words)
        _zoom(near, found)

    return draw("schemes", (178.0, max(18.0 + 3.7 * len(found), 34.0)), plot)


def _dot(axes: Axes, row: int, each: Found) -> None:
    colour = theme.scheme_colour(each.scheme) if each.scheme else theme.GREEN
    bar = None if each.sigma_m is None else [2e3 * each.sigma_m]
    hollow = each.method == "paper"
    axes.errorbar(
        [1e3 * each.deviation_m], [row], xerr=bar, fmt=MARKS.get(each.method, "^"), ms=5.5 if each.is_primary else 4.2,
        color=colour, mfc="white" if hollow else colour, elinewidth=1.2, capsize=2.2, mew=1.0, zorder=4,
    )  # fmt: skip
    if each.is_primary:
        axes.axvline(1e3 * each.deviation_m, color=colour, lw=0.6, alpha=0.5, zorder=1)


def _range(axes: Axes, found: Sequence[Found], allowable_m: float | None, words: Words) -> None:
    ends = [
        0.0,
        *(1e3 * each.deviation_m + side * 2e3 * (each.sigma_m or 0.0) for each in found for side in (-1, 1)),
    ]
    if allowable_m is not None:
        limit = 1e3 * allowable_m
        ends.append(limit)
        is_right = limit > (min(ends) + max(ends)) / 2.0
        axes.axvline(limit, color=theme.VERMILION, lw=1.1, ls=(0, (5, 2)), zorder=2)
        axes.annotate(
            words("chart.limit"),
            (limit, 0.01),
            xycoords=("data", "axes fraction"),
            xytext=(-3 if is_right else 3, 2),
            textcoords="offset points",
            ha="right" if is_right else "left",
            fontsize=6.8,
            color=theme.VERMILION,
        )
    axes.set_xlim(*padded(min(ends), max(ends), 0.04))


def _zoom(axes: Axes, found: Sequence[Found]) -> None:
    """Show what lies about the primary; bars of two-slice schemes run out of the panel."""
    middle = next((1e3 * each.deviation_m for each in found if each.is_primary), 1e3 * found[0].deviation_m)
    widths = sorted(abs(1e3 * each.deviation_m - middle) + 2e3 * (each.sigma_m or 0.0) for each in found)
    reach = 1.15 * max(widths[(2 * len(widths)) // 3], 1.0)
    axes.set_xlim(middle - reach, middle + reach)
