"""``workspace.json``: says that a folder is a workspace, of which version, and which views its catalog was made with."""

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final

from storage.atomic import write_atomically
from storage.errors import StorageError

SCHEMA_VERSION: Final = 2
"""Version of the stored tables and of the layout of a workspace; a newer one is refused, an older one is upgraded.

Since 2 every epoch has a file of every table of an epoch, empty where its code did not know the table.
"""


@dataclass(frozen=True, slots=True)
class Identity:
    """What a workspace says of itself."""

    schema_version: int
    made_by: str
    catalog: str | None = None
    """Digest of the views and columns of its catalog; none where there was no catalog yet, or it was made long ago."""


def read_identity(path: Path) -> Identity:
    """Read the identity of a workspace.

    Raises
    ------
    StorageError
        If it is absent or damaged.
    """
    try:
        content = json.loads(path.read_bytes())
        catalog = content.get("catalog")
        made_by = str(content.get("made_by", "tiltwatch"))
        return Identity(int(content["schema_version"]), made_by, None if catalog is None else str(catalog))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as fault:
        raise StorageError(
            f"{path} is damaged: needed is a JSON object with schema_version; restore the file, or "
            f'write {{"schema_version": {SCHEMA_VERSION}}} into it'
        ) from fault


def write_identity(path: Path, identity: Identity) -> None:
    """Put the identity of a workspace in place whole.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    content = {name: value for name, value in asdict(identity).items() if value is not None}
    write_atomically(path, json.dumps(content, indent=1).encode() + b"\n")


def note_catalog(path: Path, definitions: str) -> None:
    """Put down which views and columns the catalog was made with; to be called under the publish lock.

    Raises
    ------
    StorageError
        If the identity is damaged, or the disk refuses.
    """
    identity = read_identity(path)
    if identity.catalog != definitions:
        write_identity(path, replace(identity, catalog=definitions))
