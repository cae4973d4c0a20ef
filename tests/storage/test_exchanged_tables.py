"""A whole table under the name of another epoch: none of its rows is shown, and none stays when it is put right."""

import shutil

import pytest

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
