"""How points are spread around each other: covariances of nearest neighbours, and their axes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Spread:
    """How the neighbours of k points lie.

    ``enough`` (k,) says which have enough of them; all else is of those only, m: ``count`` (m,) of neighbours, the point
    itself with them; ``values`` (m, 3), ascending, and ``vectors`` (m, 3, 3), in columns, of the sums of squares about
    their mean, m2. The sign of a vector means nothing.
    """

    enough: NDArray[np.bool_]
    count: NDArray[np.int64]
    values: NDArray[np.float64]
    vectors: NDArray[np.float64]


def spread_of_neighbours(
    points_m: NDArray[np.float64], at: NDArray[np.int64], radius_m: float, few: tuple[int, int]
) -> Spread:
    """Spread of the nearest points (n, 3) around those at some indices (k,), nearer than a radius.

    ``few`` are the least and the most neighbours that count.

    Raises
    ------
    OverflowError
        If the cloud spans more than 2**21 radii along an axis.
    """
    from tasks.geometry.eigen_kernel import eigen_of  # noqa: PLC0415 (slow to import)
    from tasks.geometry.neighbour_kernel import sort_into_cubes, squares_around  # noqa: PLC0415 (slow to import)
    from tasks.geometry.voxel_kernel import AXIS_BITS, bounds  # noqa: PLC0415 (slow to import)

    points_m = np.ascontiguousarray(points_m)
    low_m, high_m = bounds(points_m)
    if not np.max(high_m - low_m) / radius_m + 3.0 <= 2**AXIS_BITS:
        raise OverflowError(f"a cloud of {np.max(high_m - low_m):.0f} m does not fit a grid of {radius_m} m")
    shape = np.floor((high_m - low_m) / radius_m).astype(np.int64) + 3
    cubes = sort_into_cubes(points_m, low_m, radius_m, shape)
    row_of = np.full(len(points_m), -1, np.int64)
    row_of[at] = np.arange(len(at))
    count, squares = squares_around(points_m, row_of, radius_m, few, cubes, shape)
    enough = count >= few[0]
    return Spread(enough, count[enough], *eigen_of(squares[enough]))
