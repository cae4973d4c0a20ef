"""What a change at an onset looks like in the movements: a step, or a rate that turns."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from tasks.trend.series import LeanSeries
from tasks.trend.walk import twofold

Kind = Literal["step", "rate"]
KINDS: Final[tuple[Kind, ...]] = ("step", "rate")

EPOCHS_BESIDE: Final = 2
"""Epochs at different times before and after the onset at the least: one that is off is no change of the trend."""


@dataclass(frozen=True, slots=True)
class Onsets:
    """Onsets of one kind: ``times`` (k,) in years, ascending, and the years ``widths`` (k,) each of them stands for."""

    kind: Kind
    times: NDArray[np.float64]
    widths: NDArray[np.float64]


def change_column(series: LeanSeries, kind: Kind, onset: float) -> NDArray[np.float64]:
    """Column (n,) of one component for a change at a time in years, zero from the onset on.

    Its unknown is what the change adds: the step, metres, or the rate after it less that before, metres a year. What
    comes before is written as the deviation, so that level and rate beside the column are those that hold at the end.
    """
    if kind == "step":
        return np.where(series.times < onset, -1.0, 0.0)
    return np.maximum(onset - series.times, 0.0)


def change_columns(series: LeanSeries, onsets: Onsets) -> NDArray[np.float64]:
    """Columns (2n, 2k) of both components for every onset, east and north in turn."""
    columns = np.column_stack([change_column(series, onsets.kind, float(onset)) for onset in onsets.times])
    return twofold(columns)


def onsets_between(series: LeanSeries, kind: Kind, parts: int) -> Onsets:
    """Midpoints of equal parts of every interval between two epochs that can hold an onset.

    A step lies anywhere between two epochs and looks alike there: one onset an interval. A rate that turns between the
    first two or the last two epochs cannot be told from a single epoch that is off.
    """
    edges = np.unique(series.times)[EPOCHS_BESIDE - 1 : series.n_times - EPOCHS_BESIDE + 1]
    lows, spans = edges[:-1], np.diff(edges)
    parts = 1 if kind == "step" else parts
    shares = (np.arange(parts) + 0.5) / parts
    return Onsets(
        kind, (lows[:, None] + spans[:, None] * shares).reshape(-1), np.repeat(spans / parts, parts)
    )


def blocks_of(onsets: Onsets, most: int) -> Iterator[Onsets]:
    """The onsets in blocks of at most so many, in their order."""
    for start in range(0, len(onsets.times), most):
        block = slice(start, start + most)
        yield Onsets(onsets.kind, onsets.times[block], onsets.widths[block])


def thinned(onsets: Onsets, most: int) -> Onsets:
    """At most that many of the onsets, evenly spread; neighbours in a long series look nearly alike."""
    if len(onsets.times) <= most:
        return onsets
    chosen = np.unique(np.linspace(0, len(onsets.times) - 1, most).round().astype(int))
    return Onsets(onsets.kind, onsets.times[chosen], onsets.widths[chosen])
