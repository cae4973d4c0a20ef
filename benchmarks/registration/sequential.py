"""The peer small_gicp: every station by GICP onto those that are placed already, 6 free parameters each."""

from typing import Final

import numpy as np
import small_gicp
from numpy.typing import NDArray

from benchmarks.registration.known import KnownEpoch
from benchmarks.registration.unadjusted import matrix_of, pose_of, stated_poses, unadjusted
from tasks.geometry.failure import FitFailure
from tasks.registration import Registration

VOXEL_M: Final = 0.25
THREADS: Final = 2
GATES_M: Final = (1.0, 0.3)
"""A heading of 0.15 deg moves the shaft by 0.65 m at 250 m; the second pass drops what the first still needed."""

ITERATIONS: Final = 100
ROTATION_STEP_RAD: Final = 1e-6
SHIFT_STEP_M: Final = 1e-4
FURTHEST_M: Final = 0.9 * 2**20 * VOXEL_M
"""Its voxels have 21 bits: what lies further out is dropped with no more than a line on stderr."""


def place_one_after_the_other(epoch: KnownEpoch) -> Registration | FitFailure:
    """Keep the first station as stated, then align each to all before it; coordinates about the stations' mean."""
    stated = stated_poses(epoch)
    centre_m = np.mean([pose.position_m for pose in stated], axis=0)
    poses, placed = [stated[0]], [_placed(_thinned(epoch.scans[0].points_m), matrix_of(stated[0], centre_m))]
    for scan, start in zip(epoch.scans[1:], stated[1:], strict=True):
        source = _thinned(scan.points_m)
        found = _align(np.vstack(placed), source, matrix_of(start, centre_m))
        if isinstance(found, FitFailure):
            return FitFailure(f"{scan.station}: {found.reason}")
        poses.append(pose_of(scan.station, found, centre_m))
        placed.append(_placed(source, found))
    return unadjusted(poses, epoch.sigmas)


def _thinned(points_m: NDArray[np.float64]) -> small_gicp.PointCloud:
    if np.abs(points_m).max() > FURTHEST_M:
        raise SystemExit(f"small_gicp needs coordinates below {FURTHEST_M:.0f} m; centre the cloud")
    return small_gicp.preprocess_points(points_m, VOXEL_M, num_threads=THREADS)[0]


def _placed(cloud: small_gicp.PointCloud, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(cloud.points()[:, :3] @ matrix[:3, :3].T + matrix[:3, 3])


def _align(
    target_m: NDArray[np.float64], source: small_gicp.PointCloud, start: NDArray[np.float64]
) -> NDArray[np.float64] | FitFailure:
    target, tree = small_gicp.preprocess_points(target_m, VOXEL_M, num_threads=THREADS)
    matrix = start
    for gate_m in GATES_M:
        result = small_gicp.align(
            target,
            source,
            tree,
            matrix,
            registration_type="GICP",
            max_correspondence_distance=gate_m,
            num_threads=THREADS,
            max_iterations=ITERATIONS,
            rotation_epsilon=ROTATION_STEP_RAD,
            translation_epsilon=SHIFT_STEP_M,
        )
        # on failure it answers with the start or the identity
        if not result.converged:
            return FitFailure(f"small_gicp did not converge within {ITERATIONS} iterations")
        matrix = np.asarray(result.T_target_source)
    return matrix
