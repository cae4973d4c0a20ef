"""All points of a shaft summed up in cells of its surface: a station, a height, a direction.

Within a cell the derivatives of the surface hardly change (5 degrees, a fraction of a knot interval), so the normal
equations of millions of points are those of their cells. Points are read in chunks and never held twice.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.side_by_side import side_by_side
from tasks.surface.profile import ProfileTable

SECTORS: Final = 72
"""Cells around the shaft: 5 degrees each."""

TUKEY_CUT: Final = 6.0
"""Cut of Tukey's biweight in sigmas: efficiency 0.98 at normal noise, and nothing beyond 6 sigma counts."""


LEAST_PRICE: Final = 0.1
"""Points without noise have the smallest noise that is counted with, and no information without bounds."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfacePoints:
    """Points (n, 3) of the isolated shaft, site frame, metres, and the station (n,) that saw each, from 0."""

    points_m: NDArray[np.float64]
    station_index: NDArray[np.uint16]
    n_stations: int


@dataclass(frozen=True, slots=True)
class Grid:
    """Cells over the shaft: ``n_heights`` from ``low_m``, each ``step_m`` tall, and ``SECTORS`` around."""

    low_m: float
    step_m: float
    n_heights: int

    def size(self, n_stations: int) -> int:
        """Number of cells."""
        return n_stations * self.n_heights * SECTORS


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Sums of the points of each cell that holds any.

    Attributes
    ----------
    station, height, sector : (c,) arrays
        Which cell it is.
    z_m, foot_m : (c,) arrays
        Weighted mean height, and that of the axis from which distances are counted, metres.
    direction : (c,) complex array
        Weighted mean of cos t + i sin t.
    n_points, n_used : (c,) arrays
        Points in the cell, and those with a weight above zero.
    weight : (c,) array
        Sum of the robust weights over the variances, 1/m2.
    residual_m : (c,) array
        Weighted mean residual, metres.
    square_m2 : (c,) array
        Sum of the squared residuals of the points used, square metres.
    influence, slope : floats
        Mean over all points of the squared influence and of the slope of the influence, in sigmas: the robust
        covariance is influence / slope^2 times that of least squares.
    mean_weight : float
        Mean robust weight.
    """

    station: NDArray[np.intp]
    height: NDArray[np.intp]
    sector: NDArray[np.intp]
    z_m: NDArray[np.float64]
    foot_m: NDArray[np.float64]
    direction: NDArray[np.complex128]
    n_points: NDArray[np.float64]
    n_used: NDArray[np.float64]
    weight: NDArray[np.float64]
    residual_m: NDArray[np.float64]
    square_m2: NDArray[np.float64]
    influence: float
    slope: float
    mean_weight: float

    @property
    def robust_price(self) -> float:
        """Variance per unit of ``weight``: 1 for least squares, a little more for what robustness costs."""
        return max(self.mean_weight * self.influence / self.slope**2, LEAST_PRICE)

    def moved(self, change_m: NDArray[np.float64]) -> "Cells":
        """The cells after the surface moved by (c,) under them, far less than the noise."""
        return Cells(
            self.station,
            self.height,
            self.sector,
            self.z_m,
            self.foot_m,
            self.direction,
            self.n_points,
            self.n_used,
            self.weight,
            self.residual_m - change_m,
            self.square_m2,
            self.influence,
            self.slope,
            self.mean_weight,
        )


PARTS: Final = 4
"""Into which the points are cut, however many threads there are: the order of the sums does not depend on the machine."""


def sum_cells(cloud: SurfacePoints, table: ProfileTable, grid: Grid, sigma_m: NDArray[np.float64]) -> Cells:
    """Look at all points and sum them up.

    Parameters
    ----------
    cloud : SurfacePoints
        The points.
    table : ProfileTable
        The surface as it is.
    grid : Grid
        The cells.
    sigma_m : (stations, SECTORS) array
        Noise of the points of each station in each direction, metres.
    """
    ends = np.linspace(0, len(cloud.points_m), PARTS + 1).astype(np.intp)

    def of_part(number: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return _sum_part(cloud, slice(ends[number], ends[number + 1]), table, grid, sigma_m)

    parts = side_by_side(of_part, range(PARTS))
    total = np.sum([sums for sums, _ in parts], axis=0)
    moments = np.sum([of for _, of in parts], axis=0)
    return _cells_of(total.T, moments / max(len(cloud.points_m), 1), grid)


def sector_of(direction: NDArray[np.complex128]) -> NDArray[np.intp]:
    """Sector (n,) of directions (n,), counterclockwise from east."""
    turn = np.arctan2(direction.imag, direction.real) * (SECTORS / (2.0 * np.pi))
    return np.asarray(np.floor(turn).astype(np.intp) % SECTORS)


def _sum_part(
    cloud: SurfacePoints, rows: slice, table: ProfileTable, grid: Grid, sigma_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    from tasks.surface.cell_kernel import MOMENTS, SUMS, add_points  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    sums, moments = np.zeros((grid.size(cloud.n_stations), SUMS)), np.zeros(MOMENTS)
    add_points(
        cloud.points_m[rows],
        cloud.station_index[rows],
        table.origin_m,
        table.rows,
        np.stack([table.harmonics.real.T, table.harmonics.imag.T], axis=1),
        (table.low_m, table.step_m),
        table.across,
        (grid.low_m, grid.step_m, grid.n_heights, sigma_m),
        TUKEY_CUT,
        sums,
        moments,
    )
    return sums, moments


def _cells_of(total: NDArray[np.float64], moments: NDArray[np.float64], grid: Grid) -> Cells:
    """Cells in which any point counts, and the other ones' points left out."""
    held = np.flatnonzero(total[2] > 0.0)
    n_points, n_used, weight, wr, wc, ws, wz, wf, square, _ = total[:, held]
    return Cells(
        station=held // (grid.n_heights * SECTORS),
        height=held // SECTORS % grid.n_heights,
        sector=held % SECTORS,
        z_m=wz / weight,
        foot_m=wf / weight,
        direction=(wc + 1j * ws) / weight,
        n_points=n_points,
        n_used=n_used,
        weight=weight,
        residual_m=wr / weight,
        square_m2=square,
        influence=float(moments[0]),
        slope=float(moments[1]),
        mean_weight=float(moments[2]),
    )
