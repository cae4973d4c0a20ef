"""Workspaces that earlier versions of tiltwatch wrote, as they wrote them: tests/data/workspaces."""

import tarfile
from pathlib import Path
from typing import Final

FOLDER: Final = Path(__file__).resolve().parents[1] / "data" / "workspaces"

FIRST, LAST = "v1-first", "v1-last"
"""Schema version 1 at its beginning, with nine tables, and at its end; `tiltwatch demo --epochs 2 --stations 4`."""


def unpacked(name: str, folder: Path) -> Path:
    """Unpack a stored workspace; gives its folder, in which the campaign file lies, too."""
    place = folder / name
    with tarfile.open(FOLDER / f"{name}.tar.xz") as tar:
        tar.extractall(place, filter="data")
    return place
