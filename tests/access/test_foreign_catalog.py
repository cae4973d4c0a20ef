"""A catalog from others cannot make us read our own files, load code or reach a network."""
# ruff: noqa: S608 (the statements are the traps)

from collections.abc import Iterator
from pathlib import Path

import duckdb
import pytest

from storage.catalog import rebuild_catalog
from storage.catalog_reading import read_catalog
from storage.errors import StorageError
from storage.export import export_view
from storage.publish import publish_epoch
from storage.verify import verify_workspace
from storage.views import epoch_rows, follow_catalog, leave_catalog
from storage.workspace import Workspace, open_workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, fill

CANARY = "canary-of-a-private-file"


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    """A file of the reader's, outside of the workspace."""
    file = tmp_path / "private.csv"
    file.write_text(f"structure\n{CANARY}\n")
    return file


@pytest.fixture
def foreign(tmp_path: Path) -> Workspace:
    ws = open_workspace(tmp_path / "ws")
    fill(ws)
    rebuild_catalog(ws)
    return ws


def spoil(ws: Workspace, name: str, definition: str) -> None:
    """Put another view in the place of one of the contract's: same columns, and what its author likes."""
    with duckdb.connect(str(ws.catalog)) as connection:
        columns = [row[0] for row in connection.execute(f"DESCRIBE main.{name}").fetchall()]
        others = ", ".join(f"s.{column}" for column in columns if column != "structure")
        connection.execute(f"CREATE TABLE data.stolen_from AS SELECT * FROM main.{name}")
        connection.execute(f"DROP VIEW main.{name}")
        connection.execute(
            f"CREATE VIEW main.{name} AS SELECT f.structure AS structure, {others} "
            f"FROM ({definition}) AS f, data.stolen_from AS s"
        )


@pytest.fixture(params=["read_csv('{}')", "read_text('{}')", "read_blob('{}')", "glob('{}')"])
def view(request: pytest.FixtureRequest, secret: Path) -> str:
    column = {"read_csv": "structure", "glob": "file"}.get(request.param.split("(")[0], "content")
    return f"SELECT {column}::VARCHAR AS structure FROM {request.param.format(secret)}"


def test_the_trap_works_for_who_opens_the_file_without_care(
    foreign: Workspace, secret: Path, view: str
) -> None:
    spoil(foreign, "epochs", view)
    with duckdb.connect(str(foreign.catalog), read_only=True) as careless:
        assert careless.execute("SELECT structure FROM main.epochs").fetchall()


def test_a_view_that_reads_a_file_of_ours_is_refused(foreign: Workspace, view: str) -> None:
    spoil(foreign, "epochs", view)
    with pytest.raises(StorageError, match="disabled by configuration"):
        epoch_rows(foreign, STRUCTURE)
    with pytest.raises(StorageError, match="disabled by configuration"):
        export_view(foreign, "epochs", "csv", foreign.root / "out.csv")
    assert not (foreign.root / "out.csv").exists()


@pytest.fixture
def followed(foreign: Workspace) -> Iterator[Workspace]:
    follow_catalog(foreign)
    yield foreign
    leave_catalog(foreign)


def test_the_dashboards_open_catalog_is_as_careful(followed: Workspace, secret: Path) -> None:
    spoil(followed, "epochs", f"SELECT structure FROM read_csv('{secret}')")
    with pytest.raises(StorageError, match="disabled by configuration"):
        epoch_rows(followed, STRUCTURE)


def test_what_is_shut_cannot_be_opened_again(foreign: Workspace) -> None:
    with read_catalog(foreign) as connection:
        for words in ("SET enable_external_access = true", "INSTALL httpfs", "LOAD httpfs"):
            with pytest.raises(duckdb.Error):
                connection.execute(words)
        for words in ("ATTACH ':memory:' AS more", f"ATTACH '{foreign.root / 'x.duckdb'}' AS x"):
            with pytest.raises(duckdb.Error):
                connection.execute(f"{words}; SELECT * FROM glob('/*')")


def test_a_variable_of_the_program_is_no_table(foreign: Workspace) -> None:
    duck_bait = duckdb.sql("SELECT 1 AS a").to_arrow_table()
    assert duck_bait.num_rows == 1
    with read_catalog(foreign) as connection, pytest.raises(duckdb.Error, match="duck_bait"):
        connection.execute("SELECT * FROM duck_bait")


def test_a_table_that_became_a_view_is_not_taken_into_the_next_catalog(
    foreign: Workspace, secret: Path
) -> None:
    with duckdb.connect(str(foreign.catalog)) as connection:
        columns = [row[0] for row in connection.execute("DESCRIBE data.stations").fetchall()]
        others = ", ".join(f"s.{column}" for column in columns if column != "structure")
        connection.execute("CREATE TABLE data.kept AS SELECT * FROM data.stations")
        connection.execute("DROP TABLE data.stations CASCADE")
        connection.execute(
            f"CREATE VIEW data.stations AS SELECT f.structure, {others} FROM read_csv('{secret}') f, data.kept s"
        )
    publish_epoch(foreign, STRUCTURE, "e7", epoch_tables("e7", 7))
    rebuild_catalog(foreign)
    with read_catalog(foreign) as connection:
        found = connection.execute("SELECT DISTINCT structure FROM main.stations").fetchall()
    assert found == [(STRUCTURE,)]
    assert CANARY.encode() not in foreign.catalog.read_bytes()


def test_a_spoiled_catalog_is_found_and_made_anew(foreign: Workspace, secret: Path) -> None:
    spoil(foreign, "epochs", f"SELECT structure FROM read_csv('{secret}')")
    assert any("catalog" in fault.where for fault in verify_workspace(foreign).faults)
    foreign.catalog.unlink()
    rebuild_catalog(foreign)
    assert epoch_rows(foreign, STRUCTURE)
