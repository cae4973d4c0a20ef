"""The ellipse of the top."""

import numpy as np
import pytest

from dashboard.content.plan import ELLIPSE_95, ellipse, tops
from tests.storage.campaign import HEIGHT_M, tilt_row


def test_the_ellipse_is_where_the_mahalanobis_distance_is_its_factor() -> None:
    covariance = np.array([[4.0, 1.5], [1.5, 9.0]])
    centre = np.array([10.0, -20.0])
    off = ellipse(centre, covariance) - centre
    distances = np.sqrt(np.einsum("ni,ij,nj->n", off, np.linalg.inv(covariance), off))
    np.testing.assert_allclose(distances, ELLIPSE_95)


def test_the_ellipse_holds_95_percent_of_what_it_describes() -> None:
    rng = np.random.default_rng(5)
    covariance = np.array([[4.0, 1.5], [1.5, 9.0]])
    drawn = rng.multivariate_normal(np.zeros(2), covariance, size=200_000)
    inside = np.einsum("ni,ij,nj->n", drawn, np.linalg.inv(covariance), drawn) < ELLIPSE_95**2
    # sigma of the share is 0.0005
    assert inside.mean() == pytest.approx(0.95, abs=0.002)


def test_a_top_without_a_covariance_has_no_ellipse() -> None:
    (top,) = tops([tilt_row("e0", lean_cov_en=None)])
    assert top.covariance_m2 is None
    np.testing.assert_allclose(top.east_north_m, HEIGHT_M * np.array([0.007, -0.0057]))
