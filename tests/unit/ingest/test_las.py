"""LAS and LAZ files that are whole."""

from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tests.unit.ingest.clouds import SCALE_M, geo_keys_vlr, wall_points, wkt_vlr, write_las

FORMATS = [
    ("1.2", 0),
    ("1.2", 1),
    ("1.2", 2),
    ("1.2", 3),
    ("1.3", 4),
    ("1.4", 6),
    ("1.4", 7),
    ("1.4", 8),
    ("1.4", 9),
]
ROUNDING_M = 1e-9
"""Of float64 at some ten metres, with room."""

WKT_FEET = (
    'PROJCS["x",GEOGCS["g",UNIT["degree",0.0174532925199433]],UNIT["US survey foot",0.304800609601219]]'
)
WKT_METRES = 'PROJCS["x",GEOGCS["g",UNIT["degree",0.0174532925199433]],UNIT["metre",1]]'
WKT_FEET_UP = f'COMPD_CS["c",{WKT_METRES},VERT_CS["v",UNIT["foot",0.3048]]]'
WKT2_FEET = 'PROJCRS["x",CS[Cartesian,2],AXIS["e",east],LENGTHUNIT["foot",0.3048]]'
WKT_FEET_OF_ONE = 'PROJCS["x",UNIT["US survey foot",1.0]]'
WKT_DEGREES = 'GEOGCS["g",UNIT["degree",0.0174532925199433]]'


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize(("version", "point_format"), FORMATS)
def test_every_point_comes_back_where_it_was(
    tmp_path: Path, suffix: str, version: str, point_format: int
) -> None:
    points_m = wall_points()
    path = write_las(tmp_path / f"a{suffix}", points_m, version=version, point_format=point_format)
    scan = read_scan(path)
    assert scan.points_m == pytest.approx(points_m, abs=ROUNDING_M)
    assert (scan.n_in_file, scan.notes) == (len(points_m), ())


def test_points_are_contiguous_doubles(tmp_path: Path) -> None:
    points_m = read_scan(write_las(tmp_path / "a.laz", wall_points())).points_m
    assert points_m.flags.c_contiguous
    assert points_m.dtype == np.float64


def test_more_points_than_a_chunk_and_than_a_piece_come_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tasks.ingest.las_points.PIECE_BYTES", 30 * 7_001)
    points_m = wall_points(120_000)
    scan = read_scan(write_las(tmp_path / "a.laz", points_m))
    assert scan.points_m == pytest.approx(points_m, abs=ROUNDING_M)


def test_the_sequential_decoder_agrees_with_the_parallel_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_las(tmp_path / "a.laz", wall_points(60_000))
    parallel = read_scan(path)
    monkeypatch.setattr("tasks.ingest.las_points.PARALLEL_CHUNK_BYTES", 0)
    assert np.array_equal(read_scan(path).points_m, parallel.points_m)


def test_the_suffix_may_be_in_capitals(tmp_path: Path) -> None:
    assert read_scan(write_las(tmp_path / "a.laz", wall_points()).rename(tmp_path / "A.LAZ")).n_in_file == 500


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_a_header_is_described_without_its_points(tmp_path: Path, suffix: str) -> None:
    points_m = wall_points()
    path = write_las(tmp_path / f"a{suffix}", points_m)
    header = describe_scan(path)
    assert (header.format, header.n_points) == (f"{suffix[1:].upper()} 1.4", 500)
    assert header.size_bytes == path.stat().st_size
    assert header.bounds is not None
    assert header.bounds.low == pytest.approx(points_m.min(axis=0), abs=SCALE_M)
    assert header.bounds.high == pytest.approx(points_m.max(axis=0), abs=SCALE_M)


def test_the_origin_is_subtracted_at_full_precision(tmp_path: Path) -> None:
    points_m, origin_m = wall_points(), np.array([512_345.25, 4_412_345.5, 78.0])
    path = write_las(tmp_path / "a.laz", points_m + origin_m)
    scan = read_scan(path, ScanRequest(origin_m=(512_345.25, 4_412_345.5, 78.0)))
    # float64 at 4.4e6 m resolves 1e-9 m
    assert scan.points_m == pytest.approx(points_m, abs=3e-9)
    assert scan.notes == ()


def test_north_east_up_becomes_east_north_up_after_the_origin(tmp_path: Path) -> None:
    points_m = wall_points()
    path = write_las(tmp_path / "a.laz", points_m)
    scan = read_scan(path, ScanRequest(origin_m=(1.0, 20.0, 300.0), swap_axes=True))
    expected = points_m[:, [1, 0, 2]] - (20.0, 1.0, 300.0)
    assert scan.points_m == pytest.approx(expected, abs=ROUNDING_M)
    assert scan.points_m.flags.c_contiguous


def test_points_far_from_the_origin_are_told(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.laz", wall_points() + np.array([500_000.0, 0.0, 0.0]))
    assert "origin_m" in " ".join(read_scan(path).notes)


@pytest.mark.parametrize("wkt", [WKT_FEET, WKT_FEET_UP, WKT2_FEET, WKT_FEET_OF_ONE])
def test_feet_in_the_coordinate_system_are_refused(tmp_path: Path, wkt: str) -> None:
    path = write_las(tmp_path / "a.laz", wall_points(), vlrs=(wkt_vlr(wkt),))
    for ask in (read_scan, describe_scan):
        with pytest.raises(InputError, match=r"a\.laz: needs coordinates in metre, came .*foot .* convert"):
            ask(path)


@pytest.mark.parametrize("keys", [(3076, 9003), (3076, 9002), (4099, 9002)])
def test_feet_in_geotiff_keys_are_refused(tmp_path: Path, keys: tuple[int, int]) -> None:
    path = write_las(
        tmp_path / "a.las",
        wall_points(),
        version="1.2",
        point_format=0,
        vlrs=(geo_keys_vlr((1024, 1), keys),),
    )
    with pytest.raises(InputError, match="needs coordinates in metre, came EPSG unit 900"):
        read_scan(path)


def test_feet_that_are_stated_become_metres(tmp_path: Path) -> None:
    points = wall_points()
    path = write_las(tmp_path / "a.laz", points, vlrs=(wkt_vlr(WKT_FEET),))
    scan = read_scan(path, ScanRequest(unit="US survey foot"))
    assert scan.points_m == pytest.approx(points * 1200.0 / 3937.0, abs=ROUNDING_M)


def test_the_other_foot_is_not_the_stated_foot(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.laz", wall_points(), vlrs=(wkt_vlr(WKT_FEET),))
    with pytest.raises(InputError, match="needs coordinates in foot, came US survey foot"):
        read_scan(path, ScanRequest(unit="foot"))


@pytest.mark.parametrize("vlr", [wkt_vlr(WKT_DEGREES), geo_keys_vlr((1024, 2)), geo_keys_vlr((1024, 3))])
def test_coordinates_on_the_globe_are_refused(tmp_path: Path, vlr: object) -> None:
    path = write_las(tmp_path / "a.las", wall_points(), vlrs=(vlr,))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="needs plane coordinates in metres"):
        read_scan(path)


def test_metres_in_the_coordinate_system_need_no_note(tmp_path: Path) -> None:
    path = write_las(
        tmp_path / "a.laz", wall_points(), vlrs=(wkt_vlr(WKT_METRES), geo_keys_vlr((1024, 1), (3076, 9001)))
    )
    assert read_scan(path).notes == ()


def test_a_damaged_coordinate_system_is_told(tmp_path: Path) -> None:
    broken = geo_keys_vlr((1024, 1))
    broken.record_data = broken.record_data[:11]
    path = write_las(tmp_path / "a.las", wall_points(), vlrs=(broken,))
    assert "record 34735 on the coordinate system is damaged" in " ".join(read_scan(path).notes)


def test_a_coarse_scale_factor_is_told(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.laz", wall_points(), scale=0.01)
    assert read_scan(path).notes == (
        "coordinates come in steps of 10 mm: export with a scale factor of 0.0001",
    )


def test_a_hopeless_scale_factor_is_refused(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.laz", wall_points(), scale=0.1)
    with pytest.raises(InputError, match="needs coordinates finer than 50 mm, came steps of 100 mm"):
        read_scan(path)


def test_a_point_outside_the_box_of_the_header_is_told(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.las", wall_points(), version="1.2", point_format=0)
    content = bytearray(path.read_bytes())
    content[179:187] = np.array([5.0], dtype="<f8").tobytes()  # largest x
    path.write_bytes(content)
    assert "points lie outside the box" in " ".join(read_scan(path).notes)


@pytest.mark.parametrize(
    ("version", "point_format", "at", "kind"), [("1.2", 0, 111, "<u4"), ("1.4", 6, 255, "<u8")]
)
def test_more_points_by_return_than_in_all_are_told(
    tmp_path: Path, version: str, point_format: int, at: int, kind: str
) -> None:
    """One chunk of LAZ may hold more than its header counts, and the rest would be left out without a word."""
    path = write_las(tmp_path / "a.laz", wall_points(), version=version, point_format=point_format)
    content = bytearray(path.read_bytes())
    count = np.array([501], kind).tobytes()
    content[at : at + len(count)] = count
    path.write_bytes(content)
    assert "counts 501 points by return and 500 in all" in " ".join(read_scan(path).notes)
