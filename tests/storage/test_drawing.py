"""Axis and slices drawn for CAD and GIS are those of the catalog, read back with the libraries of others."""

import csv
import io
import json
import math
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from ezdxf.document import Drawing as Document
from ezdxf.filemanagement import readfile
from ezdxf.sections.classes import CLASS_DEFINITIONS
from pyproj import Transformer

from storage import views
from storage.catalog import rebuild_catalog
from storage.drawing import GEOMETRY, DrawingFrame, export_geometry, formats_of
from storage.errors import StorageError, UsageError
from storage.publish import publish_epoch
from storage.records import EpochRow, TiltRow
from storage.workspace import Workspace, open_workspace
from tests.storage.campaign import HEIGHT_M, STRUCTURE, epoch_tables
from tests.storage.drawn import HOSTILE, LOCAL, UTM50, choice, drawn, fill_drawn

EAST, NORTH, UP = LOCAL.origin_m


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """One workspace for all tests here, which only read it."""
    ws = open_workspace(tmp_path_factory.mktemp("drawn"))
    fill_drawn(ws)
    return ws


@pytest.fixture(scope="module")
def tilt(filled: Workspace) -> TiltRow:
    return next(row for row in views.tilt_rows(filled, STRUCTURE, "e1") if row.scheme == "A")


def as_dxf(content: bytes, folder: Path) -> Document:
    path = folder / "drawing.dxf"
    path.write_bytes(content)
    document = readfile(path)
    assert not document.audit().has_errors
    return document


def table(content: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(content.decode())))


def top_of(tilt: TiltRow) -> tuple[float, float, float]:
    east = EAST + tilt.base_east_m + HEIGHT_M * tilt.lean_east
    return (east, NORTH + tilt.base_north_m + HEIGHT_M * tilt.lean_north, UP + HEIGHT_M)


def test_dxf_names_its_classes_in_an_order_that_no_process_changes(filled: Workspace, tmp_path: Path) -> None:
    document = as_dxf(drawn(filled, "axis", "dxf"), tmp_path)
    used = sorted(document.entitydb.dxf_types_in_use() & set(CLASS_DEFINITIONS))
    assert len(used) > 1
    assert [one.dxf.name for one in document.classes][: len(used)] == used


def test_dxf_has_the_axis_as_a_line_in_space_in_metres(
    filled: Workspace, tilt: TiltRow, tmp_path: Path
) -> None:
    document = as_dxf(drawn(filled, "axis", "dxf"), tmp_path)
    assert document.header["$INSUNITS"] == 6
    (line,) = document.modelspace().query('LINE[layer=="axis_A_paper"]')
    assert tuple(line.dxf.start) == pytest.approx((EAST + tilt.base_east_m, NORTH + tilt.base_north_m, UP))
    assert tuple(line.dxf.end) == pytest.approx(top_of(tilt))
    known = [text for _, text in line.get_xdata("TILTWATCH")]
    assert f"lean_east={tilt.lean_east}" in known
    assert f"deviation_sigma_m={tilt.deviation_sigma_m}" in known
    assert document.header.custom_vars.get("coordinates") == LOCAL.meaning


def test_the_lean_goes_from_plumb_to_axis_and_is_as_long_as_the_deviation(
    filled: Workspace, tilt: TiltRow, tmp_path: Path
) -> None:
    space = as_dxf(drawn(filled, "axis", "dxf"), tmp_path).modelspace()
    (lean,) = space.query('LINE[layer=="lean_A_paper"]')
    (plumb,) = space.query('LINE[layer=="plumb_A_paper"]')
    assert (lean.dxf.end - lean.dxf.start).magnitude == pytest.approx(tilt.deviation_m)
    assert lean.dxf.start == plumb.dxf.end


def test_dxf_has_a_circle_at_the_height_of_each_round_slice(filled: Workspace, tmp_path: Path) -> None:
    space = as_dxf(drawn(filled, "slice-circles", "dxf"), tmp_path).modelspace()
    rows = views.slice_rows(filled, STRUCTURE, "e1", "A", "paper")
    circles = space.query("CIRCLE")
    assert [circle.dxf.radius for circle in circles] == [row.radius_m for row in rows[:2]]
    assert [circle.dxf.center.z - UP for circle in circles] == pytest.approx([row.z_m for row in rows[:2]])
    assert [circle.dxf.center.x - EAST for circle in circles] == pytest.approx(
        [row.center_east_m for row in rows[:2]]
    )


def test_an_oval_slice_is_an_ellipse_with_its_larger_diameter_clockwise_from_north(
    filled: Workspace, tmp_path: Path
) -> None:
    space = as_dxf(drawn(filled, "slice-circles", "dxf"), tmp_path).modelspace()
    (ellipse,) = space.query("ELLIPSE")
    larger = ellipse.dxf.major_axis
    assert larger.magnitude == pytest.approx(4.05)
    assert ellipse.dxf.ratio == pytest.approx(3.95 / 4.05)
    assert math.degrees(math.atan2(larger.x, larger.y)) == pytest.approx(30.0)


def test_a_square_section_is_no_circle_and_a_failed_slice_is_not_drawn(filled: Workspace) -> None:
    rows = table(drawn(filled, "slice-circles", "csv"))
    assert [(row["layer"], row["slice_index"]) for row in rows] == [
        ("circle", "0"),
        ("circle", "1"),
        ("ellipse", "1"),
        ("centre", "2"),
    ]
    written = export_geometry(filled, "slice-circles", "csv", choice(), io.BytesIO())
    assert written.warnings == (
        "1 of 4 slices have no contour and are not drawn; `export slices` has the reasons",
    )


def test_csv_has_coordinates_to_the_last_bit_and_empty_nulls(filled: Workspace, tilt: TiltRow) -> None:
    rows = {row["layer"]: row for row in table(drawn(filled, "axis", "csv"))}
    assert float(rows["axis"]["to_east_m"]) == top_of(tilt)[0]
    assert float(rows["foot"]["sigma_m"]) == tilt.base_sigma_m
    assert rows["foot"]["to_east_m"] == ""
    assert rows["axis"]["wkt"].startswith("LINESTRING Z (100.0100 -50.0200 12.5000, ")
    assert rows["axis"]["warning"] == HOSTILE
    assert rows["axis"]["frame"] == LOCAL.meaning


def test_parquet_says_what_its_coordinates_are(filled: Workspace, tilt: TiltRow) -> None:
    content = pq.read_table(io.BytesIO(drawn(filled, "axis", "parquet")))
    assert content.schema.metadata[b"frame"].decode() == LOCAL.meaning
    assert content["layer"].to_pylist() == ["axis", "plumb", "lean", "foot", "top"]
    assert content["sigma_m"].to_pylist()[3:] == [tilt.base_sigma_m, tilt.deviation_sigma_m]
    assert content["allowable_m"].null_count == 5


def test_geojson_of_a_projected_system_is_longitude_and_latitude(filled: Workspace, tilt: TiltRow) -> None:
    content = json.loads(drawn(filled, "axis", "geojson", choice(UTM50)))
    foot = next(f for f in content["features"] if f["properties"]["layer"] == "foot")
    longitude, latitude, up = foot["geometry"]["coordinates"]
    back = Transformer.from_crs("EPSG:4326", "EPSG:32650", always_xy=True).transform(longitude, latitude)
    assert back == pytest.approx((440_000.0 + tilt.base_east_m, 4_420_000.0 + tilt.base_north_m), abs=2e-4)
    assert (up, foot["properties"]["sigma_m"]) == (45.0, tilt.base_sigma_m)
    assert "crs" not in content
    assert content["coordinates_are"].startswith("longitude and latitude, WGS 84, from EPSG:32650 by ")


def test_geojson_of_a_local_frame_says_so_and_warns(filled: Workspace) -> None:
    out = io.BytesIO()
    written = export_geometry(filled, "slice-circles", "geojson", choice(), out)
    content = json.loads(out.getvalue())
    assert "not longitude and latitude" in content["coordinates_are"]
    assert "the frame is local" in written.warnings[1]
    ring = content["features"][0]["geometry"]["coordinates"][0]
    assert ring[0] == ring[-1]
    row = views.slice_rows(filled, STRUCTURE, "e1", "A", "paper")[0]
    reach = [math.dist(vertex[:2], (EAST + row.center_east_m, NORTH + row.center_north_m)) for vertex in ring]
    assert reach == pytest.approx([row.radius_m] * len(ring), abs=2e-5)


def test_words_stand_upright_beside_their_slice(filled: Workspace, tmp_path: Path) -> None:
    """Flat on the ground, those of all slices would lie on one another."""
    texts = as_dxf(drawn(filled, "slice-circles", "dxf"), tmp_path).modelspace().query("TEXT")
    row = views.slice_rows(filled, STRUCTURE, "e1", "A", "paper")[0]
    assert row.center_east_m is not None
    assert row.center_north_m is not None
    assert row.radius_m is not None
    ocs = texts[0].ocs()
    assert tuple(ocs.to_wcs(texts[0].dxf.insert)) == pytest.approx(
        (EAST + row.center_east_m + row.radius_m + 0.15, NORTH + row.center_north_m, UP + row.z_m)
    )
    assert tuple(ocs.uy) == (0.0, 0.0, 1.0)
    assert texts[0].dxf.text == "A/paper 2.00 m"


def test_hostile_text_stays_text_in_a_dxf(filled: Workspace, tmp_path: Path) -> None:
    space = as_dxf(drawn(filled, "axis", "dxf"), tmp_path).modelspace()
    assert len(space.query("LINE")) == 3
    (line,) = space.query('LINE[layer=="axis_A_paper"]')
    assert any(
        text.startswith("warning=bent ") and "\n" not in text for _, text in line.get_xdata("TILTWATCH")
    )


@pytest.mark.parametrize(("what", "file_format"), [(w, f) for w in GEOMETRY[:2] for f in formats_of(w)])
def test_the_same_results_give_the_same_bytes(filled: Workspace, what: str, file_format: str) -> None:
    assert drawn(filled, what, file_format) == drawn(filled, what, file_format)


def test_an_axis_without_a_covariance_has_no_sigma_and_says_so(filled: Workspace, tmp_path: Path) -> None:
    wanted = choice(scheme="F")
    (row, *_) = table(drawn(filled, "axis", "csv", wanted))
    assert (row["lean_sigma_east"], row["deviation_sigma_m"]) == ("", "")
    texts = [
        text.dxf.text
        for text in as_dxf(drawn(filled, "axis", "dxf", wanted), tmp_path).modelspace().query("TEXT")
    ]
    assert any("uncertainty unknown" in text for text in texts)


def test_a_method_alone_takes_all_schemes_that_have_it(filled: Workspace) -> None:
    rows = table(drawn(filled, "axis", "csv", choice(method="paper")))
    assert list(dict.fromkeys(row["scheme"] for row in rows)) == ["A", "F"]


def test_another_epoch_than_the_newest_is_taken_by_its_name(filled: Workspace) -> None:
    (row, *_) = table(drawn(filled, "axis", "csv", choice(epoch="e0")))
    assert row["epoch"] == "e0"


@pytest.mark.parametrize(
    ("what", "file_format", "changed", "message"),
    [
        ("axles", "csv", {}, "unknown geometry 'axles'; known: axis, slice-circles, cloud"),
        (
            "axis",
            "las",
            {},
            "axis cannot be written as 'las'; known: csv, dxf, geojson, parquet .*WHAT = cloud",
        ),
        ("cloud", "dxf", {}, "cloud cannot be written as 'dxf'; known: csv, las, laz, parquet .*write laz"),
        ("axis", "csv", {"epoch": "e9"}, "unknown epoch 'e9' of chimney-01; in the workspace: e0, e1"),
        ("axis", "csv", {"scheme": "Q"}, "epoch e1 has nothing of Q/any method; known: A/paper, F/paper"),
        ("cloud", "laz", {"scheme": "A"}, "the cloud is the same for all schemes"),
    ],
)
def test_a_wrong_word_is_answered_with_the_known_ones(
    filled: Workspace, what: str, file_format: str, changed: dict[str, str], message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        drawn(filled, what, file_format, choice(**changed))


def test_an_epoch_that_is_published_meanwhile_does_not_mix_with_the_one_that_is_drawn(ws: Workspace) -> None:
    fill_drawn(ws)
    before = drawn(ws, "axis", "csv")

    def publish_meanwhile(_epoch: EpochRow) -> DrawingFrame:
        publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1, (0.009, 0.001), run="run-9"))
        rebuild_catalog(ws)
        return LOCAL

    assert drawn(ws, "axis", "csv", replace(choice(), frame_of=publish_meanwhile)) == before
    assert drawn(ws, "axis", "csv") != before


def test_nothing_to_draw_is_refused_with_what_to_do(ws: Workspace) -> None:
    rebuild_catalog(ws)
    with pytest.raises(StorageError, match=r"no epoch of chimney-01 .* has an axis; `tiltwatch run FILE`"):
        drawn(ws, "axis", "csv")
