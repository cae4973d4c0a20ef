"""Text with a point a line: xyz, csv, txt, asc.

Memory is bounded by the (n, 3) result, for at most as many points as the file has lines, and one block of text.
"""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.scan import RawScan, Reader, ScanHeader, ScanRequest
from tasks.ingest.text_layout import TextLayout, decimal_comma, is_number, sniff_layout, split_row, text_of

HEAD_BYTES: Final = 1 << 16
BLOCK_BYTES: Final = 4 << 20
"""Of text, parsed at a time."""


def describe_delimited(path: Path, request: ScanRequest) -> ScanHeader:
    """What the first lines of a text file say."""
    with path.open("rb") as file:
        layout = _sniff(path, file, request)
        size_bytes = file.seek(0, io.SEEK_END)
    return ScanHeader("text", layout.n_declared, size_bytes, None)


def read_delimited(path: Path, request: ScanRequest) -> RawScan:
    """All rows of a text file."""
    with path.open("rb") as file:
        layout = _sniff(path, file, request)
        values = np.empty((_count_line_ends(file, layout.rows_at) + 1, 3))
        file.seek(layout.rows_at)
        n_rows, ends_whole = _fill(path, file, layout, values)
    if layout.n_declared is not None and n_rows != layout.n_declared:
        raise InputError(
            f"{path}: needs the {layout.n_declared} points that its first line states, came {n_rows}; "
            "the file is cut short or damaged, copy or export it again"
        )
    doubtful = not ends_whole and layout.n_declared is None
    notes = (
        "the last line has no end: if the file was cut short, its last point is wrong and others are missing",
    )
    return RawScan(values[:n_rows], notes=notes if doubtful else ())


def _sniff(path: Path, file: BinaryIO, request: ScanRequest) -> TextLayout:
    head = file.read(HEAD_BYTES)
    if len(head) == HEAD_BYTES:
        head = head[: max(head.rfind(b"\n"), head.rfind(b"\r")) + 1]
        if not head:
            raise InputError(
                f"{path}: needs a point a line, came no line end in {HEAD_BYTES} bytes; export LAZ"
            )
    return sniff_layout(path, head, request.coordinates)


def _count_line_ends(file: BinaryIO, start: int) -> int:
    file.seek(start)
    n_ends = 0
    while block := file.read(BLOCK_BYTES):
        n_ends += block.count(b"\n") + block.count(b"\r")
    return n_ends


def _fill(path: Path, file: BinaryIO, layout: TextLayout, values: NDArray[np.float64]) -> tuple[int, bool]:
    """Parse the rows into values; how many there were, and whether the last line had an end."""
    n_rows, line, end = 0, layout.first_line, b""
    for block in _blocks(path, file):
        text = text_of(block).replace("\r\n", "\n").replace("\r", "\n")
        rows = _parse(path, layout, text, line)
        if n_rows + len(rows) > len(values):
            raise InputError(
                f"{path}: needs a finished file, came one that grew while it was read; try again later"
            )
        values[n_rows : n_rows + len(rows)] = rows
        n_rows, line, end = n_rows + len(rows), line + text.count("\n"), block[-1:]
    return n_rows, end in {b"\n", b"\r"}


def _blocks(path: Path, file: BinaryIO) -> Iterator[bytes]:
    """Text in blocks of whole lines; the last may lack its end."""
    rest = b""
    while block := file.read(BLOCK_BYTES):
        text = rest + block
        end = (text.rfind(b"\n") if b"\n" in text else text.rfind(b"\r")) + 1
        if end:
            yield text[:end]
        rest = text[end:]
        if len(rest) > BLOCK_BYTES:
            raise InputError(
                f"{path}: needs a point a line, came a line of over {BLOCK_BYTES} bytes; export LAZ"
            )
    if rest:
        yield rest


def _parse(path: Path, layout: TextLayout, text: str, first_line: int) -> NDArray[np.float64]:
    """Coordinates (m, 3) of a block of lines; empty lines do not count."""
    if not text.strip():
        return np.empty((0, 3))
    lines = text.split("\n")
    try:
        rows = np.loadtxt(lines, delimiter=layout.separator, usecols=layout.columns, comments=None, ndmin=2)
    except ValueError as error:
        raise _bad_row(path, layout, lines, first_line, str(error)) from error
    _check_fields(path, layout, text, lines, first_line)
    return rows


def _check_fields(path: Path, layout: TextLayout, text: str, lines: list[str], first_line: int) -> None:
    """Refuse a row of numbers that has more or fewer than the first: one may be torn, as 1 234.5, and the others moved."""
    if layout.n_fields is None:
        return
    for index in np.flatnonzero(_fields_of_lines(text, layout.separator) != layout.n_fields):
        fields = split_row(lines[index], layout.separator)
        if lines[index].strip() and all(is_number(field) for field in fields):
            raise InputError(
                f"{path}: needs {layout.n_fields} numbers in every row as in the first, came {len(fields)} in "
                f"line {first_line + index} {lines[index].strip()[:60]!r}; correct or remove that line"
            )


def _fields_of_lines(text: str, separator: str | None) -> NDArray[np.intp]:
    """Fields (n_lines,) of each line; all at once, as each by itself takes as long as to read its numbers."""
    content = np.frombuffer(f"{text}\n".encode("latin-1"), np.uint8)
    ends = np.flatnonzero(content == ord("\n"))
    if separator is None:
        shown = content > ord(" ")
        shown[1:] &= content[:-1] <= ord(" ")
        return np.diff(np.searchsorted(np.flatnonzero(shown), ends), prepend=0)
    between = np.flatnonzero(content == ord(separator))
    return np.diff(np.searchsorted(between, ends), prepend=0) + 1


def _bad_row(path: Path, layout: TextLayout, lines: list[str], first_line: int, reason: str) -> InputError:
    """Name the first line that is no row."""
    for index, line in enumerate(lines):
        fields = split_row(line, layout.separator)
        if not line.strip():
            continue
        where = f"line {first_line + index} {line.strip()[:60]!r}"
        if len(fields) <= max(layout.columns):
            return InputError(
                f"{path}: needs {max(layout.columns) + 1} columns, came {len(fields)} in {where}; "
                "the file is cut short or damaged, export it again"
            )
        bad = [fields[column] for column in layout.columns if not is_number(fields[column])]
        if bad:
            advice = "write numbers as 1.5" if decimal_comma(line) else "correct or remove that line"
            return InputError(f"{path}: needs numbers, came {bad[0][:30]!r} in {where}; {advice}")
    return InputError(f"{path}: needs rows of numbers, came what cannot be read ({reason}); export it again")


READER: Final = Reader("delimited", (".xyz", ".csv", ".txt", ".asc"), describe_delimited, read_delimited)
