"""From an adjusted circle to a contour with an honest covariance."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle, arc_coverage_deg
from tasks.contours.circle_adjustment import used_normal
from tasks.contours.section import Contour
from tasks.contours.straightening import StraightSection
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import mad_sigma

LOOSEST_CENTRE: Final = 0.25
"""A centre less certain than this part of the radius is no centre: linear error laws end there."""


@dataclass(frozen=True, slots=True, eq=False)
class Scatter:
    """How the residuals of a fit scatter.

    Attributes
    ----------
    used : (n,) bool array
        Points with a weight above zero.
    variance_m2 : float
        Variance per point that goes with the normal matrix of the used points, square metres.
    rmse_m : float
        Root mean square residual of the used points, metres.
    noise_m : float
        Robust standard deviation of all points about the circle, metres.
    relative_sigma : (n,) array or None
        Sigma of each point over the one that ``variance_m2`` is of; None where all points have the same.
    """

    used: NDArray[np.bool_]
    variance_m2: float
    rmse_m: float
    noise_m: float
    relative_sigma: NDArray[np.float64] | None = None


def circle_noise_m(residuals_m: NDArray[np.float64]) -> float:
    """Robust standard deviation of points from their residuals (n,) at a fitted circle, n > 3, metres.

    A median absolute residual, freed of what three parameters absorb.
    """
    n = len(residuals_m)
    return mad_sigma(residuals_m) * float(np.sqrt(n / (n - 3)))


def scatter_of_all(residuals_m: NDArray[np.float64]) -> Scatter:
    """The scatter of a fit to all points alike, from its residuals (n,), n > 3."""
    n = len(residuals_m)
    total = float(residuals_m @ residuals_m)
    return Scatter(
        used=np.ones(n, dtype=np.bool_),
        variance_m2=total / (n - 3),
        rmse_m=float(np.sqrt(total / n)),
        noise_m=circle_noise_m(residuals_m),
    )


def contour_of(section: StraightSection, circle: Circle, scatter: Scatter) -> Contour | FitFailure:
    """Make a contour of a circle that was adjusted, or say that the arc is too short for a centre."""
    used_xy = section.xy_m[scatter.used]
    coverage = arc_coverage_deg(used_xy, circle)
    normal = used_normal(section, circle, scatter.used, scatter.relative_sigma)
    if np.linalg.cond(normal) > 1 / np.finfo(float).eps:
        return FitFailure(f"arc too short for a centre: {coverage:g} deg of the circumference have points")
    covariance = np.asarray(scatter.variance_m2 * np.linalg.inv(normal)[:2, :2], dtype=np.float64)
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    if sigma > LOOSEST_CENTRE * circle.radius_m:
        return FitFailure(
            f"arc too short for a centre: {coverage:g} deg of the circumference have points, which fixes the centre "
            f"to {sigma:.3g} m at a radius of {circle.radius_m:.3g} m"
        )
    return Contour(
        center_east_m=float(section.origin_m[0] + circle.east_m),
        center_north_m=float(section.origin_m[1] + circle.north_m),
        radius_m=circle.radius_m,
        covariance_m2=covariance,
        rmse_m=scatter.rmse_m,
        n_used=int(scatter.used.sum()),
        arc_coverage_deg=coverage,
        noise_m=scatter.noise_m,
    )
