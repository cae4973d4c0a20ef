"""A scan that its file's pose levels stands plumb where the pose put it; one that is taken as plumb is told if it is not."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.conventions import rotation_site_scanner
from tasks.geometry.rotations import rotation_from_vector
from tasks.ingest import FilePose
from tasks.ingest.levelling import level_scan
from tests.unit.ingest.clouds import wall_points

HERE = Path("scan.e57")
SHIFT_M = np.array([512_345.0, 4_412_345.0, 1_234.0])
POINTS_M = wall_points(50)


def pose(*tilt_deg: float, heading_deg: float = 130.0) -> FilePose:
    tilt = rotation_from_vector(np.radians(np.array(tilt_deg, float)))
    return FilePose(rotation_site_scanner(np.radians(heading_deg)) @ tilt, SHIFT_M)


def placed(points_m: NDArray[np.float64], at: FilePose) -> NDArray[np.float64]:
    return points_m @ at.rotation.T + at.translation


@pytest.mark.parametrize(
    "tilt_deg", [(0, 0, 0), (0.3, -0.2, 0), (40, 15, 3), (90, 0, 0), (180, 0, 0), (0, 180, 0)]
)
def test_a_levelled_scan_lies_where_its_pose_put_it(tilt_deg: tuple[float, float, float]) -> None:
    stated = pose(*tilt_deg)
    levelled = level_scan(HERE, POINTS_M, stated, "file")
    assert levelled.pose is not None
    # rounding at coordinates of 4e6 m
    assert np.abs(placed(levelled.points_m, levelled.pose) - placed(POINTS_M, stated)).max() < 1e-8


@pytest.mark.parametrize("tilt_deg", [(0.3, -0.2, 0), (40, 15, 3), (180, 0, 0)])
def test_what_is_left_of_the_pose_is_a_heading(tilt_deg: tuple[float, float, float]) -> None:
    left = level_scan(HERE, POINTS_M, pose(*tilt_deg), "file").pose
    assert left is not None
    assert left.rotation[2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
    assert left.rotation[:, 2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)


def test_a_plumb_pose_leaves_the_points_to_the_last_bit() -> None:
    levelled = level_scan(HERE, POINTS_M, pose(0, 0, 0), "file")
    assert np.array_equal(levelled.points_m, POINTS_M)
    assert levelled.notes == ()


def test_a_file_without_pose_cannot_level() -> None:
    with pytest.raises(
        InputError, match=r'scan\.e57: needs the pose of the scan for pose = "file", came a file that'
    ):
        level_scan(HERE, POINTS_M, None, "file")


def test_a_scan_that_is_taken_as_plumb_keeps_points_and_pose() -> None:
    stated = pose(0.3, 0.0, 0.0)
    taken = level_scan(HERE, POINTS_M, stated, "scanner")
    assert taken.points_m is POINTS_M
    assert taken.pose is stated


# a note is due beyond 0.01 deg
@pytest.mark.parametrize(("tilt_deg", "is_told"), [(0.009, False), (0.011, True), (179.0, True)])
def test_a_scan_taken_as_plumb_against_its_pose_is_told(tilt_deg: float, is_told: bool) -> None:
    told = level_scan(HERE, POINTS_M, pose(tilt_deg, 0.0, 0.0), "scanner").notes
    assert [note for note in told if f"{tilt_deg:.3f} deg off plumb" in note] == list(told)
    assert bool(told) == is_told


def test_a_pose_without_turn_and_shift_is_told() -> None:
    (told,) = level_scan(HERE, POINTS_M, FilePose(np.eye(3), np.zeros(3)), "file").notes
    assert told.startswith("its file states neither a turn nor a shift")
