"""A catalog that stays open for a program that reads all day."""

import threading
from collections.abc import Iterator

import pytest

from storage.catalog import rebuild_catalog
from storage.catalog_reading import one_catalog, read_catalog
from storage.publish import publish_epoch
from storage.views import catalog_stamp, epoch_rows, follow_catalog, leave_catalog, tilt_rows
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, fill


@pytest.fixture
def followed(ws: Workspace) -> Iterator[Workspace]:
    """A workspace of two epochs whose catalog is kept open."""
    fill(ws)
    rebuild_catalog(ws)
    follow_catalog(ws)
    yield ws
    leave_catalog(ws)


def _publish(ws: Workspace, number: int) -> None:
    publish_epoch(ws, STRUCTURE, f"e{number}", epoch_tables(f"e{number}", number))
    rebuild_catalog(ws)


def _epochs(ws: Workspace) -> list[str]:
    return [row.epoch for row in epoch_rows(ws, STRUCTURE)]


def test_a_newer_catalog_is_read_as_soon_as_it_is_there(followed: Workspace) -> None:
    before = catalog_stamp(followed)
    assert _epochs(followed) == ["e0", "e1"]
    _publish(followed, 2)
    assert _epochs(followed) == ["e0", "e1", "e2"]
    assert catalog_stamp(followed) != before


def test_who_reads_while_it_is_replaced_reads_on(followed: Workspace) -> None:
    with read_catalog(followed) as before:
        _publish(followed, 2)
        assert _epochs(followed) == ["e0", "e1", "e2"]
        assert before.execute("SELECT count(*) FROM main.epochs").fetchone() == (2,)


@pytest.mark.slow
def test_readers_in_threads_never_fail_while_it_is_replaced(followed: Workspace) -> None:
    over, wrong = threading.Event(), list[BaseException]()

    def read() -> None:
        while not over.is_set():
            try:
                with one_catalog(followed):
                    assert _epochs(followed) == [row.epoch for row in tilt_rows(followed, STRUCTURE)]
            except BaseException as fault:
                wrong.append(fault)
                return

    readers = [threading.Thread(target=read) for _ in range(4)]
    for reader in readers:
        reader.start()
    for number in range(2, 10):
        _publish(followed, number)
    over.set()
    for reader in readers:
        reader.join(30.0)
    assert wrong == []
    assert not any(reader.is_alive() for reader in readers)


@pytest.mark.parametrize("kept", [True, False])
def test_what_belongs_together_is_read_from_one_catalog(ws: Workspace, kept: bool) -> None:
    fill(ws)
    rebuild_catalog(ws)
    if kept:
        follow_catalog(ws)
    with one_catalog(ws):
        tilts = tilt_rows(ws, STRUCTURE)
        _publish(ws, 2)
        assert _epochs(ws) == [row.epoch for row in tilts] == ["e0", "e1"]
    assert _epochs(ws) == ["e0", "e1", "e2"]
    leave_catalog(ws)


def test_another_thread_is_not_held_back(followed: Workspace) -> None:
    found = list[list[str]]()
    with one_catalog(followed):
        _publish(followed, 2)
        other = threading.Thread(target=lambda: found.append(_epochs(followed)))
        other.start()
        other.join(30.0)
    assert found == [["e0", "e1", "e2"]]
