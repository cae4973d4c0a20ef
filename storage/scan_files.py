"""Scan files for stages: read where they lie, or handed to workers on other machines through the store, by digest."""

import re
from pathlib import Path

from storage.artifacts import ArtifactRef
from storage.errors import InputError, StorageError
from storage.places import store_of
from storage.workspace import Workspace

KIND = "scan file"


def offer_scan(ws: Workspace, path: Path, sha256: str) -> None:
    """Put a scan into a store that lies elsewhere; where the store is the workspace's folder, stages read the path.

    Raises
    ------
    StorageError
        If the store cannot be used, or the file changed since it was hashed.
    """
    extension = _extension(path.suffix)
    if ws.store is None or extension is None:
        return
    ref = ArtifactRef(KIND, sha256, path.stat().st_size, extension)
    store_of(ws).put_file(ref.name, path, ref.content)


def scan_at(ws: Workspace, path: Path, sha256: str, suffix: str) -> Path:
    """Give the scan as a file of this machine.

    Raises
    ------
    StorageError
        If this machine does not see it.
    InputError
        If its suffix can belong to no format.
    """
    if ws.store is None:
        if not path.is_file():
            raise StorageError(
                f"{path}: the machine of this worker has no such file; put the scans on a drive that all workers mount at "
                "the same path, or name a store on S3 in [execution]"
            )
        return path
    extension = _extension(suffix)
    if extension is None:
        raise InputError(f"needs a suffix that names a format, came {suffix!r}; export LAZ")
    name = ArtifactRef(KIND, sha256, 0, extension).name
    store = store_of(ws)
    size = store.size(name)
    if size is None:
        raise StorageError(f"no {store.place}/{name}, the scan {path}; run again")
    return store.local_path(name, ArtifactRef(KIND, sha256, size, extension).content)


def _extension(suffix: str) -> str | None:
    """The suffix as a part of a name; None where it is no plain one."""
    plain = suffix.lower().removeprefix(".")
    return plain if re.fullmatch(r"[a-z0-9]{1,16}", plain) else None
