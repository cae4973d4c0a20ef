import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.geometry.failure import FitFailure
from tasks.geometry.rotations import cross_matrix
from tasks.registration import (
    Registration,
    StableBox,
    StableSurroundings,
    StationPose,
    StationScan,
    register_stations,
    stable_surroundings,
)
from tasks.registration.adjustment import rotation_vector_from
from tasks.registration.stable import frame_covariance, pose_by_motion
from tests.unit.registration.conftest import succeed
from tests.unit.registration.courtyard import HALF_M, SIGMAS, TALL_M, Courtyard, draw_courtyard

WALLS = (
    StableBox("west wall", (-HALF_M - 1.0, -HALF_M, 0.5), (-HALF_M + 1.0, HALF_M, TALL_M)),
    StableBox("south wall", (-HALF_M, -HALF_M - 1.0, 0.5), (HALF_M, -HALF_M + 1.0, TALL_M)),
    StableBox("yard", (-HALF_M, -HALF_M, -0.5), (0.0, 0.0, 0.5)),
)


def scans_m(yard: Courtyard) -> list[NDArray[np.float64]]:
    return [scan.points_m for scan in yard.scans]


def held(surroundings: StableSurroundings | FitFailure) -> StableSurroundings:
    assert isinstance(surroundings, StableSurroundings), surroundings
    return surroundings


def all_off(yard: Courtyard, off_m: NDArray[np.float64]) -> list[StationScan]:
    return [replace(scan, position_m=scan.position_m + off_m) for scan in yard.scans]


def mean_error_m(registration: Registration, yard: Courtyard) -> NDArray[np.float64]:
    return np.asarray(
        np.mean(
            [p.position_m - q.position_m for p, q in zip(registration.poses, yard.truth, strict=True)], axis=0
        )
    )


@pytest.fixture(scope="module")
def reference(yard: Courtyard) -> Registration:
    return succeed(register_stations(yard.scans, SIGMAS))


@pytest.fixture(scope="module")
def surroundings(yard: Courtyard, reference: Registration) -> StableSurroundings:
    return held(stable_surroundings(scans_m(yard), reference, WALLS))


@pytest.fixture(scope="module")
def later() -> Courtyard:
    return draw_courtyard(2)


def test_surroundings_lie_in_their_boxes(surroundings: StableSurroundings) -> None:
    inside = np.zeros(len(surroundings.points_m), bool)
    for box in WALLS:
        above = (surroundings.points_m >= np.array(box.low_m)).all(axis=1)
        inside |= above & (surroundings.points_m <= np.array(box.high_m)).all(axis=1)
    assert inside.all()
    assert len(surroundings.normals) == len(surroundings.tilts) == len(surroundings.is_ground) == len(inside)


def test_an_epoch_whose_gnss_is_all_five_centimetres_off_comes_back(
    yard: Courtyard, reference: Registration, surroundings: StableSurroundings, later: Courtyard
) -> None:
    off = np.array([0.03, -0.04, 0.0])
    free = succeed(register_stations(all_off(later, off), SIGMAS))
    tied = succeed(register_stations(all_off(later, off), SIGMAS, stable=surroundings))
    frame = mean_error_m(reference, yard)
    # without surroundings it stays where GNSS has it, within the mean of four positions of 15 mm
    assert np.hypot(*(mean_error_m(free, later) - frame)[:2]) > 0.03
    assert np.hypot(*(mean_error_m(tied, later) - frame)[:2]) < 0.025


def test_an_epoch_is_turned_to_the_heading_of_the_reference(
    yard: Courtyard, reference: Registration, surroundings: StableSurroundings, later: Courtyard
) -> None:
    tied = succeed(register_stations(later.scans, SIGMAS, stable=surroundings))

    def yaw(registration: Registration, truth: tuple[StationPose, ...]) -> float:
        pairs = zip(registration.poses, truth, strict=True)
        return float(np.mean([rotation_vector_from(pose, true)[2] for pose, true in pairs]))

    # both frames are off by the mean of four headings of 540"; by the walls the second follows the first
    assert abs(yaw(tied, later.truth) - yaw(reference, yard.truth)) < 0.15 * SIGMAS.heading_rad


def test_poses_follow_their_surroundings_as_their_covariance_says(
    surroundings: StableSurroundings, later: Courtyard
) -> None:
    sigma = 0.02
    alone, up = np.zeros((SIX, SIX)), np.zeros((SIX, SIX))
    up[5, 5] = sigma**2
    raised_m = surroundings.points_m + np.array([0.0, 0.0, 0.004])
    lifted = replace(surroundings, points_m=raised_m, covariance=alone)
    exact = succeed(register_stations(later.scans, SIGMAS, stable=replace(surroundings, covariance=alone)))
    loose = succeed(register_stations(later.scans, SIGMAS, stable=replace(surroundings, covariance=up)))
    followed = succeed(register_stations(later.scans, SIGMAS, stable=lifted))
    for i in range(len(later.scans)):
        moved = followed.poses[i].position_m[2] - exact.poses[i].position_m[2]
        row = SIX * i + 5
        added = loose.covariance[row, row] - exact.covariance[row, row]
        # some matches change, and a shift of 4 mm changes their weights
        assert np.sqrt(added) == pytest.approx(sigma * moved / 0.004, rel=0.1)


def test_the_covariance_of_a_later_epoch_holds_that_of_the_reference(
    surroundings: StableSurroundings, later: Courtyard
) -> None:
    tied = succeed(register_stations(later.scans, SIGMAS, stable=surroundings))
    exact = replace(surroundings, covariance=np.zeros((SIX, SIX)))
    without = succeed(register_stations(later.scans, SIGMAS, stable=exact))
    added = np.linalg.eigvalsh(tied.covariance - without.covariance)
    assert added.min() > -1e-6 * added.max()
    # the walls know the shift to a fraction of the 15 mm / sqrt(4) that the reference's frame has
    sigmas = np.sqrt(np.diag(tied.covariance)).reshape(-1, SIX)
    assert sigmas[:, 3:5].min() > 0.8 * 0.015 / 2.0


def test_surroundings_that_stand_as_they_did_give_no_warning(
    surroundings: StableSurroundings, later: Courtyard
) -> None:
    assert succeed(register_stations(later.scans, SIGMAS, stable=surroundings)).warnings == ()


def test_surroundings_that_are_not_seen_again_give_a_warning(
    surroundings: StableSurroundings, later: Courtyard
) -> None:
    far = replace(surroundings, points_m=surroundings.points_m + np.array([500.0, 0.0, 0.0]))
    (warning,) = succeed(register_stations(later.scans, SIGMAS, stable=far)).warnings
    assert warning.startswith(
        "0 planes of the stable surroundings are seen again, needed 120: the epoch rests on GNSS"
    )


@pytest.mark.parametrize("off_m", [(0.1, 0.0, 0.0), (0.0, 0.0, 0.1)])
def test_gnss_ten_centimetres_off_the_surroundings_gives_a_warning_with_its_size(
    surroundings: StableSurroundings, later: Courtyard, off_m: tuple[float, float, float]
) -> None:
    registration = succeed(register_stations(all_off(later, np.array(off_m)), SIGMAS, stable=surroundings))
    (warning,) = registration.warnings
    found = re.match(r"GNSS puts the epoch ([\d.]+) m away from the stable surroundings", warning)
    assert found, warning
    # two means of four positions of 15 and 22 mm
    assert float(found[1]) == pytest.approx(0.1, abs=0.03)


def test_too_few_planes_hold_no_frame(yard: Courtyard, reference: Registration) -> None:
    small = StableBox("bench", (-30.5, 0.0, 0.0), (-29.5, 0.5, 0.5))
    failure = stable_surroundings(scans_m(yard), reference, [small])
    assert isinstance(failure, FitFailure)
    assert r"the stable surroundings (bench) hold " in failure.reason
    assert (
        "planes in the reference epoch, needed 300; make the boxes larger or choose others" in failure.reason
    )


def test_the_frame_of_one_station_is_as_uncertain_as_the_station() -> None:
    place = np.array([120.0, -80.0, 3.0])
    alone = succeed(register_stations([StationScan("ST01", np.zeros((3, 3)), place, 0.4)], SIGMAS))
    turn, shift = alone.covariance[:3, :3], alone.covariance[3:, 3:]
    covariance = frame_covariance(alone)
    # a frame turned by w about the site's origin moves the scanner by w x p + t
    arm = cross_matrix(place)
    assert covariance[:3, :3] == pytest.approx(turn, rel=1e-9, abs=1e-18)
    assert covariance[3:, 3:] == pytest.approx(shift + arm @ turn @ arm.T, rel=1e-9, abs=1e-15)
    assert covariance[3:, :3] == pytest.approx(arm @ turn, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("parameter", range(SIX))
def test_a_pose_moves_with_its_frame_as_its_derivative_says(parameter: int) -> None:
    pose = StationPose("ST01", np.eye(3), np.array([120.0, -80.0, 3.0]))
    motion = 1e-7 * np.eye(SIX)[parameter]
    moved = pose.position_m + np.cross(motion[:3], pose.position_m) + motion[3:]
    step = np.r_[motion[:3], moved - pose.position_m]
    assert pose_by_motion(pose) @ motion == pytest.approx(step, abs=1e-14)


def test_four_stations_know_their_frame_better_than_one(reference: Registration) -> None:
    sigmas = np.sqrt(np.diag(frame_covariance(reference)))
    stated = [SIGMAS.level_rad] * 2 + [SIGMAS.heading_rad, 0.015, 0.015, 0.0225]
    # plumb and place are those of four instruments; the heading comes from their places, too
    assert sigmas[[0, 1]] == pytest.approx(np.array(stated)[[0, 1]] / 2.0, rel=0.1)
    assert sigmas[5] == pytest.approx(0.0225 / 2.0, rel=0.1)
    assert sigmas[2] < SIGMAS.heading_rad / 2.0
