"""A workspace of before a table existed still opens, and is made whole by publishing again."""

import shutil

import duckdb
import pytest

from storage.catalog import rebuild_catalog
from storage.errors import StorageError
from storage.publish import publish_epoch
from storage.verify import verify_workspace
from storage.views import (
    reference_lean_rows,
    scheme_comparison_rows,
    surface_change_rows,
    surface_map_rows,
    tilt_rows,
)
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, fill

NEWER = ("reference_leans", "scheme_comparison", "surface_map")


@pytest.fixture
def older(ws: Workspace) -> Workspace:
    fill(ws, 2)
    for table in NEWER:
        shutil.rmtree(ws.tables / table)
    shutil.rmtree(ws.seals)
    shutil.rmtree(ws.second)
    return ws


def test_missing_tables_are_empty_views_beside_the_rows_of_the_others(older: Workspace) -> None:
    assert rebuild_catalog(older)
    assert reference_lean_rows(older, STRUCTURE) == []
    assert scheme_comparison_rows(older, STRUCTURE) == []
    assert surface_map_rows(older, STRUCTURE, "e0") == []
    assert surface_change_rows(older, STRUCTURE) == []
    assert [row.epoch for row in tilt_rows(older, STRUCTURE)] == ["e0", "e1"]


def test_verify_names_what_lacks_and_what_to_do(older: Workspace) -> None:
    rebuild_catalog(older)
    faults = verify_workspace(older).faults
    assert {(fault.where, fault.what_to_do) for fault in faults} == {
        (f"{STRUCTURE}/e0", "run the epoch again"),
        (f"{STRUCTURE}/e1", "run the epoch again"),
    }
    assert all(f"tables/{table}/{STRUCTURE}" in faults[0].what for table in NEWER)


def test_the_same_epoch_published_again_is_whole(older: Workspace) -> None:
    for number in range(2):
        tables = epoch_tables(f"e{number}", number, (0.007 + 1e-4 * number, -0.0057))
        assert publish_epoch(older, STRUCTURE, f"e{number}", tables)
    rebuild_catalog(older)
    assert verify_workspace(older).faults == ()
    assert [row.epoch for row in reference_lean_rows(older, STRUCTURE)] == ["e0", "e1"]


def test_a_catalog_of_before_says_what_to_do(older: Workspace) -> None:
    rebuild_catalog(older)
    with duckdb.connect(str(older.catalog)) as connection:
        connection.execute("DROP VIEW main.reference_leans")
    with pytest.raises(StorageError, match="delete the catalog and run again"):
        reference_lean_rows(older, STRUCTURE)
