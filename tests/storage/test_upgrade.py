"""Workspaces of earlier versions, as those wrote them, open in this one: nothing is lost, nothing is made up."""

import shutil
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from storage.catalog_reading import read_catalog
from storage.catalog_sources import catalog_definitions
from storage.errors import StorageError
from storage.identity import SCHEMA_VERSION, read_identity, write_identity
from storage.upgrade import make_ready, ready_or_new_workspace, ready_workspace
from storage.verify import verify_workspace_deeply
from storage.view_definitions import VIEWS
from storage.views import tilt_rows
from storage.workspace import Workspace
from tests.storage.campaign import fill
from tests.storage.stored_workspaces import FIRST, LAST, unpacked

STRUCTURE = "demo-chimney"


def digests(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*.parquet")}


@pytest.mark.parametrize("name", [FIRST, LAST])
def test_an_old_workspace_opens_upgraded_with_every_stored_value(name: str, tmp_path: Path) -> None:
    place = unpacked(name, tmp_path)
    before = digests(place / "tables")
    stored = pq.read_table(place / "tables/tilt" / STRUCTURE / "2025-04.parquet").to_pylist()
    ws = ready_workspace(place)
    assert read_identity(ws.identity).schema_version == SCHEMA_VERSION
    assert before.items() <= digests(ws.tables).items()
    shown = {(row.scheme, row.method): row for row in tilt_rows(ws, STRUCTURE) if row.epoch == "2025-04"}
    assert len(shown) == len(stored)
    for row in stored:
        same = shown[row["scheme"], row["method"]]
        assert (same.lean_east, same.lean_north, same.lean_cov_ee) == (
            row["lean_east"],
            row["lean_north"],
            row["lean_cov_ee"],
        )
    with read_catalog(ws) as connection:
        for view in VIEWS:
            connection.execute(f"SELECT * FROM main.{view}").fetchall()  # noqa: S608 (names of our own)


@pytest.mark.parametrize("name", [FIRST, LAST])
def test_an_upgraded_workspace_is_whole_and_upgraded_once(name: str, tmp_path: Path) -> None:
    ws = ready_workspace(unpacked(name, tmp_path))
    assert verify_workspace_deeply(ws).faults == ()
    assert not make_ready(ws)


def test_tables_that_the_old_code_did_not_know_are_there_and_empty(tmp_path: Path) -> None:
    place = unpacked(FIRST, tmp_path)
    assert not (place / "tables/pairs").exists()
    ws = ready_workspace(place)
    assert pq.read_table(ws.tables / "pairs" / STRUCTURE / "2025-01.parquet").num_rows == 0
    with read_catalog(ws) as connection:
        assert connection.execute("SELECT count(*) FROM main.pairs").fetchone() == (0,)


def test_a_table_that_was_lost_is_not_taken_for_one_that_was_unknown(tmp_path: Path) -> None:
    place = unpacked(LAST, tmp_path)
    (place / "tables/slices" / STRUCTURE / "2025-01.parquet").unlink()
    ws = ready_workspace(place)
    (fault,) = verify_workspace_deeply(ws).faults
    assert f"tables/slices/{STRUCTURE}/2025-01.parquet" in fault.what


def test_an_upgrade_that_was_cut_short_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = unpacked(FIRST, tmp_path)

    def fail(_ws: Workspace) -> bool:
        raise StorageError("no space left on device")

    with monkeypatch.context() as broken:
        broken.setattr("storage.upgrade.rebuild_catalog", fail)
        with pytest.raises(StorageError, match=r"another version of tiltwatch.*no space left"):
            ready_workspace(place)
    assert make_ready(Workspace(place))
    assert not make_ready(Workspace(place))


def test_a_catalog_with_the_views_of_another_version_is_made_anew(ws: Workspace) -> None:
    fill(ws, 2)
    assert make_ready(ws)
    write_identity(ws.identity, replace(read_identity(ws.identity), catalog="views of yesterday"))
    assert make_ready(ws)
    assert read_identity(ws.identity).catalog == catalog_definitions()


def test_a_catalog_that_was_deleted_is_back_on_opening(ws: Workspace) -> None:
    fill(ws, 1)
    make_ready(ws)
    ws.catalog.unlink()
    ready_workspace(ws.root)
    with read_catalog(ws) as connection:
        assert connection.execute("SELECT count(*) FROM main.epochs").fetchone() == (1,)


def test_a_new_workspace_needs_no_upgrade(tmp_path: Path) -> None:
    ws = ready_or_new_workspace(tmp_path / "new")
    assert not make_ready(ws)
    assert not ws.catalog.exists()
    shutil.rmtree(ws.root)
