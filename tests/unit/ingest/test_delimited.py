"""Text files, a point a line."""

from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tests.unit.ingest.clouds import rows_of, wall_points, write_text

TWO_POINTS = np.array([[1.5, -2.0, 3.0], [4.0, 5.25, -6.0]])


@pytest.mark.parametrize(
    "text",
    [
        "1.5 -2 3\n4 5.25 -6\n",
        "1.5,-2,3\n4,5.25,-6\n",
        "1.5;-2;3\r\n4;5.25;-6\r\n",
        "1.5\t-2\t3\n4\t5.25\t-6\n",
        "1.5 , -2 , 3 , 0.1,0.2,0.3\n4 , 5.25 , -6 , 0.1,0.2,0.3\n",
        "  1.5000e+00   -2.0e0  3E+0\n  4 5.25 -6\n",
        "1.5 -2 3\r4 5.25 -6\r",
        "\n1.5 -2 3\n\n   \n4 5.25 -6\n\n",
        "x,y,z\n1.5,-2,3\n4,5.25,-6\n",
        "X Y Z\n1.5 -2 3\n4 5.25 -6\n",
        "x,y,z\n1.5 -2 3\n4 5.25 -6\n",
        "//X Y Z R G B\n1.5 -2 3 9 9 9\n4 5.25 -6 9 9 9\n",
        "# made by hand\n# x y z\n1.5 -2 3\n4 5.25 -6\n",
        "2\n1.5 -2 3\n4 5.25 -6\n",
        "2\nx y z name\n1.5 -2 3 left\n4 5.25 -6 right\n",
        "id,z,y,x\n1,3,-2,1.5\n2,-6,5.25,4\n",
        '"X [m]","Y [m]","Z [m]"\n1.5,-2,3\n4,5.25,-6\n',
        "\ufeffx;y;z;Höhe\n1.5;-2;3;0\n4;5.25;-6;0\n",
        "x_m,y_m,z_m\n1.5,-2,3\n4,5.25,-6\n",
        "1.5 -2 3 a tree\n4 5.25 -6 another one 7\n",
        "1.5,-2,3,caf\xe9\xa0\n4,5.25,-6,\n",
    ],
)
@pytest.mark.parametrize("suffix", [".xyz", ".csv", ".txt", ".asc"])
def test_every_common_layout_gives_the_same_points(tmp_path: Path, text: str, suffix: str) -> None:
    scan = read_scan(write_text(tmp_path / f"a{suffix}", text))
    assert np.array_equal(scan.points_m, TWO_POINTS)
    assert (scan.n_in_file, scan.notes) == (2, ())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y,z\n1,2,3\n1,abc,3\n", r"needs numbers, came 'abc' in line 3 '1,abc,3'; correct or remove"),
        ("1 2 3\n\n1 2\n", r"needs 3 columns, came 2 in line 3 '1 2'"),
        ("1;2;3\n1,5;2;3\n", r"needs numbers, came '1,5' in line 2 .*; write numbers as 1\.5"),
        ("x;y;z\n1,5;2,5;3,5\n", r"needs decimal points, came '1,5' in line 2"),
        ("1,2,\n1,2,3\n", r"needs rows of three numbers, came line 1 '1,2,'"),
        ("1,2,3\n1,,3\n", r"needs numbers, came '' in line 2"),
        ("1,2,3\n1_0,2,3\n", r"needs numbers, came '1_0' in line 2"),
        ("a,b,c\n1,2,3\n", r"needs one column 'x', came 0 among a, b, c"),
        ("X,Y,X\n1,2,3\n", r"needs one column 'x', came 2 among X, Y, X"),
        (
            "1 2 3\n1 005.5 2 3\n",
            r"needs 3 numbers in every row as in the first, came 4 in line 2 '1 005.5 2 3'",
        ),
        ("1,2,3,4\n1,2,3\n", r"needs 4 numbers in every row as in the first, came 3 in line 2"),
        ("1 2 3\n\n1\xa0005.5 2 3\n", r"needs numbers, came '1.{1,2}005\.5' in line 3"),
        (
            "x,y,z\n1,5,2,5,3,5\n",
            r"needs a number for each of 3 names, came 6 in line 2 .*; write numbers as 1234\.5",
        ),
        ("x,y (ft),z\n1,2,3\n", r"needs metres and degrees, came column 'y \(ft\)' in ft"),
        ("x,y,z\n", r"needs rows of three numbers, came none"),
        ("1 636.1 849.2 5\n2 636.2 849.1 5\n3 636.3 849.5 6\n", r"came the numbers 1, 2, 3; add a line"),
        ("3\n1 2 3\n4 5 6\n", r"needs the 3 points that its first line states, came 2"),
        ("1\n1 2 3\n4 5 6\n", r"needs the 1 points that its first line states, came 2"),
        ("", r"came a file that holds no points"),
        (" \n\n", r"came a file that holds no points"),
        ("1 2 3\0\n", r"needs plain text"),
        ("1 2 3\n4 nan 6\n7 inf 9\n", r"needs finite coordinates, came 2 of 3 points"),
        ("1 2 3\n4 1e300 6\n", r"needs coordinates in metres, came numbers from 1 to 1e\+300"),
    ],
)
def test_a_bad_text_says_where_and_what(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=r"a\.csv: .*" + message):
        read_scan(write_text(tmp_path / "a.csv", text))


def test_line_numbers_hold_beyond_the_first_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.ingest.delimited.BLOCK_BYTES", 1000)
    text = "x y z\r\n" + rows_of(wall_points(400)).replace("\n", "\r\n") + "1 2 oops\r\n"
    with pytest.raises(InputError, match="came 'oops' in line 402"):
        read_scan(write_text(tmp_path / "a.xyz", text))


def test_blocks_join_without_a_seam(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.ingest.delimited.BLOCK_BYTES", 997)
    points_m = wall_points(1000)
    for end in ("\n", "\r\n", "\r"):
        path = write_text(tmp_path / "a.xyz", rows_of(points_m).replace("\n", end))
        # four decimals as written
        assert read_scan(path).points_m == pytest.approx(points_m, abs=1e-9)


def test_a_line_without_end_is_told(tmp_path: Path) -> None:
    scan = read_scan(write_text(tmp_path / "a.xyz", "1.5 -2 3\n4 5.25 -6"))
    assert np.array_equal(scan.points_m, TWO_POINTS)
    assert "cut short" in scan.notes[0]


def test_a_row_cut_within_its_columns_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"needs 3 columns, came 2 in line 2 .* cut short"):
        read_scan(write_text(tmp_path / "a.xyz", "1.5 -2 3\n4 5.25"))


def test_empty_returns_are_left_out_and_counted(tmp_path: Path) -> None:
    scan = read_scan(write_text(tmp_path / "a.xyz", "0 0 0\n1.5 -2 3\n0.0 -0.0 0\n4 5.25 -6\n0 0 1\n"))
    assert np.array_equal(scan.points_m, [*TWO_POINTS, [0.0, 0.0, 1.0]])
    assert scan.n_in_file == 5
    assert scan.notes == ("2 of 5 records lie at (0, 0, 0): beams without a return, left out",)


@pytest.mark.parametrize("row", ["0 0 0", "3 4 5"])
def test_points_all_in_one_place_are_refused(tmp_path: Path, row: str) -> None:
    with pytest.raises(InputError, match="all lie at"):
        read_scan(write_text(tmp_path / "a.xyz", f"{row}\n" * 5))


def test_stated_feet_become_metres(tmp_path: Path) -> None:
    scan = read_scan(write_text(tmp_path / "a.xyz", rows_of(TWO_POINTS)), ScanRequest(unit="foot"))
    assert scan.points_m == pytest.approx(TWO_POINTS * 0.3048, rel=1e-15)


def test_only_a_count_line_tells_the_number_of_points_beforehand(tmp_path: Path) -> None:
    assert describe_scan(write_text(tmp_path / "a.xyz", "2\n1 2 3\n4 5 6\n")).n_points == 2
    assert describe_scan(write_text(tmp_path / "b.xyz", "1 2 3\n4 5 6\n")).n_points is None
