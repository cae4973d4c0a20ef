"""PTS: a count, then as many rows ``x y z [intensity] [r g b]``; several such blocks may follow each other.

All blocks share one frame, and nothing says where the scanner stood.
"""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from storage.errors import InputError
from tasks.ingest.scan import RawScan, Reader, ScanHeader, ScanPart, ScanRequest
from tasks.ingest.scan_parts import choose_parts
from tasks.ingest.text_layout import split_row
from tasks.ingest.text_rows import (
    CountedRows,
    count_in,
    end_notes,
    fill_rows,
    next_line,
    refuse_polar,
    separator_of,
    skip_lines,
    too_few,
)

COLUMNS: Final = frozenset({3, 4, 6, 7})
"""x y z, intensity, colour, or both."""


@dataclass(frozen=True, slots=True)
class _Block:
    """A block of points, and where its first row begins."""

    rows: CountedRows
    rows_at: int


def describe_pts(path: Path, request: ScanRequest) -> ScanHeader:
    """What the counts of a PTS file say; the lines are counted, not read."""
    with path.open("rb") as file:
        blocks = _index(path, file, request)
        size_bytes = file.seek(0, io.SEEK_END)
    chosen = choose_parts(path, [None] * len(blocks), request)
    parts = tuple(ScanPart(None, block.rows.n_rows, None) for block in blocks)
    return ScanHeader("PTS", sum(parts[place].n_points for place in chosen), size_bytes, None, parts)


def read_pts(path: Path, request: ScanRequest) -> RawScan:
    """All points of a PTS file, or of the block that is asked for."""
    with path.open("rb") as file:
        blocks = _index(path, file, request)
        chosen = [blocks[place] for place in choose_parts(path, [None] * len(blocks), request)]
        # the lines were counted: the file is long enough for what is allocated here
        values = np.empty((sum(block.rows.n_rows for block in chosen), 3))
        done = 0
        for block in chosen:
            file.seek(block.rows_at)
            fill_rows(path, file, block.rows, values[done : done + block.rows.n_rows])
            done += block.rows.n_rows
        notes = end_notes(file, blocks[-1].rows)
    return RawScan(values, notes=notes)


def _index(path: Path, file: BinaryIO, request: ScanRequest) -> tuple[_Block, ...]:
    refuse_polar(path, request, "PTS")
    blocks: list[_Block] = []
    line = 0
    while (text := next_line(path, file)) is not None:
        line += 1
        if not text:
            continue
        n_rows = count_in(text.removeprefix("\u00ef\u00bb\u00bf"))
        if n_rows is None:
            raise _no_count(path, line, text, blocks)
        block = _block(path, file, n_rows, line + 1)
        blocks.append(block)
        found = skip_lines(path, file, n_rows)
        if found < n_rows:
            raise too_few(path, n_rows, found, f"line {line}")
        line += found
    if not any(block.rows.n_rows for block in blocks):
        raise InputError(f"{path}: needs points, came a file that holds no points; export the scan again")
    return tuple(blocks)


def _no_count(path: Path, line: int, text: str, blocks: list[_Block]) -> InputError:
    if blocks:
        rows = blocks[-1].rows
        return InputError(
            f"{path}: needs another count or the end after the {rows.n_rows} rows that {rows.stated_by} states, "
            f"came line {line} {text[:60]!r}; the count is wrong, export again"
        )
    return InputError(
        f"{path}: needs the number of points in line {line}, came {text[:60]!r}; "
        "export again, or rename a list of points without a count to .xyz"
    )


def _block(path: Path, file: BinaryIO, n_rows: int, first_line: int) -> _Block:
    """The block whose rows begin where the file stands; it stands there afterwards, too."""
    rows_at = file.tell()
    row = next_line(path, file) if n_rows else None
    file.seek(rows_at)
    separator = separator_of(row or "")
    n_columns = len(split_row(row, separator)) if row else 3
    if n_columns not in COLUMNS:
        raise InputError(
            f"{path}: needs rows x y z [intensity] [r g b], came {n_columns} columns in line {first_line} "
            f"{(row or '')[:60]!r}; export again, or rename to .xyz and name the columns"
        )
    rows = CountedRows(n_rows, n_columns, (0, 1, 2), separator, first_line, f"line {first_line - 1}")
    return _Block(rows, rows_at)


READER: Final = Reader("pts", (".pts",), describe_pts, read_pts)
