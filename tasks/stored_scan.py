"""A scan file on its way into the store: decoded, checked, hashed and written piece by piece."""

import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.artifacts import ArtifactRef
from storage.clouds import StoredCloud, open_cloud, put_cloud
from storage.workspace import Workspace
from tasks.ingest import ScanFacts, ScanRequest, stream_scan

AT_ONCE: Final = 2
"""Scans under way in a process: one is decoded, on all cores and with Python's lock held, while the other is hashed and
written. More would take memory and save no time."""

_TURNS: Final = threading.BoundedSemaphore(AT_ONCE)


@dataclass(frozen=True, slots=True)
class StoredScan:
    """A scan in the store."""

    ref: ArtifactRef
    cloud: StoredCloud
    facts: ScanFacts


def store_scan(workspace: Workspace, path: Path, request: ScanRequest) -> StoredScan:
    """Read a scan of any size into the store, in memory that does not grow with it where the format is LAS or LAZ.

    Of many threads that ask at once, ``AT_ONCE`` work and the others wait.

    Raises
    ------
    InputError
        If the scan is refused; nothing is stored then.
    StorageError
        If the disk refuses.
    """
    facts: list[ScanFacts] = []
    with _TURNS:
        stream = stream_scan(path, request)
        ref = put_cloud(workspace, "scan", stream.pieces(facts.append), stream.grid)
    return StoredScan(ref, open_cloud(workspace, ref), facts[0])
