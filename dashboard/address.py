"""What a page shows, as its address: every view can be mailed as a link."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final
from urllib.parse import parse_qsl, urlencode

from storage.errors import UsageError

_KEYS: Final = ("structure", "epoch", "reference", "scheme", "method")
MOST_CHARACTERS: Final = 2000
"""A longer query was written by no page of ours."""


@dataclass(frozen=True, slots=True)
class Address:
    """A page and what it shows; None stands for what a visitor who asks for nothing sees.

    ``more`` holds what only some pages know, as the slice.
    """

    page: str = "overview"
    structure: str | None = None
    epoch: str | None = None
    reference: str | None = None
    scheme: str | None = None
    method: str | None = None
    more: Mapping[str, str] = field(default_factory=dict)

    @property
    def query(self) -> str:
        """The query, without its question mark."""
        fixed = [(key, getattr(self, key)) for key in _KEYS]
        return urlencode(
            [(key, value) for key, value in (*fixed, *sorted(self.more.items())) if value is not None]
        )

    @property
    def href(self) -> str:
        """The address as a link."""
        return f"/{self.page}" + (f"?{self.query}" if self.query else "")

    def at(self, page: str, **more: str) -> "Address":
        """Return the same on another page; what only the present page knows is left behind."""
        return replace(self, page=page, more=more)

    def with_more(self, **more: str) -> "Address":
        """Return the same page with some of its own choices changed."""
        return replace(self, more={**self.more, **more})

    def choosing(self, **choice: str | None) -> "Address":
        """Return the same page of another epoch, reference, scheme or method."""
        return replace(self, **choice)  # type: ignore[arg-type]


def address_of(pathname: str, search: str) -> Address:
    """Read a page's address.

    Parameters
    ----------
    pathname : str
        As ``/overview``; ``/`` is the overview.
    search : str
        As ``?structure=chimney-01&epoch=2025-03``, or empty.

    Raises
    ------
    UsageError
        If the query is longer than any of ours.
    """
    if len(search) > MOST_CHARACTERS:
        raise UsageError(f"the address has {len(search)} characters; at most {MOST_CHARACTERS} are read")
    given = dict(parse_qsl(search.removeprefix("?")))
    fixed = {key: given.pop(key) for key in _KEYS if key in given}
    return Address(page=pathname.strip("/") or "overview", more=given, **fixed)
