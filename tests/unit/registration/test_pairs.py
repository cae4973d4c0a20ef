import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.conventions import rotation_site_scanner
from tasks.geometry.rotations import rotation_from_vector
from tasks.registration.pairs import derivatives, feigned_information, match_pair, pair_equations
from tasks.registration.planar import planes_of_scan
from tasks.registration.station import StationPose
from tests.unit.registration.conftest import bare_cylinder

HERE = StationPose("here", np.eye(3), np.zeros(3))


def wall_and_ground(rng: np.random.Generator) -> NDArray[np.float64]:
    wall = np.column_stack([rng.uniform(-15, 15, 10_000), np.full(10_000, 6.0), rng.uniform(0, 8, 10_000)])
    return np.vstack([flat_ground(rng), wall + 0.001 * rng.normal(size=wall.shape)])


def flat_ground(rng: np.random.Generator) -> NDArray[np.float64]:
    ground = np.column_stack([rng.uniform(-15, 15, (20_000, 2)), np.zeros(20_000)])
    return ground + 0.001 * rng.normal(size=ground.shape)


def moved(pose: StationPose, step: NDArray[np.float64]) -> StationPose:
    return StationPose(
        pose.station, rotation_from_vector(step[:3]) @ pose.rotation, pose.position_m + step[3:]
    )


def shown_and_feigned(
    first: NDArray[np.float64], second: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Diagonals (12,) of the normal matrix of two scans, and of what is feigned of it; scanner in the origin."""
    source, target = planes_of_scan(first).fine, planes_of_scan(second).fine
    found = match_pair(source, HERE, target, HERE, 0.06)
    return np.diag(pair_equations(found, HERE, HERE).matrix), np.diag(feigned_information(found, HERE, HERE))


@pytest.mark.parametrize("parameter", range(12))
def test_jacobian_is_the_numeric_derivative_of_the_residuals(parameter: int) -> None:
    site = wall_and_ground(np.random.default_rng(2))[::4]
    poses = [
        StationPose(name, rotation_site_scanner(heading), np.array(position))
        for name, heading, position in (("a", 0.3, (4.0, -3.0, 1.5)), ("b", -1.1, (-6.0, 1.0, 1.8)))
    ]
    source, target = (planes_of_scan((site - pose.position_m) @ pose.rotation).fine for pose in poses)

    def residuals(step: NDArray[np.float64]) -> NDArray[np.float64]:
        return match_pair(
            source, moved(poses[0], step[:6]), target, moved(poses[1], step[6:]), 0.5
        ).residuals_m

    matched = match_pair(source, poses[0], target, poses[1], 0.5)
    step = 1e-7 * np.eye(12)[parameter]
    numeric = (residuals(step) - residuals(-step)) / 2e-7
    # second-order terms of a step of 1e-7 at 20 m are far below
    analytic = derivatives(matched, *poses)[:, parameter]
    assert analytic == pytest.approx(numeric, abs=1e-5)


def test_residuals_are_drawn_to_nought_by_the_step_of_the_normal_equations() -> None:
    scan = wall_and_ground(np.random.default_rng(2))
    planes = planes_of_scan(scan).fine
    off = moved(HERE, np.array([1e-4, -1e-4, 0.0, 0.0, 0.01, -0.01]))
    equations = pair_equations(match_pair(planes, off, planes, HERE, 0.5), off, HERE)
    seen = [0, 1, 2, 4, 5]  # nothing says where along the wall it is
    step = np.zeros(6)
    step[seen] = np.linalg.solve(equations.matrix[np.ix_(seen, seen)], equations.vector[seen])
    # the second-order terms of 1e-4 rad at 15 m are 1e-7 m
    assert step[[4, 5]] == pytest.approx([-0.01, 0.01], abs=2e-4)
    assert step[[0, 1]] == pytest.approx([-1e-4, 1e-4], abs=1e-5)


def test_what_noise_feigns_of_a_flat_ground_is_what_its_normal_matrix_shows_along_it() -> None:
    rng = np.random.default_rng(1)
    shown, feigned = shown_and_feigned(flat_ground(rng), flat_ground(rng))
    # along a plane all information is feigned; 5,000 normals, of which neighbours share their points
    assert feigned[[3, 4]] == pytest.approx(shown[[3, 4]], rel=0.15)


def test_what_noise_feigns_is_nothing_against_what_walls_and_ground_say() -> None:
    rng = np.random.default_rng(2)
    shown, feigned = shown_and_feigned(wall_and_ground(rng), wall_and_ground(rng))
    seen = [0, 1, 2, 4, 5]
    assert np.max(feigned[seen] / shown[seen]) < 1e-3


def test_what_is_feigned_of_a_round_shaft_is_most_of_what_its_normal_matrix_shows_of_its_yaw() -> None:
    rng = np.random.default_rng(1)
    scans = [bare_cylinder(rng) + 0.005 * rng.normal(size=(40_000, 3)) for _ in range(2)]
    shown, feigned = shown_and_feigned(*scans)
    # neighbouring normals share their points; the adjustment takes off twice what is expected
    assert 0.6 < feigned[2] / shown[2] < 1.2


def test_feigned_information_is_nought_where_too_little_matches() -> None:
    rng = np.random.default_rng(2)
    planes = planes_of_scan(flat_ground(rng)).fine
    away = StationPose("away", np.eye(3), np.array([500.0, 0.0, 0.0]))
    found = match_pair(planes, HERE, planes, away, 0.06)
    assert found.sigma_m is None
    assert not np.any(feigned_information(found, HERE, away))
    assert not np.any(pair_equations(found, HERE, away).matrix)


def test_points_along_one_line_are_not_planar() -> None:
    line = np.column_stack([np.linspace(0, 50, 5000), np.zeros(5000), np.zeros(5000)])
    rng = np.random.default_rng(1)
    assert len(planes_of_scan(line + 1e-4 * rng.normal(size=line.shape)).fine.points_m) == 0


def test_normals_of_a_wall_stand_on_it() -> None:
    cloud = planes_of_scan(wall_and_ground(np.random.default_rng(4))).fine
    on_wall = (np.abs(cloud.points_m[:, 1] - 6.0) < 0.01) & (cloud.points_m[:, 2] > 1.0)
    assert np.abs(cloud.normals[on_wall, 1]).min() > 0.99


def test_tilts_say_how_far_normals_scatter() -> None:
    cloud = planes_of_scan(flat_ground(np.random.default_rng(3))).fine
    middle = np.abs(cloud.points_m[:, :2]).max(axis=1) < 14.0
    east = cloud.normals[middle, 0] * np.sign(cloud.normals[middle, 2])
    stated = np.sqrt(np.mean(np.sum(cloud.tilts[middle, :, 0] ** 2, axis=1)))
    # 20,000 planes that share their points with a dozen others
    assert stated == pytest.approx(np.std(east), rel=0.1)


def test_a_scan_of_a_handful_of_points_has_no_planes() -> None:
    planes = planes_of_scan(np.zeros((3, 3)))
    assert [len(layer.points_m) for layer in planes.layers] == [0, 0]
