"""A cloud written for others is the cloud of the workspace, read back with their libraries."""

import csv
import io
import json
from dataclasses import replace

import laspy
import numpy as np
import pyarrow.parquet as pq
import pytest
from pyproj import CRS, Transformer

from storage.drawing.content import DrawnCloud
from storage.drawing.formats import cloud_writer_of, formats_of
from storage.errors import StorageError
from storage.views.shaft_points import shaft_points
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE
from tests.storage.drawn import LOCAL, STATIONS, UTM50, drawn, small_cloud
from tests.storage.stored_scans import N_SHAFT, keep_scans, publish_scans


def written(cloud: DrawnCloud, file_format: str) -> bytes:
    file = io.BytesIO()
    cloud_writer_of(file_format)(cloud, file)
    return file.getvalue()


@pytest.mark.parametrize("file_format", ["las", "laz"])
def test_las_has_the_points_to_a_tenth_of_a_millimetre_and_their_stations(file_format: str) -> None:
    given = small_cloud()
    read = laspy.read(io.BytesIO(written(given, file_format)))
    assert str(read.header.version) == "1.4"
    assert np.abs(read.xyz - (given.points_m + LOCAL.origin_m)).max() <= 0.5001e-4
    assert list(read.header.scales) == [1e-4] * 3
    assert np.array_equal(read.point_source_id, given.station_index + 1)
    (ours,) = [vlr for vlr in read.header.vlrs if vlr.user_id == "tiltwatch"]
    about = json.loads(ours.record_data)
    assert about["point_source_id"] == {"1": STATIONS[0], "2": STATIONS[1]}
    assert about["coordinates"] == LOCAL.meaning


def test_las_of_a_projected_system_states_it() -> None:
    header = laspy.read(io.BytesIO(written(small_cloud(UTM50), "laz"))).header
    crs = header.parse_crs()
    assert crs is not None
    assert crs.to_epsg() == 32650
    assert header.global_encoding.wkt
    assert list(header.offsets) == [440_000.0, 4_420_000.0, 45.0]


def test_las_of_a_local_frame_states_no_system() -> None:
    assert laspy.read(io.BytesIO(written(small_cloud(), "las"))).header.parse_crs() is None


def test_points_too_far_for_las_are_refused_with_a_way_out() -> None:
    given = small_cloud()
    far = replace(given, points_m=given.points_m + 3e5)
    with pytest.raises(StorageError, match=r"more than 214 km from frame\.origin_m"):
        written(far, "las")


def test_csv_has_the_points_and_stations_with_their_quotes() -> None:
    given = small_cloud()
    rows = list(csv.DictReader(io.StringIO(written(given, "csv").decode())))
    read = np.array([[float(row[name]) for name in ("east_m", "north_m", "up_m")] for row in rows])
    assert np.abs(read - (given.points_m + LOCAL.origin_m)).max() <= 0.5001e-4
    assert [row["station"] for row in rows[:2]] == list(STATIONS)


def test_parquet_has_the_points_to_the_last_bit() -> None:
    given = small_cloud()
    table = pq.read_table(io.BytesIO(written(given, "parquet")))
    assert np.array_equal(table["up_m"].to_numpy(), given.points_m[:, 2] + LOCAL.origin_m[2])
    assert table["station"].to_pylist()[:2] == list(STATIONS)
    assert table.schema.metadata[b"frame"].decode() == LOCAL.meaning


def test_pieces_of_a_cloud_go_on_where_the_last_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = {file_format: written(small_cloud(), file_format) for file_format in ("las", "csv")}
    monkeypatch.setattr("storage.drawing.content.PIECE_POINTS", 77)
    assert {file_format: written(small_cloud(), file_format) for file_format in whole} == whole


@pytest.mark.parametrize("file_format", formats_of("cloud"))
def test_the_same_cloud_gives_the_same_bytes(file_format: str) -> None:
    assert written(small_cloud(), file_format) == written(small_cloud(), file_format)


def test_the_cloud_of_an_epoch_is_its_isolated_shaft_in_the_frame_of_the_campaign(ws: Workspace) -> None:
    keep_scans(ws)
    publish_scans(ws)
    read = laspy.read(io.BytesIO(drawn(ws, "cloud", "laz")))
    stored = shaft_points(ws, STRUCTURE, "e0")
    assert len(read.points) == N_SHAFT
    assert np.abs(read.xyz - (stored.points_m + LOCAL.origin_m)).max() <= 0.5001e-4
    assert np.array_equal(read.point_source_id, stored.station_index + 1)


def test_a_cloud_that_was_swept_is_refused_with_what_to_do(ws: Workspace) -> None:
    publish_scans(ws)
    with pytest.raises(StorageError, match="not in this workspace; "):
        drawn(ws, "cloud", "laz")


@pytest.mark.parametrize("code", [32650, 4549, 31467, 7415])
def test_las_states_its_system_in_the_wkt_of_its_specification(code: int) -> None:
    header = laspy.read(io.BytesIO(written(small_cloud(replace(UTM50, epsg=code)), "las"))).header
    (vlr,) = [vlr for vlr in header.vlrs if vlr.user_id == "LASF_Projection"]
    assert vlr.record_id == 2112
    assert vlr.string.startswith(("PROJCS[", "COMPD_CS["))
    crs = header.parse_crs()
    assert crs is not None
    assert f'AUTHORITY["EPSG","{code}"]' in vlr.string
    both = Transformer.from_crs(crs, CRS.from_epsg(code), always_xy=True)
    assert both.transform(440_000.0, 4_420_000.0) == pytest.approx((440_000.0, 4_420_000.0), abs=1e-6)
    assert [axis.direction for axis in crs.axis_info[:2]] == ["east", "north"]


def test_more_names_of_stations_than_a_las_record_holds_are_refused_with_a_way_out() -> None:
    given = replace(small_cloud(), stations=[f"station-{number:050d}" for number in range(1500)])
    with pytest.raises(
        StorageError, match=r"names of 1,500 stations take .* holds 65,535; export parquet or csv"
    ):
        written(given, "las")
