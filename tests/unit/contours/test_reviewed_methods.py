"""The section methods that the paper reviews (its references 28, 37 and 40), and circles with weights of the sight."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.contours import Contour, Section, fit_contour
from tasks.geometry.failure import FitFailure
from tests.unit.contours.rings import flat_section, ring, section_of


def contour(name: str, section: Section) -> Contour:
    fit = fit_contour(name, section)
    assert isinstance(fit, Contour), fit
    return fit


def with_ladder(rng: np.random.Generator, arc_deg: float) -> NDArray[np.float64]:
    """A tenth of the points 0.2 to 1.2 m outside over 30 degrees."""
    points = ring(rng, 200, arc_deg, 0.015)
    angle, radius = np.radians(rng.uniform(-15.0, 15.0, 20)), 4.0 + rng.uniform(0.2, 1.2, 20)
    points[:20, :2] = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return points


@pytest.mark.parametrize(("arc_deg", "sigma_mm"), [(360.0, 1.58), (120.0, 7.3)])
def test_ransac_leaves_a_ladder_out(arc_deg: float, sigma_mm: float) -> None:
    rng = np.random.default_rng(1)
    fits = [contour("ransac_circle", section_of(with_ladder(rng, arc_deg))) for _ in range(100)]
    rms = np.sqrt(np.mean([fit.center_east_m**2 + fit.center_north_m**2 for fit in fits]))
    # root of 2 or of 1.07 components of 180 good points; 100 trials have s.e. 0.06
    assert 1000 * rms <= 1.25 * sigma_mm * (np.sqrt(2) if arc_deg == 360.0 else 1.04)
    assert max(fit.n_used for fit in fits) <= 180


def test_ransac_gives_the_same_circle_every_time() -> None:
    section = section_of(with_ladder(np.random.default_rng(2), 200.0))
    one, two = contour("ransac_circle", section), contour("ransac_circle", section)
    assert (one.center_east_m, one.center_north_m, one.n_used) == (
        two.center_east_m,
        two.center_north_m,
        two.n_used,
    )


def test_ransac_refuses_points_of_which_most_lie_anywhere() -> None:
    fit = fit_contour("ransac_circle", flat_section(np.random.default_rng(3).uniform(-1.0, 1.0, (300, 2))))
    if isinstance(fit, Contour):
        assert fit.noise_m is not None
        assert fit.noise_m > 0.1  # half of a square of 2 m can be called a circle only with such noise
    else:
        assert "most points on one circle" in fit.reason


def test_plumb_cylinder_keeps_the_lean_in_that_the_others_take_out() -> None:
    rng = np.random.default_rng(4)
    angle, rise = rng.uniform(-np.pi, np.pi, 4000), rng.uniform(0.0, 0.5, 4000)
    xy = 4.0 * np.column_stack([np.cos(angle), np.sin(angle)]) + rise[:, None] * [0.08, 0.0]
    section = Section(np.column_stack([xy, rise]), 0.0, 1.0, 0.0, 0.08, 0.0)
    assert contour("geometric_circle", section).center_east_m == pytest.approx(0.0, abs=1e-9)
    # the mean height of the points, 0.25 m, times the lean; 4,000 random heights leave 0.2 mm
    assert contour("vertical_cylinder", section).center_east_m == pytest.approx(0.02, abs=0.001)


def test_plumb_cylinder_is_the_least_sum_of_squared_distances_from_a_plumb_axis() -> None:
    points = ring(np.random.default_rng(5), 300, 150.0)
    fit = contour("vertical_cylinder", section_of(points))

    def cost(east_m: float, north_m: float, radius_m: float) -> float:
        return float(np.sum((np.hypot(points[:, 0] - east_m, points[:, 1] - north_m) - radius_m) ** 2))

    best = cost(fit.center_east_m, fit.center_north_m, fit.radius_m)
    for step in np.vstack([np.eye(3), -np.eye(3)]) * 1e-4:
        assert best < cost(fit.center_east_m + step[0], fit.center_north_m + step[1], fit.radius_m + step[2])


@pytest.mark.parametrize("arc_deg", [360.0, 300.0, 250.0])
def test_filled_outline_of_a_noise_free_arc_has_its_own_centre(arc_deg: float) -> None:
    fit = contour("gap_filled", section_of(ring(np.random.default_rng(6), 300, arc_deg, 0.0)))
    assert [fit.center_east_m, fit.center_north_m, fit.radius_m] == pytest.approx([0.0, 0.0, 4.0], abs=1e-9)


def test_filled_outline_of_an_oval_with_a_gap_has_the_centre_and_the_axis_of_the_oval() -> None:
    rng = np.random.default_rng(7)
    angle = np.radians(rng.uniform(-125.0, 125.0, 4000))
    radius = 4.0 + 0.03 * np.cos(2 * (angle - np.radians(20.0)))
    xy = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    filled, circle = contour("gap_filled", flat_section(xy)), contour("geometric_circle", flat_section(xy))
    assert np.hypot(filled.center_east_m, filled.center_north_m) < 0.002
    assert np.hypot(circle.center_east_m, circle.center_north_m) > 0.01  # what the gap does to a circle
    assert filled.ovality_m == pytest.approx(0.03, abs=0.001)
    assert filled.ovality_azimuth_deg == pytest.approx(70.0, abs=1.0)  # clockwise from north


def test_mean_of_vertices_falls_where_a_filled_outline_stands() -> None:
    """A density that runs from side to side moves a mean, not the centroid of an area."""
    rng = np.random.default_rng(8)
    angle = rng.uniform(-np.pi, np.pi, 8000)
    angle = angle[rng.random(8000) < (1 + 0.5 * np.cos(angle)) / 1.5][:3000]
    radius = 4.0 + 0.01 * rng.standard_normal(len(angle))
    fit = contour(
        "gap_filled", flat_section(radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))
    )
    # sigma of the centroid about 0.3 mm, against a meter of a plain mean
    assert np.hypot(fit.center_east_m, fit.center_north_m) < 0.0015


def test_wide_gap_is_refused_with_its_width() -> None:
    fit = fit_contour("gap_filled", section_of(ring(np.random.default_rng(9), 2000, 180.0)))
    assert isinstance(fit, FitFailure)
    assert "gap wider than 120 deg, got one of 175 deg" in fit.reason or "180 deg" in fit.reason


def test_uneven_outline_widens_the_covariance_of_a_gap_more_than_that_of_a_ring() -> None:
    rng = np.random.default_rng(10)

    def variance(arc_deg: float, lobes_m: float) -> float:
        angle = np.radians(rng.uniform(-arc_deg / 2, arc_deg / 2, 4000))
        radius = 4.0 + 0.005 * rng.standard_normal(4000) + lobes_m * np.cos(7 * angle)
        xy = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        return float(np.trace(contour("gap_filled", flat_section(xy)).covariance_m2))

    assert variance(260.0, 0.02) / variance(260.0, 0.0) > 3.0 * variance(360.0, 0.02) / variance(360.0, 0.0)


def mixed_noise(rng: np.random.Generator) -> Section:
    """Two thirds of the points with five times the noise of the others, all round."""
    sigma = np.where(rng.random(300) < 0.67, 0.025, 0.005)
    angle = rng.uniform(-np.pi, np.pi, 300)
    radius = 4.0 + sigma * rng.standard_normal(300)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(300)])
    return Section(points, 0.0, 0.01, sigma_m=3.0 * sigma)


def test_weights_of_the_sights_reach_the_bound_of_mixed_noise() -> None:
    rng = np.random.default_rng(11)
    found, bounds, stated = [], [], []
    for _ in range(300):
        section = mixed_noise(rng)
        assert section.sigma_m is not None
        fit = contour("weighted_circle", section)
        found.append(fit.center_east_m**2 + fit.center_north_m**2)
        bounds.append(4.0 / np.sum((section.sigma_m / 3.0) ** -2))
        stated.append(np.trace(fit.covariance_m2))
    # 300 trials: s.e. 0.06; sigmas three times too large must not matter
    assert np.mean(bounds) / np.mean(found) == pytest.approx(0.97, abs=0.15)
    assert np.mean(stated) / np.mean(found) == pytest.approx(1.0, abs=0.15)


def test_equal_sigmas_weigh_nothing() -> None:
    section = section_of(with_ladder(np.random.default_rng(12), 200.0))
    plain, weighted = contour("robust_circle", section), contour("weighted_circle", section)
    assert weighted.center_east_m == pytest.approx(plain.center_east_m, abs=1e-9)
    assert weighted.covariance_m2 == pytest.approx(plain.covariance_m2, rel=1e-6)
