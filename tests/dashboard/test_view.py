"""An address is filled in from what the catalog holds."""

from dataclasses import replace

import pytest

from dashboard.address import Address
from dashboard.reader import Reader
from dashboard.view import Site, open_view
from storage.catalog import rebuild_catalog
from storage.errors import UsageError
from storage.publish import publish_epoch
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, scheme_row

SITES = {STRUCTURE: Site("The chimney", ("A", "paper"))}


def test_who_asks_for_nothing_sees_the_newest_epoch_under_the_primary(reader: Reader) -> None:
    view = open_view(reader, Address(), SITES)
    assert view is not None
    assert (view.structure, view.epoch.epoch, view.result) == (STRUCTURE, "e1", ("A", "paper"))
    assert view.reference is not None
    assert view.reference.epoch == "e0"
    assert view.site.name == "The chimney"
    assert view.address == Address("overview", STRUCTURE, "e1", None, "A", "paper")
    assert view.asked == Address()


def test_a_workspace_without_epochs_has_no_view(ws: Workspace) -> None:
    assert open_view(Reader(ws), Address(), SITES) is None


@pytest.mark.parametrize(
    ("address", "message"),
    [
        (Address(structure="nowhere"), "unknown structure 'nowhere'; known: chimney-01"),
        (Address(epoch="e9"), "unknown epoch 'e9'; known: e0, e1"),
        (Address(reference="e9"), "unknown reference epoch 'e9'"),
        (Address(scheme="Z"), "unknown scheme and method Z/...; known: A/paper"),
        (Address(scheme="A", method="best"), "unknown scheme and method A/best"),
    ],
)
def test_what_is_not_there_is_answered_with_what_is(reader: Reader, address: Address, message: str) -> None:
    with pytest.raises(UsageError, match=message.replace(".", r"\.")):
        open_view(reader, address, SITES)


def test_an_earlier_epoch_can_be_the_reference(reader: Reader) -> None:
    view = open_view(reader, Address(epoch="e0", reference="e1"), SITES)
    assert view is not None
    assert view.reference is not None
    assert (view.epoch.epoch, view.reference.epoch) == ("e0", "e1")


def test_a_scheme_that_never_gave_an_axis_can_be_asked_for(reader: Reader, ws: Workspace) -> None:
    tables = epoch_tables("e2", 2)
    tables["schemes"] = [
        *tables["schemes"],
        replace(scheme_row("e2"), scheme="F", state="failed", reason="no points"),
    ]
    publish_epoch(ws, STRUCTURE, "e2", tables)
    rebuild_catalog(ws)
    view = open_view(reader, Address(scheme="F", method="paper"), SITES)
    assert view is not None
    assert (view.result, view.tilt()) == (("F", "paper"), None)
