"""Pages that visitors share."""

import pytest

from dashboard.address import Address
from dashboard.filled import KEPT_S, MOST_KEPT, FilledPages
from dashboard.reader import Reader
from storage.catalog import rebuild_catalog
from storage.errors import UsageError
from storage.publish import publish_epoch
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables


def test_visitors_who_come_together_get_one_page_until_it_is_old_or_the_catalog_new(
    reader: Reader, ws: Workspace
) -> None:
    now = [0.0]
    filled = FilledPages(reader, {}, lambda: now[0])
    first = filled.at(Address())
    assert filled.at(Address()) is first
    assert filled.at(Address(epoch="e0")) is not first
    now[0] = KEPT_S + 1.0
    second = filled.at(Address())
    assert second is not first
    publish_epoch(ws, STRUCTURE, "e2", epoch_tables("e2", 2))
    rebuild_catalog(ws)
    assert filled.at(Address()) is not second


def test_no_more_pages_are_kept_than_allowed(reader: Reader) -> None:
    filled = FilledPages(reader, {})
    for number in range(MOST_KEPT + 5):
        filled.at(Address(more={"x": str(number)}))
    assert len(filled._kept) == MOST_KEPT


def test_a_page_that_is_not_there_is_no_page(reader: Reader) -> None:
    with pytest.raises(UsageError, match="unknown page 'x'"):
        FilledPages(reader, {}).at(Address("x"))
