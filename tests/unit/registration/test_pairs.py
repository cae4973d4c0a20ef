import numpy as np
import pytest

from tasks.conventions import rotation_site_scanner
from tasks.geometry.rotations import rotation_from_vector
from tasks.registration.pairs import _jacobian, _matches
from tasks.registration.planar import planar_cloud
from tasks.registration.station import StationPose


def wall_and_ground(rng: np.random.Generator) -> np.ndarray:
    ground = np.column_stack([rng.uniform(-15, 15, (20_000, 2)), np.zeros(20_000)])
    wall = np.column_stack([rng.uniform(-15, 15, 10_000), np.full(10_000, 6.0), rng.uniform(0, 8, 10_000)])
    return np.vstack([ground, wall]) + 0.001 * rng.normal(size=(30_000, 3))


def moved(pose: StationPose, step: np.ndarray) -> StationPose:
    return StationPose(
        pose.station, rotation_from_vector(step[:3]) @ pose.rotation, pose.position_m + step[3:]
    )


@pytest.mark.parametrize("parameter", range(12))
def test_jacobian_is_the_numeric_derivative_of_the_residuals(parameter: int) -> None:
    rng = np.random.default_rng(2)
    site = wall_and_ground(rng)
    poses = [
        StationPose(name, rotation_site_scanner(heading), np.array(position))
        for name, heading, position in (("a", 0.3, (4.0, -3.0, 1.5)), ("b", -1.1, (-6.0, 1.0, 1.8)))
    ]
    clouds = [planar_cloud((site - pose.position_m) @ pose.rotation) for pose in poses]
    points, normals = clouds[0].points_m[::50], clouds[0].normals[::50]

    def residuals(step: np.ndarray) -> np.ndarray:
        source, target = moved(poses[0], step[:6]), moved(poses[1], step[6:])
        return _matches(
            source.to_site(points), normals @ source.rotation.T, clouds[1], target, gate_m=0.5
        ).residuals_m

    matched = _matches(
        poses[0].to_site(points), normals @ poses[0].rotation.T, clouds[1], poses[1], gate_m=0.5
    )
    step = 1e-7 * np.eye(12)[parameter]
    numeric = (residuals(step) - residuals(-step)) / 2e-7
    # second-order terms of a step of 1e-7 at 20 m are far below
    assert _jacobian(matched, *poses)[:, parameter] == pytest.approx(numeric, abs=1e-5)


def test_points_along_one_line_are_not_planar() -> None:
    line = np.column_stack([np.linspace(0, 50, 5000), np.zeros(5000), np.zeros(5000)])
    rng = np.random.default_rng(1)
    assert len(planar_cloud(line + 1e-4 * rng.normal(size=line.shape)).points_m) == 0


def test_normals_of_a_wall_stand_on_it() -> None:
    rng = np.random.default_rng(4)
    cloud = planar_cloud(wall_and_ground(rng))
    on_wall = (np.abs(cloud.points_m[:, 1] - 6.0) < 0.01) & (cloud.points_m[:, 2] > 1.0)
    assert np.abs(cloud.normals[on_wall, 1]).min() > 0.99
