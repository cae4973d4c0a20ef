"""Which names uploads may have: the client proposes, we decide; a name never is a path."""

from pathlib import PurePosixPath

from flows.watch.file_kinds import MARKER
from storage.errors import InputError
from storage.ids import check_id
from tasks.arrivals import SCAN_SUFFIXES
from tasks.settings.sidecar import SUFFIX


def upload_name(proposed: str | None) -> str:
    """Return the name under which an upload goes into the inbox.

    Raises
    ------
    InputError
        If it is missing, is a path, is not an id before its suffix, or has a suffix that no scan, sidecar or marker has.
    """
    if not proposed:
        raise InputError("needs the metadata key filename")
    name = PurePosixPath(proposed)
    known = {*SCAN_SUFFIXES, SUFFIX, MARKER}
    suffix = name.suffix.lower()
    if name.name != proposed or suffix not in known:
        raise InputError(
            f"filename needs a plain name that ends in one of {', '.join(sorted(known))}; got {proposed!r}"
        )
    return f"{check_id(proposed[: -len(suffix)], 'an upload')}{suffix}"
