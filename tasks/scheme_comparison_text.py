"""The comparison of schemes as lines of plain text, lengths in millimetres at the top."""

import math
from collections.abc import Iterator, Sequence
from typing import Final

from storage.records import SchemeComparisonRow
from tasks.accuracy import NO_VALUE, Line, grid, number
from tasks.compared_axes import SURFACE
from tasks.stored_comparison import SchemeAgreement

COLUMNS: Final = ("slices", "workload", "points", "sigma", "of points", "enough")

DIFFERENCE_COLUMNS: Final = ("east", "north", "length", "sigma", "p", "significant")

SIGMA_NOTE: Final = (
    "sigma (mm): of one component of the axis at the top, levelling and registration included; "
    "of points: the part of the points alone"
)
DIFFERENCE_NOTE: Final = (
    "difference (mm): what two schemes share of poses and points is cancelled from its sigma; "
    "a reference measurement shares nothing with ours"
)


def workload_table_lines(rows: Sequence[SchemeComparisonRow]) -> list[str]:
    """A line a scheme: slices, workload, points, sigma, and whether so many slices are enough."""
    lines = [
        Line(
            f"{row.compared}{'  <- recommended' if row.is_recommended else ''}",
            (
                _count(row.n_slices),
                number(row.workload_ratio, 1),
                _count(row.n_points),
                number(row.sigma_m, 2, 1e3),
                number(row.point_sigma_m, 2, 1e3),
                _yes_or_no(row.is_enough),
            ),
        )
        for row in rows
    ]
    title = f"How many slices are enough; workload as a multiple of {rows[0].against}"
    return [*grid(title, COLUMNS, lines), SIGMA_NOTE]


def difference_lines(rows: Sequence[SchemeComparisonRow], title: str) -> list[str]:
    """A line a difference: its components, length and sigma at the top, and whether it is significant."""
    lines = [
        Line(
            f"{row.compared} - {row.against}",
            (
                _signed(row.d_lean_east, row.height_m),
                _signed(row.d_lean_north, row.height_m),
                number(row.d_top_m, 2, 1e3),
                number(row.d_sigma_top_m, 2, 1e3),
                NO_VALUE if row.p_value is None else f"{row.p_value:.2g}",
                _yes_or_no(row.significant),
            ),
        )
        for row in rows
        if row.d_lean_east is not None
    ]
    return [*grid(title, DIFFERENCE_COLUMNS, lines), DIFFERENCE_NOTE] if lines else []


def recommendation_of(rows: Sequence[SchemeComparisonRow]) -> list[str]:
    """How many slices are enough here, in words, with the figures that say so."""
    schemes = [row for row in rows if row.scheme is not None]
    best = next((row for row in schemes if row.compared == row.best), None)
    if best is None:
        return ["recommendation: none; no axis of at least 3 centres has a known sigma"]
    chosen = next((row for row in schemes if row.is_recommended), None)
    return [*_of_best(best), *_of_chosen(chosen, best), *_of_fewer(schemes, chosen)]


def agreement_lines(found: Sequence[SchemeAgreement]) -> list[str]:
    """A line an axis: mean and scatter of its difference over the epochs, beside the stated sigma."""
    lines = [
        Line(
            f"{one.compared} - {one.against}",
            (
                str(one.agreement.n_epochs),
                _signed(one.agreement.mean_east, one.height_m),
                _signed(one.agreement.mean_north, one.height_m),
                number(one.agreement.scatter, 2, 1e3 * one.height_m),
                number(one.agreement.sigma, 2, 1e3 * one.height_m),
            ),
        )
        for one in found
    ]
    columns = ("epochs", "mean east", "mean north", "scatter", "stated sigma")
    return grid("Over the epochs (mm, one component)", columns, lines) if lines else []


def _of_best(best: SchemeComparisonRow) -> Iterator[str]:
    if best.method == SURFACE:
        yield f"{best.compared} uses all points: nothing is gained by slicing less"
    if best.sigma_m is not None and best.point_sigma_m is not None:
        poses_m = math.sqrt(max(best.sigma_m**2 - best.point_sigma_m**2, 0.0))
        yield (
            f"{best.compared} has the smallest sigma, {1e3 * best.sigma_m:.2f} mm at {best.height_m:g} m: "
            f"{1e3 * best.point_sigma_m:.2f} mm from its points, {1e3 * poses_m:.2f} mm from levelling and registration, "
            "which more points do not change"
        )


def _of_chosen(chosen: SchemeComparisonRow | None, best: SchemeComparisonRow) -> Iterator[str]:
    if chosen is None:
        yield f"recommendation: {best.compared}; no sliced scheme comes up to it"
    else:
        yield f"recommendation: {chosen.n_slices} slices ({chosen.compared}) are enough here: {chosen.reason}"


def _of_fewer(schemes: Sequence[SchemeComparisonRow], chosen: SchemeComparisonRow | None) -> Iterator[str]:
    """Say why fewer slices by the chosen method are not enough; without a choice, why the nearest scheme is not."""
    if chosen is not None and chosen.n_slices is not None:
        fewer = [row for row in schemes if row.method == chosen.method and not row.is_enough]
        for row in fewer:
            if row.n_slices is not None and row.n_slices < chosen.n_slices:
                yield f"- not enough: {row.n_slices} slices ({row.compared}): {row.reason}"
        return
    sliced = [row for row in schemes if row.method != SURFACE and row.excess_pct is not None]
    if sliced:
        nearest = min(sliced, key=lambda row: row.excess_pct or 0.0)
        yield f"- the nearest: {nearest.n_slices} slices ({nearest.compared}): {nearest.reason}"


def _signed(lean: float | None, height_m: float) -> str:
    return NO_VALUE if lean is None else f"{1e3 * height_m * lean:+.2f}"


def _count(value: int | None) -> str:
    return NO_VALUE if value is None else f"{value:,}"


def _yes_or_no(value: bool | None) -> str:
    return NO_VALUE if value is None else "yes" if value else "no"
