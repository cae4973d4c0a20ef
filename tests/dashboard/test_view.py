"""An address is filled in from what the catalog holds."""

import pytest

from dashboard.address import Address
from dashboard.reader import Reader
from dashboard.view import Site, open_view
from storage.errors import UsageError
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE

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
