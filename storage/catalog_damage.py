"""Tables that cannot be read: their epoch is shown as the old catalog knew it, or not at all, and the others as they are."""

from collections.abc import Mapping

from storage.catalog_parts import part_of, read_part
from storage.errors import StorageError
from storage.tables import EPOCH_TABLES
from storage.workspace import Workspace


def why_unreadable(ws: Workspace, name: str) -> str | None:
    """What is wrong with a file of a catalog; None where it can be read."""
    try:
        read_part(part_of(ws, name))
    except StorageError as fault:
        return str(fault)
    return None


def readable_stamps(ws: Workspace, old: Mapping[str, str], new: Mapping[str, str]) -> dict[str, str]:
    """Stamps of files, those of damaged epochs and ledgers replaced by what the old catalog was made of, or left out.

    Parameters
    ----------
    old, new : mapping of file to stamp
        What the old catalog was made of, and what there is now.
    """
    changed = [name for name, stamp in new.items() if old.get(name) != stamp]
    damaged = {_whole(ws, name) for name in changed if why_unreadable(ws, name) is not None}
    sound = {name: stamp for name, stamp in new.items() if _whole(ws, name) not in damaged}
    known = {name: stamp for name, stamp in old.items() if _whole(ws, name) in damaged}
    return {**sound, **known}


def _whole(ws: Workspace, name: str) -> tuple[str, ...]:
    """What a file is shown together with: the tables of its epoch, or nothing."""
    part = part_of(ws, name)
    return part.key if part.table in EPOCH_TABLES else (name,)
