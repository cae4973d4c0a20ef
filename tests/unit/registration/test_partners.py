"""Partners that are kept from pose to pose against a search at every pose."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.geometry.rotations import rotation_from_vector
from tasks.registration.pairs import (
    Matches,
    derivatives,
    feigned_information,
    match_pair,
    match_partners,
    match_weights,
    pair_equations,
)
from tasks.registration.partners import Partners
from tasks.registration.planar import PlanarCloud, planes_of_scan
from tasks.registration.station import StationPose
from tests.unit.registration.courtyard import Courtyard


def moved(pose: StationPose, rng: np.random.Generator, size_m: float) -> StationPose:
    turn = rotation_from_vector(size_m / 30.0 * rng.normal(size=3))
    return StationPose(pose.station, turn @ pose.rotation, pose.position_m + size_m * rng.normal(size=3))


def searched(
    source: PlanarCloud, pose: StationPose, target: PlanarCloud, other: StationPose, gate_m: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Plain numpy: which planes of the source match which of the target, and their distances."""
    points, own = pose.to_site(source.points_m), source.normals @ pose.rotation.T
    local = (points - other.position_m) @ other.rotation
    distance, index = target.tree.query(local, distance_upper_bound=max(gate_m, target.reach_m))
    near = np.flatnonzero(np.isfinite(distance))
    planes = target.normals[index[near]] @ other.rotation.T
    cosine = np.einsum("ij,ij->i", planes, own[near])
    both = planes + own[near] * np.sign(cosine)[:, None]
    residuals = 0.5 * np.einsum("ij,ij->i", both, points[near] - other.to_site(target.points_m[index[near]]))
    good = (np.abs(cosine) > np.cos(np.radians(25.0))) & (np.abs(residuals) <= gate_m)
    return near[good], index[near][good], residuals[good]


def test_kept_partners_are_those_of_a_search_at_every_pose(yard: Courtyard) -> None:
    rng = np.random.default_rng(4)
    source, target = (planes_of_scan(scan.points_m).fine for scan in yard.scans[:2])
    partners = Partners(source, target)
    # nearer to the truth, as in an adjustment, then a leap back, then gates that open again
    steps = zip(
        (0.5, 0.2, 0.05, 0.01, 1e-3, 1e-4, 0.0, 0.7, 1e-3, 0.3),
        (1.2, 0.84, 0.5, 0.3, 0.1, 0.06, 0.06, 0.06, 0.06, 1.5),
        strict=True,
    )
    n_matches = []
    for size_m, gate_m in steps:
        pose, other = moved(yard.truth[0], rng, size_m), moved(yard.truth[1], rng, size_m / 3.0)
        ours = match_partners(partners, source, pose, other, gate_m)
        mine, theirs, residuals = searched(source, pose, target, other, gate_m)
        n_matches.append(len(mine))
        assert ours.source.points_m == pytest.approx(pose.to_site(source.points_m[mine]), abs=1e-12)
        assert ours.target.points_m == pytest.approx(other.to_site(target.points_m[theirs]), abs=1e-12)
        assert ours.residuals_m == pytest.approx(residuals, abs=1e-12)
        assert ours.target.normals == pytest.approx(target.normals[theirs] @ other.rotation.T, abs=1e-12)
        assert ours.source.tilts == pytest.approx(source.tilts[mine] @ pose.rotation.T, abs=1e-12)
    assert min(n_matches) > 0
    assert max(n_matches) > 500


@pytest.fixture(scope="module")
def matched(yard: Courtyard) -> Matches:
    source, target = (planes_of_scan(scan.points_m).fine for scan in yard.scans[:2])
    return match_pair(source, yard.truth[0], target, yard.truth[1], 0.06)


def test_equations_of_a_pair_are_the_products_of_its_derivatives(yard: Courtyard, matched: Matches) -> None:
    jacobian, weights = derivatives(matched, *yard.truth[:2]), match_weights(matched)
    assert weights is not None
    equations = pair_equations(matched, *yard.truth[:2])
    weighted = jacobian * weights[:, None]
    size = np.sqrt(np.diag(weighted.T @ jacobian))
    assert equations.matrix / np.outer(size, size) == pytest.approx(
        weighted.T @ jacobian / np.outer(size, size), abs=1e-12
    )
    assert equations.vector / size == pytest.approx(-weighted.T @ matched.residuals_m / size, abs=1e-9)


def test_feigned_information_is_the_sum_over_all_tilts(yard: Courtyard, matched: Matches) -> None:
    weights = match_weights(matched)
    assert weights is not None
    still = np.zeros_like(matched.source.normals)
    total = np.zeros((12, 12))
    for k in range(2):
        for own, other in ((matched.source.tilts[:, k], still), (still, matched.target.tilts[:, k])):
            tilted = replace(
                matched,
                source=replace(matched.source, normals=own),
                target=replace(matched.target, normals=other),
            )
            wrong = derivatives(tilted, *yard.truth[:2])
            total += (wrong * weights[:, None]).T @ wrong
    size = np.sqrt(np.diag(total))
    ours = feigned_information(matched, *yard.truth[:2])
    assert ours / np.outer(size, size) == pytest.approx(total / np.outer(size, size), abs=1e-12)
