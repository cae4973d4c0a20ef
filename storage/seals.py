"""What an epoch was published with: seals/<structure>/<epoch>.json holds the SHA-256 of each of its tables.

A page of Parquet has a checksum, but a file that was exchanged for another whole one has valid checksums too. The seal is
published together with the tables (``storage.publish``), so that it is always theirs.
"""

import json
from collections.abc import Mapping
from pathlib import Path

from storage.digests import file_sha256
from storage.errors import StorageError
from storage.ids import check_id
from storage.sealed import sealed, unsealed
from storage.tables import EpochKey
from storage.workspace import Workspace


def seal_path(ws: Workspace, key: EpochKey) -> Path:
    """Where the seal of an epoch lies or would lie.

    Raises
    ------
    InputError
        If an id cannot be a file name.
    """
    return ws.seals / check_id(key.structure, "a structure") / f"{check_id(key.epoch, 'an epoch')}.json"


def seal_text(digests: Mapping[str, str]) -> bytes:
    """A seal as it is stored; equal digests give equal bytes."""
    return sealed(json.dumps(dict(digests), indent=1, sort_keys=True).encode() + b"\n")


def read_seal(ws: Workspace, key: EpochKey) -> Mapping[str, str] | None:
    """Table to the SHA-256 with which it was published; None for an epoch of before there were seals.

    Raises
    ------
    StorageError
        If the seal is damaged.
    """
    path = seal_path(ws, key)
    try:
        content = unsealed(path.read_bytes())
        if content is not None:
            return {str(table): str(digest) for table, digest in json.loads(content).items()}
    except FileNotFoundError:
        return None
    except OSError as fault:
        raise StorageError(f"cannot read {path}: {fault.strerror}") from fault
    raise StorageError(f"{path} is damaged; delete it and run the epoch again: it is made anew")


def sealed_epochs(ws: Workspace) -> list[EpochKey]:
    """Every epoch that has a seal."""
    return sorted(
        EpochKey(path.parent.name, path.name.removesuffix(".json")) for path in ws.seals.glob("*/*.json")
    )


def is_as_sealed(ws: Workspace, key: EpochKey, table: str, path: Path) -> bool:
    """Whether a table is what was published, as far as its seal can tell: without a whole one nothing speaks against."""
    try:
        digests = read_seal(ws, key)
    except StorageError:
        return True
    return digests is None or table not in digests or file_sha256(path) == digests[table]
