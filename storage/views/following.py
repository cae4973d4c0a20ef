"""Whether there is a newer catalog than the one that was read."""

from storage.workspace import Workspace


def catalog_stamp(ws: Workspace) -> str | None:
    """Say what tells the present catalog from any other one; None where there is none yet.

    A catalog is replaced as a whole, so its inode, size and time of change do so.
    """
    try:
        status = ws.catalog.stat()
    except FileNotFoundError:
        return None
    return f"{status.st_ino}-{status.st_size}-{status.st_mtime_ns}"
