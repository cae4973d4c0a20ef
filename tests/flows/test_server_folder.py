"""A damaged history of flow runs is set aside before a server starts on it, and one that is whole is left alone."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from flows.server_folder import DATABASE, make_fit
from storage.sqlite_damage import damage_of
from storage.verify import verify_workspace
from storage.workspace import open_workspace
from tests.faults.damages import empty, to_folder, truncate


@pytest.fixture
def database(tmp_path: Path) -> Path:
    path = tmp_path / DATABASE
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("PRAGMA journal_mode = wal")
        connection.execute("CREATE TABLE runs (name TEXT PRIMARY KEY, note TEXT)")
        connection.executemany("INSERT INTO runs VALUES (?, ?)", [(str(n), "n" * 200) for n in range(500)])
    return path


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def overwrite_head(path: Path) -> None:
    with path.open("r+b") as file:
        file.write(b"x" * 100)


def overwrite_pages(path: Path) -> None:
    with path.open("r+b") as file:
        file.seek(4096)
        file.write(b"\xff" * 8192)


@pytest.mark.parametrize(
    "damage",
    [overwrite_head, overwrite_pages, lambda path: truncate(path, None), lambda path: to_folder(path, None)],
)
def test_a_damaged_history_is_set_aside_and_told(
    database: Path, damage: Callable[[Path], None], capsys: pytest.CaptureFixture[str]
) -> None:
    damage(database)
    (database.parent / f"{DATABASE}-wal").write_bytes(b"of the damaged one")
    make_fit(database.parent)
    assert not {DATABASE, f"{DATABASE}-wal"} & set(names(database.parent))
    assert any(name.startswith(f"{DATABASE}.") and name.endswith(".bad") for name in names(database.parent))
    assert "no result rests on it" in capsys.readouterr().err


@pytest.mark.parametrize(
    "leave", [lambda _path: None, lambda path: empty(path, None)], ids=["whole", "empty"]
)
def test_a_history_that_a_server_can_use_stays(
    database: Path, leave: Callable[[Path], None], capsys: pytest.CaptureFixture[str]
) -> None:
    leave(database)
    make_fit(database.parent)
    assert database.is_file() and not [name for name in names(database.parent) if name.endswith(".bad")]
    assert not capsys.readouterr().err


def test_what_a_program_wrote_against_its_own_rules_is_no_damage(database: Path) -> None:
    with closing(sqlite3.connect(database)) as connection, connection:
        connection.execute("CREATE TABLE strict (n INTEGER, m INTEGER)")
        connection.execute("INSERT INTO strict VALUES (NULL, 1)")
        connection.execute("PRAGMA writable_schema = on")
        connection.execute(
            "UPDATE sqlite_master SET sql = 'CREATE TABLE strict (n INTEGER NOT NULL, m INTEGER)' WHERE name = 'strict'"
        )
    assert damage_of(database) is None
    with closing(sqlite3.connect(database)) as connection:
        assert connection.execute("PRAGMA quick_check").fetchall() == [("NULL value in strict.n",)]


def test_a_history_in_use_is_not_taken_for_damaged(database: Path) -> None:
    with closing(sqlite3.connect(database, isolation_level=None)) as user:
        user.execute("PRAGMA locking_mode = exclusive")
        user.execute("BEGIN EXCLUSIVE")
        user.execute("DELETE FROM runs")
        make_fit(database.parent)
        user.execute("ROLLBACK")
    assert database.is_file()


def test_verify_notes_a_damaged_history_and_no_whole_one(tmp_path: Path, database: Path) -> None:
    ws = open_workspace(tmp_path / "ws")
    (ws.prefect / "home").mkdir()
    place = ws.prefect / "home" / DATABASE
    place.write_bytes(database.read_bytes())
    assert verify_workspace(ws).notes == ()
    overwrite_pages(place)
    (note,) = verify_workspace(ws).notes
    assert note.where == f"prefect/home/{DATABASE}"
