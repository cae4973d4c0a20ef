"""Polar scans, eq. 1 of the paper."""

from pathlib import Path

import numpy as np
import pytest

from storage.errors import InputError
from tasks.ingest import ScanRequest, read_scan
from tasks.ingest.polar import cartesian_from_polar
from tests.unit.ingest.clouds import wall_points, write_las, write_text

POLAR = ScanRequest(coordinates="polar")


@pytest.mark.parametrize(
    ("polar", "cartesian"),
    [
        ((10.0, 0.0, 0.0), (10.0, 0.0, 0.0)),
        ((10.0, 90.0, 0.0), (0.0, 10.0, 0.0)),
        ((10.0, 123.0, 90.0), (0.0, 0.0, 10.0)),
        ((2.0, 180.0, -30.0), (-np.sqrt(3.0), 0.0, -1.0)),
        ((2.0, 45.0, 60.0), (np.sqrt(0.5), np.sqrt(0.5), np.sqrt(3.0))),
    ],
)
def test_equation_one_by_hand(polar: tuple[float, ...], cartesian: tuple[float, ...]) -> None:
    # rounding of sine and cosine at 10 m
    assert cartesian_from_polar(np.array([polar]))[0] == pytest.approx(cartesian, abs=1e-14)


def _polar_of(points_m: np.ndarray) -> np.ndarray:
    east, north, up = points_m.T
    return np.column_stack(
        (
            np.hypot(np.hypot(east, north), up),
            np.degrees(np.arctan2(north, east)),
            np.degrees(np.arctan2(up, np.hypot(east, north))),
        )
    )


@pytest.mark.parametrize("names", ["S,alpha,omega", "s (m),ALPHA [deg],Omega", "S_m,alpha_deg,omega_deg"])
def test_a_polar_text_gives_the_points_of_its_cartesian_twin(tmp_path: Path, names: str) -> None:
    points_m = wall_points()
    rows = "\n".join(",".join(f"{value:.12f}" for value in row) for row in _polar_of(points_m))
    scan = read_scan(write_text(tmp_path / "a.csv", f"{names}\n{rows}\n"), POLAR)
    # twelve digits of a degree at 60 m are 1e-12 m
    assert scan.points_m == pytest.approx(points_m, abs=1e-10)


def test_columns_are_found_by_name_in_any_order(tmp_path: Path) -> None:
    path = write_text(tmp_path / "a.csv", "omega;id;S;alpha\n0;7;10;90\n90;8;5;0\n")
    assert read_scan(path, POLAR).points_m == pytest.approx(
        np.array([[0.0, 10.0, 0.0], [0.0, 0.0, 5.0]]), abs=1e-14
    )


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize(("version", "point_format"), [("1.2", 1), ("1.4", 6)])
def test_extra_dimensions_hold_a_polar_scan(
    tmp_path: Path, suffix: str, version: str, point_format: int
) -> None:
    points_m = wall_points()
    extra = dict(zip(("S", "Alpha", "omega"), _polar_of(points_m).T, strict=True))
    path = write_las(
        tmp_path / f"a{suffix}",
        np.zeros_like(points_m),
        version=version,
        point_format=point_format,
        extra=extra,
    )
    assert read_scan(path, POLAR).points_m == pytest.approx(points_m, abs=1e-10)


def test_a_las_file_without_polar_dimensions_names_what_it_has(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.las", wall_points(), extra={"Reflectance": np.ones(500)})
    with pytest.raises(InputError, match="needs one column 's', came 0 among Reflectance"):
        read_scan(path, POLAR)


def test_beams_without_return_are_left_out_and_counted(tmp_path: Path) -> None:
    path = write_text(tmp_path / "a.csv", "S,alpha,omega\n10,90,0\n0,91,0\n0,92,0\n5,0,90\n")
    scan = read_scan(path, POLAR)
    assert (len(scan.points_m), scan.n_in_file) == (2, 4)
    assert "2 of 4 records" in scan.notes[0]


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("-1,90,0", "needs ranges S >= 0, came -1"),
        ("10,90,135", "needs elevations omega from -90 to 90 degrees, came 0 to 135"),
        ("10,399,0", "needs horizontal angles alpha from -360 to 360 degrees"),
    ],
)
def test_impossible_polar_records_are_refused(tmp_path: Path, row: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_scan(write_text(tmp_path / "a.csv", f"S,alpha,omega\n10,20,0\n{row}\n"), POLAR)


def test_angles_that_look_like_radians_are_told(tmp_path: Path) -> None:
    scan = read_scan(write_text(tmp_path / "a.csv", "S,alpha,omega\n10,6.2,1.5\n11,3.1,-0.2\n"), POLAR)
    assert "radians" in scan.notes[0]


def test_radians_in_the_header_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"needs metres and degrees, came column 'alpha \(rad\)' in rad"):
        read_scan(write_text(tmp_path / "a.csv", "S,alpha (rad),omega\n10,20,0\n9,20,0\n"), POLAR)


def test_polar_text_without_names_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="needs a line that names the columns S, alpha, omega"):
        read_scan(write_text(tmp_path / "a.csv", "10,20,0\n9,20,0\n"), POLAR)
