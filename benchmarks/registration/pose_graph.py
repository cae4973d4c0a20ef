"""The peer open3d: its tutorial's multiway registration, point-to-plane pair by pair and a pose graph."""

from itertools import combinations
from types import ModuleType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.registration.known import KnownEpoch
from benchmarks.registration.unadjusted import matrix_of, pose_of, stated_poses, unadjusted
from tasks.open3d_import import import_open3d
from tasks.registration import Registration

VOXEL_M: Final = 0.25
COARSE_M: Final = 15.0 * VOXEL_M
FINE_M: Final = 1.5 * VOXEL_M
"""Correspondence distances, in voxels as in the tutorial."""

NORMAL_RADIUS_M: Final = 4.0 * VOXEL_M
OUTLIER_NEIGHBOURS: Final = 20
OUTLIER_RATIO: Final = 2.0
PRUNE: Final = 0.25


def place_by_pose_graph(epoch: KnownEpoch) -> Registration:
    """Clouds at their stated poses, every pair by ICP in two steps, then the pose graph with the first station kept."""
    o3d = import_open3d()
    stated = stated_poses(epoch)
    centre_m = np.mean([pose.position_m for pose in stated], axis=0)
    starts = [matrix_of(pose, centre_m) for pose in stated]
    clouds = [_prepared(o3d, scan.points_m, start) for scan, start in zip(epoch.scans, starts, strict=True)]
    moves = _optimised(o3d, clouds)
    poses = [
        pose_of(scan.station, move @ start, centre_m)
        for scan, move, start in zip(epoch.scans, moves, starts, strict=True)
    ]
    return unadjusted(poses, epoch.sigmas)


def _prepared(o3d: ModuleType, points_m: NDArray[np.float64], start: NDArray[np.float64]) -> object:
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points_m))
    thin = cloud.voxel_down_sample(VOXEL_M).transform(start)
    thin, _ = thin.remove_statistical_outlier(OUTLIER_NEIGHBOURS, OUTLIER_RATIO)
    thin.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=NORMAL_RADIUS_M, max_nn=30))
    return thin


def _optimised(o3d: ModuleType, clouds: list[object]) -> list[NDArray[np.float64]]:
    """What moves each cloud (4, 4)."""
    registration = o3d.pipelines.registration
    graph = registration.PoseGraph()
    odometry = np.eye(4)
    graph.nodes.append(registration.PoseGraphNode(odometry))
    for source, target in combinations(range(len(clouds)), 2):
        transformation, information = _pairwise(registration, clouds[source], clouds[target])
        is_next = target == source + 1
        if is_next:
            odometry = transformation @ odometry
            graph.nodes.append(registration.PoseGraphNode(np.linalg.inv(odometry)))
        graph.edges.append(
            registration.PoseGraphEdge(source, target, transformation, information, uncertain=not is_next)
        )
    registration.global_optimization(
        graph,
        registration.GlobalOptimizationLevenbergMarquardt(),
        registration.GlobalOptimizationConvergenceCriteria(),
        registration.GlobalOptimizationOption(
            max_correspondence_distance=FINE_M, edge_prune_threshold=PRUNE, reference_node=0
        ),
    )
    return [np.asarray(node.pose) for node in graph.nodes]


def _pairwise(
    registration: ModuleType, source: object, target: object
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Transformation (4, 4) of the source onto the target, and its information (6, 6)."""
    matrix = np.eye(4)
    for distance_m in (COARSE_M, FINE_M):
        matrix = registration.registration_icp(
            source, target, distance_m, matrix, registration.TransformationEstimationPointToPlane()
        ).transformation
    information = registration.get_information_matrix_from_point_clouds(source, target, FINE_M, matrix)
    return np.asarray(matrix), np.asarray(information)
