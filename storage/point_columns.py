"""Columns of numbers out of a Parquet file that anyone may have written.

Nothing is allocated on the word of such a file. Its footer is short or refused; the pages of the columns that are
asked for are walked by their headers and must hold the records that the footer counts; pages that would fill the
memory are refused; and a file is refused that claims more records than a scan can be packed into so few bytes.
What is left costs a piece of records and a page a column. No type of an extension is evaluated. Arrow itself runs in a
process of its own.
"""

import io
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.decoders.parquet_points import FooterLimits, ToldField, decoded_columns, told_schema
from storage.errors import InputError
from storage.parquet_pages import DICTIONARY, Chunk, Footer, Page, parse_footer, walk_pages

MAGIC: Final = b"PAR1"
ENCRYPTED: Final = b"PARE"
SHORTEST: Final = 12
"""Bytes of a file without footer and content: the magic twice, and the length of the footer."""

MOST_FOOTER_BYTES: Final = 1 << 20
"""Some hundred million records have less; Arrow needs up to 250 times as much memory."""

MOST_ITEMS: Final = 1 << 16
"""In one list of the footer; Arrow allocates a list by its stated length."""

MOST_COLUMNS: Final = 1000

MOST_RECORDS_A_BYTE: Final = 16
"""Three noisy coordinates take over a byte a record; what has no return takes almost nothing, but is never all."""

MOST_PAGE_BYTES: Final = 64 << 20
"""Unpacked; 1 MiB is usual."""

MOST_SMALL_PAGES: Final = 1000
FEWEST_IN_PAGE: Final = 1000
"""Values in a page, but for so many small pages; some ten thousand are usual."""

MOST_BYTES_A_VALUE: Final = 40
"""Unpacked, over a column chunk: 16 for the widest number, its entry in a dictionary, index and levels."""

SLACK_BYTES: Final = 4096
"""Unpacked, over a column chunk, besides."""

NUMPY_FLOATS: Final = (32, 64)
"""Widths whose statistics are plain numbers."""

FOOTER_LIMITS: Final = FooterLimits(MOST_FOOTER_BYTES, MOST_ITEMS)


@dataclass(frozen=True, slots=True)
class StoredColumn:
    """A column at the top of a Parquet file; ``leaf`` is its place among the chunks of a row group.

    ``float_bits`` is the width of a floating-point number, and ``quantum`` the step of an integer or a decimal;
    both are None in a column that holds no plain numbers. ``low`` and ``high`` are what the footer states.
    """

    name: str
    type_name: str
    leaf: int
    float_bits: int | None
    quantum: float | None
    low: float | None
    high: float | None

    @property
    def is_number(self) -> bool:
        """Whether the column holds a plain number a record."""
        return self.float_bits is not None or self.quantum is not None

    def step_at(self, magnitude: float) -> float:
        """Distance of neighbouring numbers that the column can hold about a magnitude; 0 for double precision."""
        if self.quantum is not None:
            return self.quantum
        if self.float_bits == 32:
            return float(np.spacing(np.float32(magnitude)))
        if self.float_bits == 16:
            return float(np.spacing(np.float16(min(magnitude, 65504.0))))
        return 0.0


@dataclass(frozen=True, slots=True)
class PointHeader:
    """What the footer of a Parquet file says, consistent with the size of the file."""

    columns: tuple[StoredColumn, ...]
    footer: Footer
    size_bytes: int

    @property
    def n_records(self) -> int:
        """Records that the footer counts."""
        return self.footer.n_records


@dataclass(frozen=True, slots=True)
class PointPiece:
    """Some records, values (m, k), gone when the next are taken; ``n_incomplete`` lack a value, which is NaN here."""

    values: NDArray[np.float64]
    n_incomplete: int


def read_point_header(path: Path, file: BinaryIO) -> PointHeader:
    """Columns and count of records of a Parquet file.

    Raises
    ------
    InputError
        If it is no Parquet file, is encrypted, has no records, or claims more than can be in it.
    Exception
        What Arrow raises on a damaged footer.
    """
    size_bytes = file.seek(0, io.SEEK_END)
    footer = _read_footer(path, file, size_bytes)
    _check_counts(path, footer, size_bytes)
    schema = told_schema(path, FOOTER_LIMITS)
    paths = schema.paths
    if any(len(group.chunks) != len(paths) for group in footer.groups):
        raise ValueError(f"a row group lacks some of the {len(paths)} columns")
    columns = tuple(_column(field, paths, footer) for field in schema.fields)
    return PointHeader(columns, footer, size_bytes)


def check_point_pages(
    path: Path, file: BinaryIO, header: PointHeader, columns: Sequence[StoredColumn]
) -> None:
    """Compare the pages of columns of numbers with the footer, without decoding them.

    Raises
    ------
    InputError
        If they hold another number of records, or would unpack to more than such records take.
    ValueError
        If there are no pages where the footer says.
    """
    for group in header.footer.groups:
        for column in columns:
            _check_chunk(path, file, group.n_records, group.chunks[column.leaf])


def _check_chunk(path: Path, file: BinaryIO, n_records: int, chunk: Chunk) -> None:
    size_bytes = file.seek(0, io.SEEK_END)
    if not len(MAGIC) <= chunk.start <= chunk.end <= size_bytes:
        raise _cut_short(path, f"a column from byte {chunk.start} to {chunk.end}", f"{size_bytes} bytes")
    most_pages = MOST_SMALL_PAGES + n_records // FEWEST_IN_PAGE
    pages = tuple(islice(walk_pages(file, chunk.start, chunk.end), most_pages + 1))
    if len(pages) > most_pages:
        raise _bloated(path, f"over {most_pages} pages for {n_records} values")
    for page in pages:
        _check_page(path, page)
    n_in_pages = sum(page.n_values for page in pages if page.holds_records)
    if not n_in_pages == chunk.n_values == n_records:
        raise _cut_short(path, f"the {n_records} values of a row group in each column", f"{n_in_pages}")
    full_bytes = sum(page.full_bytes for page in pages)
    if full_bytes > MOST_BYTES_A_VALUE * n_records + SLACK_BYTES:
        raise _bloated(path, f"{full_bytes} bytes for {n_records} values")


def read_point_pieces(path: Path, names: Sequence[str]) -> Iterator[PointPiece]:
    """Records of some columns of numbers, in the order of the file; call ``check_point_pages`` before.

    Raises
    ------
    Exception
        What Arrow does on damaged pages.
    """
    for values, n_incomplete in decoded_columns(path, FOOTER_LIMITS, names):
        yield PointPiece(values, n_incomplete)


def _read_footer(path: Path, file: BinaryIO, size_bytes: int) -> Footer:
    """Footer of a file that begins and ends as Parquet does."""
    file.seek(0)
    head = file.read(len(MAGIC))
    if head == ENCRYPTED:
        raise InputError(f"{path}: needs a plain Parquet file, came an encrypted one; export it without")
    if head != MAGIC:
        raise InputError(
            f"{path}: needs a Parquet file, which begins with 'PAR1', came "
            f"{'an empty file' if not head else repr(head)}; check the file, or export it again"
        )
    if size_bytes < SHORTEST:
        raise _cut_short(path, f"at least {SHORTEST} bytes", f"{size_bytes} bytes")
    end = file.seek(size_bytes - len(MAGIC) - 4)
    footer_bytes, tail = int.from_bytes(file.read(4), "little"), file.read(len(MAGIC))
    if tail != MAGIC:
        raise _cut_short(path, "'PAR1' at its end", repr(tail))
    if footer_bytes > size_bytes - SHORTEST:
        raise _cut_short(path, f"a footer of {footer_bytes} bytes", f"a file of {size_bytes} bytes")
    if footer_bytes > MOST_FOOTER_BYTES:
        raise InputError(
            f"{path}: needs a footer of at most {MOST_FOOTER_BYTES} bytes, came {footer_bytes}; "
            "write it with larger row groups (a million records) and without columns that are not used"
        )
    file.seek(end - footer_bytes)
    return parse_footer(file.read(footer_bytes))


def _check_counts(path: Path, footer: Footer, size_bytes: int) -> None:
    n_records, in_groups = footer.n_records, sum(group.n_records for group in footer.groups)
    if n_records != in_groups:
        raise _cut_short(
            path, f"row groups with the {n_records} records that its footer states", f"{in_groups}"
        )
    n_columns = max((len(group.chunks) for group in footer.groups), default=0)
    if n_columns > MOST_COLUMNS:
        raise InputError(f"{path}: needs at most {MOST_COLUMNS} columns, came {n_columns}; write fewer")
    if n_records == 0:
        raise InputError(f"{path}: needs points, came a file that holds no records; export the scan again")
    if n_records > MOST_RECORDS_A_BYTE * size_bytes:
        raise InputError(
            f"{path}: needs at most {MOST_RECORDS_A_BYTE} records a byte, came {n_records} in {size_bytes} bytes; "
            "no scan packs so densely: the file is damaged or not a scan, export it again as LAZ"
        )


def _column(field: ToldField, paths: Sequence[str], footer: Footer) -> StoredColumn:
    # Arrow reads under a name whatever lies within it, too
    leaves = [leaf for leaf, path in enumerate(paths) if f"{path}.".startswith(f"{field.name}.")]
    leaf = leaves[0] if leaves else 0
    bits, quantum = (field.float_bits, field.quantum) if len(leaves) == 1 else (None, None)
    chunks = [group.chunks[leaf] for group in footer.groups if bits in NUMPY_FLOATS]
    low = _outermost([chunk.low for chunk in chunks], bits, min)
    high = _outermost([chunk.high for chunk in chunks], bits, max)
    return StoredColumn(field.name, field.type_name, leaf, bits, quantum, low, high)


def _outermost(
    stated: Sequence[bytes | None], bits: int | None, choose: Callable[[list[float]], float]
) -> float | None:
    """Smallest or largest number of the statistics, if every row group states a finite one."""
    numbers = [
        float(np.frombuffer(value, dtype=f"<f{bits // 8}")[0])
        for value in stated
        if value is not None and bits is not None and len(value) == bits // 8
    ]
    if not numbers or len(numbers) < len(stated) or not all(map(math.isfinite, numbers)):
        return None
    return choose(numbers)


def _check_page(path: Path, page: Page) -> None:
    if page.full_bytes > MOST_PAGE_BYTES:
        raise _bloated(path, f"a page of {page.full_bytes} bytes")
    # Arrow allocates a dictionary by its stated length
    if page.kind == DICTIONARY and page.n_values > page.full_bytes:
        raise _bloated(path, f"a dictionary of {page.n_values} values in {page.full_bytes} bytes")


def _bloated(path: Path, came: str) -> InputError:
    return InputError(
        f"{path}: needs pages of at most {MOST_PAGE_BYTES >> 20} MiB that hold what they state, came {came}; "
        "the file is damaged, or write it again with pages of 1 MiB"
    )


def _cut_short(path: Path, needed: str, came: str) -> InputError:
    return InputError(
        f"{path}: needs {needed}, came {came}; the file is cut short or damaged, copy or export it again"
    )
