"""What a Parquet file says of its row groups and pages, read without Arrow and without decoding any.

Arrow believes a page header: 64 KB that unpack to 2 GB would fill the memory before anything is checked.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO, Final

from storage.thrift_compact import CompactReader, Struct

LONGEST_PAGE_HEADER: Final = 4096
"""Of a page of numbers; some tens of bytes are usual."""

DATA, DICTIONARY, DATA_V2 = 0, 2, 3
HEADER_BY_KIND: Final = {DATA: 5, DICTIONARY: 7, DATA_V2: 8}
"""Field of a page header that holds what its kind needs; the first field there counts the values."""


@dataclass(frozen=True, slots=True)
class Chunk:
    """A column of a row group: bytes ``start`` to ``end`` of the file; ``low`` and ``high`` as its statistics have them."""

    n_values: int
    start: int
    end: int
    low: bytes | None
    high: bytes | None


@dataclass(frozen=True, slots=True)
class RowGroup:
    """Records that are stored together, a chunk a column."""

    n_records: int
    chunks: tuple[Chunk, ...]


@dataclass(frozen=True, slots=True)
class Footer:
    """Row groups, and the count of records that should be theirs."""

    n_records: int
    groups: tuple[RowGroup, ...]


@dataclass(frozen=True, slots=True)
class Page:
    """A page: its kind, the values that it claims, its bytes in the file and unpacked."""

    kind: int
    n_values: int
    stored_bytes: int
    full_bytes: int

    @property
    def holds_records(self) -> bool:
        """Whether the values are those of the column, not of its dictionary."""
        return self.kind in (DATA, DATA_V2)


def parse_footer(content: bytes) -> Footer:
    """Read the footer of a Parquet file.

    Raises
    ------
    ValueError
        If it is none.
    """
    footer = CompactReader(content).read_struct()
    return Footer(footer.number(3), tuple(_row_group(group) for group in footer.structs(4)))


def walk_pages(file: BinaryIO, start: int, end: int) -> Iterator[Page]:
    """Pages between two bytes of a file.

    Raises
    ------
    ValueError
        If they are no pages, or do not fill that span.
    """
    at = start
    while at < end:
        file.seek(at)
        reader = CompactReader(file.read(min(LONGEST_PAGE_HEADER, end - at)))
        page = _page(reader.read_struct())
        at += reader.at + page.stored_bytes
        if at > end:
            raise ValueError(f"a page ends at byte {at}, its column at byte {end}")
        yield page


def _row_group(group: Struct) -> RowGroup:
    return RowGroup(group.number(3), tuple(_chunk(chunk.struct(3)) for chunk in group.structs(1)))


def _chunk(metadata: Struct) -> Chunk:
    start = metadata.number(9)
    if 11 in metadata.fields and 0 < metadata.number(11) < start:
        start = metadata.number(11)
    statistics = metadata.struct(12)
    return Chunk(
        metadata.number(5), start, start + metadata.number(7), statistics.content(6), statistics.content(5)
    )


def _page(header: Struct) -> Page:
    kind = header.number(1)
    n_values = header.struct(HEADER_BY_KIND[kind]).number(1) if kind in HEADER_BY_KIND else 0
    return Page(kind, n_values, header.number(3), header.number(2))
