"""Pages that were filled a moment ago: visitors who come together see one reading of the catalog."""

import time
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from threading import Lock
from typing import Final, TypeAlias

from dash.development.base_component import Component

from dashboard.address import Address
from dashboard.page import pages
from dashboard.reader import Reader
from dashboard.shell import message_frame, page_frame
from dashboard.view import Site, open_view
from storage.errors import UsageError
from storage.views import one_catalog

Content: TypeAlias = Sequence[Component]
Key: TypeAlias = tuple[str, str | None]

KEPT_S: Final = 60.0
"""A page also says how long ago something was; that may be so old."""

MOST_KEPT: Final = 64


class FilledPages:
    """Fills pages, and keeps them for a minute as long as the catalog is the same; safe for several threads."""

    def __init__(
        self, reader: Reader, sites: Mapping[str, Site], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._reader, self._sites, self._clock = reader, sites, clock
        self._lock = Lock()
        self._kept: OrderedDict[Key, tuple[float, Content]] = OrderedDict()
        self._locks: dict[Key, Lock] = {}

    def at(self, address: Address) -> Content:
        """Return the page of an address.

        Raises
        ------
        UsageError
            If the address names something that is not there.
        StorageError
            If the catalog cannot be read.
        """
        key = (address.href, self._reader.stamp)
        with self._filling(key):
            kept = self._kept_at(key)
            if kept is not None:
                return kept
            content = self._whole(address)
            if self._reader.stamp != key[1]:
                # a catalog came while the page was read: its parts are to be of one. Once, for runs can be quick
                key = (address.href, self._reader.stamp)
                content = self._whole(address)
            self._keep(key, content)
            return content

    @contextmanager
    def _filling(self, key: Key) -> Iterator[None]:
        """Have one thread fill a page while the others that want it wait."""
        with self._lock:
            lock = self._locks.setdefault(key, Lock())
        try:
            with lock:
                yield
        finally:
            with self._lock:
                self._locks.pop(key, None)

    def _kept_at(self, key: Key) -> Content | None:
        with self._lock:
            filled_at, content = self._kept.get(key, (0.0, None))
        return content if content is not None and self._clock() - filled_at < KEPT_S else None

    def _keep(self, key: Key, content: Content) -> None:
        with self._lock:
            self._kept[key] = (self._clock(), content)
            self._kept.move_to_end(key)
            while len(self._kept) > MOST_KEPT:
                self._kept.popitem(last=False)

    def _whole(self, address: Address) -> Content:
        """Fill a page from one catalog; there is none before the first run."""
        if self._reader.stamp is None:
            return self._filled(address)
        with one_catalog(self._reader.workspace):
            return self._filled(address)

    def _filled(self, address: Address) -> Content:
        page = pages().get(address.page)
        if page is None:
            raise UsageError(f"unknown page {address.page!r}; known: {', '.join(pages())}")
        view = open_view(self._reader, address, self._sites)
        if view is None:
            return message_frame(
                "Nothing is processed yet",
                "The workspace holds no epoch. `tiltwatch run FILE` processes the campaign; this page follows by itself.",
            )
        return page_frame(view, page, page.fill(view))
