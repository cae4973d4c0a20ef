"""The catalog of a long run: people see its epochs before it ends."""

import time
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from storage.catalog import rebuild_catalog
from storage.errors import StorageError
from storage.workspace import Workspace

CATALOG_EVERY_S: Final = 20.0
"""In a long run the catalog follows the epochs about this often; at the end it always does."""

CATALOG_SHARE: Final = 0.05
"""It takes no larger share of the time than this: one that grew large follows less often."""


@dataclass(slots=True)
class CatalogFollower:
    """Rebuilds the catalog now and then while epochs are published."""

    workspace: Workspace
    built_at: float = 0.0
    took_s: float = 0.0

    def follow(self) -> None:
        """Rebuild it if it is time; where it cannot be swapped just now, the end of the run tells."""
        began = time.monotonic()
        if began - self.built_at > max(CATALOG_EVERY_S, self.took_s / CATALOG_SHARE):
            # on Windows a reader may hold the old one open: no reason to stop the epochs that are left
            with suppress(StorageError):
                rebuild_catalog(self.workspace)
            self.built_at = time.monotonic()
            self.took_s = self.built_at - began
