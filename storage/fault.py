"""What `verify` tells."""

from dataclasses import dataclass
from pathlib import Path

from storage.workspace import Workspace


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that is not as it should be."""

    where: str
    what: str
    what_to_do: str


def at(ws: Workspace, path: Path) -> str:
    """Where a file lies in the workspace."""
    return path.relative_to(ws.root).as_posix()
