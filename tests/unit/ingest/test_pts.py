"""PTS: counts and rows."""

from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tests.shared import SHARED, needs_shared
from tests.unit.ingest.clouds import rows_of, wall_points, write_text

FILE = ScanRequest(frame="file")
TWO_POINTS = np.array([[1.5, -2.0, 3.0], [4.0, 5.25, -6.0]])
PDAL = SHARED / "data" / "formats" / "pdal"


@pytest.mark.parametrize(
    "text",
    [
        "2\n1.5 -2 3\n4 5.25 -6\n",
        "2\n1.5 -2 3 -1613\n4 5.25 -6 7\n",
        "2\n1.5 -2 3 52 70 64\n4 5.25 -6 1 2 3\n",
        "2\n1.5 -2 3 -1613 52 70 64\n4 5.25 -6 0 1 2 3\n",
        "2\r\n1.5,-2,3,7\r\n4,5.25,-6,8\r\n",
        "2\n1.5, -2, 3\n4, 5.25, -6\n",
        "2\n1.5;-2;3\n4;5.25;-6\n",
        " 2 \n\t1.5\t-2\t3\n4  5.25  -6\n\n\n",
        "\ufeff2\n1.5 -2 3 7\n4 5.25 -6 7",
        "0\n2\n1.5 -2 3\n4 5.25 -6\n",
    ],
)
def test_every_common_layout_gives_the_same_points(tmp_path: Path, text: str) -> None:
    scan = read_scan(write_text(tmp_path / "a.pts", text), FILE)
    assert np.array_equal(scan.points_m, TWO_POINTS)
    assert (scan.n_in_file, scan.notes, scan.pose) == (2, (), None)


def blocks(tmp_path: Path) -> Path:
    text = f"50\n{rows_of(wall_points(50))}30\n{rows_of(wall_points(30, seed=4), ',')}"
    return write_text(tmp_path / "a.pts", text)


def test_blocks_are_joined_or_taken_by_number(tmp_path: Path) -> None:
    both = read_scan(blocks(tmp_path), FILE)
    # four decimals as written
    assert both.points_m == pytest.approx(np.vstack((wall_points(50), wall_points(30, seed=4))), abs=1e-9)
    second = read_scan(blocks(tmp_path), ScanRequest(part=2))
    assert np.array_equal(second.points_m, both.points_m[50:])
    header = describe_scan(blocks(tmp_path), FILE)
    assert (header.n_points, [part.n_points for part in header.parts]) == (80, [50, 30])


@pytest.mark.parametrize("ask", [read_scan, describe_scan])
def test_a_station_needs_to_know_its_block(tmp_path: Path, ask: object) -> None:
    with pytest.raises(
        InputError, match=r"came 2 scans, part = 1 to 2, without names; write part = 1, or another"
    ):
        ask(blocks(tmp_path))  # type: ignore[operator]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"came a file that holds no points"),
        ("0\n", r"came a file that holds no points"),
        ("1 2 3\n4 5 6\n", r"needs the number of points in line 1, came '1 2 3'; .* rename .* to \.xyz"),
        ("x y z\n1 2 3\n", r"needs the number of points in line 1, came 'x y z'"),
        ("3\n1 2 3\n4 5 6\n", r"needs the 3 points that line 1 states, came 2"),
        (
            "1\n1 2 3\n4 5 6\n",
            r"after the 1 rows that line 1 states, came line 3 '4 5 6'; the count is wrong",
        ),
        ("2\n1 2 3\n2\n4 5 6\n7 8 9\n", r"after the 2 rows .* came line 4 '4 5 6'"),
        ("2\n1 2 3\n\n4 5 6\n", r"after the 2 rows .* came line 4 '4 5 6'"),
        ("999999999999\n1 2 3\n", r"needs the 999999999999 points that line 1 states, came 1"),
        ("9999999999999999999999999\n1 2 3\n", r"needs the number of points in line 1, came '9999"),
        ("1\n1 2 3 4 5\n", r"needs rows x y z \[intensity\] \[r g b\], came 5 columns in line 2"),
        (
            "2\n1 2 3 7\n4 5 6\n",
            r"needs 4 columns in the 2 rows that line 1 states, came 3 in line 3 '4 5 6'",
        ),
        ("2\n1 2 3\n4 abc 6\n", r"needs numbers, came 'abc' in line 3"),
        ("2\n1;2;3\n1,5;2;3\n", r"needs numbers, came '1,5' in line 3 .*; write numbers as 1\.5"),
        ("2\n1 2 3\n4 nan 6\n", r"needs finite coordinates, came 1 of 2 points"),
    ],
)
def test_a_bad_file_says_where_and_what(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=r"a\.pts: .*" + message):
        read_scan(write_text(tmp_path / "a.pts", text), FILE)


def test_a_last_coordinate_without_line_end_is_told(tmp_path: Path) -> None:
    scan = read_scan(write_text(tmp_path / "a.pts", "2\n1.5 -2 3\n4 5.25 -6"))
    assert scan.notes == ("the last line has no end: if the file was cut short, its last point is wrong",)


def test_polar_coordinates_are_refused_with_a_hint(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"needs named columns S, alpha, omega .* came PTS"):
        read_scan(blocks(tmp_path), ScanRequest(coordinates="polar", frame="file"))


@needs_shared
@pytest.mark.parametrize(("name", "n_points"), [("autzen.pts", 10), ("site_56_8.pts", 8), ("test.pts", 19)])
def test_files_of_other_programs_are_read_whole(name: str, n_points: int) -> None:
    rows = np.loadtxt(PDAL / name, skiprows=1)
    scan = read_scan(PDAL / name)
    assert len(scan.points_m) == describe_scan(PDAL / name).n_points == n_points
    assert np.array_equal(scan.points_m, rows[:, :3])


@needs_shared
def test_a_count_that_is_too_small_is_no_reason_to_leave_points_out() -> None:
    with pytest.raises(InputError, match=r"after the 8 rows that line 1 states, came line 10 '-0\.025508"):
        read_scan(PDAL / "bunny_8.pts")


@needs_shared
def test_points_of_one_survey_are_the_same_in_two_formats() -> None:
    pts = read_scan(PDAL / "autzen.pts").points_m
    laz_ft = read_scan(PDAL / "autzen_trim.laz", ScanRequest(unit="foot")).points_m / 0.3048
    # both in international feet; the LAZ keeps hundredths, the PTS what single precision made of them
    assert all(np.abs(laz_ft - point).max(axis=1).min() < 1e-4 for point in pts)
