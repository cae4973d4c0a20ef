"""Files of other programs, whole ones: what each must give."""

import struct
from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.ingest import LengthUnit, ScanRequest, describe_scan, read_scan
from tests.shared import SHARED, needs_shared

pytestmark = needs_shared

FORMATS = SHARED / "data" / "formats"
FEET: dict[str, LengthUnit] = {
    "autzen_trim.laz": "foot",
    "prec3.las": "foot",
    "test1_4.las": "US survey foot",
}
MIXED = "simple.copc.laz"
"""Metres on the ground, feet upward."""

WITHOUT_POINTS = "1.2-no-points.las"
GOOD = sorted(
    path
    for folder in ("laspy", "pdal")
    for path in (FORMATS / folder).glob("*.la[sz]")
    if path.name not in {MIXED, WITHOUT_POINTS}
)


def _count_in_header(path: Path) -> int:
    head = path.read_bytes()[:375]
    return int(
        struct.unpack_from("<Q", head, 247)[0] if head[25] == 4 else struct.unpack_from("<I", head, 107)[0]
    )


def test_there_are_files_to_read() -> None:
    assert len(GOOD) >= 12


@pytest.mark.parametrize("path", GOOD, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_a_good_file_gives_as_many_points_as_its_header_states(path: Path) -> None:
    request = ScanRequest(unit=FEET.get(path.name, "metre"))
    scan = read_scan(path, request)
    assert (
        len(scan.points_m)
        == scan.n_in_file
        == describe_scan(path, request).n_points
        == _count_in_header(path)
    )


@pytest.mark.parametrize("name", sorted([*FEET, MIXED]))
def test_a_file_that_states_feet_is_refused(name: str) -> None:
    path = next(FORMATS.rglob(name))
    with pytest.raises(InputError, match=r"needs coordinates in metre, came .* convert"):
        read_scan(path)


def test_mixed_units_are_refused_under_any_name() -> None:
    with pytest.raises(InputError, match="needs coordinates in US survey foot, came metre"):
        read_scan(FORMATS / "laspy" / MIXED, ScanRequest(unit="US survey foot"))


@pytest.mark.parametrize("cut", [0.1, 0.5, 0.99])
@pytest.mark.parametrize("path", GOOD, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_a_good_file_cut_short_is_refused(tmp_path: Path, path: Path, cut: float) -> None:
    content = path.read_bytes()
    short = tmp_path / path.name
    short.write_bytes(content[: int(len(content) * cut)])
    with pytest.raises(InputError, match=r"cut short|LASF"):
        read_scan(short, ScanRequest(unit=FEET.get(path.name, "metre")))


@pytest.mark.parametrize(
    ("name", "n_points", "first"),
    [
        ("cars/car_cloud400.csv", 24_989, (-3.5376, 0.639553, -1.37678)),
        ("cars/car_cloud401.csv", 25_193, (2.6247663, 0.052711742, -1.0169336)),
        ("dragon/dragon1.xyz", 100_000, (3.1798, 5.0338, 5.6575)),
        ("dragon/dragon2.xyz", 100_000, (3.3077, 5.4956, 6.2422)),
        ("webots/webots1.xyz", 44_366, (0.0, 3.96, 2.18)),
        ("webots/webots2.xyz", 45_100, (0.0, 1.89, 1.04)),
    ],
)
def test_text_of_other_programs_is_read_whole(
    name: str, n_points: int, first: tuple[float, float, float]
) -> None:
    scan = read_scan(SHARED / "data" / "registration" / name)
    assert len(scan.points_m) == n_points
    assert scan.points_m[0].tolist() == list(first)


def test_a_station_of_the_campaign_is_read_without_a_note() -> None:
    scan = read_scan(SHARED / "data" / "campaign" / "e1" / "ST04.laz")
    assert (len(scan.points_m), scan.notes) == (296_094, ())


def test_the_stems_are_told_to_lie_on_a_grid_of_a_centimetre() -> None:
    scan = read_scan(SHARED / "data" / "stems" / "LPine1_demo.laz")
    assert len(scan.points_m) == 1_544_202
    assert scan.notes == ("coordinates come in steps of 10 mm: export with a scale factor of 0.0001",)
