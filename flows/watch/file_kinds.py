"""What a file of an inbox is, by its name."""

from typing import Final

from storage.inbox import InboxFile
from tasks.arrivals import SCAN_SUFFIXES
from tasks.settings.sidecar import SUFFIX

MARKER: Final = ".complete"


def is_scan(file: InboxFile) -> bool:
    """Whether the name is that of a scan."""
    return file.path.suffix.lower() in SCAN_SUFFIXES


def is_sidecar(file: InboxFile) -> bool:
    """Whether the name is that of a sidecar."""
    return file.path.suffix.lower() == SUFFIX


def is_marker(file: InboxFile) -> bool:
    """Whether the name says that no more stations of an epoch come."""
    return file.path.name.endswith(MARKER) and len(file.path.name) > len(MARKER)
