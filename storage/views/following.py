"""For programs that read all day: is there a newer catalog, and one that stays open between readings."""

from storage.catalog_stamp import stamp_of_file
from storage.kept_catalog import close_kept, keep_open
from storage.workspace import Workspace


def catalog_stamp(ws: Workspace) -> str | None:
    """Say what tells the present catalog from any other one; None where there is none yet."""
    return stamp_of_file(ws.catalog)


def follow_catalog(ws: Workspace) -> None:
    """Keep the catalog open between readings; a newer one is opened when it comes."""
    keep_open(ws.catalog)


def leave_catalog(ws: Workspace) -> None:
    """Close what ``follow_catalog`` keeps open."""
    close_kept(ws.catalog)
