import numpy as np
import pytest

from tests.unit.contours.out_of_round_rings import (
    LOBES_M,
    OVAL_M,
    contour,
    ladder,
    profile_ring,
    rms_error_m,
)


@pytest.mark.parametrize("arc_deg", [360.0, 120.0])
def test_round_shaft_costs_no_more_than_five_per_cent_against_the_circle(arc_deg: float) -> None:
    rng = np.random.default_rng(1)
    points = [profile_ring(rng, arc_deg, n=200, sigma_m=0.02) for _ in range(250)]
    best = rms_error_m([contour("best", one) for one in points])
    circle = rms_error_m([contour("robust_circle", one) for one in points])
    # the same points: only choices that differ count, and their chance is what the bound is about
    assert (circle / best) ** 2 >= 0.95


def test_ellipse_is_chosen_where_it_is_one() -> None:
    rng = np.random.default_rng(2)
    t = rng.uniform(0.0, 2 * np.pi, 800)
    # a twentieth of ellipticity: a fourth harmonic of 7 mm that an ellipse has for nothing
    x, y = 4.2 * np.cos(t), 3.8 * np.sin(t)
    radial = 1.0 + 0.003 * rng.standard_normal(800) / 4.0
    fit = contour("best", np.column_stack([x * radial, y * radial, np.zeros(800)]))
    assert fit.model == "ellipse"
    assert fit.reason is not None
    assert "ellipse: BIC -" in fit.reason
    assert fit.ovality_m == pytest.approx(0.2, abs=0.001)


def test_lobes_are_chosen_where_they_are() -> None:
    fit = contour("best", profile_ring(np.random.default_rng(3), 360.0, OVAL_M, LOBES_M))
    assert fit.model == "fourier 3"
    assert fit.reason is not None
    assert "360 deg seen" in fit.reason


@pytest.mark.parametrize("arc_deg", [360.0, 240.0, 180.0])
def test_oval_shaft_is_never_worse_than_the_circle(arc_deg: float) -> None:
    rng = np.random.default_rng(4)
    points = [ladder(rng, profile_ring(rng, arc_deg, OVAL_M)) for _ in range(25)]
    best = rms_error_m([contour("best", one) for one in points])
    circle = rms_error_m([contour("robust_circle", one) for one in points])
    assert best < 0.5 * circle
