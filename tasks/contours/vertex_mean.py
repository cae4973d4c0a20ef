"""Contour model ``vertex_mean``: the control of the paper (scheme F), a mean of contour vertices."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from skimage.measure import find_contours

from tasks.contours.circle import Circle, arc_coverage_deg, center_distances
from tasks.contours.circle_start import taubin_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.geometry.failure import FitFailure

MIN_POINTS: Final = 8
"""Fewer points make no outline."""

FINEST: Final = 500.0
"""Cells are not smaller than the half extent of the slice over this number: the raster stays below 1,000 x 1,000."""

COARSEST: Final = 25.0
"""Cells are not larger than the half extent of the slice over this number: the ring stays a ring."""


INSIDE: Final = 1.0 - 1e-9
"""Where the cell follows from the extent, the farthest point lies on the edge of two: rounding must not choose."""


def fit_vertex_mean(section: Section) -> Contour | FitFailure:
    """Outline the slice's points by marching squares and take the mean of the vertices as centre.

    Raster: square cells, 1 where a point lies, else 0; the cell is the median distance of a point to its nearest
    neighbour, within 1/500 and 1/25 of the half extent of the slice. Points further apart than a cell are outlined one
    by one. Level 0.5; inner outlines of holes are left out, all outer outlines are kept.

    The covariance is R^2 / (2 n) for each component, n the cells that hold points: the sampling scatter of a mean of n
    independent places on a ring. A density 1 + kappa cos(theta) of sparse points shifts the mean by kappa R / 2, a gap of
    half-width g by -R sin g / (pi - g) (docs/estimators.md): decimetres in practice. The value keeps that bias, as the
    control method has it; the covariance owns up to it by b b', b the distance of the mean from the centre of a circle
    through the same points. The radius is the mean distance of the vertices, about half a cell too large.

    References
    ----------
    Zhou et al. 2025, section 4.1, scheme F after its reference [9]; Lorensen & Cline 1987.
    """
    xy = section.points_m[:, :2]
    low = xy.min(axis=0)
    local = xy - low
    cell = _cell_size(local)
    raster = _raster(local, cell)
    # index 0 of the padded raster is one cell below the first, and a cell's value stands in its middle
    vertices = (_outer_vertices(raster) - 0.5) * cell
    if len(vertices) < 3:
        return FitFailure(f"needs an outline of at least 3 vertices, got {len(vertices)}")
    center = vertices.mean(axis=0)
    distances = center_distances(vertices, Circle(float(center[0]), float(center[1]), 0.0))
    circle = Circle(float(center[0]), float(center[1]), float(distances.mean()))
    round_one = taubin_circle(local)
    if isinstance(round_one, FitFailure):
        return round_one
    bias = np.array([circle.east_m - round_one.east_m, circle.north_m - round_one.north_m])
    scatter = circle.radius_m**2 / (2 * np.count_nonzero(raster))
    return Contour(
        center_east_m=float(low[0] + circle.east_m),
        center_north_m=float(low[1] + circle.north_m),
        radius_m=circle.radius_m,
        covariance_m2=scatter * np.eye(2) + np.outer(bias, bias),
        rmse_m=float(np.std(distances)),
        n_used=len(local),
        arc_coverage_deg=arc_coverage_deg(local, circle),
    )


def _cell_size(xy: NDArray[np.float64]) -> float:
    from scipy.spatial import KDTree  # noqa: PLC0415 (slow to import, and every command reads settings)

    half_extent = float(xy.max()) / 2
    nearest = KDTree(xy).query(xy, k=2)[0][:, 1]
    return float(np.clip(np.median(nearest), half_extent / FINEST, half_extent / COARSEST))


def _raster(xy: NDArray[np.float64], cell: float) -> NDArray[np.float64]:
    """Occupied cells as ones, with an empty margin so that every outline closes."""
    index = np.floor(xy / cell * INSIDE).astype(np.intp) + 1
    raster = np.zeros(index.max(axis=0) + 2)
    raster[index[:, 0], index[:, 1]] = 1.0
    return raster


def _outer_vertices(raster: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vertices (k, 2) of the outlines around occupied cells, in cells; those around holes run the other way."""
    outlines = [outline[:-1] for outline in find_contours(raster, 0.5)]  # type: ignore[no-untyped-call]
    outer = [outline for outline in outlines if _turns(outline) < 0.0]
    return np.vstack(outer) if outer else np.empty((0, 2))


def _turns(outline: NDArray[np.float64]) -> float:
    """Twice the signed area of a closed polygon (k, 2); its sign tells which way it runs."""
    first, second = outline.T
    return float(first @ np.roll(second, -1) - second @ np.roll(first, -1))


CONTOUR: Final = ContourModel(
    "vertex_mean",
    "mean of marching-squares vertices (scheme F, a control only)",
    min_points=MIN_POINTS,
    fit=fit_vertex_mean,
)
