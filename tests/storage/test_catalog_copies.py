"""A catalog that is changed in a copy holds what one holds that is made of all tables."""

import dataclasses
import json
import os
from collections.abc import Callable

import duckdb
import pytest

from storage import catalog
from storage.catalog import rebuild_catalog
from storage.catalog_reading import read_catalog
from storage.publish import publish_epoch, remove_epoch
from storage.records import ControlChartRow
from storage.series import publish_series
from storage.tables import table_path
from storage.view_definitions import VIEWS
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, fill
from tests.storage.samples import full_row

Change = Callable[[Workspace], object]


def all_rows(ws: Workspace) -> dict[str, list[object]]:
    with read_catalog(ws) as connection:
        return {view: connection.execute(f"FROM {view} ORDER BY ALL").fetchall() for view in VIEWS}


def replaced(ws: Workspace) -> int:
    """Files whose rows were replaced since the catalog was made anew."""
    with read_catalog(ws) as connection:
        row = connection.execute("SELECT replaced FROM data.made_of").fetchone()
    assert row is not None
    return int(row[0])


def add(ws: Workspace) -> None:
    publish_epoch(ws, STRUCTURE, "e9", epoch_tables("e9", 9))


def replace(ws: Workspace) -> None:
    publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1, (0.009, 0.0)))


def empty(ws: Workspace) -> None:
    publish_epoch(ws, STRUCTURE, "e1", {**epoch_tables("e1", 1), "slices": [], "tilt": []})


def series(ws: Workspace) -> None:
    for seed in (0, 1):
        rows = [dataclasses.replace(full_row(ControlChartRow, seed), structure=STRUCTURE)]
        publish_series(ws, STRUCTURE, {"control_chart": rows})
        rebuild_catalog(ws)


CHANGES: dict[str, Change] = {
    "an epoch more": add,
    "an epoch replaced, its old results kept": replace,
    "an epoch emptied": empty,
    "an epoch removed": lambda ws: remove_epoch(ws, STRUCTURE, "e0"),
    "a series made anew": series,
    "a table lost": lambda ws: table_path(ws, "tilt", STRUCTURE, "e1").unlink(),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=list(CHANGES))
def test_a_changed_copy_holds_the_rows_of_a_catalog_made_anew(ws: Workspace, change: Change) -> None:
    fill(ws, 3)
    rebuild_catalog(ws)
    change(ws)
    rebuild_catalog(ws)
    copied = all_rows(ws)
    ws.catalog.unlink()
    rebuild_catalog(ws)
    assert replaced(ws) == 0
    assert copied == all_rows(ws)


def test_an_unchanged_file_is_not_read_again(ws: Workspace) -> None:
    """A file damaged behind an unchanged stamp stands for one that must not be opened."""
    fill(ws, 2)
    rebuild_catalog(ws)
    path = table_path(ws, "tilt", STRUCTURE, "e0")
    stat = path.stat()
    path.write_bytes(b"x" * stat.st_size)
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    publish_epoch(ws, STRUCTURE, "e2", epoch_tables("e2", 2))
    assert rebuild_catalog(ws)
    assert len(all_rows(ws)["tilt"]) == 3


def test_replaced_files_are_counted_until_the_catalog_is_made_anew(
    ws: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows that were replaced leave holes in the file: it must not grow for ever."""
    fill(ws, 2)
    rebuild_catalog(ws)
    replace(ws)
    rebuild_catalog(ws)
    assert replaced(ws) > 0
    monkeypatch.setattr(catalog, "_FEW_FILES", 0)
    before = all_rows(ws)
    empty(ws)
    rebuild_catalog(ws)
    assert replaced(ws) == 0
    assert len(all_rows(ws)["tilt"]) == len(before["tilt"]) - 1


def test_other_definitions_take_over_the_rows_of_tables_whose_columns_are_the_same(ws: Workspace) -> None:
    """As after an upgrade: a table with other columns is read again, the others need not be."""
    fill(ws, 2)
    rebuild_catalog(ws)
    whole = all_rows(ws)
    with duckdb.connect(str(ws.catalog)) as connection:
        row = connection.execute("SELECT columns FROM data.made_of").fetchone()
        assert row is not None
        columns = {**json.loads(row[0]), "tilt": "of an older program"}
        connection.execute(
            "UPDATE data.made_of SET definitions = 'older', columns = ?", [json.dumps(columns)]
        )
        connection.execute("DELETE FROM data.tilt")
        connection.execute("UPDATE data.slices SET z_m = 7.0")
    rebuild_catalog(ws)
    after = all_rows(ws)
    assert after["tilt"] == whole["tilt"], "read again"
    assert after["slices"] != whole["slices"], "taken over"


def test_a_catalog_whose_rows_are_damaged_is_made_of_the_tables(ws: Workspace) -> None:
    """DuckDB tells of a damaged block when it reads it, not when it opens the file."""
    fill(ws, 2)
    rebuild_catalog(ws)
    with duckdb.connect(str(ws.catalog)) as connection:
        connection.execute("DROP TABLE data.slices CASCADE")
    add(ws)
    rebuild_catalog(ws)
    with read_catalog(ws) as connection:
        assert connection.execute("SELECT count(DISTINCT epoch) FROM slices").fetchone() == (3,)
