"""Where artifacts and the records of stages are kept: one interface, on a folder or on S3.

A store holds whole files under names like ``artifacts/ab/abcd....npy`` and ``records/ingest-12ab...``. Whoever reads a
name gets what was put there whole, or nothing; equal content goes under an equal name, so that two writers of one name
do no harm.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Content:
    """What a stored file holds, without its bytes: SHA-256 in hex, and the number of bytes."""

    sha256: str
    size: int


class Store(Protocol):
    """Named, whole files in one place; every method raises StorageError where the place cannot be used."""

    @property
    def place(self) -> str:
        """The place in words that a person and ``storage.places.store_at`` understand."""

    @property
    def incoming(self) -> Path:
        """What temps of this machine are named after that shall be handed to ``take``."""

    def put(self, name: str, content: bytes) -> None:
        """Keep bytes under a name; what was there before is replaced at once."""

    def take(self, name: str, temp: Path, content: Content) -> None:
        """Keep a finished temp under the name of its content, and remove the temp; what is there whole stays."""

    def put_file(self, name: str, source: Path, content: Content) -> None:
        """Keep a copy of a file under the name of its content; what is there whole stays.

        Raises
        ------
        StorageError
            If the file no longer has that content.
        """

    def get(self, name: str) -> bytes | None:
        """Read what is under a name; None where there is nothing."""

    def local_path(self, name: str, content: Content) -> Path:
        """Give a file of this machine with that content, to be read at once and not written to.

        Raises
        ------
        StorageError
            If it is absent or damaged.
        """

    def size(self, name: str) -> int | None:
        """Bytes under a name; None where there is nothing."""

    def names(self, folder: str) -> Iterator[str]:
        """All names in a folder and below it, sorted."""

    def remove(self, name: str) -> None:
        """Forget a name; one that is not there is no fault."""

    def is_whole(self, name: str, content: Content) -> bool:
        """Whether the content is there; what is unchanged since it was hashed is not hashed again."""

    def is_whole_by_hash(self, name: str, content: Content) -> bool:
        """Whether the content is there by its digest, whatever was found before."""
