"""A scan goes into the store whole or not at all, in memory that does not grow with it."""

import threading
import time
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from storage.workspace import Workspace, open_workspace
from tasks import stored_scan
from tasks.ingest import ScanRequest, ScanStream, read_scan
from tasks.stored_scan import AT_ONCE, store_scan
from tests.unit.ingest.clouds import rows_of, wall_points, write_las, write_text


@pytest.fixture
def ws(tmp_path: Path) -> Workspace:
    return open_workspace(tmp_path / "ws")


def test_what_is_stored_is_what_is_read(ws: Workspace, tmp_path: Path) -> None:
    points_m = wall_points()
    for path in (
        write_las(tmp_path / "a.laz", points_m),
        write_las(tmp_path / "a.las", points_m),
        write_text(tmp_path / "a.xyz", rows_of(points_m)),
    ):
        scan, stored = read_scan(path), store_scan(ws, path, ScanRequest())
        np.testing.assert_array_equal(stored.cloud.whole(), scan.points_m, strict=True)
        assert (stored.facts.n_in_file, stored.facts.notes) == (scan.n_in_file, scan.notes)


def test_laz_and_las_of_the_same_points_are_one_artifact(ws: Workspace, tmp_path: Path) -> None:
    refs = {
        store_scan(ws, write_las(tmp_path / name, wall_points()), ScanRequest()).ref
        for name in ("a.laz", "a.las")
    }
    assert len(refs) == 1


def test_a_scan_that_is_refused_at_its_end_is_not_stored(ws: Workspace, tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.laz", wall_points(2000), scale=0.1)
    with pytest.raises(InputError, match="needs coordinates finer than"):
        store_scan(ws, path, ScanRequest())
    assert [path for path in ws.artifacts.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_memory_does_not_grow_with_the_scan(
    ws: Workspace, tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tasks.ingest.las_points.PIECE_BYTES", 3 << 20)
    monkeypatch.setattr("tasks.ingest.las_points.READ_BYTES", 3 << 20)
    peaks = []
    for n_points in (200_000, 800_000):
        path = write_las(tmp_path / f"{n_points}{suffix}", wall_points(n_points))
        tracemalloc.start()
        try:
            store_scan(ws, path, ScanRequest())
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    # the larger has 14 MB more as float64; the samples for the checks, 1.2 MB each, are full in both
    assert peaks[1] < peaks[0] + 3e6


def test_no_more_scans_than_two_are_under_way_at_once(
    ws: Workspace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    under_way, most = [], []

    def slow(path: Path, request: ScanRequest) -> ScanStream:
        real = stream(path, request)

        def pieces(tell: object) -> Iterator[object]:
            under_way.append(path)
            most.append(len(under_way))
            time.sleep(0.02)
            yield from real.pieces(tell)  # type: ignore[arg-type]
            under_way.remove(path)

        return ScanStream(real.grid, pieces)  # type: ignore[arg-type]

    stream = stored_scan.stream_scan
    monkeypatch.setattr(stored_scan, "stream_scan", slow)
    path = write_las(tmp_path / "a.laz", wall_points())
    threads = [threading.Thread(target=store_scan, args=(ws, path, ScanRequest())) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(most) == 6
    assert max(most) <= AT_ONCE
