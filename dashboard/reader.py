"""Rows of the newest catalog, read once as long as it does not change."""

import math
import time
from collections.abc import Callable
from threading import Lock
from typing import Any, Final, TypeAlias, TypeVar

from storage.views import catalog_stamp, follow_catalog
from storage.workspace import Workspace

Answer = TypeVar("Answer")
Key: TypeAlias = tuple[object, ...]

MOST_ANSWERS: Final = 256
"""So many answers are kept; a page needs about ten."""

LOOK_EVERY_S: Final = 2.0
"""A run may replace the catalog more often; pages follow it at this pace."""


class Reader:
    """Asks the views of a workspace and remembers the answers until the catalog is replaced.

    Safe for several threads. A question that two ask at once may be read twice, never wrongly.
    """

    def __init__(
        self,
        workspace: Workspace,
        clock: Callable[[], float] = time.monotonic,
        look_every_s: float = LOOK_EVERY_S,
    ) -> None:
        self.workspace = workspace
        self._clock, self._look_every_s = clock, look_every_s
        self._lock = Lock()
        self._looked_at = -math.inf
        self._seen: str | None = None
        self._stamp: str | None = None
        self._answers: dict[Key, object] = {}
        follow_catalog(workspace)

    @property
    def stamp(self) -> str | None:
        """What tells this catalog from the one before, looked at anew every two seconds; None where there is none."""
        with self._lock:
            now = self._clock()
            if self._seen is None or now - self._looked_at >= self._look_every_s:
                self._seen, self._looked_at = catalog_stamp(self.workspace), now
            return self._seen

    def ask(self, question: Callable[..., Answer], *about: Any) -> Answer:
        """Call a reading of ``storage.views`` with the workspace and what it is about.

        Raises
        ------
        StorageError
            If the catalog cannot be read.
        """
        key: Key = (question, *about)
        stamp = self.stamp
        with self._lock:
            if stamp != self._stamp:
                self._answers.clear()
                self._stamp = stamp
            if key in self._answers:
                return self._answers[key]  # type: ignore[return-value]
        answer = question(self.workspace, *about)
        present = catalog_stamp(self.workspace)
        with self._lock:
            if present != stamp:
                # a catalog that came meanwhile has other answers: look again at once
                self._looked_at = -math.inf
            elif stamp == self._stamp:
                if len(self._answers) >= MOST_ANSWERS:
                    self._answers.pop(next(iter(self._answers)))
                self._answers[key] = answer
        return answer
