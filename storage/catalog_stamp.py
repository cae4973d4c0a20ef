"""Whether there is a newer catalog than the one that was read."""

from pathlib import Path


def stamp_of_file(catalog: Path) -> str | None:
    """Say what tells the present file from any other one; None where there is none yet.

    A catalog is replaced as a whole, so its inode, size and time of change do so.
    """
    try:
        status = catalog.stat()
    except FileNotFoundError:
        return None
    return f"{status.st_ino}-{status.st_size}-{status.st_mtime_ns}"
