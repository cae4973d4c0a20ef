"""Numbers that readers of text stumble over; each stood in a file of the fuzzer, or could have."""

from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tests.unit.ingest.clouds import rows_of, wall_points, write_text
from tests.unit.ingest.e57_files import SPHERICAL, Source, cloud, doubles, posed, write_e57

ROWS = rows_of(wall_points(20))
PTX = "5\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n{} 0 0 1\n"
LISTS = (
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty list uchar int n\n"
    "property double x\nproperty double y\nproperty double z\nend_header\n{}\n"
)


@pytest.mark.parametrize("digits", ["9" * 5000, "1" + "0" * 400])
@pytest.mark.parametrize("suffix", [".xyz", ".csv", ".pts"])
def test_a_number_of_thousands_of_digits_is_refused(tmp_path: Path, suffix: str, digits: str) -> None:
    text = ("21\n" if suffix == ".pts" else "") + f"{digits} 2 3\n{ROWS}"
    with pytest.raises(InputError, match="NaN or infinity"):
        read_scan(write_text(tmp_path / f"a{suffix}", text))


def test_a_number_of_thousands_of_digits_counts_no_points(tmp_path: Path) -> None:
    rows = "".join(f"{'9' * 5000} {k} {k} {k}\n" for k in range(5))
    with pytest.raises(InputError, match="NaN or infinity"):
        read_scan(write_text(tmp_path / "a.xyz", rows))


@pytest.mark.parametrize("value", ["1e308", "-1e308", "nan", "inf", "1e13"])
@pytest.mark.parametrize("place", ["turn", "shift"])
@pytest.mark.filterwarnings("error")
def test_a_matrix_beyond_all_numbers_is_refused(tmp_path: Path, place: str, value: str) -> None:
    head = (
        PTX.format(value)
        if place == "shift"
        else PTX.format("0").replace("1 0 0 0\n", f"{value} {value} 0 0\n")
    )
    path = write_text(tmp_path / "a.ptx", head + "".join(f"{row} 1\n" for row in ROWS.splitlines()))
    for ask in (describe_scan, read_scan):
        with pytest.raises(InputError, match="needs a finite pose"):
            ask(path, ScanRequest(frame="file"))


@pytest.mark.parametrize("number", ["1_0.0", "\uff11\uff10", "\u0661", "0x1p3", "1,0"])
def test_a_pose_of_e57_in_other_digits_is_refused(tmp_path: Path, number: str) -> None:
    pose = posed((1.0, 0.0, 0.0, 0.0), (7.0, 0.0, 0.0)).replace(">7.0<", f">{number}<")
    with pytest.raises(InputError, match="a pose of finite numbers"):
        read_scan(write_e57(tmp_path / "a.e57", cloud(wall_points(20), pose)), ScanRequest(frame="file"))


@pytest.mark.parametrize("number", ["2_0", "\uff12\uff10", "+", "", "2" * 5000])
def test_a_count_of_e57_in_other_digits_is_refused(tmp_path: Path, number: str) -> None:
    path = write_e57(
        tmp_path / "a.e57",
        cloud(wall_points(20)),
        edit=lambda xml: xml.replace('recordCount="20"', f'recordCount="{number}"'),
    )
    with pytest.raises(InputError, match="needs a whole number recordCount"):
        read_scan(path)


@pytest.mark.parametrize(
    "rows", ["-1 1 2 3\n0 4 5 6", "1_0 1 2 3\n0 4 5 6", "0 1_0 2 3\n0 4 5 6", "1 9 1 2 3\n-1 4 5 6"]
)
def test_a_list_of_ply_of_less_than_nothing_is_refused(tmp_path: Path, rows: str) -> None:
    with pytest.raises(InputError, match="needs the numbers and lists"):
        read_scan(write_text(tmp_path / "a.ply", LISTS.format(rows)))


def test_a_list_of_ply_is_read(tmp_path: Path) -> None:
    scan = read_scan(write_text(tmp_path / "a.ply", LISTS.format("1 9 1 2 3\n0 4 5 6")))
    assert np.array_equal(scan.points_m, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])


def test_a_header_of_ply_of_many_megabytes_is_refused(tmp_path: Path) -> None:
    comments = f"comment {'x' * 60_000}\n" * 100
    with pytest.raises(InputError, match="'end_header', came none"):
        read_scan(write_text(tmp_path / "a.ply", f"ply\nformat ascii 1.0\n{comments}{LISTS[21:]}"))


@pytest.mark.parametrize("end", ["\n\r", "\n\n"])
@pytest.mark.parametrize("suffix", [".ply", ".pcd"])
def test_binary_points_that_line_ends_have_shifted_are_refused(tmp_path: Path, suffix: str, end: str) -> None:
    ply = "ply\nformat binary_little_endian 1.0\nelement vertex 20\n{}end_header\n".format(
        "".join(f"property double {axis}\n" for axis in "xyz")
    )
    pcd = "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 20\nHEIGHT 1\nPOINTS 20\nDATA binary\n"
    head = ply if suffix == ".ply" else pcd
    body = wall_points(20).astype("<f8").tobytes()
    path = tmp_path / f"a{suffix}"
    path.write_bytes(head.encode() + body + b"\r\n")
    assert np.array_equal(read_scan(path).points_m, wall_points(20))
    path.write_bytes(head.replace("\n", end).encode() + body)
    with pytest.raises(InputError, match="needs "):
        read_scan(path)


def test_an_elevation_beyond_all_measure_is_refused(tmp_path: Path) -> None:
    polar = (np.linspace(5.0, 10.0, 300), np.linspace(0.0, 3.0, 300), np.full(300, 1e308))
    columns = tuple(doubles(name, values) for name, values in zip(SPHERICAL, polar, strict=True))
    with pytest.raises(InputError, match="needs finite coordinates, came 300 of 300"):
        read_scan(write_e57(tmp_path / "a.e57", Source(columns, 300)))
