"""What an archived epoch says of itself: versions/<structure>/<version>/<epoch>/manifest.json."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Final

from storage.errors import StorageError
from storage.version import VersionRow

MANIFEST: Final = "manifest.json"


@dataclass(frozen=True, slots=True)
class Manifest:
    """Where an archived epoch comes from, and the SHA-256 of its files by table."""

    row: VersionRow
    files: Mapping[str, str]

    def to_json(self) -> bytes:
        """The manifest as it is stored."""
        row = {**asdict(self.row), "archived_at": self.row.archived_at.isoformat()}
        return json.dumps({**row, "files": dict(self.files)}, indent=1).encode() + b"\n"


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest of an archived epoch.

    Raises
    ------
    StorageError
        If it is absent or damaged, or of another epoch than its folder says.
    """
    path = folder / MANIFEST
    try:
        content = path.read_bytes()
    except OSError as fault:
        raise _damaged(path) from fault
    return manifest_in(content, path)


def manifest_in(content: bytes, path: Path) -> Manifest:
    """Make out the manifest that a content is, where it is to lie at a path.

    Raises
    ------
    StorageError
        If it is damaged, or of another epoch than its folder says.
    """
    try:
        said = json.loads(content)
        files = {str(table): str(digest) for table, digest in said.pop("files").items()}
        row = VersionRow(**{**said, "archived_at": datetime.fromisoformat(said["archived_at"])})
    except (ValueError, KeyError, TypeError, AttributeError) as fault:
        raise _damaged(path) from fault
    folder = path.parent
    named = (folder.parent.parent.name, folder.parent.name, folder.name)
    if (row.structure, row.version, row.epoch) != named:
        raise StorageError(
            f"{path} is of {row.structure}/{row.version}/{row.epoch}, its folder of {'/'.join(named)}; put it back"
        )
    return Manifest(row, files)


def _damaged(path: Path) -> StorageError:
    return StorageError(
        f"{path} is absent or damaged; restore it from a backup, or move {path.parent} out of the workspace"
    )
