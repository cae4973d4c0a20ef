import numpy as np
import pytest
from scipy.stats import norm

from tasks.contours import Contour, fit_contour
from tests.unit.contours.rings import flat_section, ring, section_of


def test_fit_satisfies_the_normal_equations_of_the_paper() -> None:
    points = ring(np.random.default_rng(1), 100, 150.0)
    x, y = points[:, 0], points[:, 1]
    A = np.column_stack([x, y, np.ones_like(x)])
    D, E, F = np.linalg.solve(A.T @ A, A.T @ -(x**2 + y**2))
    fit = fit_contour("kasa", section_of(points))
    assert isinstance(fit, Contour)
    expected = [-D / 2, -E / 2, np.sqrt(D**2 / 4 + E**2 / 4 - F)]
    # the normal equations lose half of the digits, we do not
    assert [fit.center_east_m, fit.center_north_m, fit.radius_m] == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(
    ("arc_deg", "bias_mm"), [(180, 0.67), (120, 3.61), (90, 11.58), (60, 58.5), (40, 280.8)]
)
def test_bias_on_arcs_is_the_asymptotic_one(arc_deg: int, bias_mm: float) -> None:
    # every angle with the quantiles of the normal law instead of random numbers: N is infinite
    noise = norm.ppf((np.arange(100) + 0.5) / 100)
    radius = 4.0 + 0.02 * noise / noise.std()
    angle = np.radians((np.arange(720) + 0.5) / 720 * arc_deg - arc_deg / 2)
    xy = np.column_stack([np.outer(np.cos(angle), radius).ravel(), np.outer(np.sin(angle), radius).ravel()])
    fit = fit_contour("kasa", flat_section(xy))
    assert isinstance(fit, Contour)
    assert 1000 * fit.center_east_m == pytest.approx(bias_mm, rel=0.02)


def test_stated_sigma_matches_scatter_on_a_full_ring() -> None:
    rng = np.random.default_rng(2)
    fits = [fit_contour("kasa", section_of(ring(rng, 200))) for _ in range(800)]
    good = [fit for fit in fits if isinstance(fit, Contour)]
    scatter = np.std([fit.center_east_m for fit in good])
    stated = np.sqrt(np.mean([fit.covariance_m2[0, 0] for fit in good]))
    assert stated == pytest.approx(scatter, rel=0.08)  # 800 repeats: s.e. 0.025


def test_nothing_is_left_out() -> None:
    points = ring(np.random.default_rng(3), 100)
    points[0] *= 3.0
    fit = fit_contour("kasa", section_of(points))
    assert isinstance(fit, Contour)
    assert fit.n_used == 100
