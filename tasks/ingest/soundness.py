"""Whether the numbers of a scan are possible, and fine enough for a lean of millimetres."""

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.scan import Bounds, box_of

LONGEST_EXTENT_M: Final = 10_000.0
"""No terrestrial scanner reaches farther; what is larger is in another unit, or not such a scan."""

COARSE_STEP_M: Final = 0.002
"""A coordinate grid that adds visibly to a scanner's noise of some millimetres."""

HOPELESS_STEP_M: Final = 0.05
"""A coordinate grid on which a lean of millimetres cannot be seen."""

LARGEST_NUMBER: Final = 1e12
"""Beyond any coordinate on earth in any unit; keeps the arithmetic below from overflowing."""

SAMPLE_POINTS: Final = 100_000
"""Enough for quantiles and for the smallest step, whatever the size of the cloud."""

FEWEST_FOR_STEP: Final = 1000
"""With fewer points a gap between neighbours says nothing about a grid."""

FEWEST_DISTINCT: Final = 10
"""Fewer distinct values may be walls that run along an axis."""

WHOLE: Final = 0.01
"""A number is whole within this."""

MOST: Final = 0.99
"""This share of all gaps must be whole steps, or there is no grid."""

SMALLEST_STEP_M: Final = 1e-7
"""Smaller gaps are rounding."""


def check_finite(path: Path, values: NDArray[np.float64]) -> None:
    """Refuse records (n, 3) that are not all finite, or too large for any coordinate.

    Raises
    ------
    InputError
        With the number of records that are not.
    """
    box = box_of(values)
    if is_possible(box):
        return
    check_possible(path, box, len(values), count_not_finite(values))


def is_possible(box: Bounds) -> bool:
    """Whether the numbers in a box can be coordinates."""
    return bool(box.low.min() > -LARGEST_NUMBER and box.high.max() < LARGEST_NUMBER)


def count_not_finite(values: NDArray[np.float64]) -> int:
    """Count the records (n, 3) with NaN or infinity."""
    return int(np.count_nonzero(~np.isfinite(values).all(axis=1)))


def check_possible(path: Path, box: Bounds, n_points: int, n_bad: int) -> None:
    """Refuse records by the box around them, and how many of them are not finite.

    Raises
    ------
    InputError
        With that number, or with the box.
    """
    if is_possible(box):
        return
    low, high = float(box.low.min()), float(box.high.max())
    if n_bad:
        raise InputError(
            f"{path}: needs finite coordinates, came {n_bad} of {n_points} points with NaN or infinity; "
            "remove those points, or export again without points that have no return"
        )
    raise InputError(
        f"{path}: needs coordinates in metres, came numbers from {low:.3g} to {high:.3g}; "
        "the file is damaged or in another format, export it again"
    )


def without_empty_returns(
    path: Path, values: NDArray[np.float64], is_empty: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Records (n, 3) without those (n,) that stand for a beam without a return, and a note that counts them.

    Raises
    ------
    InputError
        If none is left.
    """
    n_empty = int(np.count_nonzero(is_empty))
    notes = note_empty_returns(path, n_empty, len(values))
    return (values[~is_empty] if n_empty else values), notes


def note_empty_returns(path: Path, n_empty: int, n_points: int) -> tuple[str, ...]:
    """Count the records that stand for a beam without a return.

    Raises
    ------
    InputError
        If all do.
    """
    if n_empty == 0:
        return ()
    if n_empty == n_points:
        raise InputError(
            f"{path}: needs points, came {n_empty} that all lie at (0, 0, 0); export again, in double precision"
        )
    return (f"{n_empty} of {n_points} records lie at (0, 0, 0): beams without a return, left out",)


def check_extent(path: Path, points_m: NDArray[np.float64]) -> tuple[str, ...]:
    """Notes on the place and size of a cloud (n, 3).

    Raises
    ------
    InputError
        If all points coincide, or 98 % of them fill more than a scanner can reach.
    """
    check_apart(path, box_of(points_m), len(points_m))
    return check_bulk(path, points_m)


def check_apart(path: Path, box: Bounds, n_points: int) -> None:
    """Refuse points that all lie at one place.

    Raises
    ------
    InputError
        If their box is a point.
    """
    if n_points > 1 and np.all(box.low == box.high):
        raise InputError(
            f"{path}: needs points at different places, came {n_points} that all lie at "
            f"({box.low[0]:g}, {box.low[1]:g}, {box.low[2]:g}); export again, in double precision"
        )


def check_bulk(path: Path, points_m: NDArray[np.float64]) -> tuple[str, ...]:
    """Notes on the place and size of a cloud, of which points (n, 3) may be an even sample.

    Raises
    ------
    InputError
        If 98 % of them fill more than a scanner can reach.
    """
    bulk = np.quantile(_sample(points_m), (0.01, 0.99), axis=0)
    extent_m = float((bulk[1] - bulk[0]).max())
    if extent_m > LONGEST_EXTENT_M:
        raise InputError(
            f"{path}: needs a cloud in metres of at most {LONGEST_EXTENT_M / 1000:g} km, came an extent of "
            f"{extent_m:.4g}; export it in metres (millimetres?), or crop it to the surroundings of the structure"
        )
    distance_m = float(np.linalg.norm(bulk.mean(axis=0)))
    if distance_m > LONGEST_EXTENT_M:
        return (
            f"the points lie {distance_m / 1000:.4g} km from the origin: is origin_m of the campaign file right?",
        )
    return ()


def check_step(path: Path, points_m: NDArray[np.float64], stored_step_m: float | None) -> tuple[str, ...]:
    """Notes on the grid on which the coordinates lie.

    Parameters
    ----------
    points_m : (n, 3) array
        Before the origin is subtracted: a grid shows in the numbers as stored.
    stored_step_m : float or None
        What the file itself says: the scale factor of a LAS file.

    Raises
    ------
    InputError
        If the grid is coarser than 5 cm.
    """
    step_m = max(stored_step_m or 0.0, horizontal_step(points_m))
    if step_m > HOPELESS_STEP_M:
        raise InputError(
            f"{path}: needs coordinates finer than {HOPELESS_STEP_M * 1000:g} mm, came steps of {step_m * 1000:.3g} mm; "
            "export again in double precision, or with a scale factor of 0.0001"
        )
    if step_m > COARSE_STEP_M:
        return (f"coordinates come in steps of {step_m * 1000:.3g} mm: export with a scale factor of 0.0001",)
    return ()


def horizontal_step(points_m: NDArray[np.float64]) -> float:
    """Coarser of the grids of x and of y, 0 if the points (n, 3) show none.

    Single precision far from the origin gives itself away by this, too. Heights may be on a grid by design.
    """
    sample = _sample(points_m)
    if len(sample) < FEWEST_FOR_STEP:
        return 0.0
    return max(_grid_step(sample[:, 0]), _grid_step(sample[:, 1]))


def _grid_step(values: NDArray[np.float64]) -> float:
    distinct = np.unique(values)
    if len(distinct) < FEWEST_DISTINCT:
        return 0.0
    gaps = np.diff(distinct)
    gaps = gaps[gaps > SMALLEST_STEP_M]
    if len(gaps) == 0:
        return 0.0
    in_steps = gaps / gaps.min()
    is_grid = np.mean(np.abs(in_steps - np.round(in_steps)) < WHOLE) > MOST
    return float(gaps.min()) if is_grid else 0.0


def _sample(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return points_m[:: sample_step(len(points_m), SAMPLE_POINTS)]


def sample_step(n_points: int, sample: int) -> int:
    """Every so many of ``n_points`` points are a sample of ``sample`` points, and fewer than twice as many."""
    return max(1, n_points // sample)
