"""``workspace.json``: says that a folder is a workspace, of which version, and which views its catalog was made with.

It is kept twice: ``second/workspace.json`` lies behind its SHA-256, is written first, and so is right where the two differ.
"""

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final

from storage.atomic import write_our_own
from storage.errors import StorageError
from storage.sealed import sealed, unsealed

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


def is_identified(path: Path) -> bool:
    """Whether a folder says of itself that it is a workspace: the file is there, or a second copy that is whole."""
    return path.is_file() or _second(path) is not None


def read_identity(path: Path) -> Identity:
    """Read the identity of a workspace; a second copy that is whole is believed.

    Raises
    ------
    StorageError
        If it is absent or damaged, and so is its second copy.
    """
    second = _second(path)
    try:
        return identity_in(path.read_bytes() if second is None else second)
    except (OSError, ValueError) as fault:
        raise StorageError(
            f"{path} is damaged: needed is a JSON object with schema_version; restore the file, or "
            f'write {{"schema_version": {SCHEMA_VERSION}}} into it'
        ) from fault


def identity_in(content: bytes) -> Identity:
    """What the content of ``workspace.json`` says.

    Raises
    ------
    ValueError
        If that is no identity.
    """
    try:
        said = json.loads(content)
        catalog = said.get("catalog")
        made_by = str(said.get("made_by", "tiltwatch"))
        return Identity(int(said["schema_version"]), made_by, None if catalog is None else str(catalog))
    except (KeyError, TypeError, AttributeError) as fault:
        raise ValueError(f"no identity of a workspace: {fault}") from fault


def write_identity(path: Path, identity: Identity) -> None:
    """Put the identity of a workspace in place whole, and its second copy before it.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    said = {name: value for name, value in asdict(identity).items() if value is not None}
    content = json.dumps(said, indent=1).encode() + b"\n"
    write_our_own(second_of_identity(path), sealed(content))
    write_our_own(path, content)


def second_of_identity(path: Path) -> Path:
    """Where the second copy lies or would lie."""
    return path.parent / "second" / path.name


def _second(path: Path) -> bytes | None:
    """What the second copy says; None where it is absent, damaged or that of another file: then there is the first."""
    try:
        content = unsealed(second_of_identity(path).read_bytes())
        if content is not None:
            identity_in(content)
    except (OSError, ValueError):
        return None
    return content


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
