"""What a run says of the store itself: what it put back before it began, and what it could not make again."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from flows.terminal import complain
from storage.identity import is_identified
from storage.mend import Mended, losses, mend_copies
from storage.presence import held_in_place
from storage.workspace import Workspace, existing_workspace

LOST: Final = 3
"""Exit code of a run that had to leave something behind."""


def mend_before(workspace: Path) -> list[Mended]:
    """Put back what is kept twice, before anything of a workspace is read; tells of it, and gives what is lost.

    A workspace that is not there yet has nothing to mend.

    Raises
    ------
    StorageError
        If it cannot be read or written.
    """
    if not is_identified(Workspace(workspace).identity):
        return []
    place = existing_workspace(workspace)
    with held_in_place(place.root):
        found = mend_copies(place)
    tell(found)
    return [told for told in found if told.is_lost]


def lost_after(workspace: Path) -> list[Mended]:
    """Tell what of the published results is not whole after a run, and give it."""
    place = existing_workspace(workspace)
    with held_in_place(place.root):
        found = losses(place)
    tell(found)
    return found


def tell(found: Iterable[Mended]) -> None:
    """Say it on stderr, one line a file."""
    complain(*(f"{'error' if told.is_lost else 'warning'}: {told.where}: {told.what}" for told in found))


def code_with_losses(code: int, lost: Sequence[Mended]) -> int:
    """Exit code of a run that ended with ``code`` when something is lost: what else it tells, as an alarm, stays."""
    return LOST if lost and code == 0 else code
