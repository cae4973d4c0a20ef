"""What every contour model does, and what it refuses; laws that hold for any section: tests/properties."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError, ShapeError
from tasks.contours import CONTOURS, Contour, Section, fit_contour
from tasks.geometry.failure import FitFailure
from tests.unit.contours.rings import flat_section, ring, section_of

CIRCLES = [
    "kasa",
    "pratt",
    "taubin",
    "hyper",
    "geometric_circle",
    "vertical_cylinder",
    "robust_circle",
    "weighted_circle",
    "ransac_circle",
]


NOT_ROUND = ["polygon"]
"""Models of other shapes: a ring is not for them."""
ROBUST = ["robust_circle", "weighted_circle", "ransac_circle"]


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


@pytest.mark.parametrize("name", [name for name in CONTOURS if name not in NOT_ROUND])
def test_coverage_counts_sectors_of_five_degrees(name: str) -> None:
    rng = np.random.default_rng(7)
    assert contour(name, section_of(ring(rng, 4000))).arc_coverage_deg == 360.0
    if name != "vertex_mean":  # its centre lies towards the arc, so its sectors are others
        half = fit_contour(name, section_of(ring(rng, 4000, 180.0, 1e-4)))
        if isinstance(half, FitFailure):  # a contour that has to close says how much of it is missing
            assert " deg" in half.reason
        else:
            assert half.arc_coverage_deg == pytest.approx(
                180.0, abs=5.0
            )  # one sector more where an end is cut


@pytest.mark.parametrize("name", [name for name in CONTOURS if name not in NOT_ROUND])
def test_covariance_is_symmetric_and_positive(name: str) -> None:
    fit = contour(name, section_of(ring(np.random.default_rng(8), 400)))
    np.testing.assert_allclose(fit.covariance_m2, fit.covariance_m2.T, rtol=1e-12)
    assert np.linalg.eigvalsh(fit.covariance_m2).min() > 0.0


@pytest.mark.parametrize("name", CIRCLES)
def test_noise_of_the_points_is_found(name: str) -> None:
    fit = contour(name, section_of(ring(np.random.default_rng(13), 4000, 200.0)))
    assert fit.noise_m == pytest.approx(0.02, rel=0.05)  # a median of 4,000 has 1.8 %


@pytest.mark.parametrize("name", ROBUST)
def test_noise_of_the_points_is_found_beside_a_ladder(name: str) -> None:
    rng = np.random.default_rng(14)
    points = ring(rng, 4000)
    points[:400, :2] *= 1.0 + rng.uniform(0.05, 0.3, (400, 1))
    # a tenth of outliers moves the median to the quantile 0.556 of the clean ones: 13 % more
    assert contour(name, section_of(points)).noise_m == pytest.approx(0.0227, rel=0.05)


@pytest.mark.parametrize("name", CONTOURS)
@pytest.mark.parametrize(
    ("xy", "reason"),
    [
        (np.empty((0, 2)), "points, got 0"),
        ([[0.0, 1.0], [1.0, 0.0]], "points, got 2"),
        (np.ones((400, 2)) * 6e6, "got 400 at one place"),
        (np.linspace(0.0, 1.0, 400)[:, None] * [3.0, 1.0], "got 400 on one line"),
        (np.linspace(0.0, 1.0, 400)[:, None] * [3.0, 1.0] + [5e5, 6e6], "got 400 on one line"),
        (
            np.vstack([np.random.default_rng(9).normal(size=(400, 2)), [[np.nan, 0.0]]]),
            "got 1 points without",
        ),
    ],
)
def test_points_without_a_circle_fail_with_a_reason(name: str, xy: object, reason: str) -> None:
    fit = fit_contour(name, flat_section(xy))
    assert isinstance(fit, FitFailure)
    assert reason in fit.reason


@pytest.mark.parametrize("name", [name for name in CIRCLES if name != "kasa"])
def test_arc_too_short_for_its_noise_fails_and_says_what_came(name: str) -> None:
    fit = fit_contour(name, section_of(ring(np.random.default_rng(10), 60, 12.0, 0.02)))
    assert isinstance(fit, FitFailure)
    assert "arc" in fit.reason or "line" in fit.reason


def test_unknown_model_is_answered_with_the_known_ones() -> None:
    with pytest.raises(
        InputError, match=r"unknown contour model 'square'; known: .*geometric_circle, .*robust_circle"
    ):
        fit_contour("square", section_of(ring(np.random.default_rng(11))))


@pytest.mark.parametrize("name", [name for name in CONTOURS if CONTOURS[name].weighs_sights])
def test_points_without_a_sigma_are_refused_by_models_that_weigh_them(name: str) -> None:
    points = ring(np.random.default_rng(12), 400)
    blind = fit_contour(name, Section(points, 0.0, 0.01))
    assert isinstance(blind, FitFailure)
    assert "needs the sigma of every point" in blind.reason
    sigma = np.full(400, 0.02)
    sigma[:3] = [0.0, np.nan, -1.0]
    bad = fit_contour(name, Section(points, 0.0, 0.01, sigma_m=sigma))
    assert isinstance(bad, FitFailure)
    assert "got 3 points without" in bad.reason


def test_points_without_height_are_misuse() -> None:
    with pytest.raises(ShapeError, match=r"points \(n, 3\), got \(5, 2\)"):
        Section(np.zeros((5, 2)), 0.0, 0.01)
