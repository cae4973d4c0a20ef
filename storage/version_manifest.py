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
        content = json.loads(path.read_bytes())
        files = {str(table): str(digest) for table, digest in content.pop("files").items()}
        row = VersionRow(**{**content, "archived_at": datetime.fromisoformat(content["archived_at"])})
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as fault:
        raise StorageError(
            f"{path} is absent or damaged; restore it from a backup, or move {folder} out of the workspace"
        ) from fault
    named = (folder.parent.parent.name, folder.parent.name, folder.name)
    if (row.structure, row.version, row.epoch) != named:
        raise StorageError(
            f"{path} is of {row.structure}/{row.version}/{row.epoch}, its folder of {'/'.join(named)}; put it back"
        )
    return Manifest(row, files)
