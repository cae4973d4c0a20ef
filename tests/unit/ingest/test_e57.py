"""E57 files that are whole."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tasks.ingest.e57_points import PIECE_RECORDS
from tests.shared import SHARED, needs_shared
from tests.unit.ingest.clouds import wall_points
from tests.unit.ingest.e57_files import (
    CARTESIAN,
    SPHERICAL,
    Column,
    Source,
    boxed,
    cloud,
    doubles,
    integers,
    named,
    posed,
    singles,
    write_e57,
)

FORMATS = SHARED / "data" / "formats"
IN_FILE = ScanRequest(frame="file")
ROUNDING_M = 1e-12
"""Of float64 at some ten metres, with room."""

HALF = float(np.sqrt(0.5))
QUARTER_TURN = (HALF, 0.0, 0.0, HALF)
"""From x to y about z."""

WKT_25832 = (
    'PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",DATUM["European_Terrestrial_Reference_System_1989",'
    'SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],'
    'PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],'
    'PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],'
    'UNIT["metre",1],AUTHORITY["EPSG","25832"]]'
)


def test_every_point_comes_back_where_it_was(tmp_path: Path) -> None:
    points = wall_points()
    scan = read_scan(write_e57(tmp_path / "a.e57", cloud(points)))
    assert np.array_equal(scan.points_m, points)
    assert scan.notes == ()


def test_scaled_integers_come_back_within_half_a_step(tmp_path: Path) -> None:
    points = wall_points()
    columns = tuple(
        integers(name, values, -600_000, 600_001, 1e-4)
        for name, values in zip(CARTESIAN, points.T, strict=True)
    )
    scan = read_scan(write_e57(tmp_path / "a.e57", Source(columns, len(points))))
    assert np.abs(scan.points_m - points).max() <= 0.5e-4 + ROUNDING_M


def test_a_coordinate_that_takes_no_bits_is_the_same_everywhere(tmp_path: Path) -> None:
    points = wall_points()
    first, second = (doubles(name, values) for name, values in zip(CARTESIAN[:2], points.T[:2], strict=True))
    element = '<cartesianZ type="ScaledInteger" minimum="12" maximum="12" scale="0.001">12</cartesianZ>'
    path = write_e57(tmp_path / "a.e57", Source((first, second, Column(element, b"")), len(points)))
    assert np.all(read_scan(path).points_m[:, 2] == 0.012)


def test_spherical_fields_are_the_same_points(tmp_path: Path) -> None:
    points = wall_points()
    level = np.hypot(points[:, 0], points[:, 1])
    polar = (
        np.hypot(level, points[:, 2]),
        np.arctan2(points[:, 1], points[:, 0]),
        np.arctan2(points[:, 2], level),
    )
    columns = tuple(doubles(name, values) for name, values in zip(SPHERICAL, polar, strict=True))
    scan = read_scan(write_e57(tmp_path / "a.e57", Source(columns, len(points))))
    assert np.abs(scan.points_m - points).max() < ROUNDING_M


def test_of_both_kinds_the_cartesian_fields_are_read(tmp_path: Path) -> None:
    points = wall_points()
    zeros = tuple(singles(name, np.zeros(len(points))) for name in SPHERICAL)
    scan = read_scan(write_e57(tmp_path / "a.e57", cloud(points, "", *zeros)))
    assert np.array_equal(scan.points_m, points)


@pytest.mark.parametrize("state", [1, 2])
@pytest.mark.parametrize("name", ["cartesianInvalidState", "sphericalInvalidState"])
def test_records_marked_as_invalid_are_counted_and_left_out(tmp_path: Path, name: str, state: int) -> None:
    points = wall_points()
    states = np.zeros(len(points))
    states[::5] = state
    stored = points.copy()
    stored[::5] = np.nan
    scan = read_scan(write_e57(tmp_path / "a.e57", cloud(stored, "", integers(name, states, 0, 2))))
    assert np.array_equal(scan.points_m, points[states == 0])
    assert scan.n_in_file == 500
    assert any("100 of 500 records are marked as invalid" in note for note in scan.notes)


def test_a_file_whose_records_are_all_invalid_is_refused(tmp_path: Path) -> None:
    states = integers("cartesianInvalidState", np.full(500, 2.0), 0, 2)
    path = write_e57(tmp_path / "a.e57", cloud(wall_points(), "", states))
    with pytest.raises(InputError, match="500 records that the file itself marks as invalid"):
        read_scan(path)


def test_a_scan_in_its_own_frame_keeps_its_points_and_its_pose(tmp_path: Path) -> None:
    points = wall_points()
    scan = read_scan(write_e57(tmp_path / "a.e57", cloud(points, posed(QUARTER_TURN, (100.0, 200.0, 3.0)))))
    assert np.array_equal(scan.points_m, points)
    assert scan.pose is not None
    assert scan.pose.rotation @ [1.0, 0.0, 0.0] == pytest.approx([0.0, 1.0, 0.0], abs=ROUNDING_M)
    assert scan.pose.translation == pytest.approx([100.0, 200.0, 3.0], abs=0.0)


def test_a_scan_without_a_pose_has_none(tmp_path: Path) -> None:
    assert read_scan(write_e57(tmp_path / "a.e57", cloud(wall_points()))).pose is None


def test_in_the_frame_of_the_file_scans_are_placed_by_their_poses_and_joined(tmp_path: Path) -> None:
    first, second = wall_points(300), wall_points(200, seed=4)
    path = write_e57(
        tmp_path / "a.e57",
        cloud(first, posed(QUARTER_TURN, (100.0, 200.0, 3.0))),
        cloud(second, posed((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))),
    )
    placed = np.column_stack([-first[:, 1] + 100.0, first[:, 0] + 200.0, first[:, 2] + 3.0])
    scan = read_scan(path, IN_FILE)
    assert np.abs(scan.points_m - np.vstack([placed, second])).max() < 1e-12 * 300.0
    assert scan.pose is None
    assert scan.notes == ()


def test_a_beam_without_a_return_is_not_placed_at_its_scanner(tmp_path: Path) -> None:
    points = wall_points()
    points[7] = 0.0
    path = write_e57(tmp_path / "a.e57", cloud(points, posed(QUARTER_TURN, (100.0, 200.0, 3.0))))
    scan = read_scan(path, IN_FILE)
    assert len(scan.points_m) == 499
    assert scan.points_m[:, 1].min() > 180.0


def test_joined_scans_without_poses_are_told(tmp_path: Path) -> None:
    path = write_e57(tmp_path / "a.e57", cloud(wall_points()), cloud(wall_points(seed=4)))
    assert any("2 of 2 scans state no pose" in note for note in read_scan(path, IN_FILE).notes)


def _two(path: Path) -> Path:
    return write_e57(path, cloud(wall_points(300), named("east")), cloud(wall_points(200), named("west")))


@pytest.mark.parametrize(("part", "n_points"), [(1, 300), (2, 200), ("east", 300), ("west", 200)])
def test_a_part_is_taken_by_number_or_by_name(tmp_path: Path, part: int | str, n_points: int) -> None:
    path = _two(tmp_path / "a.e57")
    assert len(read_scan(path, ScanRequest(part=part)).points_m) == n_points
    assert describe_scan(path, ScanRequest(part=part)).n_points == n_points


@pytest.mark.parametrize(
    ("part", "message"),
    [(None, "write part = 1"), (3, "'east', 'west'"), (0, "'east', 'west'"), ("north", "'east', 'west'")],
)
def test_a_part_that_is_missing_or_unknown_is_refused(
    tmp_path: Path, part: int | str | None, message: str
) -> None:
    path = _two(tmp_path / "a.e57")
    for ask in (read_scan, describe_scan):
        with pytest.raises(InputError, match=message):
            ask(path, ScanRequest(part=part))


def test_a_header_lists_all_scans_and_counts_those_asked_for(tmp_path: Path) -> None:
    header = describe_scan(_two(tmp_path / "a.e57"), IN_FILE)
    assert [(part.name, part.n_points) for part in header.parts] == [("east", 300), ("west", 200)]
    assert (header.format, header.n_points) == ("E57 1.0", 500)


def test_a_box_is_stated_where_no_pose_makes_its_frame_doubtful(tmp_path: Path) -> None:
    points = wall_points()
    box = boxed(points.min(axis=0).tolist(), points.max(axis=0).tolist())
    bounds = describe_scan(write_e57(tmp_path / "a.e57", cloud(points, box))).bounds
    assert bounds is not None
    assert np.array_equal(bounds.low, points.min(axis=0))
    assert np.array_equal(bounds.high, points.max(axis=0))
    moved = write_e57(tmp_path / "b.e57", cloud(points, box + posed(QUARTER_TURN, (1.0, 2.0, 3.0))))
    assert describe_scan(moved, IN_FILE).bounds is None


def test_an_empty_scan_beside_others_is_told(tmp_path: Path) -> None:
    path = write_e57(tmp_path / "a.e57", cloud(wall_points()), cloud(np.empty((0, 3)), named("none")))
    scan = read_scan(path, IN_FILE)
    assert len(scan.points_m) == 500
    assert any("scan 2 'none' holds no points" in note for note in scan.notes)


@pytest.mark.parametrize(
    ("away_m", "message"),
    [(40_000.0, r"steps of 3\.9\d? mm"), (4_400_000.0, "needs coordinates finer than")],
)
def test_single_precision_far_away_is_told_or_refused(tmp_path: Path, away_m: float, message: str) -> None:
    points = wall_points(300)
    columns = tuple(singles(name, values + away_m) for name, values in zip(CARTESIAN, points.T, strict=True))
    path = write_e57(tmp_path / "a.e57", Source(columns, len(points)))
    if away_m > 1e6:
        with pytest.raises(InputError, match=message):
            read_scan(path)
    else:
        assert any(note.startswith("coordinates come in steps of 3.9") for note in read_scan(path).notes)


def test_single_precision_near_the_scanner_is_no_matter(tmp_path: Path) -> None:
    points = wall_points(300)
    columns = tuple(singles(name, values) for name, values in zip(CARTESIAN, points.T, strict=True))
    assert read_scan(write_e57(tmp_path / "a.e57", Source(columns, len(points)))).notes == ()


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (ScanRequest(coordinates="polar"), "leave coordinates out"),
        (ScanRequest(unit="foot"), "needs the unit metre"),
    ],
)
def test_statements_against_the_format_are_refused(
    tmp_path: Path, request_: ScanRequest, message: str
) -> None:
    path = write_e57(tmp_path / "a.e57", cloud(wall_points()))
    for ask in (read_scan, describe_scan):
        with pytest.raises(InputError, match=message):
            ask(path, request_)


@pytest.mark.parametrize("w", [1.01, 0.0, float("nan"), 1e300])
def test_a_quaternion_that_is_no_rotation_is_refused(tmp_path: Path, w: float) -> None:
    path = write_e57(tmp_path / "a.e57", cloud(wall_points(), posed((w, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))))
    for ask in (read_scan, describe_scan):
        with pytest.raises(InputError, match=r"needs a .*pose .*, came .* in scan 1"):
            ask(path)


def test_a_quaternion_of_few_digits_is_told(tmp_path: Path) -> None:
    path = write_e57(
        tmp_path / "a.e57", cloud(wall_points(), posed((0.7071, 0.0, 0.0, 0.7071), (0.0, 0.0, 0.0)))
    )
    assert any("export the pose with more digits" in note for note in read_scan(path).notes)


def test_another_coordinate_system_than_that_of_the_campaign_is_refused(tmp_path: Path) -> None:
    path = write_e57(tmp_path / "a.e57", cloud(wall_points()), system=WKT_25832)
    assert describe_scan(path).horizontal == "EPSG:25832"
    assert read_scan(path, ScanRequest(frame="file", horizontal="EPSG:25832")).notes == ()
    with pytest.raises(InputError, match="came EPSG:25832"):
        read_scan(path, ScanRequest(frame="file", horizontal="EPSG:25833"))


def test_elevations_that_may_be_zenith_angles_are_told(tmp_path: Path) -> None:
    polar = (np.full(300, 10.0), np.linspace(0.0, 3.0, 300), np.linspace(0.5, 2.0, 300))
    columns = tuple(doubles(name, values) for name, values in zip(SPHERICAL, polar, strict=True))
    scan = read_scan(write_e57(tmp_path / "a.e57", Source(columns, 300)))
    assert any("elevations up to 114.6 degrees" in note for note in scan.notes)


def test_points_beyond_one_piece_are_all_read(tmp_path: Path) -> None:
    pye57 = pytest.importorskip("pye57")
    n_points = PIECE_RECORDS + 1234
    points = np.random.default_rng(5).uniform(-50.0, 50.0, (n_points, 3)).astype(np.float32).astype(float)
    with pye57.E57(str(tmp_path / "a.e57"), mode="w") as file:
        file.write_scan_raw({name: column.copy() for name, column in zip(CARTESIAN, points.T, strict=True)})
    assert np.array_equal(read_scan(tmp_path / "a.e57").points_m, points)


def test_the_library_is_not_loaded_before_an_e57_file_is_read() -> None:
    code = "import sys, tasks.ingest; sys.exit('pye57' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@needs_shared
@pytest.mark.parametrize(
    ("name", "rounding_m"),
    # half a float32 step at 0.19 m; the double and the integers hold micrometres
    [("Float", 1e-8), ("Int19", 1e-12), ("Int21", 1e-12), ("Int24", 1e-12), ("Int32", 1e-12)],
)
def test_one_bunny_is_the_same_in_every_kind_of_number(name: str, rounding_m: float) -> None:
    whole = read_scan(FORMATS / "e57" / "bunnyDouble.e57").points_m
    points = read_scan(FORMATS / "e57" / f"bunny{name}.e57").points_m
    assert points.shape == (30571, 3)
    assert np.abs(points - whole).max() <= rounding_m


@needs_shared
def test_two_scans_placed_are_the_merged_cloud() -> None:
    placed = read_scan(FORMATS / "pdal" / "A_B.e57", IN_FILE).points_m
    assert np.array_equal(placed, read_scan(FORMATS / "pdal" / "A_merged_B.e57").points_m)


@needs_shared
def test_a_moved_scan_beside_another_is_that_scan_alone() -> None:
    # A_moved_B states no poses: its second scan was moved before it was written, in float32
    together = FORMATS / "pdal" / "A_moved_B.e57"
    alone = read_scan(FORMATS / "pdal" / "A4_moved.e57").points_m
    assert np.abs(read_scan(together, ScanRequest(part=2)).points_m - alone).max() < 4e-6
    assert np.array_equal(
        read_scan(together, ScanRequest(part=1)).points_m, read_scan(FORMATS / "pdal" / "B2.e57").points_m
    )


@needs_shared
@pytest.mark.parametrize(
    ("name", "n_points"),
    [
        ("e57/float_intensity_without_min_max", 1),
        ("e57/integer_intensity", 2),
        ("e57/las2e57_no_images_tag", 153),
        ("e57/original_guids", 1),
        ("e57/scaled_integer_intensity", 2),
        ("e57/tinyCartesianFloatRgb", 2090),
        ("e57/tiny_pc_and_images", 2),
        ("e57/tiny_pc_with_extension", 1),
        ("e57/tiny_spherical", 360),
        ("libe57/ColouredCubeDouble", 7680),
        ("libe57/ColouredCubeFloat", 7680),
        ("pdal/A_B_different_dims", 2),
        ("pye57/pumpAVisualReferenceImage", 155201),
        ("pye57/translationWithoutRotation", 4),
    ],
)
def test_a_shared_file_holds_as_many_points_as_it_states(name: str, n_points: int) -> None:
    path = FORMATS / f"{name}.e57"
    assert read_scan(path, IN_FILE).n_in_file == n_points
    assert describe_scan(path, IN_FILE).n_points == n_points


@needs_shared
def test_a_translation_without_a_rotation_moves_the_points() -> None:
    path = FORMATS / "pye57" / "translationWithoutRotation.e57"
    moved_m = read_scan(path, IN_FILE).points_m - read_scan(path).points_m
    assert moved_m == pytest.approx(np.tile([4.0, 5.0, 6.0], (3, 1)), abs=0.0)
