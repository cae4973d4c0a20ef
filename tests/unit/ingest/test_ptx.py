"""PTX: scans with poses."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.geometry.rotations import rotation_from_vector
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tests.shared import SHARED, needs_shared
from tests.unit.ingest.clouds import wall_points, write_text

FILE = ScanRequest(frame="file")
WRITTEN_M = 1e-6
"""Half the last of six digits, with room for the matrix that has as many, at 60 m."""

NO_RETURN = "0 0 0 0.500000\n"
IDENTITY = np.eye(4)


def matrix_of(rotation_vector: tuple[float, ...], translation: tuple[float, ...]) -> NDArray[np.float64]:
    """The (4, 4) matrix of PTX: for row vectors."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_from_vector(np.array(rotation_vector)).T
    matrix[3, :3] = translation
    return matrix


def scan_text(
    points_m: NDArray[np.float64],
    matrix: NDArray[np.float64] = IDENTITY,
    *,
    registered: NDArray[np.float64] | None = None,
    digits: int = 8,
) -> str:
    placed = np.vstack((matrix[3, :3], matrix[:3, :3])) if registered is None else registered
    head = [f"{value[0]:.{digits}f} {value[1]:.{digits}f} {value[2]:.{digits}f}" for value in placed]
    head += [" ".join(f"{value:.{digits}f}" for value in row) for row in matrix]
    rows = ["{:.7f} {:.7f} {:.7f} 0.25".format(*point) for point in points_m]
    return "\n".join(["1", str(len(points_m)), *head, *rows]) + "\n"


FIRST = matrix_of((0.01, -0.02, 1.2), (100.0, 200.0, 5.0))
SECOND = matrix_of((0.0, 0.0, -2.5), (-40.0, 3.0, 0.5))


def two_scans(tmp_path: Path) -> Path:
    return write_text(
        tmp_path / "a.ptx", scan_text(wall_points(50), FIRST) + scan_text(wall_points(30, seed=4), SECOND)
    )


def placed(points_m: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    return (np.column_stack((points_m, np.ones(len(points_m)))) @ matrix)[:, :3]


def test_the_matrix_is_for_row_vectors(tmp_path: Path) -> None:
    # the example of rapidlasso.de/matrix-transformation-in-lastools, confirmed there by CloudCompare and Cyclone
    text = (
        "3\n3\n0.000000 0.000000 0.000000\n1.000000 0.000000 0.000000\n0.000000 1.000000 0.000000\n"
        "0.000000 0.000000 1.000000\n-0.955179 0.296021 -0.002106 0.000000\n-0.296023 -0.955180 0.001152 0.000000\n"
        "-0.001670 0.001724 0.999997 0.000000\n3.847211 12.235314 -0.425777 1.000000\n1.111111 2.111111 3.111 0.111\n"
        "1.222222 2.222222 3.222 0.212\n0 0 0 0\n0 0 0 0 \n1.333333 2.333333 3.333 0.312\n1.444444 2.444444 3.444 0.423\n"
        "0 0 0 0\n1.555555 2.555555 3.555 0.534\n1.666666 2.666666 3.666 0.678\n"
    )
    scan = read_scan(write_text(tmp_path / "sample.ptx", text), FILE)
    expected = [[2.156, 10.553, 2.685], [2.017, 10.480, 2.796], [1.877, 10.407, 2.907]]
    # given there to the millimetre
    assert scan.points_m[:3] == pytest.approx(np.array(expected), abs=6e-4)
    assert (len(scan.points_m), scan.n_in_file) == (6, 9)


def test_a_scan_in_its_own_frame_keeps_its_points_and_states_its_pose(tmp_path: Path) -> None:
    points_m = wall_points(40)
    scan = read_scan(write_text(tmp_path / "a.ptx", scan_text(points_m, SECOND)))
    assert scan.points_m == pytest.approx(points_m, abs=WRITTEN_M)
    assert scan.pose is not None
    assert scan.pose.rotation == pytest.approx(SECOND[:3, :3].T, abs=1e-8)
    assert scan.pose.rotation @ scan.pose.rotation.T == pytest.approx(np.eye(3), abs=1e-14)
    assert scan.pose.translation.tolist() == SECOND[3, :3].tolist()


def test_scans_in_the_frame_of_the_file_are_placed_and_joined(tmp_path: Path) -> None:
    scan = read_scan(two_scans(tmp_path), FILE)
    expected = np.vstack((placed(wall_points(50), FIRST), placed(wall_points(30, seed=4), SECOND)))
    assert scan.points_m == pytest.approx(expected, abs=WRITTEN_M)
    assert scan.pose is None


def test_a_part_is_chosen_by_its_number(tmp_path: Path) -> None:
    path = two_scans(tmp_path)
    assert read_scan(path, ScanRequest(part=2)).points_m == pytest.approx(
        wall_points(30, seed=4), abs=WRITTEN_M
    )
    only = read_scan(path, ScanRequest(part=1, frame="file"))
    assert only.points_m == pytest.approx(placed(wall_points(50), FIRST), abs=WRITTEN_M)


@pytest.mark.parametrize("ask", [read_scan, describe_scan])
@pytest.mark.parametrize(
    ("part", "message"),
    [
        (
            None,
            r"needs one scan for a station, came 2 scans, part = 1 to 2, without names; write part = 1, or another",
        ),
        (3, r"needs part = 3, came 2 scans, part = 1 to 2, without names"),
        (0, r"needs part = 0, came 2 scans"),
        ("2", r"needs part = '2', came 2 scans, part = 1 to 2, without names"),
    ],
)
def test_a_part_that_is_not_there_is_answered_with_those_that_are(
    tmp_path: Path, part: str | int | None, message: str, ask: object
) -> None:
    with pytest.raises(InputError, match=message):
        ask(two_scans(tmp_path), ScanRequest(part=part))  # type: ignore[operator]


def test_a_header_tells_the_parts_with_their_poses(tmp_path: Path) -> None:
    header = describe_scan(two_scans(tmp_path), FILE)
    assert header.n_points == 80
    assert [part.n_points for part in header.parts] == [50, 30]
    assert [part.pose is not None and part.pose.translation.tolist() for part in header.parts] == [
        [100.0, 200.0, 5.0],
        [-40.0, 3.0, 0.5],
    ]
    assert describe_scan(two_scans(tmp_path), ScanRequest(part=2)).n_points == 30


def test_beams_without_return_are_left_out_in_both_frames(tmp_path: Path) -> None:
    text = scan_text(wall_points(5), FIRST).replace("\n5\n", "\n8\n", 1) + NO_RETURN * 3
    path = write_text(tmp_path / "a.ptx", text)
    for request in (ScanRequest(), FILE):
        scan = read_scan(path, request)
        assert (len(scan.points_m), scan.n_in_file) == (5, 8)
        assert "3 of 8 records lie at (0, 0, 0): beams without a return, left out" in scan.notes


def test_a_scan_without_any_return_does_not_harm_the_others(tmp_path: Path) -> None:
    text = scan_text(np.zeros((4, 3)), FIRST) + scan_text(wall_points(6), SECOND)
    scan = read_scan(write_text(tmp_path / "a.ptx", text), FILE)
    assert scan.points_m == pytest.approx(placed(wall_points(6), SECOND), abs=WRITTEN_M)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.diag([1.0, 1.0, -1.0, 1.0]), r"came a mirror \(determinant below 0\) in the matrix of scan 1"),
        (np.diag([1.0, 1.0, 2.0, 1.0]), r"came axes of lengths 1, 1, 2 in the matrix of scan 1"),
        (np.diag([0.9996, 0.9996, 0.9996, 1.0]), r"came axes of lengths 0\.9996, 0\.9996, 0\.9996"),
        (np.diag([0.0, 0.0, 0.0, 1.0]), r"came axes of lengths 0, 0, 0"),
        (
            np.array([[1, 0, 0, 0], [0.001, 1 - 5e-7, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]),
            r"no right angles \(off by 0\.001\)",
        ),
        (
            FIRST.T,
            r"needs 0, 0, 0, 1 in the last column and the translation in the last row, came 100, 200, 5",
        ),
        (np.full((4, 4), np.nan), r"needs 0, 0, 0, 1 in the last column"),
    ],
)
@pytest.mark.parametrize("request_", [ScanRequest(), FILE])
@pytest.mark.parametrize("ask", [read_scan, describe_scan])
def test_a_matrix_that_is_no_pose_is_refused(
    tmp_path: Path, matrix: NDArray[np.float64], message: str, request_: ScanRequest, ask: object
) -> None:
    with pytest.raises(InputError, match=message):
        ask(write_text(tmp_path / "a.ptx", scan_text(wall_points(5), matrix)), request_)  # type: ignore[operator]


@pytest.mark.parametrize(("digits", "is_rough"), [(8, False), (6, False), (5, True)])
def test_rounding_of_a_matrix_is_taken_out_and_told_if_it_is_coarse(
    tmp_path: Path, digits: int, is_rough: bool
) -> None:
    scan = read_scan(write_text(tmp_path / "a.ptx", scan_text(wall_points(5), FIRST, digits=digits)))
    assert scan.pose is not None
    assert scan.pose.rotation @ scan.pose.rotation.T == pytest.approx(np.eye(3), abs=1e-14)
    assert any("the matrix is off a rotation by" in note for note in scan.notes) == is_rough


def test_a_matrix_of_three_digits_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="with at least five decimals"):
        read_scan(write_text(tmp_path / "a.ptx", scan_text(wall_points(5), FIRST, digits=3)))


def test_a_matrix_that_contradicts_the_scanner_lines_is_told(tmp_path: Path) -> None:
    lines = np.vstack((np.zeros(3), np.eye(3)))
    scan = read_scan(write_text(tmp_path / "a.ptx", scan_text(wall_points(5), SECOND, registered=lines)))
    assert scan.notes == (
        "scan 1: the lines on place and axes of the scanner differ from the matrix; the matrix counts",
    )
    assert scan.pose is not None
    assert scan.pose.translation.tolist() == SECOND[3, :3].tolist()


GOOD = scan_text(wall_points(6)) + scan_text(wall_points(4))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "came a file that holds no points"),
        ("\n \n", "came a file that holds no points"),
        ("0\n7\n" + "\n".join(GOOD.splitlines()[2:10]) + "\n", "came a file that holds no points"),
        ("x y z\n", r"needs the count of columns, then that of rows, came 'x y z' in line 1"),
        ("3\n", r"came the end of the file in line 2"),
        ("-3\n4\n", r"came '-3' in line 1"),
        ("3\n4\n0 0\n", r"needs 3 numbers in line 3 of the header, came '0 0'"),
        (GOOD.replace("\n6\n", "\n5\n", 1), r"after the 5 rows of scan 1, came '.*' in line 16"),
        (GOOD.replace("\n4\n", "\n5\n", 1), r"needs the 5 points that the header of scan 2 states, came 4"),
        (GOOD.replace("\n6\n", "\n7\n", 1), r"after the 7 rows of scan 1, came '0.00000000 .* in line 19"),
        (GOOD.replace("\n6\n", "\n6000000000000\n", 1), r"needs the 6000000000000 points .* came 20"),
        (GOOD.replace(" 0.25\n", "\n", 1), r"needs 3 columns in the 6 rows .* came 4 in line 12"),
        (GOOD[:-6], r"needs 4 columns in the 4 rows .*, came 3 in line 30 .* cut short"),
        (
            GOOD.replace(" 0.25\n", " 0.25 7\n"),
            r"needs rows x y z intensity \[r g b\], came 5 columns in line 11",
        ),
        (
            GOOD.replace(" 0.25\n", " 0,25\n"),
            r"needs numbers, came '0,25' in line 11 .*; write numbers as 1\.5",
        ),
    ],
)
def test_a_bad_file_says_where_and_what(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=r"a\.ptx: .*" + message):
        read_scan(write_text(tmp_path / "a.ptx", text), FILE)


@pytest.mark.parametrize("value", ["inf", "nan"])
def test_a_point_that_is_not_finite_is_refused_in_both_frames(tmp_path: Path, value: str) -> None:
    text = scan_text(wall_points(5), FIRST).replace("\n5\n", "\n6\n", 1) + f"1 {value} 2 0.25\n"
    path = write_text(tmp_path / "a.ptx", text)
    for request in (ScanRequest(), FILE):
        with pytest.raises(InputError, match="needs finite coordinates, came 1 of 6 points"):
            read_scan(path, request)


def test_blocks_join_without_a_seam(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.ingest.text_rows.BLOCK_BYTES", 331)
    monkeypatch.setattr("tasks.ingest.file_pose.PIECE", 7)
    text = scan_text(wall_points(50), FIRST) + "\n" + scan_text(wall_points(30, seed=4), SECOND)
    for end in ("\n", "\r\n"):
        scan = read_scan(write_text(tmp_path / "a.ptx", text.replace("\n", end)), FILE)
        assert scan.points_m[50:] == pytest.approx(placed(wall_points(30, seed=4), SECOND), abs=WRITTEN_M)
        assert len(scan.points_m) == 80


def test_polar_coordinates_are_refused_with_a_hint(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"needs named columns S, alpha, omega .* came PTX"):
        read_scan(two_scans(tmp_path), ScanRequest(coordinates="polar", frame="file"))


@needs_shared
def test_a_cloud_exported_twice_has_the_same_points() -> None:
    folder = SHARED / "data" / "formats" / "pdal"
    ptx = read_scan(folder / "1.2-with-color.ptx")
    las = read_scan(folder / "1.2-with-color.las")
    # both keep hundredths
    assert ptx.points_m == pytest.approx(las.points_m, abs=1e-6)
    assert read_scan(folder / "no-color.ptx").points_m == pytest.approx(las.points_m[:15], abs=1e-6)


@needs_shared
def test_a_scan_that_its_file_scales_is_refused_and_its_neighbour_is_read() -> None:
    path = SHARED / "data" / "formats" / "pdal" / "multiple-and-transform.ptx"
    for request in (FILE, ScanRequest(part=1)):
        with pytest.raises(InputError, match=r"came axes of lengths 1, 1, 2 in the matrix of scan 1"):
            read_scan(path, request)
    las = read_scan(path.with_name("1.2-with-color.las"))
    assert read_scan(path, ScanRequest(part=2)).points_m == pytest.approx(las.points_m[:4], abs=1e-6)
    assert [part.pose is None for part in describe_scan(path, ScanRequest(part=2)).parts] == [True, False]


@needs_shared
def test_a_registered_scan_of_another_program_is_placed_by_its_matrix() -> None:
    scan = read_scan(SHARED / "data" / "formats" / "pdal" / "complex-transform.ptx", FILE)
    # by hand, from the rows of its matrix
    x, y, z = -0.005630, 0.645218, -0.440506
    expected = (
        0.999979 * x + 0.003613 * y + 0.005359 * z - 3.028748,
        -0.003604 * x + 0.999992 * y - 0.001650 * z - 3.819741,
        -0.005365 * x + 0.001630 * y + 0.999984 * z - 1.384333,
    )
    assert scan.points_m[0] == pytest.approx(expected, abs=WRITTEN_M)
    assert (len(scan.points_m), scan.n_in_file) == (4, 12)
