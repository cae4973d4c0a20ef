"""Contour model ``gap_filled``: gaps of the outline are filled with generated points, its area centroid is the centre."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import SECTOR_DEG, Circle, arc_coverage_deg
from tasks.contours.circle_fit import circle_noise_m
from tasks.contours.circle_start import order_along_contour
from tasks.contours.geometric_circle import least_squares_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import StraightSection, straighten
from tasks.geometry.failure import FitFailure

SECTORS: Final = int(360.0 / SECTOR_DEG)
"""Corners of the outline."""

PARAMETERS: Final = 5
"""Of the radius that fills gaps: a mean and two harmonics, i.e. a shift and an ovality."""

MIN_POINTS: Final = 12
"""Twice the parameters, and something left for the noise."""

LEAST_SECTORS: Final = 8
"""Sectors with points: more than the parameters of the curve."""

WIDEST_GAP_DEG: Final = 120.0
"""A wider gap is no gap: what fills it would decide where the centre is."""


@dataclass(frozen=True, slots=True, eq=False)
class ClosedOutline:
    """A closed outline about a first circle.

    Attributes
    ----------
    circle : Circle
        The first circle, about the section's origin.
    corner_rad : (SECTORS,) array
        Directions of the corners from its centre.
    point_rad : (n,) array
        Directions of the points.
    sector : (n,) int array
        Sector of each point.
    counts : (SECTORS,) int array
        Points of each sector; a corner with none is generated.
    curve : (5,) array
        Mean, cosine and sine of the first and of the second harmonic of the filling curve above the circle, metres.
    residuals_m : (n,) array
        What the filling curve leaves of the points, metres.
    """

    circle: Circle
    corner_rad: NDArray[np.float64]
    point_rad: NDArray[np.float64]
    sector: NDArray[np.intp]
    counts: NDArray[np.intp]
    curve: NDArray[np.float64]
    residuals_m: NDArray[np.float64]

    @property
    def steps_m(self) -> NDArray[np.float64]:
        """Mean residual (SECTORS,) of the sectors, 0 where a sector is empty, metres."""
        total = np.bincount(self.sector, self.residuals_m, minlength=SECTORS)
        return np.asarray(total / np.maximum(self.counts, 1))

    @property
    def radii_m(self) -> NDArray[np.float64]:
        """Distances (SECTORS,) of the corners from the centre of the first circle, metres."""
        return np.asarray(self.circle.radius_m + _harmonics(self.corner_rad) @ self.curve + self.steps_m)


def fit_gap_filled(section: Section) -> Contour | FitFailure:
    """Close the outline of a slice over its gaps and take the centroid of its area as centre.

    Lean and taper within the slice are taken out first. About the circle of least squared distances the outline has a
    corner in every sector of 5 degrees: the radius of a smooth curve (two harmonics, least squares) plus the mean
    deviation of the sector's points from it. Where a sector has no points the curve alone makes the corner. Not robust.

    The centroid is the first harmonic of the radius, so it is linear in the points. The covariance carries their
    noise, n - 5 degrees of freedom, through curve, sectors and centroid; it adds for every gap the unevenness of the
    outline that the sectors show beyond their noise, as if it moved the whole gap in or out. An outline whose gaps
    hide what its seen part does not show is worse than stated.

    References
    ----------
    Kurdi et al., reference [37] of Zhou et al. 2025, as told there: cross sections of rotational buildings with the
    gaps of the point cloud filled. The curve that fills and the covariance are ours.
    """
    straight = straighten(section)
    circle = least_squares_circle(straight)
    if isinstance(circle, FitFailure):
        return circle
    outline = _outline(straight, circle)
    return outline if isinstance(outline, FitFailure) else _contour(straight, outline)


def _outline(straight: StraightSection, circle: Circle) -> ClosedOutline | FitFailure:
    east, north = (straight.xy_m - [circle.east_m, circle.north_m]).T
    angle = np.arctan2(north, east)
    order = order_along_contour(straight, circle)
    first, last = angle[order[0]], angle[order[-1]]
    # sectors counted from the middle of the widest gap turn with the points
    zero = last + (first - last) % (2 * np.pi) / 2
    sector = np.minimum(((angle - zero) % (2 * np.pi) / np.radians(SECTOR_DEG)).astype(np.intp), SECTORS - 1)
    counts = np.bincount(sector, minlength=SECTORS)
    unfit = _too_open(counts)
    if unfit is not None:
        return unfit
    deviation = straight.residuals(circle)
    shapes = _harmonics(angle)
    curve = np.asarray(np.linalg.lstsq(shapes, deviation, rcond=None)[0], dtype=np.float64)
    corners = zero + np.radians(SECTOR_DEG) * (np.arange(SECTORS) + 0.5)
    return ClosedOutline(circle, corners, angle, sector, counts, curve, deviation - shapes @ curve)


def _too_open(counts: NDArray[np.intp]) -> FitFailure | None:
    seen = int(np.count_nonzero(counts))
    if seen < LEAST_SECTORS:
        return FitFailure(f"needs points in {LEAST_SECTORS} sectors of {SECTOR_DEG:g} deg, got {seen}")
    gap_deg = SECTOR_DEG * max((len(gap) for gap in _gaps(counts)), default=0)
    if gap_deg <= WIDEST_GAP_DEG:
        return None
    return FitFailure(
        f"needs an outline without a gap wider than {WIDEST_GAP_DEG:g} deg, got one of {gap_deg:g} deg"
    )


def _gaps(counts: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Runs of empty sectors round the outline, at least one sector being occupied."""
    empty = counts == 0
    around = np.roll(np.arange(SECTORS), -int(np.argmin(empty)))
    runs = np.split(around, np.flatnonzero(np.diff(empty[around])) + 1)
    return [run for run in runs if empty[run[0]]]


def _harmonics(angle_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean and two harmonics (n, 5) in directions (n,)."""
    one, two = angle_rad, 2 * angle_rad
    return np.column_stack([np.ones_like(one), np.cos(one), np.sin(one), np.cos(two), np.sin(two)])


def _contour(straight: StraightSection, outline: ClosedOutline) -> Contour | FitFailure:
    radii = outline.radii_m
    if radii.min() <= 0.0:
        return FitFailure("needs an outline about a centre, got one that reaches it")
    corners = radii[:, None] * np.column_stack([np.cos(outline.corner_rad), np.sin(outline.corner_rad)])
    center = np.array([outline.circle.east_m, outline.circle.north_m]) + _area_centroid(corners)
    _, _, _, cosine, sine = outline.curve
    circle = Circle(float(center[0]), float(center[1]), float(radii.mean()))
    return Contour(
        center_east_m=float(straight.origin_m[0] + center[0]),
        center_north_m=float(straight.origin_m[1] + center[1]),
        radius_m=circle.radius_m,
        covariance_m2=_covariance(outline),
        rmse_m=float(np.sqrt(np.mean(outline.residuals_m**2))),
        n_used=len(outline.residuals_m),
        arc_coverage_deg=arc_coverage_deg(straight.xy_m, circle),
        noise_m=circle_noise_m(outline.residuals_m),
        roundness_m=2 * float(np.hypot(cosine, sine)),
        ovality_m=float(np.hypot(cosine, sine)),
        ovality_azimuth_deg=float((90.0 - np.degrees(np.arctan2(sine, cosine)) / 2) % 180.0),
    )


def _area_centroid(corners_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centroid (2,) of the area of a closed polygon (k, 2)."""
    following = np.roll(corners_m, -1, axis=0)
    cross = corners_m[:, 0] * following[:, 1] - following[:, 0] * corners_m[:, 1]
    return np.asarray(cross @ (corners_m + following) / (3 * cross.sum()))


def _covariance(outline: ClosedOutline) -> NDArray[np.float64]:
    """Covariance (2, 2) of the centroid, square metres: noise of the points and unevenness hidden in the gaps."""
    # first order: the centroid is twice the mean of radius times direction
    weights = 2 / SECTORS * np.vstack([np.cos(outline.corner_rad), np.sin(outline.corner_rad)])
    shapes = _harmonics(outline.point_rad)
    steps = weights[:, outline.sector] / outline.counts[outline.sector]
    curve = (weights @ _harmonics(outline.corner_rad) - steps @ shapes) @ np.linalg.pinv(shapes)
    per_point = steps + curve
    variance = float(outline.residuals_m @ outline.residuals_m) / (len(shapes) - PARAMETERS)
    moved = np.array([weights[:, gap].sum(axis=1) for gap in _gaps(outline.counts)]).reshape(-1, 2)
    return np.asarray(
        variance * per_point @ per_point.T + _unevenness_m2(outline, variance) * moved.T @ moved
    )


def _unevenness_m2(outline: ClosedOutline, variance_m2: float) -> float:
    """Variance of the sectors' mean residuals beyond the noise of the points, square metres; 0 where there is none."""
    seen = outline.counts > 0
    n, sectors = len(outline.residuals_m), int(seen.sum())
    within = outline.residuals_m - outline.steps_m[outline.sector]
    # the scatter within sectors knows nothing of the shape; few points leave only the scatter of all
    noise = float(within @ within) / (n - sectors) if n >= 2 * sectors else variance_m2
    excess = float(np.sum(outline.steps_m[seen] ** 2 - noise / outline.counts[seen]))
    return max(excess, 0.0) / (sectors - PARAMETERS)


CONTOUR: Final = ContourModel(
    "gap_filled",
    "area centroid of the outline with its gaps filled (ref. 37 of the paper)",
    min_points=MIN_POINTS,
    fit=fit_gap_filled,
)
