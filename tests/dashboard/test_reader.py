"""Answers are remembered as long as the catalog is the same."""

from dashboard.reader import MOST_ANSWERS, Reader
from storage.catalog import rebuild_catalog
from storage.publish import publish_epoch
from storage.views import epoch_rows
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables


def test_an_answer_is_read_once_until_the_catalog_is_replaced(reader: Reader, ws: Workspace) -> None:
    calls = []

    def question(workspace: Workspace, structure: str) -> list[str]:
        calls.append(structure)
        return [row.epoch for row in epoch_rows(workspace, structure)]

    assert reader.ask(question, STRUCTURE) == ["e0", "e1"]
    assert reader.ask(question, STRUCTURE) == ["e0", "e1"]
    assert len(calls) == 1
    publish_epoch(ws, STRUCTURE, "e2", epoch_tables("e2", 2))
    rebuild_catalog(ws)
    assert reader.ask(question, STRUCTURE) == ["e0", "e1", "e2"]
    assert len(calls) == 2


def test_no_more_answers_are_kept_than_allowed(reader: Reader) -> None:
    for number in range(MOST_ANSWERS + 10):
        assert reader.ask(lambda _ws, n: n, number) == number
    assert len(reader._answers) <= MOST_ANSWERS


def test_a_workspace_without_a_catalog_has_no_stamp(ws: Workspace) -> None:
    assert Reader(ws).stamp is None
