"""A slice as the contour models get it, and what they make of it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.contours.outline import Outline
from tasks.geometry.failure import FitFailure

STRAIGHT: Final = 1e-6
"""Width over length of a set of points below which it counts as a line (a 0.01 degree arc has 4e-5)."""


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """The points of one slice, with the rough shape of the shaft around it.

    Attributes
    ----------
    points_m : (n, 3) array
        Points of the slice, site frame, metres.
    z_m : float
        Height the centre refers to, metres.
    thickness_m : float
        Height of the slice, metres.
    taper : float
        dR/dz of the shaft here, dimensionless, negative where it narrows upward.
    lean_east, lean_north : float
        Rough lean vector of the shaft here, to straighten the slice.
    sigma_m : (n,) array or None
        Standard deviation of each point across the surface as instrument and line of sight give it, metres; None where
        the stations of the points are not known. Only ratios of it matter.
    outline : Outline or None
        The faces of a shaft that has plane ones; None for a round shaft, or where nothing is known of them.
    """

    points_m: NDArray[np.float64]
    z_m: float
    thickness_m: float
    taper: float = 0.0
    lean_east: float = 0.0
    lean_north: float = 0.0
    sigma_m: NDArray[np.float64] | None = None
    outline: Outline | None = None

    def __post_init__(self) -> None:
        if self.points_m.ndim != 2 or self.points_m.shape[1] != 3:
            raise ShapeError(f"Section needs points (n, 3), got {self.points_m.shape}")
        if self.sigma_m is not None and self.sigma_m.shape != (len(self.points_m),):
            raise ShapeError(
                f"Section needs sigmas (n,) of {len(self.points_m)} points, got {self.sigma_m.shape}"
            )

    def unfit_for(self, min_points: int) -> FitFailure | None:
        """Say why no circle can be fitted, or None if one can be tried."""
        n = len(self.points_m)
        if n < min_points:
            return FitFailure(f"needs at least {min_points} points, got {n}")
        if not np.isfinite(self.points_m).all():
            bad = n - int(np.isfinite(self.points_m).all(axis=1).sum())
            return FitFailure(f"needs finite coordinates, got {bad} points without")
        xy = self.points_m[:, :2] - self.points_m[0, :2]
        xy = xy - xy.mean(axis=0)
        narrow, wide = np.sqrt(np.maximum(np.linalg.eigvalsh(xy.T @ xy / n), 0.0))
        # what float64 leaves of a difference of coordinates, with room for rounding in the reader
        resolution = 8 * np.finfo(float).eps * float(np.abs(self.points_m[:, :2]).max())
        if wide <= resolution:
            return FitFailure(f"needs points around a contour, got {n} at one place")
        if narrow <= max(STRAIGHT * wide, resolution):
            return FitFailure(f"needs points around a contour, got {n} on one line")
        return None


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """A contour that was fitted.

    Attributes
    ----------
    center_east_m, center_north_m : float
        Centre at the height ``Section.z_m``, site frame, metres.
    radius_m : float
        Radius; the mean distance of the vertices for a vertex mean, metres.
    covariance_m2 : (2, 2) array
        Covariance of (east, north) of the centre from the scatter of the points alone, square metres.
    rmse_m : float
        Root mean square distance of the points used from the contour, metres.
    n_used : int
        Points with a weight above zero.
    arc_coverage_deg : float
        Sectors of 5 degrees that hold a used point, degrees.
    noise_m : float or None
        Robust standard deviation of the points about the contour, metres.
    roundness_m : float or None
        Largest minus smallest radius of the fitted contour about its centre, metres; None for a circle, which has none.
    ovality_m, ovality_azimuth_deg : float or None
        Amplitude of the second harmonic of the radius (an ellipse: half of a - b), metres, and the
        azimuth in [0, 180) of its larger diameter, clockwise from grid north; None for a circle.
    model : str
        The contour model, where the variant chose among several; "" where it is the variant itself.
    reason : str or None
        Why that model was chosen.
    """

    center_east_m: float
    center_north_m: float
    radius_m: float
    covariance_m2: NDArray[np.float64]
    rmse_m: float
    n_used: int
    arc_coverage_deg: float
    noise_m: float | None = None
    roundness_m: float | None = None
    ovality_m: float | None = None
    ovality_azimuth_deg: float | None = None
    model: str = ""
    reason: str | None = None
