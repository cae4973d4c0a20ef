"""Points that come in pieces are the points of the file, and the checks are those of the whole."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError
from storage.integer_grid import IntegerGrid
from tasks.ingest import ScanFacts, ScanRequest, describe_scan, read_scan, stream_scan
from tasks.ingest.empty_returns import zero_cell
from tasks.ingest.scan import METRES_PER_UNIT, box_of
from tasks.ingest.stream import EverySo
from tests.shared import needs_shared
from tests.unit.ingest.clouds import rows_of, wall_points, write_las, write_text
from tests.unit.ingest.test_shared_files import FEET, GOOD

FAR_M = np.array([5e5, 1e6, 0.0])
FOOT = ScanRequest(unit="foot", origin_m=(3.0, 20.0, 5.0), swap_axes=True)


def gone_through(path: Path, request: ScanRequest) -> tuple[NDArray[np.float64], ScanFacts, list[int]]:
    """All points (n, 3) in metres, the facts, and how many points each piece had."""
    stream, facts = stream_scan(path, request), list[ScanFacts]()
    pieces: list[NDArray[Any]] = [piece.copy() for piece in stream.pieces(facts.append)]
    rows = np.concatenate(pieces)
    return (
        rows if stream.grid is None else stream.grid.metres(rows),
        facts[0],
        [len(piece) for piece in pieces],
    )


def as_laspy_gives(path: Path, request: ScanRequest) -> NDArray[np.float64]:
    """Points (n, 3) in metres by laspy and plain arithmetic, in the order of operations before streams."""
    las = laspy.read(path)
    points_m = np.column_stack([np.asarray(las[name]) for name in "xyz"])
    points_m = points_m[(points_m != 0.0).any(axis=1)]
    if request.unit != "metre":
        points_m = points_m * METRES_PER_UNIT[request.unit]
    if any(request.origin_m):
        points_m = points_m - np.array(request.origin_m)
    return points_m[:, (1, 0, 2)] if request.swap_axes else points_m


@needs_shared
@pytest.mark.parametrize("path", GOOD, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_shared_files_give_the_points_of_laspy_bit_for_bit(path: Path) -> None:
    unit = FEET.get(path.name, "metre")
    for request in (
        ScanRequest(unit=unit),
        ScanRequest(unit=unit, origin_m=(10.5, -3.1, 7.7), swap_axes=True),
    ):
        expected = as_laspy_gives(path, request)
        np.testing.assert_array_equal(read_scan(path, request).points_m, expected, strict=True)
        np.testing.assert_array_equal(gone_through(path, request)[0], expected, strict=True)


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize("point_format", [0, 3, 6, 8])
def test_pieces_are_the_file_in_order(
    tmp_path: Path, suffix: str, point_format: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tasks.ingest.las_points.PIECE_BYTES", 30 * 7_001)
    monkeypatch.setattr("tasks.ingest.las_points.READ_BYTES", 30 * 7_001)
    version = "1.4" if point_format > 5 else "1.2"
    path = write_las(tmp_path / f"a{suffix}", wall_points(60_000), version=version, point_format=point_format)
    points_m, facts, sizes = gone_through(path, FOOT)
    assert len(sizes) > 5
    np.testing.assert_array_equal(points_m, as_laspy_gives(path, FOOT), strict=True)
    assert (facts.n_in_file, facts.pose) == (60_000, None)


def test_a_piece_is_whole_chunks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.ingest.las_points.PIECE_BYTES", 30 * 70_000)
    path = write_las(tmp_path / "a.laz", wall_points(120_000))
    assert gone_through(path, ScanRequest())[2] == [50_000, 50_000, 20_000]


def with_empty_returns(path: Path, n_empty: int, n_points: int = 3000) -> Path:
    points_m = wall_points(n_points)
    points_m[np.random.default_rng(4).permutation(n_points)[:n_empty]] = 0.0
    return write_las(path, points_m)


@pytest.mark.parametrize("n_empty", [1, 1500, 2999])
def test_records_without_a_return_are_left_out_and_counted(
    tmp_path: Path, n_empty: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tasks.ingest.las_points.PIECE_BYTES", 30 * 100)
    path = with_empty_returns(tmp_path / "a.laz", n_empty)
    points_m, facts, _ = gone_through(path, ScanRequest())
    np.testing.assert_array_equal(points_m, as_laspy_gives(path, ScanRequest()), strict=True)
    assert len(points_m) == 3000 - n_empty
    assert f"{n_empty} of 3000 records lie at (0, 0, 0): beams without a return, left out" in facts.notes


def test_a_file_of_empty_returns_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="needs points, came 500 that all lie at"):
        gone_through(with_empty_returns(tmp_path / "a.las", 500, 500), ScanRequest())


@pytest.mark.parametrize(
    "spoil", [lambda p: p * 1e3, lambda p: p * 0.0 + 5.0, lambda p: p + FAR_M, lambda p: p]
)
@pytest.mark.parametrize("n_empty", [0, 7, 2600])
def test_stream_and_text_of_the_same_points_are_judged_alike(
    tmp_path: Path, spoil: Any, n_empty: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Text is read whole: refusals and notes are those of the checks as they were before streams."""
    monkeypatch.setattr("tasks.ingest.soundness.SAMPLE_POINTS", 300)
    monkeypatch.setattr("tasks.ingest.stream.SAMPLE_POINTS", 300)
    points_m = np.round(spoil(wall_points(3000)), 2)
    points_m[np.random.default_rng(4).permutation(3000)[:n_empty]] = 0.0
    las = write_las(tmp_path / "a.las", points_m, scale=0.001)
    text = write_text(tmp_path / "a.xyz", rows_of(points_m))
    told = [_verdict(path) for path in (las, text)]
    assert told[0] == told[1]


def _verdict(path: Path) -> tuple[str, ...]:
    try:
        return gone_through(path, ScanRequest())[1].notes
    except InputError as fault:
        return (str(fault).removeprefix(str(path)),)


@pytest.mark.parametrize(
    ("scale", "shift"), [(1e-4, 0.0), (1e-4, -12.3), (0.25, 10.0), (1e-3, 1e9), (1e-12, 1.0), (3e-5, 0.1)]
)
def test_the_integers_at_zero_are_those_that_scaling_makes_zero(scale: float, shift: float) -> None:
    cell = zero_cell(IntegerGrid((scale,) * 3, (shift,) * 3))
    low, high = cell.low[0], cell.high[0]
    near = int(np.clip(round(-shift / scale), -(2**31), 2**31 - 1))
    around = np.clip(np.arange(near - 2000, near + 2001), -(2**31), 2**31 - 1).astype(np.int32)
    is_zero = around * scale + shift == 0.0
    np.testing.assert_array_equal(is_zero, (around >= low) & (around <= high))


@pytest.mark.parametrize("step", [1, 2, 7, 100])
def test_every_so_many_rows_do_not_depend_on_the_pieces(step: int) -> None:
    rows = np.arange(999, dtype=np.int32).reshape(333, 3)
    taken = EverySo(step)
    for piece in _pieces_of(rows):
        taken.see(piece)
    np.testing.assert_array_equal(taken.rows(), rows[::step])


def _pieces_of(rows: NDArray[np.int32]) -> Iterator[NDArray[np.int32]]:
    yield from np.split(rows, [1, 2, 50, 51, 300])


def test_what_a_damaged_scale_makes_infinite_is_counted(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.las", wall_points(), version="1.2", point_format=0)
    content = bytearray(path.read_bytes())
    content[131:139] = np.array([1e305], dtype="<f8").tobytes()
    path.write_bytes(content)
    n_bad = int(np.count_nonzero(~np.isfinite(_quietly(laspy.read(path)))))
    with pytest.raises(InputError, match=f"needs finite coordinates, came {n_bad} of 500 points"):
        gone_through(path, ScanRequest())


def _quietly(las: laspy.LasData) -> NDArray[np.float64]:
    with np.errstate(over="ignore"):
        return np.asarray(las.x)


def test_the_box_of_integers_is_the_box_of_metres() -> None:
    rng = np.random.default_rng(8)
    rows = rng.integers(-(2**31), 2**31, (5000, 3), dtype=np.int32)
    grid = IntegerGrid((1e-4, 0.3, 7e-9), (0.1, -1e7, 3.3), 0.3048, (1e3, 2.5, 0.0), swap_axes=True)
    corners = grid.metres(np.array([box_of(rows).low, box_of(rows).high]))
    box = box_of(grid.metres(rows))
    np.testing.assert_array_equal(corners, np.array([box.low, box.high]))


def test_other_formats_come_as_one_piece_of_metres(tmp_path: Path) -> None:
    path = write_text(tmp_path / "a.xyz", rows_of(wall_points()))
    points_m, facts, sizes = gone_through(path, ScanRequest())
    scan = read_scan(path)
    assert stream_scan(path).grid is None
    assert sizes == [500]
    np.testing.assert_array_equal(points_m, scan.points_m, strict=True)
    assert facts == ScanFacts(scan.n_in_file, scan.notes, scan.pose)


def test_polar_extra_dimensions_come_as_metres(tmp_path: Path) -> None:
    polar = np.column_stack([np.full(50, 10.0), np.linspace(0.0, 200.0, 50), np.linspace(-20.0, 40.0, 50)])
    extra = dict(zip(("S", "alpha", "omega"), polar.T, strict=True))
    request = ScanRequest(coordinates="polar")
    for suffix in (".las", ".laz"):
        path = write_las(tmp_path / f"a{suffix}", np.zeros((50, 3)), extra=extra)
        assert np.hypot(*gone_through(path, request)[0][0, :2]) == pytest.approx(
            10.0 * np.cos(np.radians(20.0))
        )


def test_what_the_header_shows_is_refused_before_the_first_piece(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.laz", wall_points())
    path.write_bytes(path.read_bytes()[:-20])
    for ask in (stream_scan, describe_scan):
        with pytest.raises(InputError, match="cut short"):
            ask(path)


def test_a_scan_that_its_file_shall_level_is_refused(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.laz", wall_points())
    with pytest.raises(InputError, match="came a file that states none"):
        gone_through(path, ScanRequest(levelling="file"))
