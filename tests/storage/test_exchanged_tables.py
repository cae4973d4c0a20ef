"""A whole table under the name of another epoch: none of its rows is shown, and none stays when it is put right."""

import shutil

import pytest

from storage.archive import archive_version
from storage.catalog import files_left_out, rebuild_catalog
from storage.catalog_reading import read_catalog
from storage.tables import EPOCH_TABLES, table_path
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, fill


@pytest.mark.parametrize("table", ["tilt", "slices", "epochs"])
def test_the_table_of_another_epoch_in_the_place_of_one_leaves_nothing_behind(
    ws: Workspace, table: str
) -> None:
    fill(ws, 2)
    rebuild_catalog(ws)
    place = table_path(ws, table, STRUCTURE, "e1")
    before, content = _all_rows(ws), place.read_bytes()
    shutil.copyfile(table_path(ws, table, STRUCTURE, "e0"), place)
    rebuild_catalog(ws)
    assert _all_rows(ws) == before
    assert "holds rows of epoch e0" in str(files_left_out(ws)[f"tables/{table}/{STRUCTURE}/e1.parquet"])
    place.write_bytes(content)
    rebuild_catalog(ws)
    assert (_all_rows(ws), files_left_out(ws)) == (before, {})


def _all_rows(ws: Workspace) -> list[list[tuple[object, ...]]]:
    with read_catalog(ws) as connection:
        return [connection.table(f"data.{name}").order("ALL").fetchall() for name in EPOCH_TABLES]


@pytest.mark.parametrize("name", ["tilt.parquet", "manifest.json"])
def test_earlier_results_of_another_epoch_leave_nothing_behind(ws: Workspace, name: str) -> None:
    fill(ws, 2)
    archive_version(ws, STRUCTURE, "old", ["e0", "e1"], "for the test")
    rebuild_catalog(ws)
    place = ws.versions / STRUCTURE / "old" / "e1" / name
    before, content = _earlier(ws), place.read_bytes()
    shutil.copyfile(ws.versions / STRUCTURE / "old" / "e0" / name, place)
    rebuild_catalog(ws)
    assert set(map(str, _earlier(ws))) < set(map(str, before))
    place.write_bytes(content)
    rebuild_catalog(ws)
    assert _earlier(ws) == before


def _earlier(ws: Workspace) -> list[tuple[object, ...]]:
    with read_catalog(ws) as connection:
        tables = [
            connection.table(f"data.{name}").order("ALL").fetchall() for name in ("versions", "version_tilt")
        ]
    return [*tables[0], *tables[1]]
