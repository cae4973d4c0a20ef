"""The three cross sections that fit worst, each for its own reason, with the wall as it was seen there."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dashboard import numbers
from dashboard.report.blocks import Block, Chart, Missing, Table
from dashboard.report.charts import slices
from dashboard.report.facts import Facts
from dashboard.report.words import Words
from storage.records import SliceRow, SurfaceMapRow

HOW_MANY: Final = 3


@dataclass(frozen=True, slots=True)
class Worst:
    """A slice and why it is among the worst: by its distance from the axis, its scatter, its gap or its few points."""

    row: SliceRow
    why: str


def _residual(row: SliceRow) -> float | None:
    return row.residual_m


def _scatter(row: SliceRow) -> float | None:
    return row.rmse_m


def _gap(row: SliceRow) -> float | None:
    return None if row.arc_coverage_deg is None else -row.arc_coverage_deg


def _few(row: SliceRow) -> float | None:
    return -float(row.n_points)


CRITERIA: Final[Sequence[tuple[str, Callable[[SliceRow], float | None]]]] = (
    ("residual", _residual),
    ("scatter", _scatter),
    ("gap", _gap),
    ("few", _few),
)
"""In this order; one without differences among the slices is passed over."""


def worst_of(rows: Sequence[SliceRow]) -> list[Worst]:
    """Choose the slices: failed ones first, then the worst by each criterion, no slice twice."""
    chosen = [Worst(row, "failed") for row in rows if row.state == "failed"][:HOW_MANY]
    for why, measure in CRITERIA:
        left = [row for row in rows if row.state == "ok" and all(row is not each.row for each in chosen)]
        rated = [(value, row) for row in left if (value := measure(row)) is not None]
        if len(chosen) < HOW_MANY and rated and (why != "gap" or _differ(rated)):
            chosen.append(Worst(max(rated, key=lambda each: each[0])[1], why))
    return sorted(chosen, key=lambda each: each.row.z_m)


def _differ(rated: Sequence[tuple[float, SliceRow]]) -> bool:
    values = [value for value, _ in rated]
    return max(values) - min(values) > 1.0


def blocks(facts: Facts, words: Words, charts: dict[str, str]) -> Iterator[Block]:
    """Draw and list them."""
    worst = worst_of(facts.primary_slices)
    if not worst:
        yield Missing(words("slices.title"), words("slices.none"))
        return
    rings = [ring for each in worst if (ring := _ring(each, facts.surface, words)) is not None]
    if rings:
        charts["slices"] = slices.chart(rings, words)
        yield Chart("slices", words("slices.title"), words("slices.note"), words("slices.described"))
    else:
        yield Missing(words("slices.title"), words("slices.no_surface"))
    yield _table(worst, words)


def _ring(each: Worst, surface: Sequence[SurfaceMapRow], words: Words) -> slices.Ring | None:
    """The wall in the band of the surface map that the middle of the slice lies in."""
    band = [row for row in surface if row.z_low_m <= each.row.z_m <= row.z_high_m]
    lowest = min((row.z_low_m for row in band), default=None)
    band = [row for row in band if row.z_low_m == lowest and row.radius_m is not None]
    if not band or band[0].radius_m is None:
        return None
    offset = None
    if each.row.offset_east_m is not None and each.row.offset_north_m is not None:
        offset = (each.row.offset_east_m, each.row.offset_north_m)
    return slices.Ring(
        words("slices.at", z=f"{each.row.z_m:.1f}", why=words(f"slices.{each.why}")),
        band[0].radius_m,
        np.array([row.azimuth_deg for row in band]),
        np.array([np.nan if row.deviation_m is None else row.deviation_m for row in band]),
        offset,
    )


def _table(worst: Sequence[Worst], words: Words) -> Table:
    head = ("z", "points", "coverage", "radius", "rmse", "off_axis", "weight", "why")
    return Table(
        words("slices.table"),
        tuple(words(f"slices.{name}") for name in head),
        "rrrrrrrl",
        tuple(_row(each, words) for each in worst),
        small=True,
    )


def _row(each: Worst, words: Words) -> tuple[str, ...]:
    row = each.row
    why = row.reason or words("slices.failed") if each.why == "failed" else words(f"slices.{each.why}")
    return (
        numbers.number(row.z_m, 2),
        numbers.count(row.n_points),
        numbers.degrees(row.arc_coverage_deg, 0),
        numbers.number(row.radius_m, 4),
        numbers.mm(row.rmse_m, unit=""),
        numbers.mm(row.residual_m, 2, ""),
        numbers.number(row.weight, 2),
        why,
    )
