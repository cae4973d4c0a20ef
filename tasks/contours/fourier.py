"""Contour model ``fourier``: a radius profile of a few harmonics, as many as the points show."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.arc_gaps import ArcGaps, arc_gaps
from tasks.contours.circle import Circle, arc_coverage_deg
from tasks.contours.circle_fit import LOOSEST_CENTRE
from tasks.contours.circle_start import resistant_circle
from tasks.contours.harmonic_order import OrderChoice, choose_order
from tasks.contours.model import ContourModel
from tasks.contours.out_of_round import out_of_round
from tasks.contours.profile import Harmonics, ProfileShape, profile_start
from tasks.contours.robust_adjustment import RobustFit, relative_sigma, settle_shape
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import StraightSection, straighten
from tasks.contours.tukey_circle import MIN_POINTS
from tasks.contours.unseen_ovality import BUILT_OVALITY, unseen_ovality_m2
from tasks.geometry.failure import FitFailure

HIGHEST: Final = 6
"""Highest harmonic that is tried."""

FULL_DEG: Final = 270.0
"""Below this arc only the ovality can be told from a shift of the centre: lobes leave it uncertain by decimetres."""

POINTS_PER_PARAMETER: Final = 5
"""Points that are used for each parameter of a profile, at least."""

LOOSE_SHAPE: Final = 0.01
"""Standard deviation of harmonic 2 before a look at the points, as a part of the radius; harmonic k has 2/k of it.

Ten times what is built: it holds back only what the points do not fix.
"""


@dataclass(frozen=True, slots=True, eq=False)
class ProfileFit:
    """A profile that was fitted, with what was chosen on the way."""

    straight: StraightSection
    sigma: NDArray[np.float64]
    order: int
    fit: RobustFit
    covariance_m2: NDArray[np.float64]
    gaps: ArcGaps
    reason: str


def fit_fourier(section: Section) -> Contour | FitFailure:
    """Fit r(theta) = R + sum over k of a_k cos k theta + b_k sin k theta, k from 2; the centre has no first harmonic.

    Lean and taper within the slice are taken out first. The order is 0 (a circle) or 2 to 6 by ``choose_order``; it is
    at most 2 on arcs below 270 degrees, and no gap may be wider than half a wave of the highest harmonic. Every fit is
    robust as that of ``robust_circle``. Coefficients have a loose prior (``LOOSE_SHAPE``).

    The covariance of the centre is that of the joint fit of centre, radius and harmonics. Where a circle was chosen it
    has, in addition, what the ovality that the arc does not show would move the centre by: with the loose prior where
    the criterion asks for harmonics that an arc this short may show by chance. Lobes are not in it: a shaft with three
    lobes, seen on half of its circumference, has a centre that no model here gets right.
    """
    profile = fit_profile(section)
    return profile if isinstance(profile, FitFailure) else profile_contour(profile)


def fit_profile(section: Section) -> ProfileFit | FitFailure:
    """Choose the order of the profile of a slice and fit it."""
    straight = straighten(section)
    sigma = relative_sigma(section.sigma_m, len(straight.xy_m))
    if isinstance(sigma, FitFailure):
        return sigma
    start = resistant_circle(straight)
    if isinstance(start, FitFailure):
        return start
    circle = fit_order(straight, sigma, profile_start(start, Harmonics(0)), 0)
    return circle if isinstance(circle, FitFailure) else _grown(straight, sigma, circle)


def _grown(
    straight: StraightSection, sigma: NDArray[np.float64], circle: RobustFit
) -> ProfileFit | FitFailure:
    """Add the harmonics to a settled circle that the points show."""
    gaps = arc_gaps(straight.xy_m[circle.used], circle.parameters_m[:2])
    round_one = ProfileFit(straight, sigma, 0, circle, circle.covariance_m2()[:2, :2], gaps, "")
    orders = _orders(gaps, int(circle.used.sum()))
    if not orders:
        return _kept(round_one, f"circle: {circle.used.sum()} points are too few for harmonics")
    highest = fit_order(straight, sigma, circle.parameters_m, orders[-1])
    if isinstance(highest, FitFailure):
        return _kept(round_one, f"circle: harmonics failed, {highest.reason}")
    choice = choose_order(highest, orders)
    if choice.order == 0:
        beforehand = BUILT_OVALITY if choice.bic_over_circle >= 0.0 else LOOSE_SHAPE
        return _kept(round_one, _why(gaps, choice), beforehand)
    start_m = highest.parameters_m[: 3 + Harmonics(choice.order).count]
    chosen = fit_order(straight, sigma, start_m, choice.order)
    if isinstance(chosen, FitFailure):
        return chosen
    covariance = chosen.covariance_m2()[:2, :2]
    return ProfileFit(straight, sigma, choice.order, chosen, covariance, gaps, _why(gaps, choice))


def fit_order(
    straight: StraightSection,
    sigma: NDArray[np.float64],
    start_m: NDArray[np.float64],
    order: int,
    loose_shape: float = LOOSE_SHAPE,
) -> RobustFit | FitFailure:
    """Fit a profile of harmonics 2 to ``order`` robustly.

    Parameters
    ----------
    straight : StraightSection
        Points with lean and taper taken out.
    sigma : (n,) array
        Relative standard deviations of the points.
    start_m : (3,) array or longer
        East, north, radius and the coefficients that are known, metres; the others start at 0.
    order : int
        0 for a circle, or the highest harmonic.
    loose_shape : float
        Standard deviation of harmonic 2 beforehand over the radius; inf for none.
    """
    basis = Harmonics(order)
    start = np.zeros(3 + basis.count)
    start[: len(start_m)] = start_m
    prior = np.full(len(start), np.inf)
    prior[3:] = loose_shape * start[2] * 2.0 / basis.numbers
    return settle_shape(ProfileShape.of(straight, sigma, basis), start, prior)


def profile_contour(profile: ProfileFit) -> Contour | FitFailure:
    """Make a contour of a fitted profile, or say that the arc is too short for a centre."""
    fit, straight = profile.fit, profile.straight
    east, north, radius = (float(value) for value in fit.parameters_m[:3])
    sigma = float(np.sqrt(np.linalg.eigvalsh(profile.covariance_m2)[-1]))
    if sigma > LOOSEST_CENTRE * radius:
        return FitFailure(
            f"arc too short for a centre: {profile.gaps.covered_deg:.0f} deg of the circumference have points, "
            f"which fixes the centre to {sigma:.3g} m at a radius of {radius:.3g} m"
        )
    round_one = Contour(
        center_east_m=float(straight.origin_m[0]) + east,
        center_north_m=float(straight.origin_m[1]) + north,
        radius_m=radius,
        covariance_m2=profile.covariance_m2,
        rmse_m=fit.rmse_m,
        n_used=int(fit.used.sum()),
        arc_coverage_deg=arc_coverage_deg(straight.xy_m[fit.used], Circle(east, north, radius)),
        noise_m=fit.sigma_m,
        model="circle",
        reason=profile.reason,
    )
    if not profile.order:
        return round_one
    shape = out_of_round(Harmonics(profile.order), fit.parameters_m[3:])
    return replace(
        round_one,
        roundness_m=shape.roundness_m,
        ovality_m=shape.ovality_m,
        ovality_azimuth_deg=shape.ovality_azimuth_deg,
        model=f"fourier {profile.order}",
    )


def _orders(gaps: ArcGaps, n_used: int) -> tuple[int, ...]:
    """Orders that coverage and number of points allow, rising."""
    highest = HIGHEST if gaps.covered_deg >= FULL_DEG else 2
    half_wave = max(int(180.0 / gaps.widest_deg), 2)
    points = (n_used // POINTS_PER_PARAMETER - 1) // 2
    return tuple(range(2, min(highest, half_wave, points) + 1))


def _kept(circle: ProfileFit, reason: str, beforehand: float = BUILT_OVALITY) -> ProfileFit:
    """The circle, with the ovality that it may hide in its covariance."""
    unseen = unseen_ovality_m2(circle.straight, circle.fit, beforehand)
    return replace(circle, covariance_m2=circle.covariance_m2 + unseen, reason=reason)


def _why(gaps: ArcGaps, choice: OrderChoice) -> str:
    seen = f"{gaps.covered_deg:.0f} deg seen, widest gap {gaps.widest_deg:.0f} deg"
    against = f"BIC {choice.bic_over_circle:+.1f} against a circle"
    if choice.order:
        return f"{seen}; fourier {choice.order}: {against}"
    chance = "" if choice.bic_over_circle >= 0.0 else ", which on this arc may be chance"
    return f"{seen}; circle: fourier {choice.runner_up} has {against}{chance}"


CONTOUR: Final = ContourModel(
    "fourier",
    "radius profile of harmonics 2 to 6 by BIC, Tukey weights; at most the ovality on arcs below 270 degrees",
    min_points=MIN_POINTS,
    fit=fit_fourier,
)
