import numpy as np
import pytest

from tasks.contours import fit_contour
from tasks.geometry.failure import FitFailure
from tests.unit.contours.out_of_round_rings import (
    LOBES_M,
    OVAL_M,
    contour,
    profile_ring,
    rms_error_m,
    whitened_rms,
)
from tests.unit.contours.rings import section_of


@pytest.mark.parametrize(("oval_m", "lobes_m"), [(0.0, 0.0), (OVAL_M, LOBES_M)])
def test_full_ring_has_the_error_of_a_round_one(oval_m: float, lobes_m: float) -> None:
    rng = np.random.default_rng(1)
    fits = [contour("spline", profile_ring(rng, 360.0, oval_m, lobes_m)) for _ in range(40)]
    assert 1000 * rms_error_m(fits) == pytest.approx(1.0, rel=0.3)  # sigma sqrt(4 / n), s.e. 0.08
    assert whitened_rms(fits) == pytest.approx(1.0, abs=0.24)


def test_round_ring_is_not_bent_by_its_noise() -> None:
    rng = np.random.default_rng(2)
    wavy = [contour("spline", profile_ring(rng)).roundness_m or 0.0 for _ in range(20)]
    # 22 free coefficients of 0.7 mm would make 15 mm of it
    assert float(np.median(wavy)) < 0.004


def test_dent_is_followed() -> None:
    points = profile_ring(np.random.default_rng(3), n=4000)
    angle = np.arctan2(points[:, 1], points[:, 0])
    points[:, :2] *= 1.0 - 0.01 * np.exp(-((angle - 1.0) ** 2) / (2 * 0.35**2))[:, None]
    fit = contour("spline", points)
    around = np.linspace(-np.pi, np.pi, 3600, endpoint=False)
    dent = -0.04 * np.exp(-((around - 1.0) ** 2) / (2 * 0.35**2))
    # its first harmonic is what no curve tells from a shift of the centre, by definition
    first = 2 * np.mean(dent * np.exp(1j * around))
    assert [fit.center_east_m, fit.center_north_m] == pytest.approx([first.real, first.imag], abs=1e-3)
    without = dent - (first * np.exp(-1j * around)).real
    assert fit.roundness_m == pytest.approx(float(np.ptp(without)), abs=0.004)
    assert fit.ovality_m == pytest.approx(float(np.abs(2 * np.mean(dent * np.exp(2j * around)))), abs=1e-3)


def test_ladder_on_the_wall_is_left_out() -> None:
    rng = np.random.default_rng(4)
    points = profile_ring(rng, 360.0, OVAL_M, n=800)
    hit = rng.choice(800, 80, replace=False)
    angle = np.radians(rng.uniform(20.0, 50.0, 80))
    distance = 4.0 + rng.uniform(0.2, 1.2, 80)
    points[hit, 0], points[hit, 1] = distance * np.cos(angle), distance * np.sin(angle)
    fit = contour("spline", points)
    assert fit.n_used <= 722
    assert np.hypot(fit.center_east_m, fit.center_north_m) < 0.0025  # three times the error of a clean ring


@pytest.mark.parametrize(
    ("arc_deg", "seen"), [(335.0, "335 deg with a gap of 25"), (180.0, "180 deg with a gap of 1")]
)
def test_gap_is_refused_and_named(arc_deg: float, seen: str) -> None:
    fit = fit_contour("spline", section_of(profile_ring(np.random.default_rng(5), arc_deg, n=4000)))
    assert isinstance(fit, FitFailure)
    assert f"got {seen}" in fit.reason
