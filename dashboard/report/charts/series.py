"""Deviation over the epochs with its limit, and the change since the reference with what would have been detected."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

import matplotlib.dates as mdates
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dashboard import theme
from dashboard.report.charts.style import draw, padded
from dashboard.report.legible import label
from dashboard.report.words import Words

SIZE_MM: Final = (178.0, 104.0)
DAYS_OF_MONTHS: Final = 150.0
"""Over a shorter time the days are told, too."""

BAND: Final = 2.0
"""Sigmas that bars reach, k."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A value of an epoch in metres; ``value_m`` is None where there is none."""

    epoch: str
    time: datetime
    value_m: float | None
    sigma_m: float | None
    doubtful: bool
    significant: bool | None = None
    detectable_m: float | None = None


@dataclass(frozen=True, slots=True)
class Series:
    """Both panels; ``reference`` is the epoch that changes are counted from, None where no change can be told."""

    absolute: Sequence[Mark]
    changes: Sequence[Mark]
    allowable_m: float | None
    height_m: float
    reference: str | None


def chart(series: Series, words: Words) -> str:
    """Draw both panels above each other, the same time below both."""

    def plot(figure: Figure) -> None:
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.15, 1.0))
        _absolute(upper, series, words)
        _changes(lower, series, words)
        _time_axis(lower, [mark.time for mark in series.absolute])

    return draw("series", SIZE_MM, plot)


def _absolute(axes: Axes, series: Series, words: Words) -> None:
    axes.set_title(words("chart.deviation_title", height=f"{series.height_m:g}"), loc="left")
    axes.set_ylabel(words("chart.deviation_mm"))
    _marks(axes, series.absolute, theme.INK)
    tops = [0.0]
    for mark in series.absolute:
        if mark.value_m is None:
            axes.axvline(_number(mark.time), color=theme.FAINT, lw=5, alpha=0.5)
            axes.annotate(
                words("chart.no_result"), (_number(mark.time), 0.5), xycoords=("data", "axes fraction"),
                rotation=90, ha="center", va="center", fontsize=6.5, color=theme.SOFT,
            )  # fmt: skip
        else:
            tops.append(1e3 * (mark.value_m + BAND * (mark.sigma_m or 0.0)))
    if series.allowable_m is not None:
        limit = 1e3 * series.allowable_m
        tops.append(limit)
        axes.axhline(limit, color=theme.VERMILION, lw=1.1, ls=(0, (5, 2)))
        axes.annotate(
            words("chart.limit_value", limit=f"{limit:.1f}"), (0.004, limit), xycoords=("axes fraction", "data"),
            xytext=(0, 2.5), textcoords="offset points", fontsize=6.8, color=theme.VERMILION,
        )  # fmt: skip
    axes.set_ylim(0.0, 1.14 * max(tops) or 1.0)


def _changes(axes: Axes, series: Series, words: Words) -> None:
    axes.set_ylabel(words("chart.change_mm"))
    if series.reference is None or not series.changes:
        axes.set_title(words("chart.change_title_none"), loc="left")
        axes.text(
            0.5,
            0.5,
            words("chart.no_change"),
            transform=axes.transAxes,
            ha="center",
            va="center",
            color=theme.SOFT,
        )
        axes.set_yticks([])
        return
    axes.set_title(words("chart.change_title", reference=label(series.reference, 24)), loc="left")
    times = [_number(mark.time) for mark in series.changes]
    steps = [
        (time, mark.detectable_m)
        for time, mark in zip(times, series.changes, strict=True)
        if mark.detectable_m
    ]
    half = 0.018 * max(max(times) - min(_number(mark.time) for mark in series.absolute), 20.0)
    for place, (time, detectable) in enumerate(steps):
        told = words("chart.detectable") if place == 0 else None
        axes.fill_between(
            [time - half, time + half], 0.0, 1e3 * detectable, color="#cfd6dd", lw=0, label=told
        )
    _marks(axes, series.changes, theme.INK)
    highest = max(1e3 * ((mark.value_m or 0.0) + BAND * (mark.sigma_m or 0.0)) for mark in series.changes)
    highest = max([highest, *(1e3 * detectable for _, detectable in steps)])
    axes.set_ylim(0.0, padded(0.0, highest, 0.14)[1])
    reference = next((mark for mark in series.absolute if mark.epoch == series.reference), None)
    if reference is not None:
        axes.plot([_number(reference.time)], [0.0], "D", ms=5, color=theme.SOFT, clip_on=False, zorder=6)
        axes.annotate(
            words("chart.reference"), (_number(reference.time), 0.0), (6, 5), textcoords="offset points", fontsize=6.8,
            color=theme.SOFT,
        )  # fmt: skip
    if steps:
        axes.legend(loc="lower right")


def _marks(axes: Axes, marks: Sequence[Mark], colour: str) -> None:
    """Points with bars of k = 2; hollow where the epoch is in doubt. No line joins them: nothing was measured between."""
    for mark in marks:
        if mark.value_m is None:
            continue
        bar = None if mark.sigma_m is None else 1e3 * BAND * mark.sigma_m
        axes.errorbar(
            [_number(mark.time)], [1e3 * mark.value_m], yerr=None if bar is None else [bar], fmt="o", ms=4.5, color=colour,
            mfc="white" if mark.doubtful else colour, mew=1.0, elinewidth=1.1, capsize=3, zorder=5,
        )  # fmt: skip


def _time_axis(axes: Axes, times: Sequence[datetime]) -> None:
    first, last = _number(min(times)), _number(max(times))
    pad = max(0.05 * (last - first), 10.0)
    axes.set_xlim(first - pad, last + pad)
    locator = mdates.AutoDateLocator(minticks=3, maxticks=9)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    form = "%Y-%m" if last - first > DAYS_OF_MONTHS else "%Y-%m-%d"
    axes.xaxis.set_major_formatter(mdates.DateFormatter(form))  # type: ignore[no-untyped-call]


def _number(time: datetime) -> float:
    return float(mdates.date2num(time))  # type: ignore[no-untyped-call]
