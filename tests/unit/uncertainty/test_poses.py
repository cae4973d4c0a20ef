import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from storage.errors import ShapeError
from tasks.uncertainty import combine, propagate_directional_poses, propagate_poses

ARCSEC = np.pi / 648000
SHARES = np.array([0.5, 0.3, 0.2])
LEAN = np.array([0.03, -0.05])


def covariance_of(
    n: int, level: float = 0.0, heading: float = 0.0, shift_m: float = 0.0
) -> NDArray[np.float64]:
    return np.diag(np.tile([level, level, heading, shift_m, shift_m, shift_m], n) ** 2)


def random_covariance(n: int, size: float) -> NDArray[np.float64]:
    A = np.random.default_rng(5).normal(size=(6 * n, 6 * n)) * size / np.sqrt(6 * n)
    return np.asarray(A @ A.T)


def moved(
    points_m: NDArray[np.float64], pose: NDArray[np.float64], origin_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    turned = Rotation.from_rotvec(pose[:3]).apply(points_m - origin_m)
    return np.asarray(turned + origin_m + pose[3:])


def full_rings(lean: NDArray[np.float64], n_heights: int = 11, n_points: int = 24) -> NDArray[np.float64]:
    """Points (heights, points, 3) on circles about a leaning axis."""
    z = np.linspace(0.0, 100.0, n_heights)[:, None]
    angle = np.linspace(0.0, 2 * np.pi, n_points, endpoint=False)[None, :]
    east = lean[0] * z + 4.0 * np.cos(angle)
    north = lean[1] * z + 4.0 * np.sin(angle)
    return np.stack([east, north, np.broadcast_to(z, east.shape)], axis=-1)


def lean_of_rings(rings: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Line through the weighted mean of the stations' ring centres; rings (stations, heights, points, 3)."""
    centres = np.einsum("s,shc->hc", weights, rings.mean(axis=2))
    return np.asarray(np.polyfit(centres[:, 2], centres[:, :2], 1)[0])


ORIGINS_M = np.array([[231.0, -13.0, 1.6], [-180.0, 140.0, 2.0], [20.0, -260.0, 1.5]])


@pytest.mark.parametrize("parameter", range(6))
def test_lean_by_one_pose_parameter_is_what_the_cross_product_moves(parameter: int) -> None:
    step = 1e-6
    pose = np.zeros(6)
    pose[parameter] = step
    rings = full_rings(LEAN)
    still = [moved(rings.reshape(-1, 3), np.zeros(6), o).reshape(rings.shape) for o in ORIGINS_M]
    turned = [moved(rings.reshape(-1, 3), pose, ORIGINS_M[0]).reshape(rings.shape), *still[1:]]
    change = lean_of_rings(np.array(turned), SHARES) - lean_of_rings(np.array(still), SHARES)
    C = np.zeros((18, 18))
    C[parameter, parameter] = step**2
    # the second order of the step, and 1e-12 of the polynomial fit
    np.testing.assert_allclose(
        propagate_poses(C, SHARES, LEAN), np.outer(change, change), atol=1e-5 * step**2
    )


def test_sign_of_a_rotation_about_north_is_plus_east_and_about_east_minus_north() -> None:
    up = np.array([0.0, 0.0, 1.0])
    assert np.cross([0.0, 1.0, 0.0], up)[0] == 1.0
    assert np.cross([1.0, 0.0, 0.0], up)[1] == -1.0
    C = np.zeros((6, 6))
    # rotations about east and north that go together: lean east and lean north then go against each other
    C[:2, :2] = 1.0
    np.testing.assert_array_equal(propagate_poses(C, np.ones(1)), [[1.0, -1.0], [-1.0, 1.0]])


def test_stated_covariance_matches_the_scatter_of_leans_under_random_correlated_poses() -> None:
    C = random_covariance(3, 20 * ARCSEC)
    rng = np.random.default_rng(11)
    rings = full_rings(LEAN, n_heights=5, n_points=8)
    poses = rng.multivariate_normal(np.zeros(18), C, size=3000).reshape(3000, 3, 6)
    flat = rings.reshape(-1, 3)
    leans = np.array(
        [
            lean_of_rings(
                np.array(
                    [moved(flat, p, o).reshape(rings.shape) for p, o in zip(pose, ORIGINS_M, strict=True)]
                ),
                SHARES,
            )
            for pose in poses
        ]
    )
    stated = propagate_poses(C, SHARES, LEAN)
    # an entry of a covariance from 3000 draws is known to 2.6 % of the variances
    np.testing.assert_allclose(np.cov(leans.T), stated, atol=0.09 * np.trace(stated) / 2)


def half_arc_leans(poses: NDArray[np.float64], origins_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Leans (trials, 2) by circles through what each station sees: the half of a shaft that faces it."""
    rings = full_rings(np.zeros(2), n_heights=5, n_points=48)
    toward = origins_m[:, :2] / np.linalg.norm(origins_m[:, :2], axis=1)[:, None]
    seen = [rings[:, rings[0, :, :2] @ t > 0.1] for t in toward]
    z = np.linspace(0.0, 100.0, 5)
    leans = []
    for trial in poses:
        moved_rings = [
            moved(s.reshape(-1, 3), p, o).reshape(s.shape)
            for s, p, o in zip(seen, trial, origins_m, strict=True)
        ]
        points = np.concatenate(moved_rings, axis=1)[..., :2]
        design = np.concatenate([2 * points, np.ones((*points.shape[:2], 1))], axis=2)
        centres = np.linalg.solve(
            np.einsum("hpi,hpj->hij", design, design),
            np.einsum("hpi,hp->hi", design, (points**2).sum(axis=2))[..., None],
        )[:, :2, 0]
        leans.append(np.polyfit(z, centres, 1)[0])
    return np.array(leans)


def test_equal_shares_hold_for_stations_all_round_that_see_half_the_shaft_each() -> None:
    n = 8
    angle = np.arange(n) * 2 * np.pi / n + 0.1
    origins_m = 250.0 * np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    C = covariance_of(n, level=20 * ARCSEC)
    poses = np.random.default_rng(2).multivariate_normal(np.zeros(6 * n), C, size=800).reshape(800, n, 6)
    scatter = np.sqrt(np.trace(np.cov(half_arc_leans(poses, origins_m).T)) / 2)
    stated = np.sqrt(np.trace(propagate_poses(C, np.full(n, 1 / n))) / 2)
    # 800 trials of two components know a standard deviation to 1.8 %
    assert scatter == pytest.approx(stated, rel=0.06)


def test_level_of_20_arcsec_on_8_stations_is_3_5_mm_at_102_m() -> None:
    C = propagate_poses(covariance_of(8, level=20 * ARCSEC), np.full(8, 1 / 8))
    np.testing.assert_allclose(102.0 * np.sqrt(np.diag(C)), 3.5e-3, atol=0.05e-3)


def test_shifts_of_the_stations_do_not_tilt_the_axis() -> None:
    np.testing.assert_array_equal(
        propagate_poses(covariance_of(3, shift_m=0.01), SHARES, LEAN), np.zeros((2, 2))
    )


def test_heading_common_to_all_stations_turns_the_lean_and_leaves_its_length() -> None:
    heading = np.tile([0.0, 0.0, 1e-3, 0.0, 0.0, 0.0], 3)
    C = propagate_poses(np.outer(heading, heading), SHARES, LEAN)
    along = LEAN / np.linalg.norm(LEAN)
    assert along @ C @ along == pytest.approx(0.0, abs=1e-18)
    assert np.sqrt(np.trace(C)) == pytest.approx(1e-3 * np.linalg.norm(LEAN), rel=1e-12)


def test_heading_does_nothing_to_a_plumb_axis() -> None:
    np.testing.assert_array_equal(propagate_poses(covariance_of(3, heading=1.0), SHARES), np.zeros((2, 2)))


def test_level_error_common_to_all_stations_does_not_average_out() -> None:
    level = np.tile([1e-4, 0.0, 0.0, 0.0, 0.0, 0.0], 3)
    C = propagate_poses(np.outer(level, level), SHARES)
    assert C[1, 1] == pytest.approx(1e-8, rel=1e-12)


def test_scalar_shares_are_matrix_shares_of_multiples_of_the_unit_matrix() -> None:
    C = random_covariance(3, 1e-4)
    matrices = SHARES[:, None, None] * np.eye(2)
    np.testing.assert_array_equal(
        propagate_directional_poses(C, matrices, LEAN), propagate_poses(C, SHARES, LEAN)
    )


def test_station_that_fixes_the_east_only_takes_nothing_from_the_level_that_moves_north() -> None:
    matrices = np.array([np.diag([1.0, 0.0]), np.diag([0.0, 1.0])])
    C = np.zeros((12, 12))
    C[0, 0] = 1.0  # rotation of station 0 about east moves its points north
    np.testing.assert_array_equal(propagate_directional_poses(C, matrices), np.zeros((2, 2)))


def test_combined_covariance_is_the_sum() -> None:
    np.testing.assert_array_equal(combine(np.eye(2), 2 * np.eye(2)), 3 * np.eye(2))


def test_combine_refuses_what_is_no_covariance_of_a_lean() -> None:
    with pytest.raises(ShapeError, match=r"combine needs two finite covariances"):
        combine(np.eye(2), np.eye(3))


@pytest.mark.parametrize("shares", [[0.5, 0.6, 0.2], [1.5, -0.5, 0.0], [np.nan, 0.5, 0.5], []])
def test_shares_that_are_no_weights_are_refused(shares: list[float]) -> None:
    with pytest.raises(ShapeError, match=r"propagate_poses needs .*shares"):
        propagate_poses(np.eye(18), np.array(shares))


def test_pose_covariance_of_another_number_of_stations_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"pose covariance \(18, 18\) for 3 stations; got \(12, 12\)"):
        propagate_poses(np.eye(12), SHARES)


def test_share_matrices_that_do_not_sum_to_one_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"sum to the unit matrix"):
        propagate_directional_poses(np.eye(12), np.array([np.eye(2), np.eye(2)]))


def test_a_lean_of_three_numbers_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"lean vector \(2,\)"):
        propagate_poses(np.eye(18), SHARES, np.zeros(3))
