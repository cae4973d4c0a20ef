"""Rows of numbers whose count a header states, between other lines of a text.

Memory is bounded by the (n, 3) result and one block of text. The result is allocated only after the rest of the file
proved long enough for as many rows.
"""

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.scan import ScanRequest
from tasks.ingest.text_layout import decimal_comma, is_number, split_row, text_of

BLOCK_BYTES: Final = 4 << 20
"""Of text, parsed at a time."""

LONGEST_LINE: Final = 1 << 16
"""Of a header; what is longer is no text."""

LINE_END: Final = 10

LONGEST_COUNT: Final = 18
"""Digits; more are no count."""


@dataclass(frozen=True, slots=True)
class CountedRows:
    """Rows of a text: how many there must be, and how each is to be read.

    All rows must have ``n_columns`` numbers; ``columns`` are the three that are wanted. ``separator`` None is white
    space. ``first_line`` counts from 1. ``stated_by`` says in messages what states the count.
    """

    n_rows: int
    n_columns: int
    columns: tuple[int, int, int]
    separator: str | None
    first_line: int
    stated_by: str


def separator_of(line: str) -> str | None:
    """What separates the numbers of a row; None is white space."""
    return next((separator for separator in (";", ",") if separator in line), None)


def count_in(line: str) -> int | None:
    """The whole number that a line holds; None if it holds anything else."""
    is_count = line.isdecimal() and line.isascii() and len(line) <= LONGEST_COUNT
    return int(line) if is_count else None


def refuse_polar(path: Path, request: ScanRequest, kind: str) -> None:
    """Refuse polar coordinates in a format whose columns are fixed.

    Raises
    ------
    InputError
        If polar coordinates are asked for.
    """
    if request.coordinates == "polar":
        raise InputError(
            f"{path}: needs named columns S, alpha, omega for polar coordinates, came {kind}, which holds x, y, z; "
            'write coordinates = "cartesian", or export the polar columns as CSV'
        )


def next_line(path: Path, file: BinaryIO) -> str | None:
    """The next line without its end; None at the end of the file.

    Raises
    ------
    InputError
        If it is too long for a line of a header.
    """
    line = file.readline(LONGEST_LINE)
    if len(line) == LONGEST_LINE:
        raise InputError(
            f"{path}: needs lines of text, came no line end in {LONGEST_LINE} bytes; "
            "the file is damaged or in another format, export it again"
        )
    return text_of(line).strip() if line else None


def take_lines(path: Path, file: BinaryIO, n_lines: int) -> Iterator[bytes]:
    """The next ``n_lines`` lines in blocks of whole lines, fewer where the file ends; the last may lack its end.

    Afterwards the file stands at the line that follows.

    Raises
    ------
    InputError
        If a line is longer than a block.
    """
    while n_lines > 0:
        at = file.tell()
        block = file.read(BLOCK_BYTES)
        n_ends = block.count(b"\n")
        if n_ends >= n_lines:
            stop = int(np.flatnonzero(np.frombuffer(block, np.uint8) == LINE_END)[n_lines - 1]) + 1
        elif len(block) < BLOCK_BYTES:
            stop = len(block)
        else:
            stop = block.rfind(b"\n") + 1
        if stop == 0:
            if block:
                raise InputError(
                    f"{path}: needs a point a line, came a line of over {BLOCK_BYTES} bytes; "
                    "the file is damaged or in another format, export it again"
                )
            return
        file.seek(at + stop)
        n_lines -= min(n_ends, n_lines) if n_ends else 1
        yield block[:stop]


def skip_lines(path: Path, file: BinaryIO, n_lines: int) -> int:
    """Pass over lines; how many there were."""
    return sum(count_lines(block) for block in take_lines(path, file, n_lines))


def count_lines(block: bytes) -> int:
    """Lines of a block; the last may lack its end."""
    return block.count(b"\n") + (not block.endswith(b"\n"))


def read_rows(path: Path, file: BinaryIO, rows: CountedRows) -> NDArray[np.float64]:
    """The three wanted columns (n_rows, 3) of the rows that begin where the file stands.

    Raises
    ------
    InputError
        If there are fewer than stated, or one is no row; the message names the line.
    """
    _check_room(path, file, rows)
    values = np.empty((rows.n_rows, 3))
    fill_rows(path, file, rows, values)
    return values


def fill_rows(path: Path, file: BinaryIO, rows: CountedRows, values: NDArray[np.float64]) -> None:
    """As ``read_rows``, into values (n_rows, 3) of a caller that has counted the lines.

    Raises
    ------
    InputError
        If there are fewer than stated, or one is no row; the message names the line.
    """
    done, line = 0, rows.first_line
    for block in take_lines(path, file, rows.n_rows):
        text = text_of(block).replace("\r\n", "\n")
        parsed = _parse(path, rows, text, line)
        values[done : done + len(parsed)] = parsed
        done, line = done + len(parsed), line + text.count("\n")
    if done != rows.n_rows:
        raise too_few(path, rows.n_rows, done, rows.stated_by)


def _check_room(path: Path, file: BinaryIO, rows: CountedRows) -> None:
    """Refuse a count for which the rest of the file is too short, however short the numbers."""
    at = file.tell()
    n_bytes = file.seek(0, io.SEEK_END) - at
    file.seek(at)
    if 2 * rows.n_columns * rows.n_rows - 1 > n_bytes:
        found = skip_lines(path, file, rows.n_rows)
        file.seek(at)
        if found < rows.n_rows:
            raise too_few(path, rows.n_rows, found, rows.stated_by)


def end_notes(file: BinaryIO, rows: CountedRows) -> tuple[str, ...]:
    """A note if the file ends within its last row, right behind a wanted number: that may have lost digits."""
    if max(rows.columns) < rows.n_columns - 1:
        return ()
    file.seek(-1, io.SEEK_END)
    if file.read(1) in {b"\n", b"\r", b" ", b"\t"}:
        return ()
    return ("the last line has no end: if the file was cut short, its last point is wrong",)


def refuse_rest(path: Path, file: BinaryIO, stated_by: str, line: int) -> None:
    """Refuse text after the last row; empty lines do not count.

    Raises
    ------
    InputError
        If there is any.
    """
    for block in take_lines(path, file, 1 << 62):
        if block.strip():
            first = block.strip().splitlines()[0][:60].decode("latin-1")
            raise InputError(
                f"{path}: needs no more points than {stated_by} states, came {first!r} after them, "
                f"from line {line} on; the count is wrong, export again"
            )
        line += count_lines(block)


def too_few(path: Path, stated: int, found: int, stated_by: str) -> InputError:
    """The error for a file that holds fewer points than it states."""
    return InputError(
        f"{path}: needs the {stated} points that {stated_by} states, came {found}; "
        "the file is cut short or damaged, copy or export it again"
    )


def _parse(path: Path, rows: CountedRows, text: str, first_line: int) -> NDArray[np.float64]:
    """Wanted columns (m, 3) of a block of lines."""
    if not text.strip():
        return np.empty((0, 3))
    lines = text.split("\n")
    try:
        # all columns: a row that lacks one may lack it before those that are wanted
        parsed = np.loadtxt(lines, delimiter=rows.separator, comments=None, ndmin=2)
    except ValueError as error:
        raise _bad_row(path, rows, lines, first_line, str(error)) from error
    if parsed.shape[1] != rows.n_columns:
        raise _bad_row(path, rows, lines, first_line, "columns")
    return parsed[:, rows.columns]


def _bad_row(path: Path, rows: CountedRows, lines: list[str], first_line: int, reason: str) -> InputError:
    """Name the first line that is no row."""
    for index, line in enumerate(lines):
        if not line.strip():
            continue
        fields = split_row(line, rows.separator)
        where = f"line {first_line + index} {line.strip()[:60]!r}"
        if len(fields) != rows.n_columns:
            return InputError(
                f"{path}: needs {rows.n_columns} columns in the {rows.n_rows} rows that {rows.stated_by} states, "
                f"came {len(fields)} in {where}; the file is cut short or damaged, export it again"
            )
        bad = [field for field in fields if not is_number(field)]
        if bad:
            advice = "write numbers as 1.5" if decimal_comma(line) else "correct that line or export again"
            return InputError(f"{path}: needs numbers, came {bad[0][:30]!r} in {where}; {advice}")
    return InputError(f"{path}: needs rows of numbers, came what cannot be read ({reason}); export it again")
