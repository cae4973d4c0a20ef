"""Planes of scans against plain numpy and scipy, and the even sample of large scans."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import KDTree

from storage.errors import ShapeError
from tasks.geometry.eigen_kernel import eigen_of
from tasks.geometry.even_choice import even_sample
from tasks.geometry.neighbours import spread_of_neighbours
from tasks.geometry.voxels import first_in_voxel
from tasks.registration import planar
from tasks.registration.even_sample import sampled
from tasks.registration.planar import (
    COARSE,
    FINE,
    FLATNESS,
    LYING,
    MIN_NEIGHBOURS,
    NEIGHBOURS,
    PlanarCloud,
    PlaneScale,
    planes_of_scan,
)
from tests.unit.registration.courtyard import Courtyard


@dataclass(frozen=True)
class InPieces:
    """A cloud as the store gives it."""

    points_m: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.points_m)

    def chunks(self, size: int) -> Iterator[NDArray[np.float64]]:
        # an uneven size, whatever is asked: where pieces end must not matter
        for start in range(0, len(self.points_m), min(size, 777)):
            yield self.points_m[start : start + min(size, 777)].copy()


def voxels_by_sorting(points_m: NDArray[np.float64], voxel_m: float) -> NDArray[np.int64]:
    cells = np.floor((points_m - points_m.min(axis=0)) / voxel_m).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    return np.sort(first)


def spread_by_tree(
    points_m: NDArray[np.float64], at: NDArray[np.int64], radius_m: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Counts, eigenvalues and normals, one point after the other."""
    _, index = KDTree(points_m).query(points_m[at], k=NEIGHBOURS, distance_upper_bound=radius_m)
    neighbours = [points_m[row[row < len(points_m)]] for row in index]
    solved = [
        np.linalg.eigh((near - near.mean(axis=0)).T @ (near - near.mean(axis=0))) for near in neighbours
    ]
    counts = np.array([len(near) for near in neighbours])
    return counts, np.array([s.eigenvalues for s in solved]), np.array([s.eigenvectors for s in solved])


def planes_by_tree(thin: NDArray[np.float64], scale: PlaneScale) -> tuple[PlanarCloud, NDArray[np.float64]]:
    at = voxels_by_sorting(thin, scale.spacing_m)
    counts, values, vectors = spread_by_tree(thin, at, scale.radius_m)
    flat = (counts >= MIN_NEIGHBOURS) & (values[:, 0] < FLATNESS * values[:, 1])
    flat &= values[:, 1] > 0.02 * values[:, 2]
    lengths = np.sqrt(values[flat, :1] / (counts[flat] - 3)[:, None] / values[flat, 1:])
    tilts = np.swapaxes(vectors[flat][:, :, 1:], 1, 2) * lengths[:, :, None]
    points = thin[at[flat]]
    found = PlanarCloud(points, vectors[flat][:, :, 0], tilts, KDTree(points), scale.reach_m)
    return found, thin[at[~flat]]


def squares(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sign of an eigenvector means nothing."""
    return np.einsum("...i,...j->...ij", vectors, vectors)


def same(ours: PlanarCloud, reference: PlanarCloud) -> None:
    assert np.array_equal(ours.points_m, reference.points_m)
    # neighbours within 1 m: rounding of their squares against the noise of 3 mm is 1e-10
    assert squares(ours.normals) == pytest.approx(squares(reference.normals), abs=1e-9)
    assert squares(ours.tilts) == pytest.approx(squares(reference.tilts), rel=1e-7, abs=1e-9)


def grazed(rng: np.random.Generator) -> NDArray[np.float64]:
    """Ground in scan lines 1 m apart, which has no fine planes."""
    along, across = rng.uniform(-40.0, 40.0, 12_000), np.repeat(np.arange(-60.0, 60.0, 1.0), 100)
    return np.column_stack([along, across, 0.01 * rng.normal(size=12_000) - 20.0])


def test_planes_are_those_of_a_search_tree_and_of_lapack(yard: Courtyard) -> None:
    scan = np.vstack([yard.scans[0].points_m, grazed(np.random.default_rng(3))])
    thin = scan[voxels_by_sorting(scan, FINE.voxel_m)]
    fine, rest = planes_by_tree(thin, FINE)
    ground, _ = planes_by_tree(rest[voxels_by_sorting(rest, COARSE.voxel_m)], COARSE)
    ours = planes_of_scan(scan)
    assert len(fine.points_m) > 500
    same(ours.fine, fine)
    lying = np.abs(ground.normals[:, 2]) > LYING
    assert np.count_nonzero(lying) > 100
    same(
        ours.coarse,
        PlanarCloud(
            ground.points_m[lying], ground.normals[lying], ground.tilts[lying], ground.tree, COARSE.reach_m
        ),
    )


@pytest.mark.parametrize("shift_m", [0.0, 4e5])
def test_the_first_of_each_voxel_is_that_of_sorting(shift_m: float) -> None:
    points = np.random.default_rng(1).normal(scale=20.0, size=(20_000, 3)) + shift_m
    assert np.array_equal(first_in_voxel(points, 0.7), voxels_by_sorting(points, 0.7))


def test_a_cloud_too_wide_for_the_grid_is_refused() -> None:
    with pytest.raises(OverflowError, match="does not fit the grid"):
        first_in_voxel(np.array([[0.0, 0.0, 0.0], [1e6, 0.0, 0.0]]), 0.3)


def test_of_more_neighbours_than_asked_the_nearest_count() -> None:
    points = np.random.default_rng(2).uniform(0.0, 2.0, (3000, 3))
    at = np.arange(0, 3000, 7)
    spread = spread_of_neighbours(points, at, 0.5, (MIN_NEIGHBOURS, NEIGHBOURS))
    counts, values, vectors = spread_by_tree(points, at, 0.5)
    assert np.array_equal(spread.enough, counts >= MIN_NEIGHBOURS)
    assert np.array_equal(spread.count, counts[spread.enough])
    assert spread.values == pytest.approx(values[spread.enough], rel=1e-9)
    assert squares(np.swapaxes(spread.vectors, 1, 2)) == pytest.approx(
        squares(np.swapaxes(vectors[spread.enough], 1, 2)), abs=1e-6
    )


def test_of_neighbours_equally_far_the_first_count() -> None:
    # on a lattice of 64 steps a metre every distance is exact, and many are equal
    rng = np.random.default_rng(3)
    points = np.unique(rng.integers(0, 128, (6000, 3)), axis=0)[rng.permutation(5900)] / 64.0
    at = np.arange(0, len(points), 11)
    spread = spread_of_neighbours(points, at, 0.25, (MIN_NEIGHBOURS, NEIGHBOURS))
    squared = np.sum((points[at, None, :] - points) ** 2, axis=2)
    nearest = np.argsort(squared, axis=1, kind="stable")[:, :NEIGHBOURS]
    assert np.count_nonzero(np.sum(squared < 0.25**2, axis=1) > NEIGHBOURS) > 50
    for row, values, count in zip(np.flatnonzero(spread.enough), spread.values, spread.count, strict=True):
        near = points[[k for k in nearest[row] if squared[row, k] < 0.25**2]]
        off = near - near.mean(axis=0)
        assert len(near) == count
        assert values == pytest.approx(np.linalg.eigvalsh(off.T @ off), abs=1e-14)


def test_neighbours_across_a_cloud_of_very_many_cubes_are_those_of_a_search_tree() -> None:
    rng = np.random.default_rng(4)
    heaps = rng.uniform(-1e5, 1e5, (300, 1, 3)) * (1.0, 1.0, 0.1)
    points = (heaps + rng.normal(scale=0.3, size=(300, 40, 3))).reshape(-1, 3)[rng.permutation(12_000)]
    at = np.arange(0, len(points), 5)
    spread = spread_of_neighbours(points, at, 0.5, (MIN_NEIGHBOURS, NEIGHBOURS))
    counts, values, _ = spread_by_tree(points, at, 0.5)
    assert np.array_equal(spread.count, counts[counts >= MIN_NEIGHBOURS])
    # coordinates of 100 km end at 1e-11 m
    assert spread.values == pytest.approx(values[spread.enough], rel=1e-7)


def test_eigenvalues_of_flat_round_and_equal_spreads_are_those_of_lapack() -> None:
    rng = np.random.default_rng(5)
    turns = np.linalg.qr(rng.normal(size=(200, 3, 3))).Q
    sizes = 10.0 ** rng.uniform(-12, 0, (200, 3))
    sizes[::10] = 1.0
    matrices = np.einsum("nij,nj,nkj->nik", turns, sizes, turns)
    matrices = (matrices + np.swapaxes(matrices, 1, 2)) / 2.0
    values, vectors = eigen_of(matrices)
    assert values == pytest.approx(np.linalg.eigvalsh(matrices), abs=1e-15)
    assert np.swapaxes(vectors, 1, 2) @ vectors == pytest.approx(
        np.broadcast_to(np.eye(3), (200, 3, 3)), abs=1e-14
    )
    back = np.einsum("nij,nj,nkj->nik", vectors, values, vectors)
    assert back == pytest.approx(matrices, abs=1e-15 * 8)


def test_a_sample_holds_one_of_every_row_and_follows_no_scan_line() -> None:
    n, most, column = 1_000_000, 100_000, 200
    kept = even_sample(n, most)
    assert len(kept) == most
    assert np.array_equal(kept // 10, np.arange(most))
    # every place in a scan line is taken as often: 500 times, give or take a standard deviation of 21
    taken = np.bincount(kept % column, minlength=column)
    assert np.abs(taken - 500).max() < 5 * 21


@pytest.mark.parametrize("n", [0, 5, 999, 1000, 1001, 1999, 2001, 123_457])
def test_a_sample_is_as_large_as_allowed_and_in_order(n: int) -> None:
    kept = even_sample(n, 1000)
    assert len(kept) == min(n, 1000)
    assert np.all(np.diff(kept) > 0)
    assert np.all((kept >= 0) & (kept < n))


def rows_by_hash(n: int, most: int) -> NDArray[np.int64]:
    """One of each row by splitmix64, all rows at once."""
    edges = np.arange(most + 1, dtype=np.int64) * n // most
    mixed = np.arange(1, most + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        mixed = (mixed ^ (mixed >> np.uint64(shift))) * np.uint64(factor)
    mixed ^= mixed >> np.uint64(31)
    return edges[:-1] + (mixed % np.diff(edges).astype(np.uint64)).astype(np.int64)


@pytest.mark.parametrize(("n", "most"), [(10_001, 10_000), (123_457, 1000), (12_470_831, 20_000)])
def test_the_loop_draws_what_whole_arrays_draw(n: int, most: int) -> None:
    assert np.array_equal(even_sample(n, most), rows_by_hash(n, most))


@dataclass(frozen=True)
class ByIndex(InPieces):
    """A cloud of which the store makes metres of some points alone."""

    def taken(self, rows: NDArray[np.int64]) -> NDArray[np.float64]:
        return self.points_m[rows]


@pytest.mark.parametrize("most", [4000, 10_000, 20_000])
def test_what_is_taken_by_index_is_sampled_as_a_whole(most: int) -> None:
    points = np.random.default_rng(1).normal(size=(10_000, 3))
    assert np.array_equal(sampled(ByIndex(points), most), sampled(points, most))


@pytest.mark.parametrize("most", [4000, 10_000, 20_000])
def test_what_is_read_in_pieces_is_sampled_as_a_whole(most: int) -> None:
    points = np.random.default_rng(1).normal(size=(10_000, 3))
    assert np.array_equal(sampled(InPieces(points), most), sampled(points, most))


def test_a_cloud_that_gives_fewer_points_than_it_says_is_refused() -> None:
    class Short(InPieces):
        def __len__(self) -> int:
            return len(self.points_m) + 1

    with pytest.raises(ShapeError, match="a cloud of 11 points gave 10"):
        sampled(Short(np.zeros((10, 3))), 100)


def test_planes_of_a_large_scan_are_those_of_its_sample(
    yard: Courtyard, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = yard.scans[0].points_m
    assert isinstance(scan, np.ndarray)
    monkeypatch.setattr(planar, "MOST_POINTS", 9000)
    same(planes_of_scan(InPieces(scan)).fine, planes_of_scan(scan[even_sample(len(scan), 9000)]).fine)
