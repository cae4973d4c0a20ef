"""What the first lines of a text file say about the rest: separator, columns, count."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.errors import InputError
from tasks.ingest.column_names import find_columns, plain_name
from tasks.ingest.scan import COLUMN_NAMES, Coordinates

COMMENT: Final = re.compile(r"\s*(#|//)")
ANY_SEPARATOR: Final = re.compile(r"[;,\t ]\s*")
SEPARATORS: Final = (";", "\t", ",", None)
"""Tried in this order; None is any white space."""

CONTROL: Final = frozenset(range(32)) - frozenset(b"\t\n\r\f\v")
LONGEST_NUMBER: Final = 18
"""Digits of the number of a point; more are none."""

NO_SEPARATORS: Final = bytes.maketrans(b"\x1c\x1d\x1e\x1f\x85\xa0", b"??????")
"""Bytes that Python takes for white space and no exporter does: 1<no-break space>234.5 is one number, written badly."""

FEWEST_COUNTED: Final = 3
"""So many lines whose first column counts 1, 2, 3 make it a column of numbers of points."""


@dataclass(frozen=True, slots=True)
class TextLayout:
    """How to read the rows; ``separator`` None is white space, ``first_line`` counts from 1.

    ``n_fields`` is that of the first row where all of them are numbers: then each row has as many. None where names or
    notes stand among them, which may have several words.
    """

    separator: str | None
    columns: tuple[int, int, int]
    n_fields: int | None
    rows_at: int
    first_line: int
    n_declared: int | None


@dataclass(frozen=True, slots=True)
class _Preamble:
    """The lines before the first row of numbers."""

    names: str | None
    n_declared: int | None
    rows_at: int
    first_line: int
    rows: tuple[str, ...]


def sniff_layout(path: Path, head: bytes, coordinates: Coordinates) -> TextLayout:
    """Layout of a text file from its first bytes.

    Before the rows may stand, each at most once: a line with the count of points, a line with the names of the
    columns; and any number of empty lines and comments (``#`` or ``//``, which may hold the names).

    Raises
    ------
    InputError
        If it is not such a file.
    """
    if not head.strip():
        raise InputError(f"{path}: needs points, came a file that holds no points; export the scan again")
    if not CONTROL.isdisjoint(head):
        raise InputError(
            f"{path}: needs plain text, came bytes that are no text; save it as UTF-8, or export LAZ"
        )
    preamble = _read_preamble(path, head, coordinates)
    separator = _separator(preamble.rows[0])
    if preamble.names is not None:
        names = _split_names(preamble.names, separator)
        columns = find_columns(path, names, coordinates)
        _check_names(path, preamble, names, separator)
    else:
        columns = _columns_without_names(path, preamble, separator, coordinates)
    fields = split_row(preamble.rows[0].strip(), separator)
    n_fields = len(fields) if all(is_number(field) for field in fields) else None
    return TextLayout(
        separator, columns, n_fields, preamble.rows_at, preamble.first_line, preamble.n_declared
    )


def text_of(block: bytes) -> str:
    """Text of a block of lines, in which only ASCII white space is white space; a letter is what it is in Latin-1."""
    return block.translate(NO_SEPARATORS).decode("latin-1")


def _check_names(path: Path, preamble: _Preamble, names: Sequence[str], separator: str | None) -> None:
    """Refuse more numbers than names where a number may hold the separator: 1,5,2,5,3,5 or 1 234.5 2 345.6 7 is three."""
    fields = split_row(preamble.rows[0].strip().rstrip(","), separator)
    may_be_torn = separator in (",", None) and len(fields) > len(names)
    if may_be_torn and all(is_number(field) for field in fields):
        raise InputError(
            f"{path}: needs a number for each of {len(names)} names, came {len(fields)} in line {preamble.first_line} "
            f"{preamble.rows[0].strip()[:60]!r}; write numbers as 1234.5, or name all columns"
        )


def split_row(line: str, separator: str | None) -> list[str]:
    """Fields of a row."""
    return [field.strip() for field in line.split(separator)]


def is_number(field: str) -> bool:
    """Whether a field is a number in the notation of this program."""
    try:
        float(field)
    except ValueError:
        return False
    return "_" not in field


def decimal_comma(line: str) -> str | None:
    """The first field of a row that is a number but for its decimal comma."""
    for separator in (";", "\t", None):
        fields = split_row(line, separator)
        commas = [field for field in fields if field.count(",") == 1 and is_number(field.replace(",", "."))]
        if len(fields) >= 3 and commas:
            return commas[0]
    return None


def _separator(line: str) -> str | None:
    """Separator under which the row begins with three numbers; white space if there is none."""
    for separator in SEPARATORS:
        if sum(is_number(field) for field in split_row(line, separator)) >= 3:
            return separator
    return None


def _is_row(line: str) -> bool:
    return sum(is_number(field) for field in split_row(line, _separator(line))) >= 3


def _read_preamble(path: Path, head: bytes, coordinates: Coordinates) -> _Preamble:
    names: str | None = None
    n_declared: int | None = None
    at = 3 if head.startswith(b"\xef\xbb\xbf") else 0
    lines = head[at:].splitlines(keepends=True)
    for index, raw in enumerate(lines):
        line = raw.decode("latin-1").strip()  # as a row that other white space parts: it is refused then
        if _is_row(line):
            rows = tuple(text_of(row) for row in lines[index : index + 20])
            return _Preamble(names, n_declared, at, index + 1, rows)
        at += len(raw)
        comment = COMMENT.match(line)
        if comment:
            candidate = line[comment.end() :].strip()
            names = candidate if _names_wanted(candidate, coordinates) else names
        elif line.isdecimal() and line.isascii() and len(line) < 19 and n_declared is None:
            n_declared = int(line)
        elif line:
            names = _take_names(path, line, index + 1, names)
    raise InputError(
        f"{path}: needs rows of three numbers, came none in its first {len(lines)} lines; export it again"
    )


def _take_names(path: Path, line: str, number: int, names: str | None) -> str:
    comma = decimal_comma(line)
    if comma is not None:
        raise InputError(
            f"{path}: needs decimal points, came {comma!r} in line {number}; write numbers as 1.5"
        )
    if names is not None or is_number(ANY_SEPARATOR.split(line)[0]):
        raise InputError(
            f"{path}: needs rows of three numbers, came line {number} {line[:60]!r}; correct that line"
        )
    return line


def _names_wanted(line: str, coordinates: Coordinates) -> bool:
    return set(COLUMN_NAMES[coordinates]) <= {plain_name(name) for name in _split_names(line, None)}


def _split_names(line: str, separator: str | None) -> Sequence[str]:
    if separator is not None and separator in line:
        return line.split(separator)
    return [name for name in ANY_SEPARATOR.split(line) if name]


def _columns_without_names(
    path: Path, preamble: _Preamble, separator: str | None, coordinates: Coordinates
) -> tuple[int, int, int]:
    if coordinates == "polar":
        raise InputError(
            f"{path}: needs a line that names the columns S, alpha, omega, came none before line {preamble.first_line}; "
            "add it, the order of polar columns differs from maker to maker"
        )
    rows = [split_row(row, separator) for row in preamble.rows if row.strip()]
    counted = (
        [str(index) for index in range(int(rows[0][0]), int(rows[0][0]) + len(rows))]
        if rows[0][0].isdecimal() and len(rows[0][0]) <= LONGEST_NUMBER
        else []
    )
    if len(rows) >= FEWEST_COUNTED and len(rows[0]) > 3 and [row[0] for row in rows] == counted:
        raise InputError(
            f"{path}: needs x in the first of {len(rows[0])} unnamed columns, came the numbers {counted[0]}, {counted[1]}, "
            f"{counted[2]}; add a line that names the columns, x y z among them"
        )
    return (0, 1, 2)
