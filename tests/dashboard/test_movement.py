"""How the top moved since any epoch."""

import math

import numpy as np
import pytest

from dashboard.content.direction import Direction, direction_of
from dashboard.content.movement import SUM_OF_BOTH, movements_since
from dashboard.reader import Reader
from storage.views import change_rows, tilt_rows
from tests.storage.campaign import HEIGHT_M, STRUCTURE, tilt_row


def test_a_movement_since_the_reference_of_the_catalog_is_that_of_the_catalog(reader: Reader) -> None:
    tilts, changes = reader.ask(tilt_rows, STRUCTURE), reader.ask(change_rows, STRUCTURE)
    (row,) = changes
    found = movements_since("e0", tilts, changes)
    assert list(found) == ["e1"]
    assert found["e1"].size_m == row.d_top_m
    assert found["e1"].significant == row.significant
    np.testing.assert_allclose(found["e1"].east_north_m, [1e-4 * HEIGHT_M, 0.0], atol=1e-12)


def test_since_another_epoch_leans_are_subtracted_covariances_added_and_nothing_is_called_significant() -> (
    None
):
    rows = [tilt_row("e0", 0), tilt_row("e1", 1, (0.0073, -0.0053))]
    found = movements_since("e1", rows, [])["e0"]
    np.testing.assert_allclose(found.east_north_m, HEIGHT_M * np.array([-3e-4, -4e-4]))
    assert found.covariance_m2 is not None
    np.testing.assert_allclose(found.covariance_m2, HEIGHT_M**2 * 2e-10 * np.array([[4.0, 1.0], [1.0, 9.0]]))
    assert (found.significant, found.p_value, found.detectable_m) == (None, None, None)
    assert found.basis == SUM_OF_BOTH
    along = np.array([-0.6, -0.8])
    assert found.sigma_m == pytest.approx(math.sqrt(along @ found.covariance_m2 @ along))


def test_without_a_covariance_there_is_no_sigma() -> None:
    rows = [tilt_row("e0", 0), tilt_row("e1", 1, (0.0073, -0.0053), lean_cov_ee=None)]
    found = movements_since("e0", rows, [])["e1"]
    assert (found.covariance_m2, found.sigma_m, found.sigmas_m(Direction(0.0, is_lean=True))) == (
        None,
        None,
        None,
    )


def test_a_reference_without_an_axis_has_no_movements() -> None:
    assert movements_since("gone", [tilt_row("e0", 0)], []) == {}


@pytest.mark.parametrize("azimuth_deg", [0.0, 37.0, 90.0, 134.5, 270.0])
def test_along_and_across_keep_lengths_and_point_the_right_way(azimuth_deg: float) -> None:
    direction = Direction(azimuth_deg, is_lean=True)
    rad = math.radians(azimuth_deg)
    np.testing.assert_allclose(
        direction.turn(np.array([math.sin(rad), math.cos(rad)])), [1.0, 0.0], atol=1e-12
    )
    across = math.radians(azimuth_deg + 90.0)
    np.testing.assert_allclose(
        direction.turn(np.array([math.sin(across), math.cos(across)])), [0.0, 1.0], atol=1e-12
    )
    covariance = np.array([[4.0, 1.0], [1.0, 9.0]])
    turned = direction.turn_covariance(covariance)
    assert np.trace(turned) == pytest.approx(13.0)
    assert np.linalg.det(turned) == pytest.approx(35.0)


def test_a_lean_that_is_not_significant_is_looked_at_from_north() -> None:
    assert direction_of(tilt_row("e0", azimuth_deg=None)).words == ("north", "east")
