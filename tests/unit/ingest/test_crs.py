"""The coordinate system that a file states, against the one of the campaign."""

import re
from pathlib import Path

import laspy
import numpy as np
import pytest
from numpy.typing import NDArray
from pyproj import CRS
from pyproj.enums import WktVersion

from storage.errors import InputError
from tasks.ingest import ScanRequest, describe_scan, read_scan
from tests.shared import SHARED, needs_shared
from tests.unit.ingest.clouds import geo_keys_vlr, wall_points, wkt_vlr, write_las

EAST_NORTH_UP_M = np.array([500_123.0, 4_412_345.0, 78.0])
"""A foot near the central meridian of EPSG:4548, x = east as LAS files hold it."""

ROUNDING_M = 3e-9
"""Of float64 at 4.4e6 m."""

SITE = 'LOCAL_CS["site grid",UNIT["metre",1],AXIS["x",EAST],AXIS["y",NORTH]]'

OWN = (
    'PROJCS["{name}",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",{meridian}],PARAMETER["scale_factor",1],'
    'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1]]'
)
"""A Transverse Mercator of somebody's own."""


def write_in(path: Path, system: CRS, points_m: NDArray[np.float64] | None = None) -> Path:
    """A file that laspy gave its coordinate system."""
    points_m = wall_points() + EAST_NORTH_UP_M if points_m is None else points_m
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales, header.offsets = np.full(3, 1e-4), np.round(points_m.mean(axis=0))
    header.add_crs(system)
    las = laspy.LasData(header)
    las.x, las.y, las.z = points_m.T
    las.write(path)
    return path


def write_with(path: Path, *vlrs: laspy.VLR) -> Path:
    return write_las(path, wall_points() + EAST_NORTH_UP_M, vlrs=vlrs)


def registered(horizontal: str | None) -> ScanRequest:
    return ScanRequest(frame="file", horizontal=horizontal, origin_m=tuple(EAST_NORTH_UP_M))


def bare(system: CRS, version: WktVersion) -> str:
    """WKT of a system without any code, and in WKT 1 without the order of its axes."""
    text = re.sub(r',\s*(AUTHORITY|ID)\["[^"]*",\s*"?[^"\]]*"?\]', "", str(system.to_wkt(version)))
    return re.sub(r',\s*AXIS\["[^\]]*\]', "", text) if "WKT1" in version.value else text


@pytest.mark.parametrize("code", [4548, 32650])
def test_the_same_code_passes_without_a_note(tmp_path: Path, code: int) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(code))
    assert describe_scan(path, registered(f"EPSG:{code}")).horizontal == f"EPSG:{code}"
    assert read_scan(path, registered(f"EPSG:{code}")).notes == ()


@pytest.mark.parametrize(("stated", "wanted"), [(32650, 4548), (4548, 32650), (32650, 32651), (4548, 4527)])
def test_another_code_is_refused_before_points_are_read(tmp_path: Path, stated: int, wanted: int) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(stated))
    for ask in (describe_scan, read_scan):
        with pytest.raises(
            InputError,
            match=rf"a\.laz: needs coordinates in EPSG:{wanted}, .* came EPSG:{stated} .* reproject .* or correct",
        ):
            ask(path, registered(f"EPSG:{wanted}"))


def test_the_horizontal_part_of_a_compound_counts(tmp_path: Path) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_user_input("EPSG:25832+7837"))
    assert describe_scan(path, registered("EPSG:25832")).horizontal == "EPSG:25832"
    with pytest.raises(InputError, match="came EPSG:25832"):
        read_scan(path, registered("EPSG:25833"))


def test_a_compound_in_the_campaign_passes_a_file_with_its_horizontal_part(tmp_path: Path) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(25832))
    assert read_scan(path, registered("EPSG:5555")).notes == ()


@pytest.mark.parametrize("version", [WktVersion.WKT1_GDAL, WktVersion.WKT1_ESRI, WktVersion.WKT2_2019])
@pytest.mark.parametrize("code", [4548, 32650, 31370, 2056])
def test_a_definition_without_codes_is_recognised(tmp_path: Path, code: int, version: WktVersion) -> None:
    path = write_with(tmp_path / "a.laz", wkt_vlr(bare(CRS.from_epsg(code), version)))
    assert describe_scan(path, registered(f"EPSG:{code}")).horizontal == f"EPSG:{code}"
    with pytest.raises(InputError, match=f"needs coordinates in EPSG:25833, .* came EPSG:{code}"):
        read_scan(path, registered("EPSG:25833"))


def test_a_system_of_ones_own_is_shown_and_refused_by_name(tmp_path: Path) -> None:
    path = write_with(tmp_path / "a.laz", wkt_vlr(OWN.format(name="plant grid", meridian=117.25)))
    assert describe_scan(path).horizontal == "'plant grid'"
    with pytest.raises(InputError, match=r"needs coordinates in EPSG:32650, .* came 'plant grid'"):
        read_scan(path, registered("EPSG:32650"))


def test_a_system_under_another_name_passes_if_it_is_the_same(tmp_path: Path) -> None:
    """EPSG:4548 with another name, east first and without a code."""
    text = bare(CRS.from_epsg(4548), WktVersion.WKT1_GDAL)
    renamed = re.sub(r'PROJCS\["[^"]*"', 'PROJCS["Beijing plant"', text)
    path = write_with(tmp_path / "a.laz", wkt_vlr(renamed))
    assert read_scan(path, registered("EPSG:4548")).notes == ()


def test_a_file_without_a_statement_passes_without_a_note(tmp_path: Path) -> None:
    path = write_with(tmp_path / "a.laz")
    assert describe_scan(path).horizontal is None
    for horizontal in (None, "local", "EPSG:4548"):
        assert read_scan(path, registered(horizontal)).notes == ()


def test_a_grid_of_the_site_is_no_statement(tmp_path: Path) -> None:
    path = write_with(tmp_path / "a.laz", wkt_vlr(SITE))
    assert describe_scan(path).horizontal is None
    assert read_scan(path, registered("EPSG:4548")).notes == ()


def test_a_projected_system_under_a_local_frame_is_told(tmp_path: Path) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(32650))
    (note,) = read_scan(path, registered("local")).notes
    assert note.startswith('the file states the coordinate system EPSG:32650, [frame] horizontal is "local"')


def test_nothing_is_compared_where_the_campaign_says_nothing(tmp_path: Path) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(32650))
    assert read_scan(path, registered(None)).notes == ()


@pytest.mark.parametrize("code", [4326, 4490])
def test_latitude_and_longitude_are_refused_whatever_the_campaign_says(tmp_path: Path, code: int) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(code), wall_points())
    for horizontal in (None, "local", "EPSG:4548"):
        with pytest.raises(InputError, match="needs plane coordinates in metres"):
            describe_scan(path, registered(horizontal))


def test_geotiff_keys_are_compared_as_a_definition_is(tmp_path: Path) -> None:
    path = write_with(tmp_path / "a.laz", geo_keys_vlr((1024, 1), (3072, 32650), (3076, 9001)))
    assert describe_scan(path).horizontal == "EPSG:32650"
    assert read_scan(path, registered("EPSG:32650")).notes == ()
    with pytest.raises(InputError, match=r"needs coordinates in EPSG:4548, .* came EPSG:32650"):
        read_scan(path, registered("EPSG:4548"))


@pytest.mark.parametrize("value", [0, 32767])
def test_keys_that_give_no_code_do_not_refuse_a_file(tmp_path: Path, value: int) -> None:
    path = write_with(tmp_path / "a.laz", geo_keys_vlr((1024, 1), (3072, value)))
    notes = " ".join(read_scan(path, registered("EPSG:4548")).notes)
    assert ("could not be compared with EPSG:4548" in notes) == (value == 32767)


def test_a_definition_that_cannot_be_understood_is_told(tmp_path: Path) -> None:
    path = write_with(tmp_path / "a.laz", wkt_vlr('PROJCS["half a system",GEOGCS["x"'))
    (note,) = read_scan(path, registered("EPSG:4548")).notes
    assert note.startswith(
        "the coordinate system that the file states, 'half a system', is not fully defined"
    )


def test_two_statements_must_both_agree(tmp_path: Path) -> None:
    text = CRS.from_epsg(32650).to_wkt(WktVersion.WKT1_GDAL)
    path = write_with(tmp_path / "a.laz", wkt_vlr(text), geo_keys_vlr((3072, 32651)))
    with pytest.raises(InputError, match="came EPSG:32651"):
        read_scan(path, registered("EPSG:32650"))


def test_a_code_that_nobody_knows_is_no_other_name_of_a_system(tmp_path: Path) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(32650))
    with pytest.raises(InputError, match=r"needs coordinates in EPSG:99999, .* came EPSG:32650"):
        read_scan(path, registered("EPSG:99999"))


def test_x_stays_x_in_a_system_that_has_north_first(tmp_path: Path) -> None:
    """EPSG:4548 has north first; files hold east first all the same, and the campaign's axes alone say what is east."""
    assert CRS.from_epsg(4548).axis_info[0].direction == "north"
    points_m = wall_points()
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(4548))
    assert read_scan(path, registered("EPSG:4548")).points_m == pytest.approx(points_m, abs=ROUNDING_M)


def test_axes_of_the_campaign_swap_whatever_the_system(tmp_path: Path) -> None:
    points_m = wall_points()
    north_first = (points_m + EAST_NORTH_UP_M)[:, [1, 0, 2]]
    east, north, up = EAST_NORTH_UP_M
    for code in (4548, 32650):
        path = write_in(tmp_path / "a.laz", CRS.from_epsg(code), north_first)
        request = ScanRequest(
            frame="file", horizontal=f"EPSG:{code}", origin_m=(north, east, up), swap_axes=True
        )
        assert read_scan(path, request).points_m == pytest.approx(points_m, abs=ROUNDING_M)


def test_the_scan_of_a_station_on_a_grid_is_told(tmp_path: Path) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(32650))
    notes = read_scan(path).notes
    assert "EPSG:32650 and its points lie 4412 km from zero" in notes[0]
    assert "must be in the frame of its scanner" in notes[0]


def test_the_scan_of_a_station_near_zero_may_state_any_system(tmp_path: Path) -> None:
    path = write_in(tmp_path / "a.laz", CRS.from_epsg(32650), wall_points())
    assert read_scan(path).notes == ()


@needs_shared
@pytest.mark.parametrize(
    ("name", "stated", "same", "other"),
    [
        ("laspy/autzen_trim.laz", "'NAD_1983_HARN_Lambert_Conformal_Conic'", "EPSG:2994", "EPSG:2992"),
        ("laspy/test1_4.las", "EPSG:2903", "EPSG:2903", "EPSG:2904"),
        ("pdal/1.0_1.las", "EPSG:26915", "EPSG:26915", "EPSG:26916"),
    ],
)
def test_a_file_of_another_program_is_compared(name: str, stated: str, same: str, other: str) -> None:
    path = SHARED / "data" / "formats" / name
    unit = {"autzen_trim.laz": "foot", "test1_4.las": "US survey foot"}.get(path.name, "metre")
    assert describe_scan(path, ScanRequest(unit=unit, horizontal=same)).horizontal == stated  # type: ignore[arg-type]
    with pytest.raises(InputError, match=f"needs coordinates in {other}, .* came {stated}"):
        describe_scan(path, ScanRequest(unit=unit, horizontal=other))  # type: ignore[arg-type]
