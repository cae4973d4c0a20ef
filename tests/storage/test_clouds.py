"""A stored cloud gives back the points that went in, in whatever parts they are asked for."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from storage import clouds
from storage.artifacts import artifact_path, is_whole, is_whole_by_hash, put_array
from storage.clouds import StoredCloud, open_cloud, put_cloud
from storage.errors import InputError, ShapeError, StorageError
from storage.integer_grid import IntegerGrid
from storage.places import workspace_at
from storage.verify import verify_workspace_deeply
from storage.workspace import Workspace
from tests.storage.s3_places import new_place, use_endpoint

GRID = IntegerGrid((1e-4, 2e-4, 1e-3), (12.5, -3.25, 100.0), 0.3048, (1.0, 2.0, 3.0), swap_axes=True)
PLAIN = IntegerGrid((1e-4, 1e-4, 1e-4), (0.0, 0.0, 0.0))


def integers(n_points: int = 20_000) -> NDArray[np.int32]:
    return np.random.default_rng(2).integers(-(2**31), 2**31, (n_points, 3), dtype=np.int32)


def metres(rows: NDArray[np.int32], grid: IntegerGrid) -> NDArray[np.float64]:
    """The arithmetic of a scan as one reads it: unit, origin, axes."""
    points = rows * np.array(grid.scale) + np.array(grid.shift)
    points_m = points * grid.unit_m - np.array(grid.origin_m)
    return points_m[:, (1, 0, 2)] if grid.swap_axes else points_m


def cut(rows: NDArray[np.int32], places: Sequence[int]) -> Iterator[NDArray[np.int32]]:
    yield from np.split(rows, places)


@pytest.fixture(params=[GRID, PLAIN], ids=["all", "plain"])
def grid(request: pytest.FixtureRequest) -> IntegerGrid:
    found: IntegerGrid = request.param
    return found


def stored(ws: Workspace, grid: IntegerGrid = GRID, n_points: int = 20_000) -> StoredCloud:
    return open_cloud(ws, put_cloud(ws, "scan", cut(integers(n_points), [7, 7, 9000]), grid))


def test_metres_are_those_of_float64_arithmetic_bit_for_bit(ws: Workspace, grid: IntegerGrid) -> None:
    expected = metres(integers(), grid)
    np.testing.assert_array_equal(stored(ws, grid).whole(), expected, strict=True)
    assert stored(ws, grid).whole().flags.c_contiguous


@pytest.mark.parametrize("size", [1, 999, 20_000, 10**9])
def test_chunks_are_the_whole_in_order(ws: Workspace, size: int) -> None:
    cloud = stored(ws, n_points=2_000)
    parts = list(cloud.chunks(size))
    assert [len(part) for part in parts[:-1]] == [size] * (len(parts) - 1)
    np.testing.assert_array_equal(np.concatenate(parts), cloud.whole())


@pytest.mark.parametrize(("start", "stop"), [(0, 0), (0, 1), (5, 17), (19_999, 20_000), (20_000, 20_000)])
def test_rows_are_those_of_the_whole(ws: Workspace, start: int, stop: int) -> None:
    cloud = stored(ws)
    np.testing.assert_array_equal(cloud.rows(start, stop), cloud.whole()[start:stop], strict=True)


@pytest.mark.parametrize(("start", "stop"), [(-1, 3), (3, 2), (0, 20_001)])
def test_rows_that_are_not_there_are_a_fault_of_the_caller(ws: Workspace, start: int, stop: int) -> None:
    with pytest.raises(ShapeError, match="needs points from 0 to 20000"):
        stored(ws).rows(start, stop)


@pytest.mark.parametrize("most", [0, 1, 700, 20_000])
def test_points_that_are_taken_are_those_of_the_whole(
    ws: Workspace, grid: IntegerGrid, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clouds, "CHUNK_POINTS", 777)
    rows = np.sort(np.random.default_rng(7).choice(20_000, most, replace=False))
    cloud = stored(ws, grid)
    np.testing.assert_array_equal(cloud.taken(rows), cloud.whole()[rows], strict=True)
    plain = open_cloud(ws, put_array(ws, "scan", cloud.whole()))
    np.testing.assert_array_equal(plain.taken(rows), cloud.whole()[rows], strict=True)


@pytest.mark.parametrize("rows", [[-1, 3], [3, 3], [5, 2], [7, 20_000]])
def test_points_that_are_not_there_cannot_be_taken(ws: Workspace, rows: list[int]) -> None:
    with pytest.raises(ShapeError, match="needs ascending indices from 0 to 19999"):
        stored(ws).taken(np.array(rows))


@pytest.mark.parametrize("most", [1, 2, 38, 39, 40, 1000, 19_999, 20_000, 30_000])
def test_a_sample_is_every_so_many_points_and_no_more_than_asked(
    ws: Workspace, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clouds, "CHUNK_POINTS", 777)
    cloud = stored(ws)
    step = -(-len(cloud) // most)
    sample = cloud.sample(most)
    assert len(sample) <= most
    np.testing.assert_array_equal(sample, cloud.whole()[::step], strict=True)


def test_an_empty_cloud_is_a_cloud(ws: Workspace) -> None:
    cloud = open_cloud(ws, put_cloud(ws, "scan", (), PLAIN))
    assert (len(cloud), cloud.whole().shape, cloud.sample(5).shape) == (0, (0, 3), (0, 3))
    assert list(cloud.chunks()) == []


def test_metres_without_a_grid_come_back(ws: Workspace) -> None:
    points_m = metres(integers(), GRID)
    cloud = open_cloud(ws, put_cloud(ws, "scan", (points_m[:50], points_m[50:])))
    np.testing.assert_array_equal(cloud.whole(), points_m, strict=True)
    np.testing.assert_array_equal(cloud.sample(100), points_m[::200], strict=True)


def test_an_array_of_points_is_read_as_a_cloud(ws: Workspace) -> None:
    points_m = metres(integers(), GRID)
    cloud = open_cloud(ws, put_array(ws, "shaft", points_m))
    np.testing.assert_array_equal(cloud.whole(), points_m, strict=True)
    np.testing.assert_array_equal(cloud.rows(3, 9), points_m[3:9], strict=True)


@pytest.mark.parametrize("array", [np.zeros(6), np.zeros((2, 2)), np.zeros((2, 3), np.float32)])
def test_another_array_is_no_cloud(ws: Workspace, array: NDArray[np.float64]) -> None:
    with pytest.raises(StorageError, match=r"needs points \(n, 3\) of float64; it holds"):
        open_cloud(ws, put_array(ws, "stations", array))


def test_the_digest_does_not_depend_on_the_pieces_but_on_points_and_grid(ws: Workspace) -> None:
    rows = integers(1000)
    refs = [put_cloud(ws, "scan", cut(rows, places), GRID) for places in ([], [1, 2], [500])]
    assert len(set(refs)) == 1
    others = [put_cloud(ws, "scan", cut(rows[::-1], []), GRID), put_cloud(ws, "scan", cut(rows, []), PLAIN)]
    assert len({ref.sha256 for ref in (*refs, *others)}) == 3
    # 12 bytes a point and a trailer
    assert refs[0].size == 12 * 1000 + 128


def test_equal_points_have_equal_fingerprints_however_they_are_stored(ws: Workspace) -> None:
    exact = metres(integers(), GRID)
    one = stored(ws, GRID)
    assert open_cloud(ws, put_cloud(ws, "scan", (exact,))).fingerprint() == one.fingerprint()
    moved = exact + 1e-9
    assert open_cloud(ws, put_cloud(ws, "scan", (moved,))).fingerprint() != one.fingerprint()
    assert open_cloud(ws, put_cloud(ws, "scan", (exact[:-1],))).fingerprint() != one.fingerprint()


def test_pieces_that_fail_leave_nothing_behind(ws: Workspace) -> None:
    def pieces() -> Iterator[NDArray[np.int32]]:
        yield integers(10)
        raise InputError("the scan is cut short")

    with pytest.raises(InputError, match="cut short"):
        put_cloud(ws, "scan", pieces(), GRID)
    assert [path for path in ws.artifacts.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("piece", [np.zeros((2, 3)), np.zeros((2, 2), np.int32), np.zeros(3, np.int32)])
def test_pieces_of_another_shape_or_type_are_a_fault_of_the_caller(
    ws: Workspace, piece: NDArray[np.int32]
) -> None:
    with pytest.raises(ShapeError, match=r"needs pieces \(m, 3\) of int32; got"):
        put_cloud(ws, "scan", (piece,), GRID)


def test_a_torn_cloud_is_told_as_any_torn_artifact_is(ws: Workspace) -> None:
    ref = put_cloud(ws, "scan", (integers(10),), GRID)
    cloud, path = open_cloud(ws, ref), artifact_path(ws, ref)
    os.truncate(path, 30)
    assert not is_whole(ws, ref)
    with pytest.raises(StorageError, match="is damaged"):
        open_cloud(ws, ref)
    with pytest.raises(StorageError, match=r"is damaged .*; delete it and run again"):
        cloud.whole()
    path.unlink()
    with pytest.raises(StorageError, match="run again"):
        open_cloud(ws, ref)
    with pytest.raises(StorageError, match="run again"):
        cloud.rows(0, 1)


@pytest.mark.parametrize("at", [-128, -120, -112])
def test_a_trailer_that_lies_is_told(ws: Workspace, at: int) -> None:
    """Magic, form, number of points: a flipped bit in them is seen before points are made of it."""
    ref = put_cloud(ws, "scan", (integers(10),), GRID)
    _flip(artifact_path(ws, ref), at)
    with pytest.raises(StorageError, match="is damaged"):
        open_cloud(ws, ref)


def test_deep_verification_finds_a_flipped_byte_in_a_cloud(ws: Workspace) -> None:
    ref = put_cloud(ws, "scan", (integers(10),), GRID)
    assert is_whole_by_hash(ws, ref)
    assert verify_workspace_deeply(ws).faults == ()
    _flip(artifact_path(ws, ref), 5)
    (fault,) = verify_workspace_deeply(ws).faults
    assert fault.where == ref.name


@pytest.mark.parametrize("where", ["folder", "s3"])
def test_a_cloud_is_the_same_wherever_it_lies(
    where: str, ws: Workspace, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    if where == "s3":
        endpoint = request.getfixturevalue("s3_endpoint")
        use_endpoint(endpoint, tmp_path / "cache", monkeypatch)
        ws = workspace_at(new_place(endpoint))
    ref = put_cloud(ws, "scan", cut(integers(100), [40]), GRID)
    np.testing.assert_array_equal(open_cloud(ws, ref).whole(), metres(integers(100), GRID), strict=True)
    assert put_cloud(ws, "scan", cut(integers(100), []), GRID) == ref
    assert is_whole(ws, ref)


def test_metres_need_three_columns() -> None:
    with pytest.raises(ShapeError, match=r"needs integers and points \(n, 3\)"):
        GRID.metres(np.zeros((2, 2), np.int32))


def _flip(path: Path, at: int) -> None:
    content = bytearray(path.read_bytes())
    content[at] ^= 64
    path.write_bytes(content)
