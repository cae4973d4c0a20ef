"""What every contour model does, and what it refuses."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError, ShapeError
from tasks.contours import CONTOURS, Contour, Section, fit_contour
from tasks.geometry.failure import FitFailure
from tests.unit.contours.rings import flat_section, ring, section_of

CIRCLES = ["kasa", "geometric_circle", "robust_circle"]


def contour(name: str, section: Section) -> Contour:
    fit = fit_contour(name, section)
    assert isinstance(fit, Contour), fit
    return fit


def center(fit: Contour) -> NDArray[np.float64]:
    return np.array([fit.center_east_m, fit.center_north_m])


@pytest.mark.parametrize("name", CIRCLES)
def test_noise_free_arc_gives_its_own_circle(name: str) -> None:
    points = ring(np.random.default_rng(1), 60, 90.0, sigma_m=0.0) + np.array([10.0, -20.0, 0.0])
    fit = contour(name, section_of(points))
    # 1e-9 m: float64 at 20 m, times the weakness of a quarter arc
    assert [*center(fit), fit.radius_m] == pytest.approx([10.0, -20.0, 4.0], abs=1e-9)


@pytest.mark.parametrize("name", CONTOURS)
def test_centre_moves_with_the_points(name: str) -> None:
    points = ring(np.random.default_rng(2), 300)
    shift = np.array([3.25, -7.5, 0.0])  # exact in binary: the raster of the vertex mean moves with it
    here, there = contour(name, section_of(points)), contour(name, section_of(points + shift))
    assert center(there) - center(here) == pytest.approx(shift[:2], abs=1e-9)
    assert there.radius_m == pytest.approx(here.radius_m, abs=1e-9)


@pytest.mark.parametrize("name", CIRCLES)
def test_coordinates_of_millions_of_metres_cost_a_micrometre_at_most(name: str) -> None:
    points = ring(np.random.default_rng(3), 200, 180.0)
    far = np.array([500_000.0, 6_000_000.0, 0.0])
    here, there = contour(name, section_of(points)), contour(name, section_of(points + far))
    assert center(there) - far[:2] == pytest.approx(
        center(here), abs=1e-6
    )  # points are rounded to 1e-9 m there


@pytest.mark.parametrize("name", CIRCLES)
def test_centre_turns_with_the_points(name: str) -> None:
    points = ring(np.random.default_rng(4), 200, 200.0)
    c, s = np.cos(1.1), np.sin(1.1)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    here, there = contour(name, section_of(points)), contour(name, section_of(points @ turn.T))
    assert center(there) == pytest.approx(turn[:2, :2] @ center(here), abs=1e-9)
    turned = turn[:2, :2] @ here.covariance_m2 @ turn[:2, :2].T
    np.testing.assert_allclose(there.covariance_m2, turned, rtol=1e-6, atol=1e-15)


@pytest.mark.parametrize("name", CONTOURS)
def test_unit_of_length_does_not_matter(name: str) -> None:
    points = ring(np.random.default_rng(5), 200)
    metres, thousands = contour(name, section_of(points)), contour(name, section_of(points * 1024.0))
    assert center(thousands) / 1024.0 == pytest.approx(center(metres), abs=1e-9)
    np.testing.assert_allclose(
        thousands.covariance_m2 / 1024.0**2, metres.covariance_m2, rtol=1e-6, atol=1e-15
    )


@pytest.mark.parametrize("name", CONTOURS)
def test_order_of_the_points_does_not_matter(name: str) -> None:
    rng = np.random.default_rng(6)
    points = ring(rng, 200, 250.0)
    straight, mixed = contour(name, section_of(points)), contour(name, section_of(rng.permutation(points)))
    assert center(mixed) == pytest.approx(center(straight), abs=1e-9)


@pytest.mark.parametrize("name", CONTOURS)
def test_coverage_counts_sectors_of_five_degrees(name: str) -> None:
    rng = np.random.default_rng(7)
    assert contour(name, section_of(ring(rng, 4000))).arc_coverage_deg == 360.0
    if name != "vertex_mean":  # its centre lies towards the arc, so its sectors are others
        half = contour(name, section_of(ring(rng, 4000, 180.0, 1e-4)))
        assert half.arc_coverage_deg == pytest.approx(180.0, abs=5.0)  # one sector more where an end is cut


@pytest.mark.parametrize("name", CONTOURS)
def test_covariance_is_symmetric_and_positive(name: str) -> None:
    fit = contour(name, section_of(ring(np.random.default_rng(8))))
    np.testing.assert_allclose(fit.covariance_m2, fit.covariance_m2.T, rtol=1e-12)
    assert np.linalg.eigvalsh(fit.covariance_m2).min() > 0.0


@pytest.mark.parametrize("name", CONTOURS)
@pytest.mark.parametrize(
    ("xy", "reason"),
    [
        (np.empty((0, 2)), "points, got 0"),
        ([[0.0, 1.0], [1.0, 0.0]], "points, got 2"),
        (np.ones((50, 2)) * 6e6, "got 50 at one place"),
        (np.linspace(0.0, 1.0, 50)[:, None] * [3.0, 1.0], "got 50 on one line"),
        (np.linspace(0.0, 1.0, 50)[:, None] * [3.0, 1.0] + [5e5, 6e6], "got 50 on one line"),
        (np.vstack([np.random.default_rng(9).normal(size=(50, 2)), [[np.nan, 0.0]]]), "got 1 points without"),
    ],
)
def test_points_without_a_circle_fail_with_a_reason(name: str, xy: object, reason: str) -> None:
    fit = fit_contour(name, flat_section(xy))
    assert isinstance(fit, FitFailure)
    assert reason in fit.reason


@pytest.mark.parametrize("name", ["geometric_circle", "robust_circle"])
def test_arc_too_short_for_its_noise_fails_and_says_what_came(name: str) -> None:
    fit = fit_contour(name, section_of(ring(np.random.default_rng(10), 60, 12.0, 0.02)))
    assert isinstance(fit, FitFailure)
    assert "arc" in fit.reason or "line" in fit.reason


def test_unknown_model_is_answered_with_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"unknown contour model 'square'; known: geometric_circle, kasa"):
        fit_contour("square", section_of(ring(np.random.default_rng(11))))


def test_points_without_height_are_misuse() -> None:
    with pytest.raises(ShapeError, match=r"points \(n, 3\), got \(5, 2\)"):
        Section(np.zeros((5, 2)), 0.0, 0.01)
