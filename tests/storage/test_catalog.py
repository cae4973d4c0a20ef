"""The catalog shows whole epochs, to anyone, at any time, anywhere."""

import shutil
import subprocess
import sys
from pathlib import Path

import duckdb
import pytest

from storage.catalog import files_left_out, rebuild_catalog
from storage.catalog_reading import read_catalog
from storage.errors import StorageError
from storage.publish import publish_epoch, remove_epoch
from storage.records import TABLES, columns_of
from storage.tables import EPOCH_TABLES
from storage.view_definitions import VIEWS, view_definition
from storage.views import latest_epochs, tilt_rows
from storage.workspace import Workspace, open_workspace
from tests.shared import SHARED, needs_shared
from tests.storage.campaign import N_SLICES, STRUCTURE, epoch_tables, fill

DUCKDB_TYPES = {
    bool: "BOOLEAN",
    int: "BIGINT",
    float: "DOUBLE",
    str: "VARCHAR",
    "datetime": "TIMESTAMP WITH TIME ZONE",
}
every_view = pytest.mark.parametrize("view", VIEWS)

# each answer must be a whole epoch: as many slices as the tilt says, and the state that belongs to the lean
READER = """
import sys, time, duckdb
path, until = sys.argv[1], time.monotonic() + float(sys.argv[2])
seen = set()
print("ready", flush=True)
while time.monotonic() < until or (len(seen) < 2 and time.monotonic() < until + 60):  # a loaded machine publishes slowly
    con = duckdb.connect(path, read_only=True)
    for lean, state, n, cut in con.execute(
        "select t.lean_east, e.state, t.n_slices, count(s.slice_index) from tilt t join epochs e using (structure, epoch) "
        "left join slices s using (structure, epoch, scheme, method) group by all"
    ).fetchall():
        assert n == cut, (n, cut)
        assert state == f"lean {lean}", (lean, state)
        seen.add(state)
    con.close()
print(len(seen))
"""


@pytest.fixture(scope="module")
def empty(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """A catalog without rows, for tests that only read it."""
    ws = open_workspace(tmp_path_factory.mktemp("empty"))
    rebuild_catalog(ws)
    return ws


def count(ws: Workspace, view: str) -> int:
    with read_catalog(ws) as connection:
        row = connection.execute(f"SELECT count(*) FROM {view}").fetchone()  # noqa: S608
    assert row is not None
    return int(row[0])


@every_view
def test_an_empty_catalog_has_every_view_with_its_types(empty: Workspace, view: str) -> None:
    with duckdb.connect(str(empty.catalog), read_only=True) as connection:
        found = [row[:2] for row in connection.execute(f"DESCRIBE {view}").fetchall()]
    assert found == [
        (field.name, DUCKDB_TYPES.get(field.python_type, DUCKDB_TYPES["datetime"]))
        for field in columns_of(VIEWS[view])
    ]


@every_view
def test_the_first_line_of_a_view_says_what_a_row_is(view: str) -> None:
    definition = view_definition(view)
    assert definition.sql.startswith(f"-- {definition.row_is}\n")
    assert len(definition.row_is) > 20


def test_no_view_lies_about_that_is_not_in_the_catalog() -> None:
    stored = Path(sys.modules["storage.views"].__file__ or "").parent.glob("*.sql")
    assert {path.stem for path in stored} == set(VIEWS)


@pytest.mark.parametrize("files_a_batch", [1, 2, 3, 64])
def test_the_catalog_holds_the_rows_of_the_tables(
    ws: Workspace, monkeypatch: pytest.MonkeyPatch, files_a_batch: int
) -> None:
    monkeypatch.setattr("storage.catalog_content.FILES_A_BATCH", files_a_batch)
    fill(ws, 3)
    assert rebuild_catalog(ws)
    counts = {view: count(ws, view) for view in VIEWS}
    assert counts == {
        "epochs": 3,
        "stations": 6,
        "pairs": 3,
        "removals": 3,
        "coverage": 6,
        "surface_map": 6,
        "slices": 3 * N_SLICES,
        "tilt": 3,
        "schemes": 3,
        "accuracy": 3,
        "reference_leans": 3,
        "scheme_comparison": 3,
        "axis_parameters": 12,
        "axis_covariances": 30,
        "verdicts": 3,
        "change_tests": 0,
        "trends": 0,
        "control_chart": 0,
        "alarm_events": 0,
        "alarms": 0,
        "runs": 3,
        "changes": 2,
        "surface_changes": 4,
        "latest": 1,
        "versions": 0,
        "version_tilt": 0,
        "version_changes": 0,
    }


def test_nothing_is_built_when_nothing_changed(ws: Workspace) -> None:
    fill(ws)
    assert rebuild_catalog(ws)
    inode = ws.catalog.stat().st_ino
    assert not rebuild_catalog(ws)
    assert ws.catalog.stat().st_ino == inode


@pytest.mark.parametrize("change", ["publish", "republish", "remove"])
def test_each_change_of_the_tables_reaches_the_catalog(ws: Workspace, change: str) -> None:
    fill(ws, 2)
    rebuild_catalog(ws)
    if change == "publish":
        publish_epoch(ws, STRUCTURE, "e2", epoch_tables("e2", 2))
    elif change == "republish":
        publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1, (0.009, 0.0)))
    else:
        remove_epoch(ws, STRUCTURE, "e0")
    assert rebuild_catalog(ws)
    leans = {row.epoch: row.lean_east for row in tilt_rows(ws, STRUCTURE)}
    assert (
        leans
        == {
            "publish": {"e0": 0.007, "e1": 0.0071, "e2": 0.007},
            "republish": {"e0": 0.007, "e1": 0.009},
            "remove": {"e1": 0.0071},
        }[change]
    )


def test_a_damaged_catalog_is_built_again(ws: Workspace) -> None:
    fill(ws)
    ws.catalog.write_bytes(b"no database")
    assert rebuild_catalog(ws)
    assert count(ws, "tilt") == 2


def test_a_publication_cut_short_is_finished_before_the_catalog_is_built(ws: Workspace) -> None:
    class PowerCut(Exception):  # noqa: N818
        pass

    def stop(step: str) -> None:
        if step.startswith("rename"):
            raise PowerCut

    with pytest.raises(PowerCut):
        publish_epoch(ws, STRUCTURE, "e0", epoch_tables("e0"), after_step=stop)
    rebuild_catalog(ws)
    assert [count(ws, table) for table in EPOCH_TABLES] == [
        1,
        2,
        1,
        1,
        2,
        2,
        N_SLICES,
        1,
        1,
        1,
        1,
        1,
        4,
        10,
        1,
    ]


def test_an_epoch_with_a_damaged_table_is_shown_as_the_old_catalog_knew_it_and_others_go_on(
    ws: Workspace,
) -> None:
    fill(ws)
    rebuild_catalog(ws)
    (damaged,) = ws.tables.glob("tilt/*/e1.parquet")
    damaged.write_bytes(b"PAR1")
    publish_epoch(ws, STRUCTURE, "e2", epoch_tables("e2", 2))
    assert rebuild_catalog(ws)
    assert count(ws, "tilt") == 3
    (why,) = files_left_out(ws).values()
    assert why is not None and "e1.parquet is damaged" in why
    assert list(ws.tmp.iterdir()) == []


def test_an_epoch_with_a_damaged_table_that_no_catalog_knows_is_left_out_whole(ws: Workspace) -> None:
    fill(ws)
    next(ws.tables.glob("tilt/*/e1.parquet")).write_bytes(b"PAR1")
    rebuild_catalog(ws)
    assert [count(ws, table) for table in ("tilt", "epochs", "pairs")] == [1, 1, 1]
    assert len(files_left_out(ws)) == len(EPOCH_TABLES)


def test_a_copy_elsewhere_under_another_name_still_answers(ws: Workspace, tmp_path: Path) -> None:
    fill(ws)
    rebuild_catalog(ws)
    copy = tmp_path / "elsewhere.db"
    shutil.copy(ws.catalog, copy)
    shutil.rmtree(ws.root)
    with duckdb.connect(str(copy), read_only=True) as connection:
        assert connection.execute("SELECT count(*) FROM changes").fetchone() == (1,)
    with duckdb.connect() as connection:
        connection.execute(f"ATTACH '{copy}' AS other (READ_ONLY)")
        assert connection.execute("SELECT count(*) FROM other.changes").fetchone() == (1,)


def test_the_file_is_of_a_version_that_older_clients_read(ws: Workspace) -> None:
    """The number after the mark DUCK: 64 is v1.0.0's, 999 that of DuckDB 2's own files."""
    rebuild_catalog(ws)
    head = ws.catalog.read_bytes()[:20]
    assert head[8:12] == b"DUCK"
    assert int.from_bytes(head[12:20], "little") == 64


def test_views_and_columns_carry_their_meaning(ws: Workspace) -> None:
    rebuild_catalog(ws)
    with duckdb.connect(str(ws.catalog), read_only=True) as connection:
        views = dict(
            connection.execute("SELECT view_name, comment FROM duckdb_views() WHERE NOT internal").fetchall()
        )
        columns = dict(
            connection.execute(
                "SELECT column_name, comment FROM duckdb_columns() WHERE schema_name = 'main' AND table_name = 'tilt'"
            ).fetchall()
        )
    assert views["tilt"].startswith("a row is the axis of an epoch")
    assert columns["deviation_m"].endswith("[m]")
    assert columns["verdict"] == "pass, fail, cannot tell or no limit"


def test_the_data_dictionary_has_each_column_once(ws: Workspace) -> None:
    rebuild_catalog(ws)
    with duckdb.connect(str(ws.catalog), read_only=True) as connection:
        found = connection.execute("FROM data_dictionary").fetchall()
    assert found == [
        (view, field.name, field.unit, field.meaning, field.nullable)
        for view, record in VIEWS.items()
        for field in columns_of(record)
    ]


def test_an_open_reader_keeps_its_rows_and_the_next_in_the_same_process_sees_the_new(ws: Workspace) -> None:
    fill(ws, 1)
    rebuild_catalog(ws)
    with read_catalog(ws) as old:
        publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1))
        rebuild_catalog(ws)
        assert old.execute("SELECT count(*) FROM tilt").fetchone() == (1,)
        with read_catalog(ws) as new:
            assert new.execute("SELECT count(*) FROM tilt").fetchone() == (2,)


def test_the_reader_cannot_write(ws: Workspace) -> None:
    rebuild_catalog(ws)
    with read_catalog(ws) as connection, pytest.raises(duckdb.Error, match="read-only"):
        connection.execute("DELETE FROM data.tilt")


def test_readers_of_another_process_never_fail_and_never_see_half_an_epoch(ws: Workspace) -> None:
    def publish(number: int) -> None:
        lean = 0.007 + 1e-5 * number
        tables = epoch_tables("e0", 0, (lean, 0.0), state=f"lean {lean}")
        tables["slices"] = tables["slices"][: 1 + number % N_SLICES]
        tables["tilt"] = [
            type(row)(**{**_fields(row), "n_slices": 1 + number % N_SLICES}) for row in tables["tilt"]
        ]
        publish_epoch(ws, STRUCTURE, "e0", tables)
        rebuild_catalog(ws)

    publish(0)
    readers = [
        subprocess.Popen(
            [sys.executable, "-c", READER, str(ws.catalog), "2"], stdout=subprocess.PIPE, text=True
        )
        for _ in range(2)
    ]
    for reader in readers:
        assert reader.stdout is not None
        assert reader.stdout.readline() == "ready\n"
    number = 1
    while any(reader.poll() is None for reader in readers):
        publish(number)
        number += 1
    answers = [reader.communicate()[0] for reader in readers]
    assert [reader.returncode for reader in readers] == [0, 0]
    assert all(int(answer) > 1 for answer in answers), "the readers must have seen several states"


def _fields(row: object) -> dict[str, object]:
    return {field.name: getattr(row, field.name) for field in columns_of(type(row))}


def test_an_absent_catalog_is_answered_with_what_to_do(ws: Workspace) -> None:
    with pytest.raises(StorageError, match=r"no catalog at .*tiltwatch run FILE"):
        latest_epochs(ws)


def test_a_file_that_is_no_catalog_is_answered_with_what_to_do(ws: Workspace) -> None:
    ws.catalog.write_bytes(b"x" * 20_000)
    with pytest.raises(StorageError, match=r"cannot open .*delete it and run again"):
        latest_epochs(ws)


def test_a_write_ahead_log_of_a_stranger_is_not_replayed_into_the_new_catalog(ws: Workspace) -> None:
    ws.catalog.with_name("catalog.duckdb.wal").write_bytes(b"of another file")
    rebuild_catalog(ws)
    assert count(ws, "tilt") == 0


@needs_shared
def test_the_workspace_keeps_the_contract(ws: Workspace) -> None:
    fill(ws, 3)
    rebuild_catalog(ws)
    checked = subprocess.run(
        [sys.executable, str(SHARED / "tools" / "check_workspace.py"), str(ws.root)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert checked.stdout.startswith("contract kept"), checked.stdout + checked.stderr


def test_every_table_has_a_view() -> None:
    assert set(TABLES) <= set(VIEWS)
